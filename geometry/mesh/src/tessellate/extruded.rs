//! Tessellation of extrusions: profiles in the xy plane, from z = 0 upwards.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{Extrusion, Path, Segment};
use manifold_rust::linalg::Vec2;
use manifold_rust::polygon::triangulate_idx;
use manifold_rust::types::PolyVert;

use super::arc::Arc;
use super::circle::arc_count;
use crate::facets::Facets;

const BOTTOM: u32 = 0;
const TOP: u32 = 1;
const FIRST_WALL: u32 = 2;

/// Tessellates an extrusion. Returns false if the caps cannot be triangulated.
pub(super) fn extrude(out: &mut Facets, solid: &Extrusion, tolerance_mm: f64) -> bool {
    let mut first_wall = FIRST_WALL;
    let mut loops = Vec::new();
    for (i, path) in solid.profile.paths().enumerate() {
        let mut points = flatten(path, first_wall, tolerance_mm);
        if (signed_area(&points) > 0.0) != (i == 0) {
            // In a reversed path each point would start the wall on its other side.
            let walls: Vec<u32> = points.iter().map(|p| p.wall).collect();
            let count = points.len();
            for (k, point) in points.iter_mut().enumerate() {
                point.wall = walls[(k + count - 1) % count];
            }
            points.reverse();
        }
        loops.push(points);
        first_wall += path.segments.len() as u32;
    }
    let count: u32 = loops.iter().map(|l| l.len() as u32).sum();
    for z in [0.0, solid.height_mm] {
        for point in loops.iter().flatten() {
            out.vertex([point.at[0], point.at[1], z]);
        }
    }
    let mut polygons = Vec::new();
    let mut first = 0;
    for points in &loops {
        let size = points.len() as u32;
        for (k, point) in (0..size).zip(points) {
            let (a, b) = (first + k, first + (k + 1) % size);
            out.triangle([a, b, count + b], point.wall);
            out.triangle([a, count + b, count + a], point.wall);
        }
        let vertex = |(k, p): (u32, &Point)| PolyVert {
            pos: Vec2::new(p.at[0], p.at[1]),
            idx: (first + k) as i32,
        };
        polygons.push((0..size).zip(points).map(vertex).collect());
        first += size;
    }
    let caps = triangulate_idx(&polygons, -1.0, true);
    // Euler's formula: n points in h holes and one outer loop take n + 2h - 2 triangles.
    let expected = count as usize + 2 * (loops.len() - 1) - 2;
    if caps.len() != expected {
        return false;
    }
    for t in caps {
        let [a, b, c] = [t.x as u32, t.y as u32, t.z as u32];
        // The bottom faces downwards, so its triangles are reversed.
        out.triangle([a, c, b], BOTTOM);
        out.triangle([count + a, count + b, count + c], TOP);
    }
    true
}

/// Corner of the flattened path, with the face number of the wall that starts there.
struct Point {
    at: [f64; 2],
    wall: u32,
}

fn flatten(path: &Path, first_wall: u32, tolerance_mm: f64) -> Vec<Point> {
    let mut points = Vec::new();
    let mut from = path.start;
    for (wall, segment) in (first_wall..).zip(&path.segments) {
        points.push(Point { at: from, wall });
        if let Segment::Arc { to, centre, ccw } = segment {
            // The arc is divided in the same way in both directions, so that shared walls have equal vertices.
            let [first, last] = if *ccw { [from, *to] } else { [*to, from] };
            let mut inner = arc_points(first, last, *centre, tolerance_mm);
            if !ccw {
                inner.reverse();
            }
            points.extend(inner.into_iter().map(|at| Point { at, wall }));
        }
        from = segment.to();
    }
    points
}

/// Returns the points strictly between the ends of a counter-clockwise arc, including the extreme ones.
fn arc_points(from: [f64; 2], to: [f64; 2], centre: [f64; 2], tolerance_mm: f64) -> Vec<[f64; 2]> {
    let radius_mm = (to[0] - centre[0]).hypot(to[1] - centre[1]);
    let arc = Arc::between(from, to, centre, [radius_mm; 2]);
    let mut points = Vec::new();
    for piece in arc.split_at_extremes() {
        if piece.from_rad != arc.from_rad {
            points.push(arc.point(piece.from_rad));
        }
        let angle = (piece.to_rad - piece.from_rad).min(FRAC_PI_2);
        let count = arc_count(radius_mm, angle, tolerance_mm);
        let step = (piece.to_rad - piece.from_rad) / count as f64;
        points.extend((1..count).map(|k| arc.point(piece.from_rad + k as f64 * step)));
    }
    points
}

fn signed_area(points: &[Point]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(p, q)| p.at[0] * q.at[1] - q.at[0] * p.at[1]).sum::<f64>() / 2.0
}
