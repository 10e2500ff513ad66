//! How much of a sensor's surface a camera sees.

use fabkit_fixtures::SurfacePoints;
use fabkit_geometry::{InvalidSolid, TouchSurface};

use super::Viewpoint;
use super::probes::places_of_seed;

/// Places that are looked at; the share is good to about a 1e-4th.
const PLACES: u32 = 20_000;

/// What a camera sees of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCoverage {
    /// Share of the surface's area.
    pub area: f64,
    /// Area of the whole surface, mm2.
    pub area_mm2: f64,
    /// Smallest and largest angle of the surface's places to the camera's axis, rad.
    pub angles_rad: [f64; 2],
    /// The largest angle that the lens shows, rad.
    pub lens_rad: f64,
}

/// Looks at places spread evenly over the surface. From within a convex surface nothing hides
/// anything, so that a place in the picture is a place seen.
///
/// # Errors
/// Dimensions that make no solid.
pub fn coverage(
    touch: &TouchSurface,
    viewpoint: &Viewpoint,
) -> Result<SurfaceCoverage, InvalidSolid> {
    let points = SurfacePoints::new(touch)?;
    let camera = viewpoint.camera();
    let camera_from_sensor = viewpoint.sensor_from_camera.inverse();
    let (mut seen, mut angles_rad) = (0u32, [f64::INFINITY, 0.0f64]);
    let places = places_of_seed(0);
    for [along, around, _] in (0..PLACES as usize).map(|number| places.at(number)) {
        let Some((point, _)) = points.by_area([along, around]) else { continue };
        let point = camera_from_sensor.point(point);
        let angle = point.coords.xy().norm().atan2(point.z);
        angles_rad = [angles_rad[0].min(angle), angles_rad[1].max(angle)];
        seen += u32::from(camera.project(&point).is_ok_and(|pixel| camera.sees(&pixel)));
    }
    Ok(SurfaceCoverage {
        area: f64::from(seen) / f64::from(PLACES),
        area_mm2: points.area_mm2(),
        angles_rad,
        lens_rad: camera.angle_limit_rad(),
    })
}
