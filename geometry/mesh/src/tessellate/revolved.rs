//! Tessellation of surfaces of revolution: a closed path in the (distance from axis, z) half plane, rotated around z.

use fabkit_geometry::{Path, Segment};

use super::arc::Arc;
use super::circle::ring_count;
use super::rings::{Ring, find_rings};
use super::stitch::{RingPoints, StripTriangle, stitch};
use crate::facets::Facets;

/// Distance below which a point counts as on the axis, mm.
const ON_AXIS_MM: f64 = 1e-9;

/// Segment of a generatrix.
pub(super) struct Stroke {
    pub to: [f64; 2],
    /// Arc, which always runs counter-clockwise; `None` for a straight stroke.
    pub arc: Option<Arc>,
    /// True if the stroke follows its arc, false if it runs against it.
    pub ccw: bool,
    pub face: u32,
}

impl Stroke {
    pub fn line(to: [f64; 2], face: u32) -> Self {
        Self { to, arc: None, ccw: true, face }
    }

    pub fn arc(to: [f64; 2], arc: Arc, face: u32) -> Self {
        Self { to, arc: Some(arc), ccw: true, face }
    }
}

/// Returns the strokes of a profile's path; faces are numbered from `first_face`.
pub(super) fn strokes(path: &Path, first_face: u32) -> Vec<Stroke> {
    let mut from = path.start;
    let mut strokes = Vec::with_capacity(path.segments.len());
    for (face, segment) in (first_face..).zip(&path.segments) {
        let to = segment.to();
        let bent = |centre, semi_axes, ccw| {
            let [a, b] = if ccw { [from, to] } else { [to, from] };
            Stroke { to, arc: Some(Arc::between(a, b, centre, semi_axes)), ccw, face }
        };
        strokes.push(match segment {
            Segment::Line { .. } => Stroke::line(to, face),
            Segment::Arc { centre, ccw, .. } => {
                // The radius is taken from the same end in both directions, so that shared arcs have equal radii.
                let end = if *ccw { to } else { from };
                let radius_mm = (end[0] - centre[0]).hypot(end[1] - centre[1]);
                bent(*centre, [radius_mm; 2], *ccw)
            }
            Segment::EllipticArc { centre, semi_axes_mm, ccw, .. } => {
                bent(*centre, *semi_axes_mm, *ccw)
            }
        });
        from = to;
    }
    strokes
}

/// Rotates one closed path around z. `solid_inside` is false for a hole's path. Returns false if too many triangles
/// would be needed.
pub(super) fn revolve(
    out: &mut Facets,
    start: [f64; 2],
    strokes: &[Stroke],
    solid_inside: bool,
    tolerance_mm: f64,
) -> bool {
    // Rings of each stroke, including the first and the last one; neighbouring strokes share theirs.
    let mut profiles = Vec::with_capacity(strokes.len());
    let mut from = start;
    for stroke in strokes {
        let Some(rings) = rings_of(from, stroke, tolerance_mm) else { return false };
        profiles.push(rings);
        from = stroke.to;
    }
    let area = enclosed_area(&profiles);
    // The direction of the path does not matter; only the side of the solid does.
    let flip = (area > 0.0) != solid_inside;

    let is_pole = |ring: &Ring| ring.spread.count == 1;
    let shared: Vec<Option<Placed>> = profiles
        .iter()
        .map(|rings| (!is_pole(&rings[0])).then(|| Placed::new(out, rings[0])))
        .collect();
    for (k, (stroke, rings)) in strokes.iter().zip(&profiles).enumerate() {
        let last = rings.len() - 1;
        if last == 1 && is_pole(&rings[0]) && is_pole(&rings[1]) {
            continue; // On the axis: sweeps nothing.
        }
        // Two fans that meet on the axis must not share the point, which would pinch the solid.
        let mut end = |at: usize, ring| at_end(out, shared[at % strokes.len()], ring);
        let (first, final_ring) = (end(k, rings[0]), end(k + 1, rings[last]));
        let mut placed = vec![first];
        placed.extend(rings[1..last].iter().map(|&ring| Placed::new(out, ring)));
        placed.push(final_ring);
        for pair in placed.windows(2) {
            // Stitching does not depend on the stroke's direction, so that bodies that share a face share its
            // triangles.
            if runs_forward(stroke, rings) {
                connect(out, pair[0], pair[1], stroke.face, flip);
            } else {
                connect(out, pair[1], pair[0], stroke.face, !flip);
            }
        }
    }
    true
}

