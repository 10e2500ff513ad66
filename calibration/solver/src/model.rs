//! What is between a pin's nominal contact and its pixel, and which parts of it can be solved for.
//!
//! A pin's nominal contact, sensor frame, is displaced by the seating offset along the pin and by
//! the lean around the sensor's axis, then moved with the dome as it was seated in that capture,
//! then carried into the camera's frame and projected. Each of these has a derivative. Its mark is
//! found some way beside that pixel, which is known beforehand and hardly changes with any of them.

use std::collections::BTreeMap;
use std::fmt;

use fabkit_camera::{Camera, Interface, OutsideDomain, POSE_PARAMETERS};
use fabkit_geometry::{Matrix3, Point3, Pose, Vector3};
use nalgebra::{Matrix2x3, Point2, Rotation3, SMatrix, Vector2};

use crate::drawn::{self, DrawnInterface};

/// Nearer to the sensor's axis than this there is no way round it, mm.
const ON_AXIS_MM: f64 = 0.1;
/// How far a dome can seat from its place, mm (one standard deviation).
const RESEATING_SHIFT_MM: f64 = 0.3;
/// How far a dome can turn on its seat, rad (one standard deviation): 1 degree.
const RESEATING_TURN_RAD: f64 = 0.0175;

/// How well it is known how much a layer scatters, as a logarithm, and how far light goes sideways in it, mm (one standard
/// deviation each): a factor of two, and what published captures of one unit leave open.
const SCATTER_SIGMA: f64 = 0.7;
const SPREAD_SIGMA_MM: f64 = 0.15;

/// Parameters of a lens before its coefficients: two focal lengths, two coordinates of the centre.
const INTRINSICS: usize = 4;

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

impl Axis {
    /// All three.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    fn index(self) -> usize {
        self as usize
    }

    pub(crate) fn unit(self) -> Vector3<f64> {
        let mut vector = Vector3::zeros();
        vector[self.index()] = 1.0;
        vector
    }
}

/// How a dome sits in one capture, against where it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MountingError {
    /// Shifted along the sensor's x, mm.
    ShiftX,
    /// Shifted along the sensor's y, mm.
    ShiftY,
    /// Turned about the sensor's z, rad.
    Turn,
}

/// Something that can be solved for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FitParameter {
    /// Rotation of the pose, about an axis of the camera frame through the sensor's origin, rad.
    Rotation(Axis),
    /// Translation of the pose: the sensor's origin in the camera frame, mm.
    Translation(Axis),
    /// How much farther than nominal all pins go in along their axes, mm.
    SeatingOffset,
    /// How far all pins lean sideways, the same way round the sensor's z axis, mm at the tip. That
    /// is what happens when a dome is turned a little while its pins stick to the surface.
    Lean,
    /// Both focal lengths by one factor: 0.01 is one percent longer.
    FocalScale,
    /// How much farther from the lens than drawn the interface lies, mm: see [`Model::drawn`].
    InterfaceShift,
    /// How much more than assumed the layer scatters, as a logarithm: it moves marks, see [`MarkOffset`].
    LayerScatter,
    /// How much farther than assumed light goes sideways in the layer, mm: it moves marks as well.
    LayerSpread,
    /// A parameter of the camera, by the name that [`Camera::parameters`] gives it.
    Camera(&'static str),
    /// How the dome sits in one capture.
    Reseating(usize, MountingError),
}

impl FitParameter {
    /// The six of a pose, in the order of [`POSE_PARAMETERS`]: rotation, then translation.
    pub const POSE: [Self; 6] = [
        Self::Rotation(Axis::X),
        Self::Rotation(Axis::Y),
        Self::Rotation(Axis::Z),
        Self::Translation(Axis::X),
        Self::Translation(Axis::Y),
        Self::Translation(Axis::Z),
    ];

    /// What a drawing leaves open of the interface that it draws.
    pub const DRAWN: [Self; 2] = [Self::InterfaceShift, Self::Camera("interface_index_outside")];

