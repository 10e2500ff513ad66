//! Last face of the interface that a camera file states.

use fabkit_camera::Interface;
use fabkit_geometry::{Point3, Pose, Ray, Vector3};

/// Distance by which rays start behind the face, mm: beyond rounding, and straight on in the same medium.
const BEHIND_MM: f64 = 1e-5;

/// Last face of a drawn interface, sensor frame.
///
/// The calibrated interface of a unit lies slightly beside the drawn one. A ray that leaves it is continued behind the
/// drawn one, so that it is not refracted by both.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LastFace {
    Plane { point: Point3<f64>, normal: Vector3<f64> },
    Sphere { centre: Point3<f64>, radius_mm: f64 },
}

impl LastFace {
    /// Creates the last face of an interface in the camera's frame; `None` if there is no such interface.
    pub(crate) fn from_interface(interface: &Interface, sensor_from_camera: &Pose) -> Option<Self> {
        match interface {
            Interface::None | Interface::FromDrawing => None,
            Interface::Flat(flat) => {
                let normal = flat.normal();
                let point = Point3::from(normal * (flat.distance_mm + flat.glass_thickness_mm));
                let (point, normal) =
                    (sensor_from_camera.point(point), sensor_from_camera.vector(normal));
                Some(Self::Plane { point, normal })
            }
            Interface::Sphere(sphere) => {
                let centre = sensor_from_camera.point(sphere.centre_in_camera);
                Some(Self::Sphere { centre, radius_mm: sphere.radius_mm })
            }
        }
    }

    /// Returns the distance of the face along a ray, mm; negative or NaN if the ray begins behind it.
    fn distance_mm(&self, ray: &Ray) -> f64 {
        match self {
            Self::Plane { point, normal } => {
                (point - ray.origin).dot(normal) / ray.direction.dot(normal)
            }
            Self::Sphere { centre, radius_mm } => {
                let from = ray.origin - centre;
                let along = from.dot(&ray.direction);
                let square = from.norm_squared() - radius_mm * radius_mm;
                // A ray from outside the sphere does not leave it.
                if square > 0.0 { f64::NAN } else { -along + (along * along - square).sqrt() }
            }
        }
    }

    /// Returns the ray continued behind the face.
    pub(crate) fn advance(&self, ray: &Ray) -> Ray {
        let ahead_mm = self.distance_mm(ray);
        // A ray along the plane never meets it: the quotient is infinite or NaN.
        if ahead_mm > -BEHIND_MM && ahead_mm.is_finite() {
            Ray { origin: ray.at(ahead_mm + BEHIND_MM), ..*ray }
        } else {
            *ray
        }
    }
}
