//! Detection of the single interface that refracts a camera's rays, if the drawn bodies form one.
//!
//! Camera calibration fits a lens behind a plane, a pane or a sphere (`camera/`). Which of them a design draws, and
//! where, is found from the rays that reach its sensing surface.

use fabkit_camera::{Camera, FlatInterface, Interface, Point2, SphericalInterface};
use fabkit_geometry::{Point3, Pose, Ray, Vector3};

use crate::error::InvalidStack;
use crate::inverse::{SightLineSolver, ViewStacks};
use crate::last_face::LastFace;
use crate::stack::OpticalStack;
use crate::trace::{RayEnd, Refraction};
use crate::viewer::CameraView;

/// Number of rays along the longer side of the image.
const RAYS: u32 = 48;
/// Tolerance within which points lie in a common plane or sphere, mm, and within which unit normals are equal. Both are
/// computed a thousand times more precisely.
const TOLERANCE: f64 = 1e-6;
/// Number of pairs of rays from which an interface is guessed.
const MAX_GUESSES: usize = 24;
/// Minimum share of the rays that must pass one interface for it to represent all.
const MIN_SHARE: f64 = 0.9;

/// Refracting interface between a camera and its sensing surface.
///
/// ```
/// # use fabkit_geometry::{Angle, Assembly, Body, FixtureGrip, MaterialProperties, NominalCamera};
/// # use fabkit_geometry::{OpticalClarity, Path, Placement, PlaneSurface, Pose, Sensor, Solid};
/// # let nominal = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 64, height_px: 48,
/// #     field_of_view: Angle::from_deg(60.0).unwrap(), lens: Default::default(),
/// # };
/// # let outline = Path::circle([0.0, 0.0], 20.0);
/// # let grip = FixtureGrip {
/// #     outline: outline.clone(), top_z_mm: 0.0, bottom_z_mm: -9.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// # let touch = PlaneSurface { outline, top_z_mm: 11.0, foot_z_mm: 10.0, max_indentation_mm: 1.0, grip };
/// # let skin = Body::cast("skin", "", Solid::cylinder(20.0, 1.0).at(0.0, 0.0, 10.0)).as_deformable();
/// # let mut pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
/// #     .with_clarity(OpticalClarity::Clear);
/// # pane.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
/// # let [skin, pane] = [skin, pane].map(|body| body.placed([Placement::in_place(Assembly::sensor())]));
/// use fabkit_camera::{Camera, Interface};
/// use fabkit_optics::{FirstInterface, OpticalStack, ViewStacks};
///
/// // A pane of glass, 2 mm thick, 5 mm before the camera; behind it, in air, the skin that is touched.
/// let mut sensor = Sensor::new("window", "A window", "", nominal, [pane, skin]);
/// sensor.touch = Some(touch.into());
/// let sights = ViewStacks::new(OpticalStack::from_sensor(&sensor)?);
/// let camera = Camera::equidistant(64, 48, 60_f64.to_radians())?;
/// let found = FirstInterface::from_camera(&camera, &Pose::identity(), &sights);
/// let FirstInterface::Single { interface: Interface::Flat(flat), share, again } = found else { panic!() };
/// assert!((flat.distance_mm - 5.0).abs() < 1e-6 && (flat.glass_thickness_mm - 2.0).abs() < 1e-6);
/// assert_eq!((flat.index_glass, share, again), (1.5, 1.0, false));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstInterface {
    /// No ray reaches the sensing surface.
    NothingVisible,
    /// One interface comes first.
    Single {
        /// Interface in the camera's frame; [`Interface::None`] if nothing refracts the rays.
        interface: Interface,
        /// Share of the rays to the surface that pass it; the others are refracted differently.
        share: f64,
        /// True if rays are refracted again behind it. See [`FirstInterface::displacement`].
        again: bool,
    },
    /// Several interfaces, or one that is not a plane, a pane or a sphere.
    Other,
}

impl FirstInterface {
    /// Finds the interface that the drawn bodies form between a lens and the sensing surface.
    ///
    /// `camera` must be a lens alone, as for [`CameraView::new`].
    pub fn from_camera(camera: &Camera, sensor_from_camera: &Pose, sights: &ViewStacks) -> Self {
        let rays = rays_to_surface(camera, sensor_from_camera, sights);
        if rays.is_empty() {
            return Self::NothingVisible;
        }
        let stride = rays.len().div_ceil(MAX_GUESSES);
        let guesses = (0..rays.len()).step_by(stride);
        // Each ray is paired with one far away in the list, so that their normals differ.
        let pairs = guesses.map(|i| (&rays[i], &rays[(i + rays.len() / 2) % rays.len()]));
        let counted =
            pairs.filter_map(|(ray, other)| InterfaceCandidate::guess(ray, other)).map(|faces| {
                let passing = rays.iter().filter(|bends| faces.are_passed_by(bends)).count();
                (passing, faces)
            });
        let best = counted.reduce(|best, next| if next.0 > best.0 { next } else { best });
        let Some((passing, faces)) = best else { return Self::Other };
        let share = passing as f64 / rays.len() as f64;
        if share < MIN_SHARE {
            return Self::Other;
        }
        let again = rays.iter().any(|bends| bends.len() > faces.indices.len());
        Self::Single { interface: drawn_behind(faces.interface, again), share, again }
    }