fn at_end(out: &mut Facets, shared: Option<Placed>, ring: Ring) -> Placed {
    shared.unwrap_or_else(|| Placed::new(out, ring))
}

fn runs_forward(stroke: &Stroke, rings: &[Ring]) -> bool {
    match stroke.arc {
        Some(_) => stroke.ccw,
        None => {
            let ([r0, z0], [r1, z1]) = (rings[0].at, rings[rings.len() - 1].at);
            (z0, r0) <= (z1, r1)
        }
    }
}

fn end_ring(at: [f64; 2], t: f64, tolerance_mm: f64) -> Ring {
    if at[0] < ON_AXIS_MM {
        // Exactly on the axis, so that both strokes at a pole use the same point.
        return Ring { t, at: [0.0, at[1]], spread: RingPoints::pole() };
    }
    Ring { t, at, spread: RingPoints { count: ring_count(at[0], tolerance_mm), staggered: false } }
}

fn rings_of(from: [f64; 2], stroke: &Stroke, tolerance_mm: f64) -> Option<Vec<Ring>> {
    let Some(arc) = &stroke.arc else {
        return Some([from, stroke.to].map(|p| end_ring(p, 0.0, tolerance_mm)).to_vec());
    };
    let [first, last] = if stroke.ccw { [from, stroke.to] } else { [stroke.to, from] };
    let mut rings = vec![end_ring(first, arc.from_rad, tolerance_mm)];
    let pieces = arc.split_at_extremes();
    for (i, piece) in pieces.iter().enumerate() {
        let end = if i + 1 == pieces.len() { last } else { arc.point(piece.to_rad) };
        let end = end_ring(end, piece.to_rad, tolerance_mm);
        let start = Ring { t: piece.from_rad, ..rings[rings.len() - 1] };
        rings.extend(find_rings(piece, [start, end], tolerance_mm)?);
        rings.push(end);
    }
    if !stroke.ccw {
        rings.reverse();
    }
    Some(rings)
}

/// Computes the area of the polygon through all rings, positive for counter-clockwise polygons, mm^2.
fn enclosed_area(profiles: &[Vec<Ring>]) -> f64 {
    let pairs = profiles.iter().flat_map(|rings| rings.windows(2));
    pairs.map(|w| w[0].at[0] * w[1].at[1] - w[1].at[0] * w[0].at[1]).sum::<f64>() / 2.0
}

/// Ring whose points are vertices of the mesh.
#[derive(Clone, Copy)]
struct Placed {
    ring: Ring,
    first_vertex: u32,
}

impl Placed {
    fn new(out: &mut Facets, ring: Ring) -> Self {
        let first_vertex = out.vertices.len() as u32;
        let [r, z] = ring.at;
        for k in 0..ring.spread.count {
            let [c, s] = ring.spread.direction(k);
            out.vertex([r * c, r * s, z]);
        }
        Self { ring, first_vertex }
    }

    fn vertex(&self, k: usize) -> u32 {
        self.first_vertex + (k % self.ring.spread.count) as u32
    }
}

/// Adds the triangles between two rings. Seen from outside, `upper` follows `lower` counter-clockwise along the
/// profile, or clockwise if `flip`.
fn connect(out: &mut Facets, lower: Placed, upper: Placed, face: u32, flip: bool) {
    stitch(lower.ring.spread, upper.ring.spread, |strip| {
        let [p, q, r] = match strip {
            StripTriangle::Lower { a, b } => {
                [lower.vertex(a), lower.vertex(a + 1), upper.vertex(b)]
            }
            StripTriangle::Upper { a, b } => {
                [lower.vertex(a), upper.vertex(b + 1), upper.vertex(b)]
            }
        };
        out.triangle(if flip { [p, r, q] } else { [p, q, r] }, face);
    });
}
