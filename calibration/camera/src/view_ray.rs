//! View rays: half lines along which a camera looks.

use nalgebra::{Point3, Vector3};

/// Half line in the last medium that projects to one pixel.
///
/// ```
/// use fabkit_camera::{Camera, Point2, Point3};
/// let camera = Camera::equidistant(640, 480, 2.5)?;
/// // The middle of the image looks along +z; distances are along the ray.
/// let ray = camera.unproject(&Point2::new(319.5, 239.5))?;
/// assert_eq!(ray.at(25.0), Point3::new(0.0, 0.0, 25.0));
/// // All points of a ray have the same pixel.
/// let ray = camera.unproject(&Point2::new(100.0, 50.0))?;
/// assert!((camera.project(&ray.at(7.0))? - Point2::new(100.0, 50.0)).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRay {
    /// Origin on the interface, or the lens's centre of projection if there is none, mm.
    pub origin_in_camera: Point3<f64>,
    /// Direction of unit length, away from the camera.
    pub direction: Vector3<f64>,
}

impl ViewRay {
    /// Returns the point at `distance_mm` along the ray, mm.
    pub fn at(&self, distance_mm: f64) -> Point3<f64> {
        self.origin_in_camera + self.direction * distance_mm
    }
}
