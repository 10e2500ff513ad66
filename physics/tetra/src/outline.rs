//! Triangulation of a flat face with any outline.

use fabkit_geometry::{Path, Segment};
use spade::{
    AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation,
};

use crate::mesh::{Face, TetraError};

/// Minimum angle of the refined triangles, degrees. Ruppert's method is proven to reach 20.7; in practice it reaches
/// 30.
const MIN_ANGLE_DEG: f64 = 30.0;
/// Maximum area of a triangle over its squared side: that of an equilateral triangle, with some room for longer sides.
const MAX_AREA_PER_EDGE_SQUARED: f64 = 0.5;
/// Maximum number of nodes. A refinement that reaches it would not end.
const MAX_NODES: usize = 2_000_000;

/// Triangulates a face. Returns corners and triangles, counter-clockwise, with edges about `edge_mm` long. Nodes of the
/// outline lie on it exactly.
///
/// # Errors
/// [`TetraError::Outline`].
pub(crate) fn triangulate(
    outline: &Path,
    edge_mm: f64,
) -> Result<(Vec<[f64; 2]>, Vec<Face>), TetraError> {
    let failed = |what: String| TetraError::Outline { what };
    let mut triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut edge = Vec::new();
    for [x, y] in sample_outline(outline, edge_mm) {
        let handle = triangulation.insert(Point2::new(x, y));
        edge.push(handle.map_err(|error| failed(error.to_string()))?);
    }
    for (i, from) in edge.iter().enumerate() {
        let to = edge[(i + 1) % edge.len()];
        if *from == to || !triangulation.can_add_constraint(*from, to) {
            return Err(failed("the outline meets itself".to_owned()));
        }
        triangulation.add_constraint(*from, to);
    }
    let parameters = RefinementParameters::<f64>::new()
        .exclude_outer_faces(true)
        .keep_constraint_edges()
        .with_angle_limit(AngleLimit::from_deg(MIN_ANGLE_DEG))
        .with_max_allowed_area(MAX_AREA_PER_EDGE_SQUARED * edge_mm * edge_mm)
        .with_max_additional_vertices(MAX_NODES);
    let refined = triangulation.refine(parameters);
    if !refined.refinement_complete {
        return Err(failed(format!("its triangles do not become even with {MAX_NODES} nodes")));
    }
    let mut excluded: Vec<usize> = refined.excluded_faces.iter().map(|face| face.index()).collect();
    excluded.sort_unstable();
    let nodes = triangulation.vertices().map(|vertex| {
        let Point2 { x, y } = vertex.position();
        [x, y]
    });
    let faces = triangulation
        .inner_faces()
        .filter(|face| excluded.binary_search(&face.fix().index()).is_err())
        .map(|face| face.vertices().map(|vertex| vertex.fix().index() as u32));
    Ok((nodes.collect(), faces.collect()))
}

/// Samples the outline with points about `edge_mm` apart, including each of its corners.
fn sample_outline(outline: &Path, edge_mm: f64) -> Vec<[f64; 2]> {
    let (mut points, mut from) = (Vec::new(), outline.start);
    for segment in &outline.segments {
        let to = segment.to();
        match segment {
            Segment::Arc { centre, ccw, .. } => {
                let angle = |p: [f64; 2]| (p[1] - centre[1]).atan2(p[0] - centre[0]);
                let radius_mm = (from[0] - centre[0]).hypot(from[1] - centre[1]);
                let turn = (angle(to) - angle(from)) * if *ccw { 1.0 } else { -1.0 };
                let turn = turn.rem_euclid(std::f64::consts::TAU);
                // An arc that ends where it starts is a full circle.
                let turn = if turn == 0.0 { std::f64::consts::TAU } else { turn };
                let steps = (radius_mm * turn / edge_mm).ceil().max(2.0);
                let sign = if *ccw { 1.0 } else { -1.0 };
                points.push(from);
                for i in 1..steps as usize {
                    let (sin, cos) = (angle(from) + sign * turn * i as f64 / steps).sin_cos();
                    points.push([centre[0] + radius_mm * cos, centre[1] + radius_mm * sin]);
                }
            }
            // Only revolutions have elliptic arcs, so none occurs here.
            Segment::Line { .. } | Segment::EllipticArc { .. } => {
                let length_mm = (to[0] - from[0]).hypot(to[1] - from[1]);
                let steps = (length_mm / edge_mm).ceil().max(1.0);
                for i in 0..steps as usize {
                    let share = i as f64 / steps;
                    points.push([0, 1].map(|k| from[k] + share * (to[k] - from[k])));
                }
            }
        }
        from = to;
    }
    points
}
