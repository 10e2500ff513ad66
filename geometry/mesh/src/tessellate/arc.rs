//! Curved generatrix: an arc of an ellipse or of a curve parallel to it.

use std::f64::consts::{FRAC_PI_2, TAU};

/// Number of intervals of the table that converts scaled arc length to the ellipse's parameter.
const TABLE: usize = 512;

/// Step of Newton's method below which it stops: the remaining error of the distance is the step's square times the
/// radius of curvature.
const NEWTON_TOLERANCE_RAD: f64 = 1e-5;

/// Counter-clockwise arc in the (distance from axis, z) half plane: the points at `offset_mm` along the outward normal
/// of an ellipse, for its parameter between `from_rad` and `to_rad`.
#[derive(Clone, Debug)]
pub(super) struct Arc {
    pub centre: [f64; 2],
    pub semi_axes_mm: [f64; 2],
    pub offset_mm: f64,
    pub from_rad: f64,
    pub to_rad: f64,
}

impl Arc {
    /// Creates the arc from one point counter-clockwise to another.
    pub fn between(from: [f64; 2], to: [f64; 2], centre: [f64; 2], semi_axes_mm: [f64; 2]) -> Self {
        let parameter = |p: [f64; 2]| {
            ((p[1] - centre[1]) / semi_axes_mm[1]).atan2((p[0] - centre[0]) / semi_axes_mm[0])
        };
        let from_rad = parameter(from);
        let sweep = (parameter(to) - from_rad).rem_euclid(TAU);
        // Ends that differ only by rounding are those of a full turn, not of an empty arc.
        let sweep = if sweep < 1e-12 { TAU } else { sweep };
        Self { centre, semi_axes_mm, offset_mm: 0.0, from_rad, to_rad: from_rad + sweep }
    }

    fn is_circle(&self) -> bool {
        self.semi_axes_mm[0] == self.semi_axes_mm[1]
    }

    /// Returns the unit normal away from the centre.
    pub fn normal(&self, t: f64) -> [f64; 2] {
        let ([a, b], [c, s]) = (self.semi_axes_mm, cos_sin(t));
        let length = (b * c).hypot(a * s);
        [b * c / length, a * s / length]
    }

    /// Returns the point of the curve, mm.
    pub fn point(&self, t: f64) -> [f64; 2] {
        let ([a, b], [c, s], n) = (self.semi_axes_mm, cos_sin(t), self.normal(t));
        [
            self.centre[0] + a * c + self.offset_mm * n[0],
            self.centre[1] + b * s + self.offset_mm * n[1],
        ]
    }

    /// Returns the speed (mm per unit of `t`) and the curvature (1/mm) of the parallel curve.
    fn speed_and_curvature(&self, t: f64) -> (f64, f64) {
        let ([a, b], [c, s]) = (self.semi_axes_mm, cos_sin(t));
        let speed = (a * s).hypot(b * c);
        let curvature = a * b / (speed * speed * speed);
        // A parallel curve at the distance d has the radius of curvature R + d at the same parameter.
        let stretch = 1.0 + self.offset_mm * curvature;
        (speed * stretch, curvature / stretch)
    }

    /// Computes the signed distance of a point from the curve, mm, positive inside.
    ///
    /// `near` is the parameter of a nearby point of the curve, from which Newton's method finds the foot of the
    /// perpendicular on the ellipse.
    pub fn depth_of(&self, point: [f64; 2], near: f64) -> f64 {
        let [x, y] = [point[0] - self.centre[0], point[1] - self.centre[1]];
        let [a, b] = self.semi_axes_mm;
        if self.is_circle() {
            return a + self.offset_mm - (x * x + y * y).sqrt();
        }
        let (mut s, mut c) = near.sin_cos();
        for _ in 0..4 {
            let slope = (a * a - b * b) * s * c - a * x * s + b * y * c;
            let change = (a * a - b * b) * (c * c - s * s) - a * x * c - b * y * s;
            let step = -(slope / change).clamp(-0.2, 0.2);
            // The rotation is by the step's arc tangent, which equals the step when it is small enough to matter.
            let length = (1.0 + step * step).sqrt();
            (s, c) = ((s + step * c) / length, (c - step * s) / length);
            if step.abs() < NEWTON_TOLERANCE_RAD {
                break;
            }
        }
        let length = (b * b * c * c + a * a * s * s).sqrt();
        self.offset_mm - ((x - a * c) * b * c + (y - b * s) * a * s) / length
    }

    /// Splits the arc at its extreme points along the axes, so that they become vertices.
    pub fn split_at_extremes(&self) -> Vec<Self> {
        // Ends that are extreme points themselves, up to rounding, are not cut off again.
        let slack = 1e-9 * (self.to_rad - self.from_rad).max(1e-3);
        let first = (self.from_rad / FRAC_PI_2).floor() as i64;
        let last = (self.to_rad / FRAC_PI_2).ceil() as i64;
        let inner = (first..=last)
            .map(|k| k as f64 * FRAC_PI_2)
            .filter(|t| *t > self.from_rad + slack && *t < self.to_rad - slack);
        let mut cuts = vec![self.from_rad];
        cuts.extend(inner);
        cuts.push(self.to_rad);
        cuts.windows(2).map(|w| Self { from_rad: w[0], to_rad: w[1], ..self.clone() }).collect()
    }

    /// Computes a scaled arc length in which chords of equal length deviate equally far: the integral of the square
    /// root of the curvature.
    pub fn scale(&self) -> ScaledLength {
        let step = (self.to_rad - self.from_rad) / TABLE as f64;
        let mut cumulative = vec![0.0];
        if self.is_circle() {
            let total =
                (self.to_rad - self.from_rad) * (self.semi_axes_mm[0] + self.offset_mm).sqrt();
            cumulative.push(total);
        } else {
            for i in 0..TABLE {
                let t = self.from_rad + (i as f64 + 0.5) * step;
                let (speed, curvature) = self.speed_and_curvature(t);
                cumulative.push(cumulative[i] + speed * curvature.sqrt() * step);
            }
        }
        ScaledLength { from_rad: self.from_rad, to_rad: self.to_rad, cumulative }
    }
}

/// Scaled arc length, see [`Arc::scale`].
pub(super) struct ScaledLength {
    from_rad: f64,
    to_rad: f64,
    cumulative: Vec<f64>,
}

impl ScaledLength {
    /// Returns the scaled length of the whole arc, in square roots of millimetres.
    pub fn total(&self) -> f64 {
        self.cumulative[self.cumulative.len() - 1]
    }

    /// Returns the ellipse's parameter at a fraction of the whole.
    pub fn parameter(&self, fraction: f64) -> f64 {
        let target = fraction * self.total();
        let above = self.cumulative.partition_point(|&c| c < target).max(1);
        let above = above.min(self.cumulative.len() - 1);
        let (low, high) = (self.cumulative[above - 1], self.cumulative[above]);
        let place = (above - 1) as f64 + (target - low) / (high - low);
        let turn = self.to_rad - self.from_rad;
        self.from_rad + turn * place / (self.cumulative.len() - 1) as f64
    }
}

/// Computes cosine and sine, exact at quarter turns, where the extreme points are.
fn cos_sin(t: f64) -> [f64; 2] {
    let quarters = t / FRAC_PI_2;
    if quarters == quarters.round() {
        return match quarters.rem_euclid(4.0) as u8 {
            0 => [1.0, 0.0],
            1 => [0.0, 1.0],
            2 => [-1.0, 0.0],
            _ => [0.0, -1.0],
        };
    }
    let (s, c) = t.sin_cos();
    [c, s]
}
