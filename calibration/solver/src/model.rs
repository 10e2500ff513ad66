//! Measurement model: from a pin's nominal contact to its pixel, with the parameters that can be solved for.
//!
//! A pin's nominal contact, sensor frame, is displaced by the seating offset along the pin and by the lean around the
//! sensor's axis. It is then moved with the dome as seated in that capture, transformed into the camera frame and
//! projected. Each of these steps has a derivative. The pin's mark is found at an offset from that pixel, which is
//! known beforehand and hardly depends on any of the parameters.

use std::collections::BTreeMap;
use std::fmt;

use fabkit_camera::{Camera, Interface, OutsideDomain, POSE_PARAMETERS};
use fabkit_geometry::{Matrix3, Point3, Pose, Vector3};
use nalgebra::{Matrix2x3, Point2, Rotation3, SMatrix, Vector2};

use crate::drawn_interface::{self, DrawnInterface};

/// Radius around the sensor's z axis below which there is no tangential direction, mm.
const ON_AXIS_MM: f64 = 0.1;
/// Shift of a dome from its nominal place when it is seated, mm (one standard deviation).
const RESEATING_SHIFT_MM: f64 = 0.3;
/// Turn of a dome on its seat, rad (one standard deviation): 1 degree.
const RESEATING_TURN_RAD: f64 = 0.0175;

/// Prior standard deviation of a layer's scattering, as a natural logarithm: a factor of two, the range that published
/// captures of one unit leave open.
const SCATTER_SIGMA: f64 = 0.7;
/// Prior standard deviation of the lateral spread of light in a layer, mm: the range that published captures of one
/// unit leave open.
const SPREAD_SIGMA_MM: f64 = 0.15;

/// Number of a lens's parameters before its coefficients: two focal lengths, two coordinates of the centre.
const INTRINSICS: usize = 4;

/// Coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl Axis {
    /// All three axes.
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

/// Deviation of a dome in one capture from its nominal place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MountingError {
    /// Shift along the sensor's x axis, mm.
    ShiftX,
    /// Shift along the sensor's y axis, mm.
    ShiftY,
    /// Turn about the sensor's z axis, rad.
    Turn,
}

/// Parameter that a fit can solve for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FitParameter {
    /// Rotation of the pose, about an axis of the camera frame through the sensor's origin, rad.
    Rotation(Axis),
    /// Translation of the pose: the sensor's origin in the camera frame, mm.
    Translation(Axis),
    /// Depth by which all pins go in beyond nominal along their axes, mm.
    SeatingOffset,
    /// Sideways lean of all pins, in the same sense around the sensor's z axis, mm at the tip. It occurs when a dome is
    /// turned a little while its pins stick to the surface.
    Lean,
    /// Common factor of both focal lengths: 0.01 is one percent longer.
    FocalScale,
    /// Distance by which the interface lies farther from the lens than drawn, mm; see [`Model::with_drawn_interface`].
    InterfaceShift,
    /// Natural logarithm of the layer's scattering relative to the assumed one; it moves marks, see [`MarkOffset`].
    LayerScatter,
    /// Lateral spread of light in the layer beyond the assumed one, mm; it moves marks as well.
    LayerSpread,
    /// Parameter of the camera, by its name in [`Camera::parameters`].
    Camera(&'static str),
    /// Deviation of the dome in one capture, by the capture's index.
    Reseating(usize, MountingError),
}

impl FitParameter {
    /// Six parameters of a pose, in the order of [`POSE_PARAMETERS`]: rotation, then translation.
    pub const POSE: [Self; 6] = [
        Self::Rotation(Axis::X),
        Self::Rotation(Axis::Y),
        Self::Rotation(Axis::Z),
        Self::Translation(Axis::X),
        Self::Translation(Axis::Y),
        Self::Translation(Axis::Z),
    ];

    /// Parameters of a drawn interface that its drawing leaves uncertain.
    pub const DRAWN_INTERFACE: [Self; 2] =
        [Self::InterfaceShift, Self::Camera("interface_index_outside")];

    /// Parameters of the light that move marks.
    pub const LIGHT: [Self; 2] = [Self::LayerScatter, Self::LayerSpread];