    /// What of the light moves marks.
    pub const LIGHT: [Self; 2] = [Self::LayerScatter, Self::LayerSpread];

    /// What is known before any picture is taken, as one standard deviation in the parameter's
    /// unit: assembly holds the camera to a few degrees and millimetres, a pin stops within 2 mm,
    /// a lens is within a few tens of percent of its data sheet. A combination about which
    /// pictures say little more than this is called not observable.
    pub fn prior_sigma(self) -> f64 {
        match self {
            Self::Rotation(_) => 0.1,
            Self::Translation(_) => 5.0,
            Self::SeatingOffset => 2.0,
            Self::Lean => 1.0,
            Self::FocalScale => 0.3,
            Self::InterfaceShift => drawn::PLACE_SIGMA_MM,
            Self::LayerScatter => SCATTER_SIGMA,
            Self::LayerSpread => SPREAD_SIGMA_MM,
            Self::Camera("interface_distance_mm") => 10.0,
            Self::Camera("interface_index_outside") => 0.1,
            Self::Camera("fx_px" | "fy_px") => 100.0,
            Self::Camera("cx_px" | "cy_px") => 20.0,
            Self::Camera(_) => 0.3,
            Self::Reseating(_, MountingError::Turn) => RESEATING_TURN_RAD,
            Self::Reseating(..) => RESEATING_SHIFT_MM,
        }
    }
}

impl FitParameter {
    /// What it is, for people: `the camera's distance (translation_z_mm)`.
    pub fn in_words(self) -> String {
        let what = match self {
            Self::Rotation(_) => "the camera's orientation",
            Self::Translation(Axis::Z) => "the camera's distance",
            Self::Translation(_) => "the camera's place across",
            Self::SeatingOffset => "how far pins go in",
            Self::Lean => "how far pins lean",
            Self::FocalScale => "the lens's focal length",
            Self::Camera("interface_distance_mm") => "the gel's distance from the lens",
            Self::Camera("interface_index_outside") => "the gel's refractive index",
            Self::InterfaceShift => "how far the gel's face lies from where it is drawn",
            Self::LayerScatter => "how much the layer scatters",
            Self::LayerSpread => "how far light goes sideways in the layer",
            Self::Camera(_) => "a parameter of the camera",
            Self::Reseating(..) => "how the dome sits",
        };
        format!("{what} ({self})")
    }
}

impl fmt::Display for FitParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rotation(axis) => f.write_str(POSE_PARAMETERS[axis.index()]),
            Self::Translation(axis) => f.write_str(POSE_PARAMETERS[3 + axis.index()]),
            Self::SeatingOffset => f.write_str("seating_offset_mm"),
            Self::Lean => f.write_str("lean_mm"),
            Self::FocalScale => f.write_str("focal_scale"),
            Self::InterfaceShift => f.write_str("interface_shift_mm"),
            Self::LayerScatter => f.write_str("layer_scatter_log"),
            Self::LayerSpread => f.write_str("layer_spread_mm"),
            Self::Camera(name) => f.write_str(name),
            Self::Reseating(capture, MountingError::ShiftX) => {
                write!(f, "capture_{capture}_shift_x_mm")
            }
            Self::Reseating(capture, MountingError::ShiftY) => {
                write!(f, "capture_{capture}_shift_y_mm")
            }
            Self::Reseating(capture, MountingError::Turn) => {
                write!(f, "capture_{capture}_turn_rad")
            }
        }
    }
}

/// A pin in a hole, pushed home in one capture.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Counts from 0.
    pub capture: usize,
    /// Number of the hole.
    pub hole: u32,
    /// Nominal, mm.
    pub contact_in_sensor_mm: Point3<f64>,
    /// The way the pin is pushed, if known; unit length.
    pub axis_in_sensor: Option<Vector3<f64>>,
}

/// A contact and where it was seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Which pin.
    pub contact: Contact,
    /// Where, px.
    pub pixel: Point2<f64>,
    /// Standard deviation of each coordinate, px.
    pub sigma_px: f64,
}

