//! Placement of the rings of a doubly curved face, and the number of points of each.
//!
//! To second order, a triangle inscribed in a surface deviates from it by half the square of the radius of the smallest
//! circle around it, in a plane whose axes are scaled by the square roots of the two principal curvatures. This gives
//! the candidates. Whether a candidate holds the tolerance is measured on the candidate itself, and the one with the
//! fewest triangles wins.

use super::arc::{Arc, ScaledLength};
use super::circle::{chords_per_turn, tolerance_for};
use super::stitch::{RingPoints, StripTriangle, stitch_sector};

/// Fraction of the tolerance that the measured deviation may reach; the rest covers the error of the measurement, which
/// is of second order along each edge.
const MEASURED_SHARE: f64 = 0.9;

/// Relative steps along the axis to try for the first and the last strip where they do not end in a pole: a given ring
/// next to them may have long chords.
const END_STRIPS: [f64; 4] = [0.4, 0.55, 0.75, 1.0];

/// Ratio of successive steps around the axis to try, beginning with the longest that could hold.
const CHORD_STEP_RATIO: f64 = 0.97;

/// Fraction of the best number of triangles so far above which a candidate is not measured.
const WORTH_MEASURING: f64 = 0.985;

/// Number of chord lengths to try.
const CHORDS: i32 = 26;

/// Numbers of strips to try from the first that holds: the best is never far from there.
const TRIES: usize = 4;

/// Largest number of strips; a whole sphere would have five million triangles.
const MOST_STRIPS: usize = 500;

/// Number of strips up to which neighbouring rings may have matching counts throughout. Beyond, counts differ, and
/// somewhere around each strip a triangle has its right angle on the shorter ring.
const FEW_STRIPS: usize = 6;

/// Ring of points around the axis at one height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    /// Parameter on the arc.
    pub t: f64,
    /// Distance from the axis and z, mm.
    pub at: [f64; 2],
    pub spread: RingPoints,
}

/// Finds the rings strictly between the two ends of an arc, in its direction. `None` if too many would be needed for
/// the tolerance.
pub(super) fn find_rings(arc: &Arc, ends: [Ring; 2], tolerance_mm: f64) -> Option<Vec<Ring>> {
    let [a, b] = arc.semi_axes_mm;
    // The rings at the ends are given: none of them may be coarser than the arc.
    let widest_mm = (a.max(b) + arc.offset_mm).max(ends[0].at[0]).max(ends[1].at[0]);
    let tolerance_mm = tolerance_for(widest_mm, tolerance_mm);
    let search = Search { arc, ends, tolerance_mm, scale: arc.scale() };
    let longest = 2.0 * (2.0 * MEASURED_SHARE * tolerance_mm).sqrt();
    let fewest = search.fewest_strips(longest);
    if fewest > MOST_STRIPS {
        return None;
    }
    let mut best: Option<(usize, Vec<Ring>)> = None;
    // Generous limit until a first candidate holds; then only a few more strips are tried.
    let mut last = 2 * fewest + 30;
    let mut strips = fewest;
    while strips <= last {
        for weights in end_weights(ends) {
            let Some(limit) = search.longest_chord(strips, weights, longest) else { continue };
            let mut shorter = 0;
            while shorter < CHORDS {
                let rings =
                    search.candidate(strips, weights, limit * CHORD_STEP_RATIO.powi(shorter));
                let cost = triangles(&ends, &rings);
                let enough =
                    |(least, _): &(usize, _)| cost as f64 > WORTH_MEASURING * *least as f64;
                if best.as_ref().is_some_and(enough) {
                    break; // Shorter chords only cost more.
                }
                let excess = search.deviation_ratio(&rings);
                if excess <= 1.0 {
                    if best.is_none() {
                        last = strips + TRIES;
                    }
                    best = Some((cost, rings));
                    break;
                }
                shorter += steps_shorter(excess);
            }
        }
        strips += 1;
    }
    best.map(|(_, rings)| rings)
}

/// Returns the smallest number of steps of [`CHORD_STEP_RATIO`] that can remove the excess deviation, which falls at most with
/// the square of the chord.
fn steps_shorter(excess: f64) -> i32 {
    let steps = 0.5 * excess.ln() / -CHORD_STEP_RATIO.ln();
    // The cast saturates, and the number never comes near that limit.
    1.max(steps.floor() as i32)
}

fn end_weights(ends: [Ring; 2]) -> Vec<[f64; 2]> {
    let poles = ends.map(|e| e.spread.count == 1);
    let both = |w: f64| [if poles[0] { 1.0 } else { w }, if poles[1] { 1.0 } else { w }];
    match poles {
        [true, true] => vec![[1.0, 1.0]],
        _ => END_STRIPS.map(both).into_iter().collect(),
    }
}

