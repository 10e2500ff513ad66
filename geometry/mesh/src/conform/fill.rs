//! Triangulation of the gap between a cavity's rim and the curve inside it.

use std::ops::Range;

use manifold_rust::linalg::Vec2;
use manifold_rust::polygon::triangulate_idx;
use manifold_rust::types::PolyVert;

/// Marker for an edge without neighbour: it is on a loop.
const RIM: u32 = u32::MAX;

/// Triangles, counter-clockwise, and the neighbour across each edge.
pub(super) struct Fill {
    pub triangles: Vec<[u32; 3]>,
    /// Edge `3 t + i` of the neighbour, or [`Fill::RIM`].
    pub twins: Vec<u32>,
}

impl Fill {
    pub const RIM: u32 = RIM;

    /// Triangulates the region to the left of all loops, each a range of `flat`. `None` if the loops bound no region,
    /// or one that is too narrow somewhere.
    ///
    /// The result is the constrained Delaunay triangulation for the points of `scaled`, by Lawson's edge flips: its
    /// triangles have the smallest circumcircles.
    pub fn new(flat: &[[f64; 2]], scaled: &[[f64; 2]], loops: &[Range<usize>]) -> Option<Self> {
        let points = flat;
        let polygon = |range: &Range<usize>| {
            let vertex =
                |i: usize| PolyVert { pos: Vec2::new(points[i][0], points[i][1]), idx: i as i32 };
            range.clone().map(vertex).collect::<Vec<_>>()
        };
        let polygons = loops.iter().map(polygon).collect();
        let triangles: Vec<[u32; 3]> = triangulate_idx(&polygons, -1.0, true)
            .into_iter()
            .map(|t| [t.x as u32, t.y as u32, t.z as u32])
            .collect();
        // Euler's formula: n points on h inner loops and an outer one take n + 2 h - 2 triangles.
        if triangles.len() + 4 != points.len() + 2 * loops.len() {
            return None;
        }
        let at = |v: u32| points[v as usize];
        if triangles.iter().any(|t| turn(at(t[0]), at(t[1]), at(t[2])) <= 0.0) {
            return None;
        }
        let twins = neighbours(&triangles, loops)?;
        let mut fill = Self { triangles, twins };
        fill.flip_all(points, scaled);
        Some(fill)
    }

    fn flip_all(&mut self, points: &[[f64; 2]], scaled: &[[f64; 2]]) {
        let mut stack: Vec<u32> = (0..self.twins.len() as u32).collect();
        // Each flip improves the triangulation; the limit only guards against cycles caused by rounding.
        let mut left = 40 * self.twins.len();
        while let Some(edge) = stack.pop() {
            let twin = self.twins[edge as usize];
            if twin == RIM || left == 0 {
                continue;
            }
            left -= 1;
            let [a, b] = [edge, next(edge)].map(|e| self.corner(e));
            let [c, d] = [previous(edge), previous(twin)].map(|e| self.corner(e));
            let at = |v: u32| points[v as usize];
            // Only the diagonals of a convex quadrilateral can be exchanged.
            let convex = turn(at(d), at(b), at(c)) > 0.0 && turn(at(c), at(a), at(d)) > 0.0;
            let s = |v: u32| scaled[v as usize];
            if convex && in_circle(s(a), s(b), s(c), s(d)) {
                // Only the four outer edges can have become non-Delaunay.
                stack.extend(self.flip(edge));
            }
        }
    }

    /// Replaces an edge by the other diagonal of its two triangles; returns the four edges around it.
    fn flip(&mut self, edge: u32) -> [u32; 4] {
        let other = self.twins[edge as usize];
        let (c, d) = (self.corner(previous(edge)), self.corner(previous(other)));
        let outer_ca = self.twins[previous(edge) as usize];
        let outer_db = self.twins[previous(other) as usize];
        self.set_corner(edge, d);
        self.set_corner(other, c);
        self.link(edge, outer_db);
        self.link(other, outer_ca);
        self.link(previous(edge), previous(other));
        [edge, next(edge), other, next(other)]
    }

    fn link(&mut self, a: u32, b: u32) {
        self.twins[a as usize] = b;
        if b != RIM {
            self.twins[b as usize] = a;
        }
    }

    fn corner(&self, edge: u32) -> u32 {
        self.triangles[(edge / 3) as usize][(edge % 3) as usize]
    }

    fn set_corner(&mut self, edge: u32, vertex: u32) {
        self.triangles[(edge / 3) as usize][(edge % 3) as usize] = vertex;
    }
}

fn next(edge: u32) -> u32 {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

fn previous(edge: u32) -> u32 {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}

fn neighbours(triangles: &[[u32; 3]], loops: &[Range<usize>]) -> Option<Vec<u32>> {
    let corners = triangles.as_flattened();
    let ends = |e: u32| [corners[e as usize], corners[next(e) as usize]];
    let mut order: Vec<u32> = (0..corners.len() as u32).collect();
    let key = |e: u32| {
        let [a, b] = ends(e);
        (a.min(b), a.max(b))
    };
    order.sort_unstable_by_key(|&e| key(e));
    let mut twins = vec![RIM; corners.len()];
    // Edges with one triangle must be exactly those of the loops.
    let mut single = 0;
    for group in order.chunk_by(|&e, &f| key(e) == key(f)) {
        match *group {
            [_] => single += 1,
            [e, f] if ends(e)[0] == ends(f)[1] => {
                twins[e as usize] = f;
                twins[f as usize] = e;
            }
            // More than two triangles at an edge, or two with the same direction.
            _ => return None,
        }
    }
    let rim: usize = loops.iter().map(|l| l.len()).sum();
    (single == rim).then_some(twins)
}

/// Computes twice the signed area of a triangle.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns whether `d` lies clearly inside the circumcircle of the other three points, which are counter-clockwise.
fn in_circle(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> bool {
    let rel = |p: [f64; 2]| [p[0] - d[0], p[1] - d[1]];
    let ([ax, ay], [bx, by], [cx, cy]) = (rel(a), rel(b), rel(c));
    let (a2, b2, c2) = (ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy);
    let determinant =
        ax * (by * c2 - b2 * cy) - ay * (bx * c2 - b2 * cx) + a2 * (bx * cy - by * cx);
    let size = a2.max(b2).max(c2);
    // Relative tolerance: without it, cocircular points would be flipped back and forth.
    determinant > 1e-12 * size * size
}
