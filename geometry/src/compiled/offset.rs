//! Parallel surface of an ellipsoid of revolution.

use nalgebra::{Vector2, Vector3};

use super::ring::{meridian, turned};
use super::shape::{Chord, LocalRay, Shape, Work};
use crate::{Ellipsoid, EllipsoidOffset};

/// Signed distance from an ellipse around the origin and its gradient, the unit outward normal at
/// the nearest point. `p` must lie in the first quadrant; negative inside.
///
/// The nearest point comes from one root of a scalar equation (Eberly, "Distance from a Point to
/// an Ellipse, an Ellipsoid, or a Hyperellipsoid", 2013), written as for a trust region (Conn,
/// Gould and Toint, "Trust-Region Methods", 2000, section 7.3): an increasing concave function,
/// which Newton's method climbs from the left without ever overshooting. No branch of the distance
/// can be mistaken for another. From a point to the right of the root one step leads to its left.
///
/// `start` is where the climb begins, and becomes its end: for a point nearby it is almost there.
fn ellipse_distance(
    half_axes: Vector2<f64>,
    p: Vector2<f64>,
    start: &mut f64,
) -> (f64, Vector2<f64>) {
    if half_axes.x < half_axes.y {
        let (distance, normal) = ellipse_distance(half_axes.yx(), p.yx(), start);
        return (distance, normal.yx());
    }
    let (a, b) = (half_axes.x, half_axes.y);
    // In units of the short half axis: the point is z, the ellipse has half axes `long` and 1.
    let long = a / b;
    let k = long * long;
    // k - 1 without cancellation; the parameter s is counted from its pole for the same reason.
    let gap = (a - b) * (a + b) / (b * b);
    let z = p / b;
    let n = long * z.x;
    let nearest = if z.y > 1e-200 {
        // At the root |(u, v)| = 1; both bounds lie left of it, where the length is above 1.
        let least = z.y.max((n * n + z.y * z.y).sqrt() - gap);
        let mut s = least.max(*start);
        for _ in 0..100 {
            let (u, v) = (n / (s + gap), z.y / s);
            let squared = u * u + v * v;
            let length = squared.sqrt();
            let next = s + (length - 1.0) * squared / (u * u / (s + gap) + v * v / s);
            if next.is_nan() {
                break;
            }
            // Convergence is quadratic: after a step this small the next one is rounding.
            let is_last = (next - s).abs() <= 1e-9 * s;
            s = next.max(least);
            if is_last {
                break;
            }
        }
        *start = s;
        Vector2::new(k * z.x / (s + gap), z.y / s)
    } else if n < gap {
        // On the long axis, between the centres of curvature of its two ends.
        let x = k * z.x / gap;
        Vector2::new(x, (1.0 - x * x / k).max(0.0).sqrt())
    } else {
        Vector2::new(long, 0.0)
    };
    let normal = Vector2::new(nearest.x / k, nearest.y).normalize();
    // Projected on the normal: an error in the nearest point enters only squared.
    ((z - nearest).dot(&normal) * b, normal)
}

impl EllipsoidOffset {
    fn half_axes(&self) -> Vector2<f64> {
        Vector2::new(self.equatorial_mm, self.polar_mm)
    }

    /// Distance outside the parallel surface, mm, and its gradient.
    #[inline]
    pub(crate) fn distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        // Of a sphere it needs no iteration; its centre is as near to one side as to any other.
        if self.equatorial_mm == self.polar_mm {
            let far_mm = p.norm();
            let normal = if far_mm > 0.0 { p / far_mm } else { Vector3::x() };
            return (far_mm - self.equatorial_mm - self.offset_mm, normal);
        }
        self.distance_from(p, &mut 0.0)
    }

    /// The same for points one after the other, each near the last.
    fn distance_from(&self, p: &Vector3<f64>, start: &mut f64) -> (f64, Vector3<f64>) {
        let flat = meridian(p);
        let quadrant = Vector2::new(flat.x, flat.y.abs());
        let (from_ellipse, mut normal) = ellipse_distance(self.half_axes(), quadrant, start);
        normal.y = normal.y.copysign(p.z);
        (from_ellipse - self.offset_mm, turned(normal, p))
    }

    /// An ellipsoid that encloses the solid, for a first guess and for misses, and one that lies within
    /// where there is a tight one.
    fn bounding(&self) -> (Ellipsoid, Option<Ellipsoid>) {
        let short = self.equatorial_mm.min(self.polar_mm);
        // Minkowski's inequality on the support functions: within for positive offsets, around for
        // negative ones.
        let shifted = [self.equatorial_mm + self.offset_mm, self.polar_mm + self.offset_mm];
        let of = |[equatorial, polar]: [f64; 2], growth: f64| Ellipsoid {
            // The least growth that rounding cannot undo.
            semi_axes_mm: [equatorial, equatorial, polar].map(|v| v * (1.0 + growth)),
        };
        if self.offset_mm < 0.0 {
            return (of(shifted, 1e-12), None);
        }
        // A ball of radius r lies within the ellipsoid scaled by r over its short half axis.
        let scale = 1.0 + self.offset_mm / short;
        let scaled = [self.equatorial_mm * scale, self.polar_mm * scale];
        (of(scaled, 1e-12), Some(of(shifted, 0.0)))
    }

    /// The first parameter after `outside_mm` (going `sign`) at which the line enters, if any.
    ///
    /// Distance from a convex body is convex along a line, so Newton's method from outside
    /// approaches the crossing from one side only, and a slope that turns proves a miss. From a
    /// `guess_mm` within, its first step leads outside, to where few more are left.
    fn enter(&self, ray: &LocalRay, [outside_mm, guess_mm]: [f64; 2], sign: f64) -> Option<f64> {
        let mut t_mm = guess_mm;
        let resolution_mm = 4.0 * f64::EPSILON * ray.reach_mm;
        let mut start = 0.0;
        for i in 0..80 {
            let (distance, gradient) = self.distance_from(&ray.at(t_mm), &mut start);
            let approach = sign * gradient.dot(&ray.direction);
            if i == 0 && distance < -resolution_mm {
                // Along a grazing line the step would lead far away.
                t_mm = if approach < -0.1 { t_mm - sign * distance / approach } else { outside_mm };
                continue;
            }
            if distance <= resolution_mm {
                return Some(t_mm);
            }
            if approach >= 0.0 {
                return None;
            }
            let step = -distance / approach;
            t_mm += sign * step;
            // As above; near a tangent steps only halve, and what is left is as small as the last.
            if step <= 1e-9 * ray.reach_mm {
                return Some(t_mm);
            }
        }
        // Linear convergence for this long means a tangent.
        None
    }
}

impl Shape for EllipsoidOffset {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        meridian(u).component_mul(&self.half_axes()).norm() + self.offset_mm
    }

    fn holds(&self, p: &Vector3<f64>) -> bool {
        self.distance(p).0 < 0.0
    }

    fn normal(&self, _face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        self.distance(p).1
    }

    fn cast(&self, ray: &LocalRay, work: &mut Work) {
        let (around, within) = self.bounding();
        let Some(outer) = around.chord(ray) else { return };
        let inner = within.and_then(|within| within.chord(ray)).unwrap_or(outer);
        let from = |end: usize| [outer.t_mm[end], inner.t_mm[end]];
        let chord = self
            .enter(ray, from(0), 1.0)
            .zip(self.enter(ray, from(1), -1.0))
            .map(|(enter, exit)| Chord::on_face(0, enter, exit));
        work.chords.extend(chord.filter(|c| c.t_mm[0] < c.t_mm[1]));
    }
}
