//! Half lines along which a camera looks.

use nalgebra::{Point3, Vector3};

/// A half line in the last medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRay {
    /// On the interface; the lens's centre if there is none. mm.
    pub origin_in_camera: Point3<f64>,
    /// Unit length, away from the camera.
    pub direction: Vector3<f64>,
}

impl ViewRay {
    /// The point `distance_mm` along the ray.
    pub fn at(&self, distance_mm: f64) -> Point3<f64> {
        self.origin_in_camera + self.direction * distance_mm
    }
}