/// Everything between contacts and pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The camera with its interface.
    pub camera: Camera,
    /// Sensor frame to camera frame, mm.
    pub camera_from_sensor: Pose,
    /// See [`FitParameter::SeatingOffset`].
    pub seating_offset_mm: f64,
    /// See [`FitParameter::Lean`].
    pub lean_mm: f64,
    /// The translation that the design gives the pose, if it takes part in a fit as what is known
    /// beforehand; see [`FitParameter::prior_sigma`].
    pub expected_translation_mm: Option<Vector3<f64>>,
    /// Shift in x and y, mm, and turn, rad, for each capture; captures beyond the end sit as they
    /// should.
    pub reseatings: Vec<[f64; 3]>,
    /// The interface that the design draws, if the camera's is that one: it stands still in the sensor, and
    /// the camera's follows from the pose.
    pub drawn: Option<DrawnInterface>,
    /// See [`FitParameter::InterfaceShift`].
    pub interface_shift_mm: f64,
    /// See [`FitParameter::LayerScatter`].
    pub layer_scatter_log: f64,
    /// See [`FitParameter::LayerSpread`].
    pub layer_spread_mm: f64,
    /// How far from where they are contacts seem to be, because light is bent again behind the camera's
    /// interface; the rest seem to be where they are.
    pub displacements: Displacements,
    /// How far from the pixels of their tips marks are found; the rest are found there.
    pub mark_offsets: MarkOffsets,
}

/// Where the mark of a pin is found beside the pixel of its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkOffset {
    /// How far, px.
    pub by_px: Vector2<f64>,
    /// How much farther for each millimetre that the pin goes in deeper, px/mm.
    pub by_depth: Vector2<f64>,
    /// By each of [`FitParameter::LIGHT`], px for one of its unit.
    pub by_light: [Vector2<f64>; 2],
    /// Standard deviation along each coordinate, px.
    pub sigma_px: f64,
}

/// Offsets of marks, by the contacts of their pins, sensor frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkOffsets(BTreeMap<[u64; 3], MarkOffset>);

impl MarkOffsets {
    /// Of each contact's nominal place.
    pub fn new(all: impl IntoIterator<Item = (Point3<f64>, MarkOffset)>) -> Self {
        Self(all.into_iter().map(|(place, offset)| (key(&place), offset)).collect())
    }

    /// Of a contact's nominal place, if it is known.
    pub fn of(&self, place: &Point3<f64>) -> Option<MarkOffset> {
        self.0.get(&key(place)).copied()
    }

    /// Whether none is known.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// By contacts, sensor frame, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Displacements(BTreeMap<[u64; 3], Vector3<f64>>);

impl Displacements {
    /// Of each contact's nominal place.
    pub fn new(all: impl IntoIterator<Item = (Point3<f64>, Vector3<f64>)>) -> Self {
        Self(all.into_iter().map(|(place, by)| (key(&place), by)).collect())
    }

    fn of(&self, place: &Point3<f64>) -> Vector3<f64> {
        match self.0.is_empty() {
            true => Vector3::zeros(),
            false => self.0.get(&key(place)).copied().unwrap_or_default(),
        }
    }
}

fn key(place: &Point3<f64>) -> [u64; 3] {
    [place.x, place.y, place.z].map(f64::to_bits)
}

impl Model {
    /// A camera at a pose, and pins where they should be.
    pub fn new(camera: Camera, camera_from_sensor: Pose) -> Self {
        Self {
            camera,
            camera_from_sensor,
            seating_offset_mm: 0.0,
            lean_mm: 0.0,
            expected_translation_mm: None,
            reseatings: Vec::new(),
            drawn: None,
            interface_shift_mm: 0.0,
            layer_scatter_log: 0.0,
            layer_spread_mm: 0.0,
            displacements: Displacements::default(),
            mark_offsets: MarkOffsets::default(),
        }
    }

    /// The same behind an interface that the design draws, where it is drawn.
    #[must_use]
    pub fn behind(mut self, drawn: &DrawnInterface) -> Option<Self> {
        self.drawn = Some(*drawn);
        self.interface_shift_mm = 0.0;
        self.camera = self.camera_behind(drawn.index_outside())?;
        Some(self)
    }