    /// Computes the apparent displacement of a point if only the first interface is known, mm: from the point to the
    /// line that its ray follows behind that interface. `None` if no light from the point reaches the pupil.
    pub fn displacement(
        &self,
        pupil: &Point3<f64>,
        place_in_sensor: &Point3<f64>,
        seeker: &mut SightLineSolver<'_>,
    ) -> Option<Vector3<f64>> {
        let Self::Single { interface, again: true, .. } = self else {
            return Some(Vector3::zeros());
        };
        // Number of faces of the first interface.
        let faces = match interface {
            Interface::None | Interface::FromDrawing => 0,
            Interface::Flat(flat) if flat.glass_thickness_mm > 0.0 => 2,
            Interface::Flat(_) | Interface::Sphere(_) => 1,
        };
        let sight = seeker.find_sight_line(pupil, place_in_sensor)?;
        let way = seeker.corners(pupil, place_in_sensor, &sight);
        let [from, to] = way.get(faces..faces + 2)? else { return None };
        let along = (to - from).normalize();
        let away = from - place_in_sensor;
        Some(away - along * along.dot(&away))
    }
}

/// Returns the interface with its flag for refraction behind it.
fn drawn_behind(interface: Interface, is_drawn_behind: bool) -> Interface {
    match interface {
        Interface::None | Interface::FromDrawing => interface,
        Interface::Flat(flat) => {
            Interface::Flat(FlatInterface { has_drawn_bodies_behind: is_drawn_behind, ..flat })
        }
        Interface::Sphere(sphere) => Interface::Sphere(SphericalInterface {
            has_drawn_bodies_behind: is_drawn_behind,
            ..sphere
        }),
    }
}

impl OpticalStack {
    /// Returns the stack for a camera whose own model contains the first drawn interface, near its drawn place. Rays
    /// then begin behind that interface, and only the bodies behind it refract them. See [`OpticalStack::enter`].
    ///
    /// # Errors
    /// [`InvalidStack::NoInterface`].
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Pose, Sensor};
    /// # let camera = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_optics::{FirstInterface, InvalidStack, OpticalStack};
    ///
    /// // Where nothing is drawn there is no interface to begin behind.
    /// let stack = OpticalStack::from_sensor(&Sensor::new("air", "Air", "", camera, []))?;
    /// assert!(!stack.starts_behind_interface());
    /// let behind = stack.starting_behind(&FirstInterface::NothingVisible, &Pose::identity());
    /// assert_eq!(behind.unwrap_err(), InvalidStack::NoInterface);
    /// # Ok::<(), fabkit_optics::InvalidStack>(())
    /// ```
    pub fn starting_behind(
        mut self,
        window: &FirstInterface,
        sensor_from_camera: &Pose,
    ) -> Result<Self, InvalidStack> {
        let last = match window {
            FirstInterface::Single { interface, .. } => {
                LastFace::from_interface(interface, sensor_from_camera)
            }
            FirstInterface::NothingVisible | FirstInterface::Other => None,
        };
        self.modelled_face = Some(last.ok_or(InvalidStack::NoInterface)?);
        Ok(self)
    }

    /// Returns whether rays begin behind the first interface.
    pub fn starts_behind_interface(&self) -> bool {
        self.modelled_face.is_some()
    }

    /// Moves a ray that leaves a camera to where it can be traced from: behind the first drawn interface, if the
    /// camera's model contains it (see [`OpticalStack::starting_behind`]). Otherwise returns the ray itself.
    pub fn enter(&self, ray: &Ray) -> Ray {
        self.modelled_face.as_ref().map_or(*ray, |face| face.advance(ray))
    }
}

/// Returns the refractions of the rays that end at the sensing surface, for a lattice of pixels, in the camera's frame.
fn rays_to_surface(
    camera: &Camera,
    sensor_from_camera: &Pose,
    sights: &ViewStacks,
) -> Vec<Vec<Refraction>> {
    let mut viewer = CameraView::new(camera, sensor_from_camera, sights);
    let camera_from_sensor = sensor_from_camera.inverse();
    let size = [camera.width_px(), camera.height_px()].map(f64::from);
    let step = size[0].max(size[1]) / f64::from(RAYS);
    let lattice = |size: f64| {
        (0..RAYS).map(move |i| (f64::from(i) + 0.5) * step - 0.5).take_while(move |at| *at < size)
    };
    let mut rays = Vec::new();
    for (y, x) in lattice(size[1]).flat_map(|y| lattice(size[0]).map(move |x| (y, x))) {
        if viewer.path(&Point2::new(x, y)).is_ok_and(|path| path.end == RayEnd::Surface) {
            let in_camera = |bend: &Refraction| Refraction {
                place: camera_from_sensor.point(bend.place),
                normal: camera_from_sensor.vector(bend.normal),
                ..*bend
            };
            rays.push(viewer.bends().iter().map(in_camera).collect());
        }
    }
    rays
}

