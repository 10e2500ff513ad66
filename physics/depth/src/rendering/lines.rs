//! Line detection between samples that do not see one smooth surface.

use super::framing::Framing;
use super::surface::{CUT_LEAF, VisibleSurface};

/// Cosine of about 10 degrees: faces that meet at more make a crease.
const SMOOTH_COSINE: f64 = 0.985;

/// Sine of the angle at which a chord between neighbouring samples leaves a surface; a steeper one is a step in depth.
const STEEPEST_CHORD: f64 = 0.35;

/// Safety factor on the largest depth difference on a monotone slope, which is the steeper slope times the distance
/// (mean value theorem). A larger difference is a step.
const STEP_FACTOR: f64 = 1.5;

/// Step below which a difference is numerical noise, mm.
const LEAST_STEP_MM: f64 = 1e-6;

/// Strength of a line between two samples, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Line {
    /// Strength as an outline: a step in depth, the border of a body or of a section.
    pub outline: f32,
    /// Strength as a crease, where two faces meet.
    pub crease: f32,
}

impl Line {
    pub const NONE: Self = Self { outline: 0.0, crease: 0.0 };

    pub fn is_visible(self) -> bool {
        self.outline > 0.02 || self.crease > 0.02
    }

    #[must_use]
    pub fn stronger(self, other: Self) -> Self {
        Self { outline: self.outline.max(other.outline), crease: self.crease.max(other.crease) }
    }
}

/// Finds the line between two neighbouring samples from the surfaces that each sees, front to back.
///
/// The n-th surface of a body in one is compared with its n-th in the other.
pub(super) fn line_between(a: &[VisibleSurface], b: &[VisibleSurface], framing: &Framing) -> Line {
    let mut line = Line::NONE;
    for (index, surface) in a.iter().enumerate() {
        let found = match partner(a, index, b) {
            Some(other) => break_between(surface, other, framing),
            None => outline(surface.line_weight),
        };
        line = line.stronger(found);
    }
    for (index, surface) in b.iter().enumerate() {
        if partner(b, index, a).is_none() {
            line = line.stronger(outline(surface.line_weight));
        }
    }
    line
}

fn outline(weight: f64) -> Line {
    Line { outline: weight as f32, crease: 0.0 }
}

/// Returns the surface in `there` that corresponds to surface `index` of `here`.
fn partner<'a>(
    here: &[VisibleSurface],
    index: usize,
    there: &'a [VisibleSurface],
) -> Option<&'a VisibleSurface> {
    let actor = here[index].actor;
    // A body may show several surfaces along a ray, such as both walls of a tube.
    let rank = here[..index].iter().filter(|s| s.actor == actor).count();
    there.iter().filter(|s| s.actor == actor).nth(rank)
}

/// Finds the discontinuity between corresponding surfaces of two samples.
fn break_between(a: &VisibleSurface, b: &VisibleSurface, framing: &Framing) -> Line {
    let chord = b.point - a.point;
    let length_mm = chord.norm();
    let direction = framing.direction_to(&a.point);
    let step_mm = chord.dot(&direction).abs();
    if length_mm == 0.0 {
        return Line::NONE;
    }
    let across_mm = (length_mm * length_mm - step_mm * step_mm).max(0.0).sqrt();
    let (facing_a, facing_b) = (a.normal.dot(&direction).abs(), b.normal.dot(&direction).abs());
    let facing = facing_a.min(facing_b).max(1e-9);
    // Tangent of the steeper surface's inclination to the image plane.
    let slope = (1.0 - facing * facing).max(0.0).sqrt() / facing;
    let is_smooth = a.normal.dot(&b.normal) > SMOOTH_COSINE;
    let same_face = a.leaf == b.leaf && a.face == b.face;
    let steepness = a.normal.dot(&chord).abs().max(b.normal.dot(&chord).abs()) / length_mm;

    let ends_a_section = (a.leaf == CUT_LEAF) != (b.leaf == CUT_LEAF);
    let leaves_the_surface = (same_face || is_smooth) && steepness > STEEPEST_CHORD;
    if step_mm > STEP_FACTOR * slope * across_mm + LEAST_STEP_MM
        || leaves_the_surface
        || ends_a_section
    {
        outline(a.line_weight.max(b.line_weight))
    } else if !same_face && !is_smooth {
        Line { outline: 0.0, crease: a.line_weight.min(b.line_weight) as f32 }
    } else {
        Line::NONE
    }
}
