//! Bounding balls, the cheapest test of a ray.

use fabkit_geometry::{Aabb, Point3, Pose, Ray, Vector3};

/// Relative growth of balls, so that rounding hides no point on them.
const GROWTH: f64 = 1e-6;

/// Bounding ball of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoundingBall {
    pub(super) centre: Point3<f64>,
    pub(super) radius_mm: f64,
}

impl BoundingBall {
    /// Bounds a box that is given in another frame. Returns `None` for an empty box, an infinite ball for an infinite
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

    /// Returns whether the line of a ray of unit direction may pass through the ball.
    #[inline]
    pub(super) fn may_meet(&self, ray: &Ray) -> bool {
        let towards = self.centre - ray.origin;
        let along = towards.dot(&ray.direction);
        towards.norm_squared() - along * along <= self.radius_mm * self.radius_mm
    }
}