    /// Returns the standard deviation of what is known before any image is taken, in the parameter's unit. Assembly
    /// holds the camera to a few degrees and millimetres, a pin stops within 2 mm, a lens is within a few tens of
    /// percent of its data sheet. A combination of parameters about which images say little more than this is called
    /// not observable.
    pub fn prior_sigma(self) -> f64 {
        match self {
            Self::Rotation(_) => 0.1,
            Self::Translation(_) => 5.0,
            Self::SeatingOffset => 2.0,
            Self::Lean => 1.0,
            Self::FocalScale => 0.3,
            Self::InterfaceShift => drawn_interface::PLACE_SIGMA_MM,
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
    /// Describes the parameter for people: `the camera's distance (translation_z_mm)`.
    pub fn description(self) -> String {
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

/// Contact of a pin that is pushed home in one hole, in one capture.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Index of the capture, from 0.
    pub capture: usize,
    /// Number of the hole.
    pub hole: u32,
    /// Nominal contact, sensor frame, mm.
    pub contact_in_sensor_mm: Point3<f64>,
    /// Direction in which the pin is pushed, if known; unit length.
    pub axis_in_sensor: Option<Vector3<f64>>,
}

/// Contact with its observed mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Contact that made the mark.
    pub contact: Contact,
    /// Observed position of the mark, px.
    pub pixel: Point2<f64>,
    /// Standard deviation of each coordinate, px.
    pub sigma_px: f64,
}

/// Measurement model: all parameters between contacts and pixels.
///
/// ```
/// use fabkit_calibration::model::{Contact, Model};
/// use fabkit_geometry::{Point3, Pose};
/// let camera = fabkit_camera::Camera::equidistant(640, 480, 2.8).unwrap();
/// let model = Model::new(camera, Pose::translation(0.0, 0.0, 7.0));
/// let tip = Point3::new(0.0, 0.0, 15.0); // 22 mm in front of the lens
/// let pin = Contact { capture: 0, hole: 1, contact_in_sensor_mm: tip, axis_in_sensor: None };
/// assert_eq!(model.project(&pin), Ok(fabkit_camera::Point2::new(319.5, 239.5)));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Camera with its interface.
    pub camera: Camera,
    /// Pose: sensor frame to camera frame, mm.
    pub camera_from_sensor: Pose,
    /// Value of [`FitParameter::SeatingOffset`].
    pub seating_offset_mm: f64,
    /// Value of [`FitParameter::Lean`].
    pub lean_mm: f64,
    /// Translation of the pose by design, mm, if it takes part in a fit as prior knowledge; see
    /// [`FitParameter::prior_sigma`].
    pub expected_translation_mm: Option<Vector3<f64>>,
    /// Shift in x and y, mm, and turn, rad, of the dome in each capture; later captures have none.
    pub reseatings: Vec<[f64; 3]>,
    /// Interface that the design draws, if the camera's interface is that one. It is fixed in the sensor, and the
    /// camera's interface follows from the pose.
    pub drawn_interface: Option<DrawnInterface>,
    /// Value of [`FitParameter::InterfaceShift`].
    pub interface_shift_mm: f64,
    /// Value of [`FitParameter::LayerScatter`].
    pub layer_scatter_log: f64,
    /// Value of [`FitParameter::LayerSpread`].
    pub layer_spread_mm: f64,
    /// Apparent displacements of contacts, because bodies behind the camera's interface refract light again. Contacts
    /// that are not listed have none.
    pub displacements: ApparentDisplacements,
    /// Offsets of marks from the pixels of their tips. Contacts that are not listed have none.
    pub mark_offsets: MarkOffsets,
}

/// Offset of a pin's mark from the pixel of its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkOffset {
    /// Offset, px.
    pub offset_px: Vector2<f64>,
    /// Derivative by the pin's depth, px/mm.
    pub by_depth: Vector2<f64>,
    /// Derivatives by each of [`FitParameter::LIGHT`], px per unit of the parameter.
    pub by_light: [Vector2<f64>; 2],
    /// Standard deviation of each coordinate, px.
    pub sigma_px: f64,
}

/// Offsets of marks, by the nominal contacts of their pins, sensor frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkOffsets(BTreeMap<[u64; 3], MarkOffset>);

impl MarkOffsets {
    /// Creates the map from nominal contacts, sensor frame, mm, and their offsets.
    pub fn new(all: impl IntoIterator<Item = (Point3<f64>, MarkOffset)>) -> Self {
        Self(all.into_iter().map(|(place, offset)| (key(&place), offset)).collect())
    }

    /// Returns the offset of a nominal contact, if it has one.
    pub fn offset_at(&self, place: &Point3<f64>) -> Option<MarkOffset> {
        self.0.get(&key(place)).copied()
    }

    /// Returns whether there are no offsets.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Apparent displacements, mm, by nominal contacts, sensor frame, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ApparentDisplacements(BTreeMap<[u64; 3], Vector3<f64>>);

impl ApparentDisplacements {
    /// Creates the map from nominal contacts and their displacements, both sensor frame, mm.
    pub fn new(all: impl IntoIterator<Item = (Point3<f64>, Vector3<f64>)>) -> Self {
        Self(all.into_iter().map(|(place, by)| (key(&place), by)).collect())
    }