    /// The camera with the drawn interface as it is seen from its pose.
    fn camera_behind(&self, index_outside: f64) -> Option<Camera> {
        let Some(drawn) = &self.drawn else { return Some(self.camera) };
        let pose = &self.camera_from_sensor;
        let interface = drawn.seen_from(pose, self.interface_shift_mm, index_outside);
        let [width_px, height_px] = [self.camera.width_px(), self.camera.height_px()];
        Camera::new(width_px, height_px, *self.camera.lens(), interface).ok()
    }

    /// Refractive index behind the camera's interface, if it has one.
    fn index_outside(&self) -> Option<f64> {
        match self.camera.interface() {
            Interface::None | Interface::Drawn => None,
            Interface::Flat(flat) => Some(flat.index_outside),
            Interface::Sphere(sphere) => Some(sphere.index_outside),
        }
    }

    /// Where the mark of a contact is seen, px.
    ///
    /// # Errors
    /// It lies outside what the camera can see.
    pub fn project(&self, contact: &Contact) -> Result<Point2<f64>, OutsideDomain> {
        let tip = self.camera.project(&self.camera_from_sensor.point(self.seated(contact)))?;
        Ok(tip + self.mark_offset(contact))
    }

    /// [`Model::project`] with its derivatives by each of `parameters`, in their units.
    ///
    /// # Errors
    /// As [`Model::project`].
    pub fn differentiate(
        &self,
        contact: &Contact,
        parameters: &[FitParameter],
        columns: &mut [Vector2<f64>],
    ) -> Result<Point2<f64>, OutsideDomain> {
        let seated = self.seated(contact);
        let point = self.camera_from_sensor.point(seated);
        let projection = self.camera.project_with_jacobians(&point)?;
        let turned = point - self.camera_from_sensor.translation_mm();
        let by_interface = self.by_interface(&projection.by_parameters);
        let of_mark = self.mark_offsets.of(&contact.contact_in_sensor_mm);
        let by_sensor: Matrix2x3<f64> = projection.by_point * self.camera_from_sensor.rotation();
        let intrinsics = self.camera.lens().intrinsics();
        let turn = self.reseatings.get(contact.capture).map_or(0.0, |[_, _, turn]| *turn);
        let turned_with_dome = |v: Vector3<f64>| v + turn * Vector3::z().cross(&v);
        for (column, parameter) in columns.iter_mut().zip(parameters) {
            *column = match parameter {
                FitParameter::Rotation(axis) => {
                    projection.by_point * axis.unit().cross(&turned.coords)
                        + by_interface.column(axis.index())
                }
                FitParameter::Translation(axis) => {
                    projection.by_point.column(axis.index()) + by_interface.column(3 + axis.index())
                }
                FitParameter::InterfaceShift => by_interface.column(6).into(),
                FitParameter::LayerScatter => {
                    of_mark.map_or_else(Vector2::zeros, |o| o.by_light[0])
                }
                FitParameter::LayerSpread => of_mark.map_or_else(Vector2::zeros, |o| o.by_light[1]),
                FitParameter::SeatingOffset => {
                    by_sensor * turned_with_dome(contact.axis_in_sensor.unwrap_or_default())
                        + of_mark.map_or_else(Vector2::zeros, |offset| offset.by_depth)
                }
                FitParameter::Lean => {
                    by_sensor * turned_with_dome(way_round(contact.contact_in_sensor_mm))
                }
                FitParameter::FocalScale => {
                    projection.by_parameters[0] * intrinsics.fx_px
                        + projection.by_parameters[1] * intrinsics.fy_px
                }
                FitParameter::Camera(name) => match self.camera_index(name) {
                    Some(index) => projection.by_parameters[index],
                    None => Vector2::zeros(),
                },
                FitParameter::Reseating(capture, _) if *capture != contact.capture => {
                    Vector2::zeros()
                }
                FitParameter::Reseating(_, MountingError::ShiftX) => by_sensor.column(0).into(),
                FitParameter::Reseating(_, MountingError::ShiftY) => by_sensor.column(1).into(),
                FitParameter::Reseating(_, MountingError::Turn) => {
                    by_sensor * Vector3::z().cross(&self.displaced(contact).coords)
                }
            };
        }
        Ok(projection.pixel + self.mark_offset(contact))
    }

