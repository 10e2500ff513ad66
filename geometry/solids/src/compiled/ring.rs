//! Torus, and the surface of any ellipse rotated around the z axis.

use nalgebra::{Vector2, Vector3};

use super::region::Ellipse;
use super::shape::{Candidate, CastBuffers, LocalRay, Shape};
use crate::{
    Torus,
    roots::{Roots, polynomial, quadratic},
};

/// Returns a point's distance from the z axis and its height.
#[inline]
pub(crate) fn meridian(p: &Vector3<f64>) -> Vector2<f64> {
    // Squares of lengths in mm neither overflow nor underflow. `hypot` guards against both, which costs a tenth of the
    // time of casting a torus.
    Vector2::new((p.x * p.x + p.y * p.y).sqrt(), p.z)
}

/// Finds where the line may cross the surface that the ellipse, given in (distance from z, height), sweeps around z,
/// for parameters within `between_mm`. Includes crossings of the mirrored ellipse beyond the axis, which callers
/// discard.
pub(crate) fn swept_ellipse(ellipse: &Ellipse, ray: &LocalRay, between_mm: [f64; 2]) -> Roots {
    let Ellipse { centre, half_axes } = ellipse;
    let (o, d) = (&ray.origin, &ray.direction);
    let ratio = (half_axes.x / half_axes.y).powi(2);
    let height = o.z - centre.y;
    // Squared distance from the axis along the ray: s(t) = s2 t^2 + 2 s1 t + s0.
    let (s2, s1, s0) = (d.xy().norm_squared(), o.xy().dot(&d.xy()), o.xy().norm_squared());
    // With r = sqrt(s), centre c and half axes a, b, the surface (r - c)^2 / a^2 + z^2 / b^2 = 1
    // is q(t) = s + c^2 - a^2 + (a/b)^2 z^2 = 2 c r.
    let q2 = s2 + ratio * d.z * d.z;
    let q1 = s1 + ratio * d.z * height;
    let q0 = s0 + centre.x * centre.x - half_axes.x * half_axes.x + ratio * height * height;
    if centre.x == 0.0 {
        return quadratic(q2, q1, q0);
    }
    // q^2 = 4 c^2 s, in units of the ray's reach so that all coefficients are of order one.
    let unit = ray.reach_mm;
    let square = unit * unit;
    let (s2, s1, s0) = (s2, s1 / unit, s0 / square);
    let (q1, q0) = (q1 / unit, q0 / square);
    let c = 4.0 * centre.x * centre.x / square;
    let quartic = [
        q0 * q0 - c * s0,
        4.0 * q1 * q0 - 2.0 * c * s1,
        4.0 * q1 * q1 + 2.0 * q2 * q0 - c * s2,
        4.0 * q2 * q1,
        q2 * q2,
    ];
    let [low, high] = between_mm.map(|t_mm| (t_mm / unit).clamp(-1.0, 1.0));
    polynomial(&quartic, low, high).scaled(unit)
}

/// Refines a root by two Newton steps on the implicit function of the surface itself: the squared equation costs digits
/// where the tube is thin.
pub(crate) fn refine_root(ellipse: &Ellipse, ray: &LocalRay, t_mm: f64) -> f64 {
    let mut t_mm = t_mm;
    for _ in 0..2 {
        let p = ray.at(t_mm);
        let flat = meridian(&p);
        let scaled = (flat - ellipse.centre).component_div(&ellipse.half_axes);
        let gradient = scaled.component_div(&ellipse.half_axes);
        let outward_speed = p.xy().dot(&ray.direction.xy()) / flat.x;
        let slope = 2.0 * (gradient.x * outward_speed + gradient.y * ray.direction.z);
        let step = (scaled.norm_squared() - 1.0) / slope;
        // Far from the surface (the mirrored ellipse) or at a tangent the root stays as it is.
        if step.is_finite() && step.abs() < 1e-6 * ray.reach_mm {
            t_mm -= step;
        }
    }
    t_mm
}

impl Torus {
    fn tube(&self) -> Ellipse {
        Ellipse {
            centre: Vector2::new(self.ring_radius_mm, 0.0),
            half_axes: Vector2::new(self.tube_radius_mm, self.tube_radius_mm),
        }
    }
}

impl Shape for Torus {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        self.ring_radius_mm * u.x.hypot(u.y) + self.tube_radius_mm
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        let from_tube = meridian(p) - self.tube().centre;
        from_tube.norm_squared() < self.tube_radius_mm * self.tube_radius_mm
    }

    fn normal(&self, _face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        let from_tube = meridian(p) - self.tube().centre;
        rotate_to_azimuth(from_tube, p)
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        let tube = self.tube();
        for &t_mm in swept_ellipse(&tube, ray, [-ray.reach_mm, ray.reach_mm]).as_slice() {
            let t_mm = refine_root(&tube, ray, t_mm);
            work.candidates.push(Candidate { t_mm, face: 0 });
        }
        work.candidates_to_chords(|t_mm| self.contains(&ray.at(t_mm)));
    }
}

/// Rotates a direction of the (distance from z, height) half plane to the azimuth of `p`.
pub(crate) fn rotate_to_azimuth(flat: Vector2<f64>, p: &Vector3<f64>) -> Vector3<f64> {
    let across = meridian(p).x;
    if across == 0.0 {
        return Vector3::new(0.0, 0.0, flat.y);
    }
    Vector3::new(flat.x * p.x / across, flat.x * p.y / across, flat.y)
}
