//! Projection of points of a sensor into its camera's image through the sensor's bodies, with the reason where a point
//! is not visible.

use fabkit_camera::Point2;
use fabkit_geometry::{Point3, Ray};
use fabkit_optics::{CameraView, InvisibleReason, OpticalStack, Tracer, ViewStacks};

use super::Viewpoint;

/// Tolerance within which a ray counts as reaching a point, mm.
const ARRIVAL_TOLERANCE_MM: f64 = 1e-6;

/// Distance at which a ray counts as passing through a point, mm: ten times the rounding error of the aiming.
const AIMING_TOLERANCE_MM: f64 = 1e-9;

/// Maximum number of aiming iterations. Each reduces the miss about tenfold.
const MOST_AIMS: usize = 24;

/// Number of points that one worker looks at in sequence. The solution for one point starts the search for the next, so
/// the order of points must not depend on the number of threads.
pub(super) const POINTS_PER_CHUNK: usize = 1_024;

/// Projector of points, one after the other.
pub(super) enum Projector<'a> {
    /// A bare lens: bodies refract its rays.
    Lens(Box<CameraView<'a>>),
    /// A camera whose model contains all refraction: bodies can only block rays.
    Model(&'a Viewpoint, Box<Tracer<'a>>),
    /// A camera whose model contains the first interface: bodies behind it refract its rays.
    Behind(Box<InterfaceProjector<'a>>),
}

impl<'a> Projector<'a> {
    pub(super) fn new(viewpoint: &'a Viewpoint, sights: &'a ViewStacks) -> Self {
        let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
        match viewpoint.is_bare_lens() {
            true => Self::Lens(Box::new(CameraView::new(camera, pose, sights))),
            false if sights.stack().starts_behind_interface() => {
                Self::Behind(Box::new(InterfaceProjector {
                    viewpoint,
                    stack: sights.stack(),
                    clear: sights.media_tracer(),
                    all: Tracer::new(sights.stack()),
                }))
            }
            false => Self::Model(viewpoint, Box::new(Tracer::new(sights.stack()))),
        }
    }

    /// Projects a point, sensor frame, mm, to its pixel, or returns why it is not visible.
    pub(super) fn look(&mut self, place: &Point3<f64>) -> Result<Point2<f64>, InvisibleReason> {
        match self {
            Self::Lens(viewer) => viewer.visible_pixel(place),
            Self::Model(viewpoint, tracer) => project_with_model(viewpoint, tracer, place),
            Self::Behind(behind) => behind.look(place),
        }
    }

    /// Projects a point whether or not it lies inside the image or is hidden. Returns `None` where the lens maps no
    /// direction, or no light arrives.
    pub(super) fn project(&mut self, place: &Point3<f64>) -> Option<Point2<f64>> {
        match self {
            Self::Lens(viewer) => viewer.project(place).ok().map(|look| look.pixel),
            Self::Model(viewpoint, _) => {
                let point = viewpoint.sensor_from_camera.inverse().point(*place);
                viewpoint.camera().project(&point).ok()
            }
            Self::Behind(behind) => Some(behind.aim(place)?.0),
        }
    }
}

/// A camera with the first interface in its own model, and the bodies behind that interface.
pub(super) struct InterfaceProjector<'a> {
    viewpoint: &'a Viewpoint,
    stack: &'a OpticalStack,
    /// Tracers through clear media only, for aiming, and through all bodies, for blocking.
    clear: Tracer<'a>,
    all: Tracer<'a>,
}