    fn displacement_at(&self, place: &Point3<f64>) -> Vector3<f64> {
        if self.0.is_empty() {
            Vector3::zeros()
        } else {
            self.0.get(&key(place)).copied().unwrap_or_default()
        }
    }
}

// Bit patterns make coordinates comparable: contacts are looked up by exactly the numbers that were put in.
fn key(place: &Point3<f64>) -> [u64; 3] {
    [place.x, place.y, place.z].map(f64::to_bits)
}

impl Model {
    /// Creates the model of a camera at a pose, with all pins at their nominal places.
    pub fn new(camera: Camera, camera_from_sensor: Pose) -> Self {
        Self {
            camera,
            camera_from_sensor,
            seating_offset_mm: 0.0,
            lean_mm: 0.0,
            expected_translation_mm: None,
            reseatings: Vec::new(),
            drawn_interface: None,
            interface_shift_mm: 0.0,
            layer_scatter_log: 0.0,
            layer_spread_mm: 0.0,
            displacements: ApparentDisplacements::default(),
            mark_offsets: MarkOffsets::default(),
        }
    }

    /// Returns the same model with the drawn interface at its drawn place; `None` if no such camera exists.
    #[must_use]
    pub fn with_drawn_interface(mut self, drawn: &DrawnInterface) -> Option<Self> {
        self.drawn_interface = Some(*drawn);
        self.interface_shift_mm = 0.0;
        self.camera = self.camera_with_drawn_interface(drawn.index_outside())?;
        Some(self)
    }

    /// Returns the camera with the drawn interface at its place relative to the camera's pose.
    fn camera_with_drawn_interface(&self, index_outside: f64) -> Option<Camera> {
        let Some(drawn) = &self.drawn_interface else { return Some(self.camera) };
        let pose = &self.camera_from_sensor;
        let interface = drawn.interface_at(pose, self.interface_shift_mm, index_outside);
        let [width_px, height_px] = [self.camera.width_px(), self.camera.height_px()];
        Camera::new(width_px, height_px, *self.camera.lens(), interface).ok()
    }

    /// Refractive index behind the camera's interface, if it has one.
    fn index_outside(&self) -> Option<f64> {
        match self.camera.interface() {
            Interface::None | Interface::FromDrawing => None,
            Interface::Flat(flat) => Some(flat.index_outside),
            Interface::Sphere(sphere) => Some(sphere.index_outside),
        }
    }

    /// Computes the pixel of a contact's mark.
    ///
    /// # Errors
    /// Fails if the contact lies outside what the camera can see.
    pub fn project(&self, contact: &Contact) -> Result<Point2<f64>, OutsideDomain> {
        let tip =
            self.camera.project(&self.camera_from_sensor.point(self.displaced_contact(contact)))?;
        Ok(tip + self.mark_offset(contact))
    }

