//! Where the rings of a doubly curved face go, and how many points each has.
//!
//! To second order, a triangle inscribed in a surface strays from it by half the square of the
//! radius of the smallest circle around it, in a plane whose axes are scaled by the square roots of
//! the two principal curvatures. That gives the candidates; which of them hold the tolerance is
//! measured on the candidate itself, and the one with the fewest triangles wins.

use super::arc::{Arc, ScaledLength};
use super::circle::chords_per_turn;
use super::stitch::{Spread, Strip, stitch_part};

/// Share of the tolerance that the measured deviation may reach; the rest covers what the
/// measurement, second order along each edge, may miss.
const MEASURED_SHARE: f64 = 0.9;

/// Steps along the axis of the first and last strip, relative to the others. A given ring next to
/// them may have long chords, and a pole's fan reaches farther than a strip.
const END_STRIPS: [f64; 5] = [0.35, 0.55, 0.75, 1.0, 1.25];

/// Steps around the axis to try, in units of the scaled radius that the tolerance allows.
const CHORDS: [f64; 7] = [1.95, 1.8, 1.65, 1.5, 1.35, 1.15, 0.9];

/// Points around the axis at one height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    /// The arc's parameter.
    pub t: f64,
    /// Distance from the axis and z, mm.
    pub at: [f64; 2],
    pub spread: Spread,
}

/// The rings strictly between the two ends of an arc, in its direction. `None` if no sensible
/// number of them holds the tolerance.
pub(super) fn between(arc: &Arc, ends: [Ring; 2], tolerance_mm: f64) -> Option<Vec<Ring>> {
    let search = Search { arc, ends, tolerance_mm, scale: arc.scale() };
    let reach = (2.0 * tolerance_mm).sqrt();
    let fewest = ((search.scale.total() / (2.5 * reach)).floor() as usize).max(1);
    let most = 8 + (search.scale.total() / (0.25 * reach)).ceil() as usize;
    let mut best: Option<(usize, Vec<Ring>)> = None;
    for strips in fewest..=most {
        let mut hopeless = best.is_some();
        for weights in end_weights(ends) {
            for chord in CHORDS {
                let Some(rings) = search.candidate(strips, weights, chord * reach) else {
                    continue;
                };
                let cost = triangles(&ends, &rings);
                if best.as_ref().is_some_and(|(least, _)| cost >= *least) {
                    break; // Shorter chords only cost more.
                }
                hopeless = false;
                if search.holds(&rings) {
                    best = Some((cost, rings));
                    break;
                }
            }
        }
        if hopeless {
            break;
        }
    }
    best.map(|(_, rings)| rings)
}

fn end_weights(ends: [Ring; 2]) -> Vec<[f64; 2]> {
    let poles = ends.map(|e| e.spread.count == 1);
    let both = |w: f64| [if poles[0] { 1.0 } else { w }, if poles[1] { 1.0 } else { w }];
    match poles {
        [true, true] => vec![[1.0, 1.0]],
        _ => END_STRIPS.map(both).into_iter().collect(),
    }
}

/// Every step of a ring is the base of one triangle on each side.
fn triangles(ends: &[Ring; 2], rings: &[Ring]) -> usize {
    let base = |ring: &Ring| if ring.spread.count == 1 { 0 } else { ring.spread.count };
    base(&ends[0]) + base(&ends[1]) + 2 * rings.iter().map(base).sum::<usize>()
}

struct Search<'a> {
    arc: &'a Arc,
    ends: [Ring; 2],
    tolerance_mm: f64,
    scale: ScaledLength,
}

