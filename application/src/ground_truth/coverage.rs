//! How much of a sensor's surface a camera sees, and what keeps it from the rest.

use std::collections::BTreeMap;

use fabkit_camera::Camera;
use fabkit_fixtures::SurfacePoints;
use fabkit_geometry::{InvalidSolid, Point3, Ray, TouchSurface};
use fabkit_optics::{End, Sights, Tracer, Unseen, Viewer};
use rayon::prelude::*;

use super::Viewpoint;
use super::probes::places_of_seed;

/// Places that are looked at; the share is good to about a thousandth.
const PLACES: u32 = 4_096;

/// A ray that ends that near to a place ends there, mm.
const THERE_MM: f64 = 1e-6;

/// What is lost since the camera looks elsewhere, in [`SurfaceCoverage::lost`].
pub const BESIDE_PICTURE: &str = "beside the picture";

/// What is lost since light is bent away or totally reflected, in the same.
pub const REFRACTION: &str = "refraction";

/// What a camera sees of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceCoverage {
    /// Share of the surface's area.
    pub area: f64,
    /// Shares of the rest, by what keeps the camera from it: a body, or words; the largest first.
    pub lost: Vec<(String, f64)>,
    /// Area of the whole surface, mm2.
    pub area_mm2: f64,
    /// Smallest and largest angle of the surface's places to the camera's axis, rad.
    pub angles_rad: [f64; 2],
    /// The largest angle that the lens shows, rad.
    pub lens_rad: f64,
}

/// What becomes of a place on the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fate {
    Seen,
    Hidden(u8),
    /// Light from there is bent away, or reflected back.
    Refraction,
    /// Light from there enters the lens, but beside what it shows.
    BesidePicture,
}

/// Looks at places spread evenly over the surface, each through the sensor's bodies.
///
/// # Errors
/// Dimensions that make no solid.
pub fn coverage(
    touch: &TouchSurface,
    viewpoint: &Viewpoint,
    sights: &Sights,
) -> Result<SurfaceCoverage, InvalidSolid> {
    let points = SurfacePoints::new(touch)?;
    let camera_from_sensor = viewpoint.sensor_from_camera.inverse();
    let places = places_of_seed(0);
    let point = |number: u32| {
        let [along, around, _] = places.at(number as usize);
        points.by_area([along, around]).map(|(point, _)| point)
    };
    let fates: Vec<(Fate, f64)> = (0..PLACES)
        .into_par_iter()
        .map_init(
            || Looking::new(viewpoint, sights),
            |looking, number| {
                let point = point(number)?;
                let in_camera = camera_from_sensor.point(point);
                let angle_rad = in_camera.coords.xy().norm().atan2(in_camera.z);
                Some((looking.fate(&point), angle_rad))
            },
        )
        .flatten()
        .collect();
    let mut counts: BTreeMap<Fate, u32> = BTreeMap::new();
    fates.iter().for_each(|(fate, _)| *counts.entry(*fate).or_default() += 1);
    let share = |count: u32| f64::from(count) / f64::from(PLACES);
    let area = counts.remove(&Fate::Seen).map_or(0.0, share);
    let word = |fate: Fate| match fate {
        Fate::Hidden(name) => sights.stack().names()[usize::from(name)].clone(),
        Fate::Refraction => REFRACTION.to_owned(),
        Fate::Seen | Fate::BesidePicture => BESIDE_PICTURE.to_owned(),
    };
    let mut lost: Vec<(String, f64)> =
        counts.into_iter().map(|(fate, count)| (word(fate), share(count))).collect();
    lost.sort_by(|a, b| b.1.total_cmp(&a.1));
    let fold = |start: f64, pick: fn(f64, f64) -> f64| {
        fates.iter().fold(start, |so_far, (_, angle_rad)| pick(so_far, *angle_rad))
    };
    Ok(SurfaceCoverage {
        area,
        lost,
        area_mm2: points.area_mm2(),
        angles_rad: [fold(f64::INFINITY, f64::min), fold(0.0, f64::max)],
        lens_rad: viewpoint.camera().angle_limit_rad(),
    })
}

/// One thread's way to look.
enum Looking<'a> {
    /// A lens and nothing else: bodies bend what it sees.
    Lens(&'a Camera, Box<Viewer<'a>>),
    /// A camera that knows by itself how light is bent on its way: bodies only hide.
    Model(&'a Viewpoint, Box<Tracer<'a>>),
}

impl<'a> Looking<'a> {
    fn new(viewpoint: &'a Viewpoint, sights: &'a Sights) -> Self {
        let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
        match viewpoint.is_drawn() {
            true => Self::Lens(camera, Box::new(Viewer::new(camera, pose, sights))),
            false => Self::Model(viewpoint, Box::new(Tracer::new(sights.stack()))),
        }
    }

    fn fate(&mut self, place: &Point3<f64>) -> Fate {
        match self {
            Self::Lens(camera, viewer) => match viewer.look_at(place) {
                Err(Unseen::NoLight { .. }) => Fate::Refraction,
                Err(Unseen::Lens(_)) => Fate::BesidePicture,
                Ok(look) if !camera.sees(&look.pixel) => Fate::BesidePicture,
                Ok(look) => look.sight.hidden_by(THERE_MM).map_or(Fate::Seen, by),
            },
            Self::Model(viewpoint, tracer) => by_its_own_model(viewpoint, tracer, place),
        }
    }
}

fn by_its_own_model(viewpoint: &Viewpoint, tracer: &mut Tracer, place: &Point3<f64>) -> Fate {
    let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
    let seen = camera.project(&pose.inverse().point(*place)).ok();
    let seen = seen.filter(|pixel| camera.sees(pixel));
    let Some(ray) = seen.and_then(|pixel| camera.unproject(&pixel).ok()) else {
        return Fate::BesidePicture;
    };
    // From the pupil to where the camera's own interface lets the ray go, and from there.
    let (pupil, start) = (pose.point(Point3::origin()), pose.point(ray.origin_in_camera));
    for (from, to) in [(pupil, start), (start, *place)] {
        let Some(direction) = (to - from).try_normalize(0.0) else { continue };
        let path = tracer.follow(&Ray { origin: from, direction });
        if path.lead_mm + path.end_mm < (to - from).norm() - THERE_MM {
            return by(path.end);
        }
    }
    Fate::Seen
}

/// What keeps a place from being seen by ending its ray.
fn by(end: End) -> Fate {
    match end {
        End::Body(name) => Fate::Hidden(name),
        End::Surface | End::Mirror(_) | End::Nothing => Fate::Refraction,
    }
}