    /// Change of a mark's pixel with its contact's place in the sensor frame, px/mm.
    ///
    /// # Errors
    /// As [`Model::project`].
    pub fn by_place(&self, contact: &Contact) -> Result<Matrix2x3<f64>, OutsideDomain> {
        let point = self.camera_from_sensor.point(self.seated(contact));
        let projection = self.camera.project_with_jacobians(&point)?;
        Ok(projection.by_point * self.camera_from_sensor.rotation())
    }

    fn mark_offset(&self, contact: &Contact) -> Vector2<f64> {
        self.mark_offsets.of(&contact.contact_in_sensor_mm).map_or_else(Vector2::zeros, |offset| {
            let [scatter, spread] = offset.by_light;
            offset.by_px
                + self.seating_offset_mm * offset.by_depth
                + self.layer_scatter_log * scatter
                + self.layer_spread_mm * spread
        })
    }

    /// Change of a pixel with pose and shift by way of the drawn interface, which they move before the lens.
    fn by_interface(&self, by_parameters: &[Vector2<f64>]) -> SMatrix<f64, 2, 7> {
        let Some(drawn) = &self.drawn else { return SMatrix::zeros() };
        let by_pose = drawn.by_pose(&self.camera_from_sensor, self.interface_shift_mm);
        let of_lens = INTRINSICS + self.camera.lens().coefficient_names().len();
        let of_interface = by_parameters.iter().skip(of_lens);
        let parts = of_interface.zip(by_pose.row_iter()).map(|(pixel, row)| pixel * row);
        parts.sum()
    }

    /// The same model with each parameter moved by its step; `None` where no such camera exists.
    #[must_use]
    pub fn stepped(&self, parameters: &[FitParameter], steps: &[f64]) -> Option<Self> {
        let mut next = self.clone();
        let (mut turn, mut shift) = (Vector3::zeros(), *self.camera_from_sensor.translation_mm());
        let mut values: Option<Vec<f64>> = None;
        let current = || self.camera.parameters().into_iter().map(|(_, value)| value).collect();
        for (parameter, step) in parameters.iter().zip(steps) {
            match parameter {
                FitParameter::Rotation(axis) => turn[axis.index()] += step,
                FitParameter::Translation(axis) => shift[axis.index()] += step,
                FitParameter::SeatingOffset => next.seating_offset_mm += step,
                FitParameter::Lean => next.lean_mm += step,
                FitParameter::FocalScale => {
                    let values = values.get_or_insert_with(current);
                    values[0] *= 1.0 + step;
                    values[1] *= 1.0 + step;
                }
                FitParameter::InterfaceShift => next.interface_shift_mm += step,
                FitParameter::LayerScatter => next.layer_scatter_log += step,
                FitParameter::LayerSpread => next.layer_spread_mm += step,
                FitParameter::Camera(name) => {
                    values.get_or_insert_with(current)[self.camera_index(name)?] += step;
                }
                FitParameter::Reseating(capture, seat) => {
                    if next.reseatings.len() <= *capture {
                        next.reseatings.resize(capture + 1, [0.0; 3]);
                    }
                    next.reseatings[*capture][*seat as usize] += step;
                }
            }
        }
        if let Some(values) = values {
            next.camera = self.camera.with_parameters(&values).ok()?;
        }
        let rotation: Matrix3<f64> =
            Rotation3::new(turn).matrix() * self.camera_from_sensor.rotation();
        next.camera_from_sensor = Pose::new(rotation, shift)?;
        if let Some(index_outside) = next.index_outside().filter(|_| next.drawn.is_some()) {
            next.camera = next.camera_behind(index_outside)?;
        }
        Some(next)
    }

