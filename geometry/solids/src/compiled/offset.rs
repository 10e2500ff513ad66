//! Parallel surface of an ellipsoid of revolution: distance function and line crossings.

use nalgebra::{Vector2, Vector3};

use super::ring::{meridian, rotate_to_azimuth};
use super::shape::{CastBuffers, Chord, LocalRay, Shape};
use crate::{Ellipsoid, EllipsoidOffset};

/// First quadrant of an ellipse around the origin, in units of its short half axis and with the long one first.
///
/// The nearest point comes from one root of a scalar equation (Eberly, "Distance from a Point to an Ellipse, an
/// Ellipsoid, or a Hyperellipsoid", 2013), written as for a trust region (Conn, Gould and Toint, "Trust-Region
/// Methods", 2000, section 7.3): an increasing concave function on which Newton's method approaches the root from the
/// left without ever overshooting. No branch of the distance can be mistaken for another. From a point to the right of
/// the root one step leads to its left.
#[derive(Clone, Copy)]
struct Quadrant {
    short_mm: f64,
    /// Ratio of the long to the short half axis; `k` is its square.
    long: f64,
    k: f64,
    /// k - 1 without cancellation. For the same reason the parameter s is counted from its pole.
    gap: f64,
    /// True if the long axis lies along y, false if along x.
    is_upright: bool,
}

impl Quadrant {
    fn new(half_axes: Vector2<f64>) -> Self {
        let is_upright = half_axes.x < half_axes.y;
        let (a, b) = (half_axes.max(), half_axes.min());
        let long = a / b;
        let gap = (a - b) * (a + b) / (b * b);
        Self { short_mm: b, long, k: long * long, gap, is_upright }
    }

    fn turned(&self, v: Vector2<f64>) -> Vector2<f64> {
        if self.is_upright { v.yx() } else { v }
    }

    /// Returns the nearest point of the ellipse, in units of the half axes, for a point so near to the long axis that
    /// the equation's root is lost in rounding; `None` for any other point.
    fn on_axis(&self, z: Vector2<f64>) -> Option<[f64; 2]> {
        if z.y > 1e-100 {
            return None;
        }
        let u = self.long * z.x / self.gap;
        // The point lies between the centres of curvature of the axis' two ends, or beyond them.
        Some(if u < 1.0 { [u, (1.0 - u * u).sqrt()] } else { [1.0, 0.0] })
    }

    /// Estimates the parameter of the nearest point for a point about `offset` outside the ellipse, by treating it as a
    /// point of an ellipse with half axes longer by `offset`.
    fn first_guess(&self, offset: f64, z: Vector2<f64>) -> f64 {
        let (long, short) = (self.long + offset, 1.0 + offset);
        let normal = Vector2::new(z.x * short * short, z.y * long * long);
        let (x, y) = (normal.x * normal.x, normal.y * normal.y);
        1.0 + offset * ((self.k * x + y) / (x + y)).sqrt()
    }

    /// Computes the signed distance, mm, of a point in the first quadrant (negative inside) and its gradient, the unit
    /// outward normal at the nearest point. Converges fastest where the distance is about `guess_mm`.
    fn distance(&self, p: Vector2<f64>, guess_mm: f64) -> (f64, Vector2<f64>) {
        let z = self.turned(p) / self.short_mm;
        let [u, v] = self.on_axis(z).unwrap_or_else(|| {
            let n = self.long * z.x;
            // At the root |(u, v)| = 1. Both bounds lie left of it, where the length is above 1.
            let least = z.y.max((n * n + z.y * z.y).sqrt() - self.gap);
            let mut s = least.max(self.first_guess(guess_mm / self.short_mm, z));
            for _ in 0..100 {
                let (for_u, for_v) = (1.0 / (s + self.gap), 1.0 / s);
                let (u, v) = (n * for_u, z.y * for_v);
                let squared = u * u + v * v;
                let slope = u * u * for_u + v * v * for_v;
                let next = (s + (squared.sqrt() - 1.0) * squared / slope).max(least);
                // Convergence is quadratic: after a step this small the next one would be rounding.
                let is_last = (next - s).abs() <= 1e-9 * s;
                s = next;
                if is_last {
                    break;
                }
            }
            [n / (s + self.gap), z.y / s]
        });
        let normal = Vector2::new(u / self.long, v).normalize();
        // Projected on the normal, an error in the nearest point enters only squared.
        let beyond = (z - Vector2::new(self.long * u, v)).dot(&normal);
        (beyond * self.short_mm, self.turned(normal))
    }
}

