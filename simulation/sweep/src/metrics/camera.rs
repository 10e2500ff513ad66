//! Metrics of the designed camera's view of the surface, through the drawn bodies.

use fabkit_camera::Camera;
use fabkit_fixtures::SurfacePoints;
use fabkit_geometry::sequences::GOLDEN_RATIO_CONJUGATE;
use fabkit_geometry::{InvalidSolid, Point3, Sensor, Vector3};
use fabkit_optics::{CameraView, InvalidStack, OpticalStack, PointProjection, ViewStacks};
use nalgebra::{Matrix2x3, Matrix3x2, Vector2};

use super::ComputedMetrics;

/// Number of places on the surface; fractions of its area are accurate to about a thousandth.
const PLACES: u32 = 1024;

/// Distance from a place, mm, within which a ray that ends counts as reaching it.
const REACHED_MM: f64 = 1e-6;

/// Camera of a design, with the bodies that it looks through.
pub(super) struct View<'a> {
    sensor: &'a Sensor,
    camera: Camera,
    sights: ViewStacks,
    /// Places that are spread evenly over the area of the surface, and that area, mm2; `None` if its shape is unknown.
    places: Option<(Vec<SurfacePlace>, f64)>,
}

/// Place on the surface that lies in the image, if no body is in the way of its light.
pub(super) struct SurfacePlace {
    /// Position in the sensor frame, mm.
    pub point: Point3<f64>,
    pub look: PointProjection,
    /// Name of the body in its way, if any.
    pub hidden_by: Option<String>,
    scale: Option<PixelScale>,
}

/// Size of a pixel on the surface.
#[derive(Clone, Copy, Debug)]
struct PixelScale {
    /// Side of the square on the surface that has the area of one pixel, mm.
    mm_per_px: f64,
    /// Change of the distance from one pixel to the next, in the direction where it is largest, mm.
    range_mm_per_px: f64,
}

impl<'a> View<'a> {
    /// Creates the view; `None` for an impossible camera.
    ///
    /// # Errors
    /// Fails for bodies through which light cannot be traced.
    pub(super) fn new(sensor: &'a Sensor) -> Result<Option<Self>, InvalidStack> {
        let design = &sensor.camera;
        let (width, height) = (design.width_px, design.height_px);
        let (view_rad, terms) = (design.field_of_view.rad(), design.lens.projection.terms());
        let Ok(camera) = Camera::from_data_sheet(width, height, view_rad, terms) else {
            return Ok(None);
        };
        let sights = ViewStacks::new(OpticalStack::from_sensor(sensor)?);
        let mut view = Self { sensor, camera, sights, places: None };
        let of_surface = |source| InvalidStack::Solid { body: "surface".into(), source };
        view.places = view.find_places().map_err(of_surface)?;
        Ok(Some(view))
    }

    pub(super) fn sensor(&self) -> &Sensor {
        self.sensor
    }

    pub(super) fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Creates a viewer through the drawn bodies.
    pub(super) fn viewer(&self) -> CameraView<'_> {
        CameraView::new(&self.camera, &self.sensor.camera.sensor_from_camera, &self.sights)
    }

    /// Places that lie in the image, and the whole area of the surface, mm2.
    pub(super) fn places(&self) -> Option<(&[SurfacePlace], f64)> {
        self.places.as_ref().map(|(places, area_mm2)| (&places[..], *area_mm2))
    }

    /// Finds the places on the surface that lie in the image.
    fn find_places(&self) -> Result<Option<(Vec<SurfacePlace>, f64)>, InvalidSolid> {
        let Some(touch) = &self.sensor.touch else { return Ok(None) };
        let surface = SurfacePoints::new(touch)?;
        let mut viewer = self.viewer();
        let places = (0..PLACES).filter_map(|i| {
            // A low-discrepancy sequence: even steps along one axis, the golden ratio along the other.
            let shares = [
                (f64::from(i) + 0.5) / f64::from(PLACES),
                (f64::from(i) * GOLDEN_RATIO_CONJUGATE).fract(),
            ];
            let (point, normal) = surface.point_at_area_fractions(shares)?;
            let look =
                viewer.project(&point).ok().filter(|look| self.camera.is_in_image(&look.pixel))?;
            let hidden = look.sight.hidden_by(REACHED_MM);
            let hidden_by = hidden.map(|end| self.sights.stack().name_of(end).to_owned());
            let by_place = viewer.pixel_by_point(&point, &look);
            let scale = by_place.and_then(|by| scale(&by, &look.sight.direction_at_point, &normal));
            Some(SurfacePlace { point, look, hidden_by, scale })
        });
        Ok(Some((places.collect(), surface.area_mm2())))
    }
}

