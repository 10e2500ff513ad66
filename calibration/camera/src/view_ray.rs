//! View rays: half lines along which a camera looks.

use nalgebra::{Point3, Vector3};

/// Half line in the last medium that projects to one pixel.
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