    /// Computes [`Model::project`] with its derivatives by each of `parameters`, px per unit, into `columns`.
    ///
    /// # Errors
    /// Fails as [`Model::project`].
    pub fn differentiate(
        &self,
        contact: &Contact,
        parameters: &[FitParameter],
        columns: &mut [Vector2<f64>],
    ) -> Result<Point2<f64>, OutsideDomain> {
        let seated = self.displaced_contact(contact);
        let point = self.camera_from_sensor.point(seated);
        let projection = self.camera.project_with_jacobians(&point)?;
        // The pose and the shift also move a drawn interface in front of the lens.
        let turned = point - self.camera_from_sensor.translation_mm();
        let by_interface = self.pixel_by_interface(&projection.by_parameters);
        let of_mark = self.mark_offsets.offset_at(&contact.contact_in_sensor_mm);
        let by_sensor: Matrix2x3<f64> = projection.by_point * self.camera_from_sensor.rotation();
        let intrinsics = self.camera.lens().intrinsics();
        let turn = self.reseatings.get(contact.capture).map_or(0.0, |[_, _, turn]| *turn);
        // First order in the turn, as in `seated`.
        let turned_with_dome = |v: Vector3<f64>| v + turn * Vector3::z().cross(&v);
        for (column, parameter) in columns.iter_mut().zip(parameters) {
            // Each derivative follows the chain of `project`: seat and displacement, pose, lens, offset of the mark.
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
                    by_sensor * turned_with_dome(tangent_around_axis(contact.contact_in_sensor_mm))
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
                    by_sensor * Vector3::z().cross(&self.contact_before_reseating(contact).coords)
                }
            };
        }
        Ok(projection.pixel + self.mark_offset(contact))
    }

    /// Computes the derivative of a mark's pixel by its contact in the sensor frame, px/mm.
    ///
    /// # Errors
    /// Fails as [`Model::project`].
    pub fn pixel_by_contact(&self, contact: &Contact) -> Result<Matrix2x3<f64>, OutsideDomain> {
        let point = self.camera_from_sensor.point(self.displaced_contact(contact));
        let projection = self.camera.project_with_jacobians(&point)?;
        Ok(projection.by_point * self.camera_from_sensor.rotation())
    }

    /// Computes the offset of a contact's mark with the present depth and light, px.
    fn mark_offset(&self, contact: &Contact) -> Vector2<f64> {
        self.mark_offsets.offset_at(&contact.contact_in_sensor_mm).map_or_else(
            Vector2::zeros,
            |offset| {
                let [scatter, spread] = offset.by_light;
                offset.offset_px
                    + self.seating_offset_mm * offset.by_depth
                    + self.layer_scatter_log * scatter
                    + self.layer_spread_mm * spread
            },
        )
    }

    /// Computes the derivative of a pixel by pose and shift through the drawn interface, which both move in front of
    /// the lens.
    fn pixel_by_interface(&self, by_parameters: &[Vector2<f64>]) -> SMatrix<f64, 2, 7> {
        let Some(drawn) = &self.drawn_interface else { return SMatrix::zeros() };
        let by_pose = drawn.interface_by_pose(&self.camera_from_sensor, self.interface_shift_mm);
        let of_lens = INTRINSICS + self.camera.lens().coefficient_names().len();
        let of_interface = by_parameters.iter().skip(of_lens);
        let parts = of_interface.zip(by_pose.row_iter()).map(|(pixel, row)| pixel * row);
        parts.sum()
    }

    /// Returns the model with each parameter changed by its step; `None` if no such camera exists.
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
                        // Captures without a step keep their nominal seat.
                        next.reseatings.resize(capture + 1, [0.0; 3]);
                    }
                    next.reseatings[*capture][*seat as usize] += step;
                }
            }
        }
        // All camera parameters at once: between two single steps the camera may be invalid.
        if let Some(values) = values {
            next.camera = self.camera.with_parameters(&values).ok()?;
        }
        let rotation: Matrix3<f64> =
            Rotation3::new(turn).matrix() * self.camera_from_sensor.rotation();
        next.camera_from_sensor = Pose::new(rotation, shift)?;
        // The drawn interface follows the new pose and shift, with the index just stepped.
        if let Some(index_outside) = next.index_outside().filter(|_| next.drawn_interface.is_some())
        {
            next.camera = next.camera_with_drawn_interface(index_outside)?;
        }
        Some(next)
    }

    /// Returns the value of a parameter, in its unit. Rotations are the components of the rotation vector of the whole
    /// pose. A focal scale is relative to the camera's own focal length, hence 0. `None` for a parameter that the
    /// camera does not have.
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

    /// Computes the contact in the sensor frame with everything that displaces it, mm.
    pub fn displaced_contact(&self, contact: &Contact) -> Point3<f64> {
        let displaced = self.contact_before_reseating(contact);
        let Some([x, y, turn]) = self.reseatings.get(contact.capture) else {
            return displaced;
        };
        displaced + Vector3::new(*x, *y, 0.0) + *turn * Vector3::z().cross(&displaced.coords)
    }

    /// Returns a parameter's deviation from its prior value and the prior's standard deviation, if the prior takes part
    /// in a fit. A dome's seat has more unknowns than its few pins can fix, and the camera is at its designed place up
    /// to assembly errors.
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
                let away = self.index_outside()? - self.drawn_interface.as_ref()?.index_outside();
                return Some((away, drawn_interface::INDEX_SIGMA));
            }
            _ => return None,
        };
        Some((away, parameter.prior_sigma()))
    }

    /// Returns whether a parameter has a prior: that of the drawing, or that of the light.
    pub(crate) fn has_drawing_prior(&self, parameter: FitParameter) -> bool {
        self.drawn_interface.is_some() && FitParameter::DRAWN_INTERFACE.contains(&parameter)
            || FitParameter::LIGHT.contains(&parameter)
    }

    fn contact_before_reseating(&self, contact: &Contact) -> Point3<f64> {
        contact.contact_in_sensor_mm
            + self.displacements.displacement_at(&contact.contact_in_sensor_mm)
            + self.seating_offset_mm * contact.axis_in_sensor.unwrap_or_default()
            + self.lean_mm * tangent_around_axis(contact.contact_in_sensor_mm)
    }

    fn camera_index(&self, name: &str) -> Option<usize> {
        self.camera.parameters().iter().position(|(found, _)| *found == name)
    }
}

/// Returns the tangential unit vector around the sensor's z axis; zero close to the axis.
fn tangent_around_axis(point: Point3<f64>) -> Vector3<f64> {
    let radius_mm = point.x.hypot(point.y);
    if radius_mm < ON_AXIS_MM {
        return Vector3::zeros();
    }
    Vector3::new(-point.y, point.x, 0.0) / radius_mm
}
