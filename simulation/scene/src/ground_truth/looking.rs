//! Where places of a sensor appear in the picture of its camera, and why some do not.

use fabkit_camera::Point2;
use fabkit_geometry::{Point3, Ray};
use fabkit_optics::{Lost, Sights, Stack, Tracer, Viewer};

use super::Viewpoint;

/// A ray that ends that near to a place ends there, mm.
const THERE_MM: f64 = 1e-6;

/// A ray that passes a place that near goes there, mm: ten roundings of what aims at it.
const AIMED_MM: f64 = 1e-9;

/// Most times that a place is aimed at. Each comes nearer tenfold.
const MOST_AIMS: usize = 24;

/// Places that are looked at one after the other. What leads to one place is tried for the next, so that who
/// comes after whom must not depend on threads.
pub(super) const AT_ONCE: usize = 1_024;

/// A way to look at places one after the other.
pub(super) enum Looking<'a> {
    /// A lens and nothing else: bodies bend what it sees.
    Lens(Box<Viewer<'a>>),
    /// A camera that knows by itself how light is bent on its way: bodies only hide.
    Model(&'a Viewpoint, Box<Tracer<'a>>),
    /// A camera that knows that of the first interface: bodies behind that bend what it sees.
    Behind(Box<Behind<'a>>),
}

impl<'a> Looking<'a> {
    pub(super) fn new(viewpoint: &'a Viewpoint, sights: &'a Sights) -> Self {
        let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
        match viewpoint.is_drawn() {
            true => Self::Lens(Box::new(Viewer::new(camera, pose, sights))),
            false if sights.stack().is_entered() => Self::Behind(Box::new(Behind {
                viewpoint,
                stack: sights.stack(),
                clear: sights.media_tracer(),
                all: Tracer::new(sights.stack()),
            })),
            false => Self::Model(viewpoint, Box::new(Tracer::new(sights.stack()))),
        }
    }

    /// The pixel of a place, sensor frame, mm.
    pub(super) fn look(&mut self, place: &Point3<f64>) -> Result<Point2<f64>, Lost> {
        match self {
            Self::Lens(viewer) => viewer.see(place),
            Self::Model(viewpoint, tracer) => by_its_own_model(viewpoint, tracer, place),
            Self::Behind(behind) => behind.look(place),
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
            Self::Behind(behind) => Some(behind.aim(place)?.0),
        }
    }
}

/// A camera with the first interface in its own model, and the bodies behind that.
pub(super) struct Behind<'a> {
    viewpoint: &'a Viewpoint,
    stack: &'a Stack,
    /// Past what is clear, and past all bodies.
    clear: Tracer<'a>,
    all: Tracer<'a>,
}

impl Behind<'_> {
    /// The pixel whose ray passes a place, with that ray; `None` where the lens maps nothing, or none passes.
    ///
    /// What bodies behind the interface displace hardly depends on where the camera aims: it aims beside the place by as
    /// much as it missed, again and again.
    fn aim(&mut self, place: &Point3<f64>) -> Option<(Point2<f64>, Ray)> {
        let (camera, pose) = (self.viewpoint.camera(), &self.viewpoint.sensor_from_camera);
        let camera_from_sensor = pose.inverse();
        let mut at = *place;
        for _ in 0..MOST_AIMS {
            let pixel = camera.project(&camera_from_sensor.point(at)).ok()?;
            let ray = camera.unproject(&pixel).ok()?;
            let (origin, direction) =
                (pose.point(ray.origin_in_camera), pose.vector(ray.direction));
            let ray = self.stack.entered(&Ray { origin, direction });
            let last = self.clear.follow(&ray).last;
            let off = place - last.at((place - last.origin).dot(&last.direction));
            if off.norm() < AIMED_MM {
                return Some((pixel, ray));
            }
            at += off;
        }
        None
    }

    fn look(&mut self, place: &Point3<f64>) -> Result<Point2<f64>, Lost> {
        let (pixel, ray) = self.aim(place).ok_or(Lost::Refraction)?;
        if !self.viewpoint.camera().sees(&pixel) {
            return Err(Lost::BesidePicture);
        }
        let pupil = self.viewpoint.sensor_from_camera.point(Point3::origin());
        let to = ray.origin - pupil;
        if let Some(direction) = to.try_normalize(0.0) {
            let path = self.all.follow(&Ray { origin: pupil, direction });
            if path.lead_mm + path.end_mm < to.norm() - THERE_MM {
                return Err(Lost::at(path.end));
            }
        }
        // What ends a ray before it is bent last ends it before the place.
        let path = self.all.follow(&ray);
        let left_mm = (place - path.last.origin).dot(&path.last.direction);
        if path.end_mm < left_mm - THERE_MM {
            return Err(Lost::at(path.end));
        }
        Ok(pixel)
    }
}

/// The pixel of each place, column and row; nothing of those beside the picture and of those from which no light reaches the
/// camera. What opaque bodies hide has one.
pub fn pixels_of(
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
pub fn are_seen(
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