    /// What a parameter's value is now, in its unit: rotations as the components of the rotation
    /// vector of the whole pose. A focal scale is a step from the camera's own focal length: 0.
    /// `None` for the name of a parameter that the camera does not have.
    pub fn value(&self, parameter: FitParameter) -> Option<f64> {
        Some(match parameter {
            FitParameter::Rotation(axis) => {
                let rotation = *self.camera_from_sensor.rotation();
                Rotation3::from_matrix_unchecked(rotation).scaled_axis()[axis.index()]
            }
            FitParameter::Translation(axis) => {
                self.camera_from_sensor.translation_mm()[axis.index()]
            }
            FitParameter::SeatingOffset => self.seating_offset_mm,
            FitParameter::Lean => self.lean_mm,
            FitParameter::FocalScale => 0.0,
            FitParameter::InterfaceShift => self.interface_shift_mm,
            FitParameter::LayerScatter => self.layer_scatter_log,
            FitParameter::LayerSpread => self.layer_spread_mm,
            FitParameter::Camera(name) => {
                self.camera.parameters().into_iter().find(|(found, _)| *found == name)?.1
            }
            FitParameter::Reseating(capture, seat) => {
                self.reseatings.get(capture).map_or(0.0, |seated| seated[seat as usize])
            }
        })
    }

    /// Where the contact is in the sensor frame with everything that displaces it, mm.
    pub fn seated(&self, contact: &Contact) -> Point3<f64> {
        let displaced = self.displaced(contact);
        let Some([x, y, turn]) = self.reseatings.get(contact.capture) else {
            return displaced;
        };
        displaced + Vector3::new(*x, *y, 0.0) + *turn * Vector3::z().cross(&displaced.coords)
    }

    /// How far a parameter is from what is known of it beforehand, and how well that is known, if
    /// that takes part in a fit. A dome's seat has more unknowns than its few pins could fix, and
    /// the camera stands where the design puts it but for its assembly.
    pub(crate) fn prior(&self, parameter: FitParameter) -> Option<(f64, f64)> {
        let away = match parameter {
            FitParameter::Reseating(capture, seat) => {
                self.reseatings.get(capture).map_or(0.0, |seated| seated[seat as usize])
            }
            FitParameter::Translation(axis) => {
                let expected = self.expected_translation_mm?;
                (self.camera_from_sensor.translation_mm() - expected)[axis.index()]
            }
            FitParameter::InterfaceShift => self.interface_shift_mm,
            FitParameter::LayerScatter => self.layer_scatter_log,
            FitParameter::LayerSpread => self.layer_spread_mm,
            FitParameter::Camera("interface_index_outside") => {
                let away = self.index_outside()? - self.drawn.as_ref()?.index_outside();
                return Some((away, drawn::INDEX_SIGMA));
            }
            _ => return None,
        };
        Some((away, parameter.prior_sigma()))
    }

    /// Whether the drawing says beforehand what a parameter is.
    pub(crate) fn is_drawn(&self, parameter: FitParameter) -> bool {
        self.drawn.is_some() && FitParameter::DRAWN.contains(&parameter)
            || FitParameter::LIGHT.contains(&parameter)
    }

    fn displaced(&self, contact: &Contact) -> Point3<f64> {
        contact.contact_in_sensor_mm
            + self.displacements.of(&contact.contact_in_sensor_mm)
            + self.seating_offset_mm * contact.axis_in_sensor.unwrap_or_default()
            + self.lean_mm * way_round(contact.contact_in_sensor_mm)
    }

    fn camera_index(&self, name: &str) -> Option<usize> {
        self.camera.parameters().iter().position(|(found, _)| *found == name)
    }
}

/// Unit vector the way round the sensor's axis; zero on it.
fn way_round(point: Point3<f64>) -> Vector3<f64> {
    let radius_mm = point.x.hypot(point.y);
    if radius_mm < ON_AXIS_MM {
        return Vector3::zeros();
    }
    Vector3::new(-point.y, point.x, 0.0) / radius_mm
}
