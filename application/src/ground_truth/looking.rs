//! Where places of a sensor appear in the picture of its camera, and why some do not.

use fabkit_camera::Point2;
use fabkit_geometry::{Point3, Ray};
use fabkit_optics::{Lost, Sights, Tracer, Viewer};

use super::Viewpoint;

/// A ray that ends that near to a place ends there, mm.
const THERE_MM: f64 = 1e-6;

/// Places that are looked at one after the other. What leads to one place is tried for the next, so that who
/// comes after whom must not depend on threads.
pub(super) const AT_ONCE: usize = 1_024;

/// A way to look at places one after the other.
pub(super) enum Looking<'a> {
    /// A lens and nothing else: bodies bend what it sees.
    Lens(Box<Viewer<'a>>),
    /// A camera that knows by itself how light is bent on its way: bodies only hide.
    Model(&'a Viewpoint, Box<Tracer<'a>>),
}

impl<'a> Looking<'a> {
    pub(super) fn new(viewpoint: &'a Viewpoint, sights: &'a Sights) -> Self {
        let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
        match viewpoint.is_drawn() {
            true => Self::Lens(Box::new(Viewer::new(camera, pose, sights))),
            false => Self::Model(viewpoint, Box::new(Tracer::new(sights.stack()))),
        }
    }

    /// The pixel of a place, sensor frame, mm.
    pub(super) fn look(&mut self, place: &Point3<f64>) -> Result<Point2<f64>, Lost> {
        match self {
            Self::Lens(viewer) => viewer.see(place),
            Self::Model(viewpoint, tracer) => by_its_own_model(viewpoint, tracer, place),
        }
    }

    /// The same, inside the picture or not, hidden or not; `None` where the lens maps nothing, or no light
    /// arrives.
    pub(super) fn project(&mut self, place: &Point3<f64>) -> Option<Point2<f64>> {
        match self {
            Self::Lens(viewer) => viewer.look_at(place).ok().map(|look| look.pixel),
            Self::Model(viewpoint, _) => {
                let point = viewpoint.sensor_from_camera.inverse().point(*place);
                viewpoint.camera().project(&point).ok()
            }
        }
    }
}

/// The pixel of each place, column and row; nothing of those beside the picture and of those from which no light reaches the
/// camera. What opaque bodies hide has one.
pub(crate) fn pixels_of(
    viewpoint: &Viewpoint,
    sights: &Sights,
    places: &[Option<Point3<f64>>],
) -> Vec<Option<[f64; 2]>> {
    let mut looking = Looking::new(viewpoint, sights);
    let camera = viewpoint.camera();
    let pixel = |place: &Option<Point3<f64>>| {
        let pixel = looking.project(place.as_ref()?)?;
        camera.sees(&pixel).then_some([pixel.x, pixel.y])
    };
    places.iter().map(pixel).collect()
}

/// Whether each place is seen: in the picture, and nothing opaque before it.
pub(crate) fn are_seen(
    viewpoint: &Viewpoint,
    sights: &Sights,
    places: &[Option<Point3<f64>>],
) -> Vec<bool> {
    let mut looking = Looking::new(viewpoint, sights);
    places.iter().map(|place| place.is_some_and(|place| looking.look(&place).is_ok())).collect()
}

fn by_its_own_model(
    viewpoint: &Viewpoint,
    tracer: &mut Tracer,
    place: &Point3<f64>,
) -> Result<Point2<f64>, Lost> {
    let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
    let pixel = camera.project(&pose.inverse().point(*place)).ok();
    let pixel = pixel.filter(|pixel| camera.sees(pixel)).ok_or(Lost::BesidePicture)?;
    let ray = camera.unproject(&pixel).map_err(|_| Lost::BesidePicture)?;
    // From the pupil to where the camera's own interface lets the ray go, and from there.
    let (pupil, start) = (pose.point(Point3::origin()), pose.point(ray.origin_in_camera));
    for (from, to) in [(pupil, start), (start, *place)] {
        let Some(direction) = (to - from).try_normalize(0.0) else { continue };
        let path = tracer.follow(&Ray { origin: from, direction });
        if path.lead_mm + path.end_mm < (to - from).norm() - THERE_MM {
            return Err(Lost::at(path.end));
        }
    }
    Ok(pixel)
}