impl Search<'_> {
    /// `strips` strips whose chords around the axis are `chord` long in the scaled plane. `None`
    /// where a step along the axis could not hold the tolerance whatever the chords.
    fn candidate(&self, strips: usize, weights: [f64; 2], chord: f64) -> Option<Vec<Ring>> {
        let weight = |i: usize| match i {
            0 => weights[0],
            _ if i + 1 == strips => weights[1],
            _ => 1.0,
        };
        let whole: f64 = (0..strips).map(weight).sum();
        let step = self.scale.total() / whole;
        if strips > 2 && step > 2.0 * (2.0 * self.tolerance_mm).sqrt() {
            return None;
        }
        let mut rings = Vec::with_capacity(strips);
        let mut done = 0.0;
        for i in 0..strips - 1 {
            done += weight(i);
            let t = self.scale.parameter(done / whole);
            let (at, normal) = (self.arc.point(t), self.arc.normal(t));
            let around = std::f64::consts::TAU * (at[0] * normal[0].abs()).sqrt() / chord;
            // Where the surface lies flat across the axis, chords bend it along its other
            // curvature: keep each ring clear of the next.
            let next = self.arc.point(self.scale.parameter((done + 0.5) / whole));
            let room = (next[0] - at[0]).hypot(next[1] - at[1]);
            let clear = chords_per_turn(at[0], 0.5 * room);
            let count = (around.max(clear) - 1e-9).ceil().max(3.0) as usize;
            rings.push(Ring { t, at, spread: Spread { count, staggered: i % 2 == 0 } });
        }
        Some(rings)
    }

    fn holds(&self, rings: &[Ring]) -> bool {
        let mut below = self.ends[0];
        let mut check = |above: &Ring| {
            let good = self.strip_deviation(&below, above);
            below = *above;
            good
        };
        // The middle strip stands for most: look there first.
        if let [.., _, _] = rings {
            let i = rings.len() / 2;
            if !self.strip_deviation(&rings[i - 1], &rings[i]) {
                return false;
            }
        }
        rings.iter().all(&mut check) && check(&self.ends[1])
    }

    /// Whether all triangles between two rings hold the tolerance.
    fn strip_deviation(&self, lower: &Ring, upper: &Ring) -> bool {
        let mut good = true;
        let lower_chord = self.edge(corner(lower, 0), corner(lower, 1));
        let upper_chord = self.edge(corner(upper, 0), corner(upper, 1));
        stitch_part(lower.spread, upper.spread, |strip| {
            if !good {
                return;
            }
            let (corners, base) = match strip {
                Strip::Lower { a, b } => {
                    ([corner(lower, a), corner(lower, a + 1), corner(upper, b)], lower_chord)
                }
                Strip::Upper { a, b } => {
                    ([corner(upper, b), corner(upper, b + 1), corner(lower, a)], upper_chord)
                }
            };
            good = self.triangle_deviation(corners, base) <= MEASURED_SHARE * self.tolerance_mm;
        });
        good
    }

    /// Largest distance of a triangle's points from the surface, mm.
    ///
    /// Along an edge the distance is a parabola, so over the triangle it is the quadratic form
    /// 4 (a uv + b vw + c wu) of the barycentric coordinates, with the values at the edge midpoints.
    fn triangle_deviation(&self, corners: [Corner; 3], base: f64) -> f64 {
        let (a, b, c) =
            (base, self.edge(corners[1], corners[2]), self.edge(corners[2], corners[0]));
        let edges = a.abs().max(b.abs()).max(c.abs());
        let weights = [b * (a + c - b), c * (a + b - c), a * (b + c - a)];
        let inside = weights.iter().all(|w| *w > 0.0) || weights.iter().all(|w| *w < 0.0);
        if !inside {
            return edges;
        }
        let sum: f64 = weights.iter().sum();
        edges.max(self.depth(corners, weights.map(|w| w / sum)).abs())
    }

    fn edge(&self, from: Corner, to: Corner) -> f64 {
        self.depth([from, to, to], [0.5, 0.5, 0.0])
    }

    fn depth(&self, corners: [Corner; 3], weights: [f64; 3]) -> f64 {
        let mix = |pick: fn(&Corner) -> f64| {
            corners.iter().zip(weights).map(|(c, w)| w * pick(c)).sum::<f64>()
        };
        let [x, y, z] = [mix(|c| c.at[0]), mix(|c| c.at[1]), mix(|c| c.at[2])];
        self.arc.depth_of([x.hypot(y), z], mix(|c| c.t))
    }
}

#[derive(Clone, Copy)]
struct Corner {
    at: [f64; 3],
    t: f64,
}

fn corner(ring: &Ring, k: usize) -> Corner {
    let [c, s] = ring.spread.direction(k);
    let [r, z] = ring.at;
    Corner { at: [r * c, r * s, z], t: ring.t }
}
