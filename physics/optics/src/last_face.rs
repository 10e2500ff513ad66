//! Where rays leave the interface that a camera file states.

use fabkit_camera::Interface;
use fabkit_geometry::{Point3, Pose, Ray, Vector3};

/// Behind a face by this much, mm: beyond rounding, and straight on in the same medium.
const BEHIND_MM: f64 = 1e-5;

/// The last face of a drawn interface, sensor frame.
///
/// A unit's own interface lies a little beside the drawn one. A ray that leaves it goes on behind the drawn one: it is not
/// bent by both.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LastFace {
    Plane { point: Point3<f64>, normal: Vector3<f64> },
    Sphere { centre: Point3<f64>, radius_mm: f64 },
}

impl LastFace {
    /// Of an interface in a camera's frame; `None` where that has none.
    pub(crate) fn of(interface: &Interface, sensor_from_camera: &Pose) -> Option<Self> {
        match interface {
            Interface::None | Interface::Drawn => None,
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

    /// How far along a ray it lies, mm; negative or not a number where the ray begins behind it.
    fn ahead_mm(&self, ray: &Ray) -> f64 {
        match self {
            Self::Plane { point, normal } => {
                (point - ray.origin).dot(normal) / ray.direction.dot(normal)
            }
            Self::Sphere { centre, radius_mm } => {
                let from = ray.origin - centre;
                let along = from.dot(&ray.direction);
                let square = from.norm_squared() - radius_mm * radius_mm;
                // From outside there is nothing to leave.
                if square > 0.0 { f64::NAN } else { -along + (along * along - square).sqrt() }
            }
        }
    }

    /// The ray as it goes on behind it.
    pub(crate) fn passed(&self, ray: &Ray) -> Ray {
        let ahead_mm = self.ahead_mm(ray);
        match ahead_mm > -BEHIND_MM {
            true => Ray { origin: ray.at(ahead_mm + BEHIND_MM), ..*ray },
            false => *ray,
        }
    }
}
