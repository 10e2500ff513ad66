//! Part of the tool's own surface that becomes part of the body.

use super::intersection_curves::Curve;
use super::revolved_tool::RevolvedTool;
use crate::tessellate::{RingPoints, StripTriangle, stitch};

/// Corner of a wall's triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Corner {
    /// Vertex of the tool's tessellation.
    Tool(u32),
    /// Point of a curve.
    Curve { curve: usize, point: usize },
}

/// Emits the part of the tool's surface inside (or outside) the base, with the orientation of the tool.
pub(super) fn wall(
    pin: &RevolvedTool,
    curves: &[Curve],
    keep_inside: bool,
    mut emit: impl FnMut([Corner; 3], u32),
) {
    // Curves divide the profile into stretches that are alternately inside and outside of the base.
    let mut inside = !curves[0].entering;
    for i in 0..=curves.len() {
        if inside == keep_inside {
            stretch(pin, curves, i.checked_sub(1), (i < curves.len()).then_some(i), &mut emit);
        }
        inside = !inside;
    }
}

/// Emits the stretch from one curve to another; `None` stands for the start or the end of the profile.
fn stretch(
    pin: &RevolvedTool,
    curves: &[Curve],
    from: Option<usize>,
    to: Option<usize>,
    emit: &mut impl FnMut([Corner; 3], u32),
) {
    let stroke_of = |curve: usize| curves[curve].stroke;
    let first = from.map_or(0, stroke_of);
    let last = to.map_or(pin.strokes.len() - 1, stroke_of);
    for (index, stroke) in pin.strokes.iter().enumerate().take(last + 1).skip(first) {
        let starts_here = from.filter(|&c| stroke_of(c) == index);
        let ends_here = to.filter(|&c| stroke_of(c) == index);
        if starts_here.is_none() && ends_here.is_none() {
            for &t in &stroke.triangles {
                emit(pin.facets.triangles[t as usize].map(Corner::Tool), stroke.face);
            }
            continue;
        }
        let ring = |curve: Option<usize>, end: usize| match curve {
            Some(curve) => Ring::Curve(curve, curves[curve].in_tool.len()),
            None => Ring::Tool(&stroke.rings[end]),
        };
        let (lower, upper) = (ring(starts_here, 0), ring(ends_here, 1));
        stitch(lower.spread(), upper.spread(), |strip| {
            let corners = match strip {
                StripTriangle::Lower { a, b } => {
                    [lower.corner(a), lower.corner(a + 1), upper.corner(b)]
                }
                StripTriangle::Upper { a, b } => {
                    [lower.corner(a), upper.corner(b + 1), upper.corner(b)]
                }
            };
            emit(corners, stroke.face);
        });
    }
}

enum Ring<'a> {
    Curve(usize, usize),
    Tool(&'a [u32]),
}

impl Ring<'_> {
    fn spread(&self) -> RingPoints {
        let count = match self {
            Self::Curve(_, count) => *count,
            Self::Tool(vertices) => vertices.len(),
        };
        RingPoints { count, staggered: false }
    }

    fn corner(&self, k: usize) -> Corner {
        match self {
            Self::Curve(curve, count) => Corner::Curve { curve: *curve, point: k % count },
            Self::Tool(vertices) => Corner::Tool(vertices[k % vertices.len()]),
        }
    }
}