impl InterfaceProjector<'_> {
    /// Finds the pixel whose ray passes through a point, and that ray. Returns `None` where the lens maps no direction,
    /// or no ray passes the point.
    ///
    /// Fixed-point iteration: the displacement by the bodies behind the interface hardly depends on the aim, so each
    /// step shifts the aim by the last miss.
    fn aim(&mut self, place: &Point3<f64>) -> Option<(Point2<f64>, Ray)> {
        let (camera, pose) = (self.viewpoint.camera(), &self.viewpoint.sensor_from_camera);
        let camera_from_sensor = pose.inverse();
        let mut at = *place;
        for _ in 0..MOST_AIMS {
            let pixel = camera.project(&camera_from_sensor.point(at)).ok()?;
            let ray = camera.unproject(&pixel).ok()?;
            let (origin, direction) =
                (pose.point(ray.origin_in_camera), pose.vector(ray.direction));
            let ray = self.stack.enter(&Ray { origin, direction });
            let last = self.clear.follow(&ray).last;
            // The miss is the vector from the foot of the perpendicular on the ray to the point.
            let off = place - last.at((place - last.origin).dot(&last.direction));
            if off.norm() < AIMING_TOLERANCE_MM {
                return Some((pixel, ray));
            }
            at += off;
        }
        None
    }

    fn look(&mut self, place: &Point3<f64>) -> Result<Point2<f64>, InvisibleReason> {
        let (pixel, ray) = self.aim(place).ok_or(InvisibleReason::Refraction)?;
        if !self.viewpoint.camera().is_in_image(&pixel) {
            return Err(InvisibleReason::OutsideImage);
        }
        // First leg, from the pupil to the camera's own interface: only blocking matters.
        let pupil = self.viewpoint.sensor_from_camera.point(Point3::origin());
        let to = ray.origin - pupil;
        if let Some(direction) = to.try_normalize(0.0) {
            let path = self.all.follow(&Ray { origin: pupil, direction });
            if path.lead_mm + path.end_mm < to.norm() - ARRIVAL_TOLERANCE_MM {
                return Err(InvisibleReason::from_end(path.end));
            }
        }
        // Second leg, behind the interface. Whatever blocks the ray before its last refraction also ends it before the
        // point.
        let path = self.all.follow(&ray);
        let left_mm = (place - path.last.origin).dot(&path.last.direction);
        if path.end_mm < left_mm - ARRIVAL_TOLERANCE_MM {
            return Err(InvisibleReason::from_end(path.end));
        }
        Ok(pixel)
    }
}

/// Returns the pixel of each point, column and row. `None` stands for points outside the image and for points from
/// which no light reaches the camera. Points hidden by opaque bodies have a pixel.
///
/// ```
/// use fabkit_geometry::Point3;
/// use fabkit_scene::ground_truth::project_points;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([640, 480])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let apex = Point3::new(0.0, 0.0, scene.touch()?.apex_z_mm());
/// let behind = Point3::new(0.0, 0.0, -50.0);
/// let pixels = project_points(&scene.viewpoint, scene.sights(), &[Some(apex), Some(behind), None]);
/// let [column, row] = pixels[0].ok_or("outside the image")?;
/// assert!((column - 319.5).abs() < 1e-6 && (row - 239.5).abs() < 1e-6);
/// assert_eq!(pixels[1..], [None, None]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn project_points(
    viewpoint: &Viewpoint,
    sights: &ViewStacks,
    places: &[Option<Point3<f64>>],
) -> Vec<Option<[f64; 2]>> {
    let mut looking = Projector::new(viewpoint, sights);
    let camera = viewpoint.camera();
    let pixel = |place: &Option<Point3<f64>>| {
        let pixel = looking.project(place.as_ref()?)?;
        camera.is_in_image(&pixel).then_some([pixel.x, pixel.y])
    };
    places.iter().map(pixel).collect()
}

/// Returns for each point whether it is visible: inside the image, and not behind an opaque body.
///
/// ```
/// use fabkit_geometry::Point3;
/// use fabkit_scene::ground_truth::are_visible;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([640, 480])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let apex_z_mm = scene.touch()?.apex_z_mm();
/// // The apex, a point behind the camera, and a point of unknown place.
/// let places = [Some(Point3::new(0.0, 0.0, apex_z_mm)), Some(Point3::new(15.0, 0.0, -40.0)), None];
/// assert_eq!(are_visible(&scene.viewpoint, scene.sights(), &places), [true, false, false]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn are_visible(
    viewpoint: &Viewpoint,
    sights: &ViewStacks,
    places: &[Option<Point3<f64>>],
) -> Vec<bool> {
    let mut looking = Projector::new(viewpoint, sights);
    places.iter().map(|place| place.is_some_and(|place| looking.look(&place).is_ok())).collect()
}

fn project_with_model(
    viewpoint: &Viewpoint,
    tracer: &mut Tracer,
    place: &Point3<f64>,
) -> Result<Point2<f64>, InvisibleReason> {
    let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
    let pixel = camera.project(&pose.inverse().point(*place)).ok();
    let pixel =
        pixel.filter(|pixel| camera.is_in_image(pixel)).ok_or(InvisibleReason::OutsideImage)?;
    let ray = camera.unproject(&pixel).map_err(|_| InvisibleReason::OutsideImage)?;
    // Two straight legs: from the pupil to where the ray leaves the camera's own interface, and from there to the
    // point.
    let (pupil, start) = (pose.point(Point3::origin()), pose.point(ray.origin_in_camera));
    for (from, to) in [(pupil, start), (start, *place)] {
        let Some(direction) = (to - from).try_normalize(0.0) else { continue };
        let path = tracer.follow(&Ray { origin: from, direction });
        if path.lead_mm + path.end_mm < (to - from).norm() - ARRIVAL_TOLERANCE_MM {
            return Err(InvisibleReason::from_end(path.end));
        }
    }
    Ok(pixel)
}