/// Candidate interface, with the refractive indices of its faces.
struct InterfaceCandidate {
    interface: Interface,
    indices: Vec<[f64; 2]>,
}

impl InterfaceCandidate {
    /// Guesses the interface that two rays pass first, if they pass the same one.
    fn guess(ray: &[Refraction], other: &[Refraction]) -> Option<Self> {
        let Some((face, first)) = ray.first().zip(other.first()) else {
            let both = ray.is_empty() && other.is_empty();
            return both.then_some(Self { interface: Interface::None, indices: Vec::new() });
        };
        let behind = ray.get(1).zip(other.get(1)).filter(|(back, next)| {
            are_parallel(face, back) && are_parallel(back, next) && are_parallel(face, first)
        });
        let (interface, faces) = match behind {
            Some((back, _)) => (Interface::Flat(flat(face, Some(back))?), 2),
            None if are_parallel(face, first) => (Interface::Flat(flat(face, None)?), 1),
            None => (Interface::Sphere(sphere(face, first)?), 1),
        };
        let indices = ray[..faces].iter().map(|bend| bend.indices).collect();
        Some(Self { interface, indices })
    }

    /// Returns whether a ray passes the faces of the candidate first.
    fn are_passed_by(&self, bends: &[Refraction]) -> bool {
        let first = bends.get(..self.indices.len()).unwrap_or_default();
        if !first.iter().map(|bend| bend.indices).eq(self.indices.iter().copied()) {
            return false;
        }
        match &self.interface {
            Interface::None | Interface::FromDrawing => bends.is_empty(),
            Interface::Sphere(sphere) => first.iter().all(|bend| {
                let from_centre = bend.place - sphere.centre_in_camera;
                (from_centre.norm() - sphere.radius_mm).abs() < TOLERANCE
            }),
            Interface::Flat(plane) => {
                let normal = plane.normal();
                let depths = [plane.distance_mm, plane.distance_mm + plane.glass_thickness_mm];
                first.iter().zip(depths).all(|(bend, depth)| {
                    (normal.dot(&bend.place.coords) - depth).abs() < TOLERANCE
                        && normal.cross(&bend.normal).norm() < TOLERANCE
                })
            }
        }
    }
}

/// Returns whether two normals are parallel.
fn are_parallel(a: &Refraction, b: &Refraction) -> bool {
    a.normal.cross(&b.normal).norm() < TOLERANCE
}

/// Builds a plane, or a pane if there is a second face.
fn flat(face: &Refraction, back: Option<&Refraction>) -> Option<FlatInterface> {
    // Normals point away from the lens.
    let outward = |bend: &Refraction| bend.normal * bend.normal.dot(&bend.place.coords).signum();
    let normal = outward(face);
    let distance_mm = normal.dot(&face.place.coords);
    let last = back.unwrap_or(face);
    let flat = FlatInterface {
        distance_mm,
        tilt_x_rad: (-normal.y).atan2(normal.z),
        tilt_y_rad: normal.x.clamp(-1.0, 1.0).asin(),
        index_inside: face.indices[0],
        index_outside: last.indices[1],
        glass_thickness_mm: normal.dot(&last.place.coords) - distance_mm,
        index_glass: face.indices[1],
        has_drawn_bodies_behind: false,
    };
    (distance_mm > 0.0 && flat.glass_thickness_mm >= 0.0).then_some(flat)
}

/// Builds the sphere around the lens from two points with normals that are not parallel.
fn sphere(a: &Refraction, b: &Refraction) -> Option<SphericalInterface> {
    let across = a.normal.cross(&b.normal);
    // Distance along the first normal at which it comes closest to the second: the centre of the sphere.
    let along = (b.place - a.place).cross(&b.normal).dot(&across) / across.norm_squared();
    let centre: Point3<f64> = a.place + a.normal * along;
    let sphere = SphericalInterface {
        centre_in_camera: centre,
        radius_mm: along.abs(),
        index_inside: a.indices[0],
        index_outside: a.indices[1],
        has_drawn_bodies_behind: false,
    };
    let outward: Vector3<f64> = (a.place - centre) / along.abs();
    // Only a sphere that contains the lens is accepted.
    (centre.coords.norm() < sphere.radius_mm && outward.dot(&a.place.coords) > 0.0)
        .then_some(sphere)
}
