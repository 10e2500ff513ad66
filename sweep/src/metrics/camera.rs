//! What the camera sees of the surface, as designed: equidistant, without refraction.

use fabkit_camera::Camera;
use fabkit_fixtures::SurfacePoints;
use fabkit_geometry::sequences::GOLDEN_SHARE;
use fabkit_geometry::{InvalidSolid, Point3, Sensor, Vector3};
use nalgebra::{Matrix3x2, Vector2};

use super::Computed;

/// Places on the surface; shares of its area are good to about a thousandth.
const PLACES: u32 = 1024;

/// A place on the surface that lies in the picture.
pub(super) struct Seen {
    /// mm, sensor frame.
    pub point_in_sensor: Point3<f64>,
    /// Edge of the square on the surface that one pixel sees, mm.
    mm_per_px: f64,
    /// Change of the distance from one pixel to the next, in the direction where it is largest, mm.
    range_mm_per_px: f64,
}

/// The camera as designed; `None` where it cannot be.
pub(super) fn nominal(sensor: &Sensor) -> Option<Camera> {
    let camera = &sensor.camera;
    Camera::equidistant(camera.width_px, camera.height_px, camera.field_of_view.rad()).ok()
}

/// Places spread evenly over the area of the surface that lie in the picture, and that area, mm2;
/// `None` for flat sensors.
pub(super) fn seen(
    sensor: &Sensor,
    camera: &Camera,
) -> Result<Option<(Vec<Seen>, f64)>, InvalidSolid> {
    let Some(touch) = &sensor.touch else { return Ok(None) };
    let surface = SurfacePoints::new(touch)?;
    let camera_from_sensor = sensor.camera.sensor_from_camera.inverse();
    let places = (0..PLACES).filter_map(|i| {
        let shares =
            [(f64::from(i) + 0.5) / f64::from(PLACES), (f64::from(i) * GOLDEN_SHARE).fract()];
        let (point, normal) = surface.by_area(shares)?;
        let normal_in_camera = camera_from_sensor.vector(normal);
        look(camera, point, &camera_from_sensor.point(point), &normal_in_camera)
    });
    Ok(Some((places.collect(), surface.area_mm2())))
}

fn look(
    camera: &Camera,
    point_in_sensor: Point3<f64>,
    point: &Point3<f64>,
    normal: &Vector3<f64>,
) -> Option<Seen> {
    let projection = camera.project_with_jacobians(point).ok()?;
    if !camera.sees(&projection.pixel) {
        return None;
    }
    // Two directions along the surface.
    let u = Vector3::ith(normal.iamin(), 1.0).cross(normal).normalize();
    let along = Matrix3x2::from_columns(&[u, normal.cross(&u)]);
    let px_per_mm = projection.by_point * along;
    let mm_per_px = 1.0 / px_per_mm.determinant().abs().sqrt();
    // The distance grows by the line of sight's part along the surface; by pixels, through the
    // inverse of the above.
    let sight = point.coords.normalize();
    let by_mm: Vector2<f64> = along.transpose() * sight;
    let by_px = px_per_mm.transpose().try_inverse()? * by_mm;
    Some(Seen { point_in_sensor, mm_per_px, range_mm_per_px: by_px.norm() })
}

pub(super) fn compute(sensor: &Sensor, computed: &mut Computed) -> Result<(), InvalidSolid> {
    let Some(camera) = nominal(sensor) else { return Ok(()) };
    let Some((seen, area_mm2)) = seen(sensor, &camera)? else { return Ok(()) };
    computed.put("surface_area_mm2", area_mm2);
    computed.put("coverage", seen.len() as f64 / f64::from(PLACES));
    computed.put_spread("mm_per_px", seen.iter().map(|place| place.mm_per_px).collect());
    computed
        .put_spread("range_mm_per_px", seen.iter().map(|place| place.range_mm_per_px).collect());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A camera in the middle of a sphere: one pixel sees `radius / focal`, and no depth changes.
    #[test]
    fn from_the_middle_of_a_sphere_all_pixels_are_alike() {
        let camera = Camera::equidistant(640, 480, 2.0).unwrap();
        let focal_px = 800.0 / 2.0;
        let radius_mm = 15.0;
        let point = Point3::new(0.0, 0.0, radius_mm);
        let seen = look(&camera, point, &point, &Vector3::z()).unwrap();
        assert!((seen.mm_per_px - radius_mm / focal_px).abs() < 1e-12);
        assert!(seen.range_mm_per_px < 1e-12);
        // Off the axis an equidistant lens stretches circles by angle / sine.
        let angle = 0.6f64;
        let normal = Vector3::new(angle.sin(), 0.0, angle.cos());
        let point = Point3::from(radius_mm * normal);
        let seen = look(&camera, point, &point, &normal).unwrap();
        let expected = radius_mm / focal_px * (angle.sin() / angle).sqrt();
        assert!((seen.mm_per_px - expected).abs() < 1e-9, "{} {expected}", seen.mm_per_px);
        assert!(seen.range_mm_per_px < 1e-12);
    }

    /// A plane askew, against differences of neighbouring pixels.
    #[test]
    fn the_change_of_range_is_that_between_pixels() {
        let camera = Camera::equidistant(640, 480, 2.0).unwrap();
        let normal = Vector3::new(0.3, -0.2, 1.0).normalize();
        let point = Point3::new(2.0, 1.0, 10.0);
        let seen = look(&camera, point, &point, &normal).unwrap();
        let pixel = camera.project(&point).unwrap();
        let range = |dx: f64, dy: f64| {
            let ray = camera.unproject(&(pixel + Vector2::new(dx, dy))).unwrap();
            normal.dot(&point.coords) / normal.dot(&ray.direction)
        };
        let h = 1e-3;
        let gradient = Vector2::new(range(h, 0.0) - range(-h, 0.0), range(0.0, h) - range(0.0, -h));
        let expected = gradient.norm() / (2.0 * h);
        assert!((seen.range_mm_per_px / expected - 1.0).abs() < 1e-6);
    }
}