/// Counts triangles: every step of a ring is the base of one triangle on each side.
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
    /// Returns the relative length of strip `i` of `strips` along the axis.
    fn weight(strips: usize, weights: [f64; 2], i: usize) -> f64 {
        match i {
            0 => weights[0],
            _ if i + 1 == strips => weights[1],
            _ => 1.0,
        }
    }

    /// Returns the smallest number of strips whose steps along the axis could just hold, with the best step around it.
    fn fewest_strips(&self, longest: f64) -> usize {
        let strips = self.scale.total() / longest;
        // The best right triangle of a given size has two equal legs.
        let many = if self.is_saddle() { strips } else { std::f64::consts::SQRT_2 * strips };
        let strips = if many <= FEW_STRIPS as f64 { strips / 1.25 } else { 0.97 * many };
        (strips.floor() as usize).max(1)
    }

    /// Returns whether the surface is a saddle: curved in opposite senses along the axis and around it.
    fn is_saddle(&self) -> bool {
        let middle = (self.arc.from_rad + self.arc.to_rad) / 2.0;
        self.arc.normal(middle)[0] <= 0.0
    }

    /// Returns the longest step around the axis worth trying, in the scaled plane, next to a step along it that follows
    /// from the number of strips. `None` if the latter alone is too long.
    fn longest_chord(&self, strips: usize, weights: [f64; 2], longest: f64) -> Option<f64> {
        let whole: f64 = (0..strips).map(|i| Self::weight(strips, weights, i)).sum();
        let step = self.scale.total() / whole;
        if self.is_saddle() {
            // On a saddle edges deviate to one side or the other, and no combination is worse than one alone.
            return (strips <= 2 || step <= longest).then_some(longest);
        }
        if strips <= FEW_STRIPS {
            return Some(longest);
        }
        let square = longest * longest - step * step;
        (square > 0.0).then(|| square.sqrt())
    }

    /// Returns the rings of `strips` strips whose chords around the axis have the length `chord` in the scaled plane.
    fn candidate(&self, strips: usize, weights: [f64; 2], chord: f64) -> Vec<Ring> {
        let weight = |i: usize| Self::weight(strips, weights, i);
        let whole: f64 = (0..strips).map(weight).sum();
        let mut rings = Vec::with_capacity(strips);
        let mut done = 0.0;
        for i in 0..strips - 1 {
            done += weight(i);
            let t = self.scale.parameter(done / whole);
            let (at, normal) = (self.arc.point(t), self.arc.normal(t));
            // Circumference of the ring in the scaled plane: TAU r sqrt(curvature around), with curvature normal / r.
            let around = std::f64::consts::TAU * (at[0] * normal[0].abs()).sqrt() / chord;
            // Where the surface is flat across the axis, chords deviate along its other curvature: each ring must stay
            // clear of the next.
            let next = self.arc.point(self.scale.parameter((done + 0.5) / whole));
            let room = (next[0] - at[0]).hypot(next[1] - at[1]);
            let clear = chords_per_turn(at[0], 0.5 * room);
            let count = (around.max(clear) - 1e-9).ceil().max(3.0) as usize;
            rings.push(Ring { t, at, spread: RingPoints { count, staggered: i % 2 == 0 } });
        }
        rings
    }

    /// Returns the ratio of the measured deviation to the allowed one. If it exceeds 1, it is that of some triangle
    /// that deviates too far, not necessarily the worst.
    fn deviation_ratio(&self, rings: &[Ring]) -> f64 {
        let [first, last] = &self.ends;
        let at = |i: usize| match i {
            0 => first,
            _ => rings.get(i - 1).unwrap_or(last),
        };
        // Candidates mostly fail at an end or everywhere, so these strips are tested first.
        let likely = [0, rings.len(), rings.len() / 2];
        let others = (0..=rings.len()).filter(|i| !likely.contains(i));
        let mut worst = 0.0;
        for i in likely.into_iter().chain(others) {
            worst = self.strip_deviation_ratio(at(i), at(i + 1));
            if worst > 1.0 {
                break;
            }
        }
        worst
    }

    /// Returns the same ratio for the triangles between two rings.
    fn strip_deviation_ratio(&self, lower: &Ring, upper: &Ring) -> f64 {
        let mut worst = 0.0f64;
        let (mut a_old, mut a_new) = (corner(lower, 0), corner(lower, 1));
        let (mut b_old, mut b_new) = (corner(upper, 0), corner(upper, 1));
        let (lower_chord, upper_chord) = (self.edge(a_old, a_new), self.edge(b_old, b_new));
        let mut cross = self.edge(a_old, b_old);
        stitch_sector(lower.spread, upper.spread, |strip| {
            if worst > 1.0 {
                return;
            }
            let (corners, base) = match strip {
                StripTriangle::Lower { .. } => ([a_new, b_old, a_old], lower_chord),
                StripTriangle::Upper { .. } => ([b_new, a_old, b_old], upper_chord),
            };
            let next_cross = self.edge(corners[0], corners[1]);
            // Edges in the order of the corners: new diagonal, old diagonal, chord.
            let deviation = self.triangle_deviation(corners, [next_cross, cross, base]);
            worst = worst.max(deviation / (MEASURED_SHARE * self.tolerance_mm));
            cross = next_cross;
            match strip {
                StripTriangle::Lower { a, .. } => (a_old, a_new) = (a_new, corner(lower, a + 2)),
                StripTriangle::Upper { b, .. } => (b_old, b_new) = (b_new, corner(upper, b + 2)),
            }
        });
        worst
    }

    /// Computes the largest distance of a triangle's points from the surface, mm.
    ///
    /// Along an edge the distance is a parabola, so over the triangle it is the quadratic form 4 (a uv + b vw + c wu)
    /// of the barycentric coordinates, with `edges` the values halfway along the edges from each corner to the next.
    fn triangle_deviation(&self, corners: [Corner; 3], [a, b, c]: [f64; 3]) -> f64 {
        let edges = a.abs().max(b.abs()).max(c.abs());
        // Barycentric coordinates of the stationary point of the form, up to their sum.
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
        self.arc.depth_of([(x * x + y * y).sqrt(), z], mix(|c| c.t))
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