/// Computes a pixel's size from the derivative of the pixel by the place, px/mm.
fn scale(
    by_place: &Matrix2x3<f64>,
    sight: &Vector3<f64>,
    normal: &Vector3<f64>,
) -> Option<PixelScale> {
    // Two orthogonal directions along the surface.
    let u = Vector3::ith(normal.iamin(), 1.0).cross(normal).normalize();
    let along = Matrix3x2::from_columns(&[u, normal.cross(&u)]);
    let px_per_mm = by_place * along;
    // The determinant is the area in the image per area on the surface.
    let mm_per_px = 1.0 / px_per_mm.determinant().abs().sqrt();
    // The distance changes by the component of the line of sight along the surface; by pixels, through the inverse of
    // the derivative above.
    let by_mm: Vector2<f64> = along.transpose() * sight;
    let by_px = px_per_mm.transpose().try_inverse()? * by_mm;
    Some(PixelScale { mm_per_px, range_mm_per_px: by_px.norm() })
}

/// Computes the group's metrics.
pub(super) fn compute(view: &View, computed: &mut ComputedMetrics) {
    let Some((places, area_mm2)) = view.places() else { return };
    let seen: Vec<&SurfacePlace> =
        places.iter().filter(|place| place.hidden_by.is_none()).collect();
    computed.put("surface_area_mm2", area_mm2);
    computed.put("coverage", seen.len() as f64 / f64::from(PLACES));
    let scales = || seen.iter().filter_map(|place| place.scale);
    computed.put_spread("mm_per_px", scales().map(|scale| scale.mm_per_px).collect());
    computed.put_spread("range_mm_per_px", scales().map(|scale| scale.range_mm_per_px).collect());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With nothing in between.
    fn look(camera: &Camera, point: &Point3<f64>, normal: &Vector3<f64>) -> PixelScale {
        let by_place = camera.project_with_jacobians(point).unwrap().by_point;
        scale(&by_place, &point.coords.normalize(), normal).unwrap()
    }

    /// A camera in the middle of a sphere: one pixel sees `radius / focal`, and no depth changes.
    #[test]
    fn from_the_middle_of_a_sphere_all_pixels_are_alike() {
        let camera = Camera::equidistant(640, 480, 2.0).unwrap();
        let focal_px = 800.0 / 2.0;
        let radius_mm = 15.0;
        let point = Point3::new(0.0, 0.0, radius_mm);
        let seen = look(&camera, &point, &Vector3::z());
        assert!((seen.mm_per_px - radius_mm / focal_px).abs() < 1e-12);
        assert!(seen.range_mm_per_px < 1e-12);
        // Off the axis an equidistant lens stretches circles by angle / sine.
        let angle = 0.6f64;
        let normal = Vector3::new(angle.sin(), 0.0, angle.cos());
        let point = Point3::from(radius_mm * normal);
        let seen = look(&camera, &point, &normal);
        let expected = radius_mm / focal_px * (angle.sin() / angle).sqrt();
        assert!((seen.mm_per_px - expected).abs() < 1e-9, "{} {expected}", seen.mm_per_px);
        assert!(seen.range_mm_per_px < 1e-12);
    }

    /// A tilted plane, compared with differences of neighbouring pixels.
    #[test]
    fn the_change_of_range_is_that_between_pixels() {
        let camera = Camera::equidistant(640, 480, 2.0).unwrap();
        let normal = Vector3::new(0.3, -0.2, 1.0).normalize();
        let point = Point3::new(2.0, 1.0, 10.0);
        let seen = look(&camera, &point, &normal);
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