impl EllipsoidOffset {
    fn half_axes(&self) -> Vector2<f64> {
        Vector2::new(self.equatorial_mm, self.polar_mm)
    }

    /// Computes the signed distance from the parallel surface, mm (positive outside), and its gradient.
    #[inline]
    pub(crate) fn distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        // The sphere needs no iteration. At its centre all normals are equivalent, so any serves.
        if self.equatorial_mm == self.polar_mm {
            let far_mm = p.norm();
            let normal = if far_mm > 0.0 { p / far_mm } else { Vector3::x() };
            return (far_mm - self.equatorial_mm - self.offset_mm, normal);
        }
        let flat = meridian(p);
        let (from_ellipse, mut normal) = Quadrant::new(self.half_axes())
            .distance(Vector2::new(flat.x, flat.y.abs()), self.offset_mm);
        normal.y = normal.y.copysign(p.z);
        (from_ellipse - self.offset_mm, rotate_to_azimuth(normal, p))
    }

    /// Returns an ellipsoid that encloses the solid, for a first guess and for early misses, and one that lies within
    /// the solid if a tight one is known.
    fn bounding(&self) -> (Ellipsoid, Option<Ellipsoid>) {
        let short = self.equatorial_mm.min(self.polar_mm);
        // By Minkowski's inequality on the support functions this ellipsoid lies within for positive offsets and
        // encloses for negative ones.
        let shifted = [self.equatorial_mm + self.offset_mm, self.polar_mm + self.offset_mm];
        let of = |[equatorial, polar]: [f64; 2], growth: f64| Ellipsoid {
            // Smallest growth that rounding cannot undo.
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

    /// Finds where a line enters and leaves, by two iterations that approach along it from either side. `None` if the
    /// line misses.
    ///
    /// `outer_mm` are parameters before each crossing, and `guess_mm` parameters near it.
    fn find_chord_ends(
        &self,
        ray: &LocalRay,
        outer_mm: [f64; 2],
        guess_mm: [f64; 2],
    ) -> Option<[f64; 2]> {
        let ellipse = Quadrant::new(self.half_axes());
        let offset = self.offset_mm / ellipse.short_mm;
        let mut ends = [0, 1].map(|end| {
            let sign = [1.0, -1.0][end];
            ChordEndIteration {
                sign,
                outside_mm: sign * outer_mm[end],
                t_mm: sign * guess_mm[end],
                s: None,
                is_found: false,
            }
        });
        for _ in 0..200 {
            // The ends take turns: neither waits for the other's result, so a processor computes both at once.
            for end in ends.iter_mut().filter(|end| !end.is_found) {
                end.step(&ellipse, offset, ray)?;
            }
            if ends.iter().all(|end| end.is_found) {
                return Some(ends.map(|end| end.sign * end.t_mm));
            }
        }
        // If it converges only linearly for this long, the line is a tangent.
        None
    }
}

/// Iteration for one end of a line's chord.
///
/// The solid lies behind every plane that touches it. So where a line crosses such a plane from its front it has not
/// entered yet, and if it never crosses, it misses. Neither conclusion needs the plane at the nearest point, which is
/// what Newton's method on the distance would require. Therefore each iteration takes one step on the line and one
/// towards the nearest point. The line is followed from one side only, and both unknowns converge as fast as in
/// Newton's method in two unknowns.
struct ChordEndIteration {
    /// Direction along the line that leads into the solid: 1 or -1.
    sign: f64,
    /// Parameter no farther than the crossing, mm along the line in the inward direction. From the second step on, the
    /// same holds for `t_mm`.
    outside_mm: f64,
    t_mm: f64,
    /// Approximate parameter of the point nearest to the one at `t_mm`; see [`Quadrant`].
    s: Option<f64>,
    is_found: bool,
}

impl ChordEndIteration {
    /// Takes one step. `None` if the line misses.
    #[inline]
    fn step(&mut self, ellipse: &Quadrant, offset: f64, ray: &LocalRay) -> Option<()> {
        let Quadrant { short_mm, long, gap, .. } = *ellipse;
        let p = ray.at(self.sign * self.t_mm);
        let flat = meridian(&p);
        // Velocity away from the axis and the equator of a point that moves inward, per mm.
        let across = if flat.x > 0.0 { p.xy().dot(&ray.direction.xy()) / flat.x } else { 0.0 };
        let along = ray.direction.z * 1.0_f64.copysign(p.z);
        let velocity = ellipse.turned(Vector2::new(across, along)) * (self.sign / short_mm);
        let z = ellipse.turned(Vector2::new(flat.x, flat.y.abs())) / short_mm;

        let is_first = self.s.is_none();
        let s = self.s.unwrap_or_else(|| ellipse.first_guess(offset, z)).max(z.y);
        let (for_u, for_v) = (1.0 / (s + gap), 1.0 / s);
        let on_axis = ellipse.on_axis(z);
        let [u, v] = on_axis.unwrap_or([long * z.x * for_u, z.y * for_v]);
        // Length of the plane's normal, and the plane's distance from the centre times that length.
        let normal = Vector2::new(u / long, v);
        let (norm, support) = (normal.norm(), (u * u + v * v).sqrt());
        let beyond = normal.dot(&z) - support - offset * norm;
        let approach = normal.dot(&velocity);
        let (missing, slope) = ((support - 1.0) * support * support, u * u * for_u + v * v * for_v);
        let is_nearest = on_axis.is_some() || missing.abs() <= 1e-8 * s * slope;

        // Error of `beyond` by rounding of coordinates of the size of the ray's reach.
        let resolution = 4.0 * f64::EPSILON * ray.reach_mm / short_mm * norm;
        let is_outside = !is_first || beyond >= -resolution;
        if is_nearest && is_outside && beyond <= resolution {
            self.is_found = true;
            return Some(());
        }
        if beyond > resolution && approach >= 0.0 {
            return None;
        }
        // Along a grazing line a step back would lead far away.
        let is_grazing = approach >= 0.0 || (beyond < 0.0 && approach * short_mm > -0.1 * norm);
        if !is_grazing {
            self.outside_mm = self.outside_mm.max(self.t_mm - beyond / approach);
        }
        let step_mm = self.outside_mm - self.t_mm;
        self.t_mm = self.outside_mm;
        // Convergence is quadratic. Near a tangent steps only halve, and the remaining distance is as small as the last
        // step.
        self.is_found = is_nearest && !is_grazing && step_mm.abs() <= 1e-9 * ray.reach_mm;
        // The root is updated to first order for the moved point.
        let moved = (u * for_u * long * velocity.x + v * for_v * velocity.y) * step_mm;
        self.s = Some(if on_axis.is_some() { s } else { s + (missing + moved) / slope });
        Some(())
    }
}

impl Shape for EllipsoidOffset {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        meridian(u).component_mul(&self.half_axes()).norm() + self.offset_mm
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        self.distance(p).0 < 0.0
    }

    fn normal(&self, _face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        self.distance(p).1
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        let (around, within) = self.bounding();
        let Some(outer) = around.chord(ray) else { return };
        let inner = within.and_then(|within| within.chord(ray)).unwrap_or(outer);
        let chord = self
            .find_chord_ends(ray, outer.t_mm, inner.t_mm)
            .map(|[enter, exit]| Chord::on_face(0, enter, exit));
        work.chords.extend(chord.filter(|c| c.t_mm[0] < c.t_mm[1]));
    }
}
