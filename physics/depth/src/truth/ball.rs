//! Balls around bodies: the cheapest question about a ray.

use fabkit_geometry::{Aabb, Point3, Pose, Ray, Vector3};

/// Balls grow by this share, so that rounding hides nothing of what lies on them.
const GROWTH: f64 = 1e-6;

/// A ball that holds a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub(super) centre: Point3<f64>,
    pub(super) radius_mm: f64,
}

impl Ball {
    /// Around a box given in another frame; `None` around an empty one, endless around an endless
    /// one.
    pub(super) fn around(bounds: &Aabb, to_here: &Pose) -> Option<Self> {
        if bounds.is_empty() {
            return None;
        }
        if !bounds.is_finite() {
            return Some(Self { centre: Point3::origin(), radius_mm: f64::INFINITY });
        }
        let radius_mm = 0.5 * Vector3::from(bounds.size_mm()).norm() * (1.0 + GROWTH);
        Some(Self { centre: to_here.point(bounds.centre()), radius_mm })
    }

    /// Whether the line of a ray of unit direction may pass through.
    #[inline]
    pub(super) fn may_meet(&self, ray: &Ray) -> bool {
        let towards = self.centre - ray.origin;
        let along = towards.dot(&ray.direction);
        towards.norm_squared() - along * along <= self.radius_mm * self.radius_mm
    }
}
