//! Triangles of the base that a curve removes, and the loops of edges around them.

use fabkit_geometry::{Point3, Pose};

use super::EVERYWHERE;
use super::base_mesh::{BaseMesh, NONE};
use super::intersection_curves::Curve;
use super::revolved_tool::RevolvedTool;

/// Base triangles that touch a curve or the area enclosed by it.
pub(super) struct Cavity {
    pub triangles: Vec<u32>,
    /// Edges around the cavity from its own side, each loop in the edges' direction.
    pub loops: Vec<Vec<u32>>,
    /// 1 if the base faces along the tool's axis, -1 if against it.
    pub facing: f64,
    /// Stamp on its triangles.
    pub stamp: u32,
}

/// Base triangle near the tool: its corners in the tool's frame.
pub(super) struct Candidate {
    pub triangle: u32,
    pub corners: [[f64; 3]; 3],
}

impl Candidate {
    pub fn new(triangle: u32, points: [[f64; 3]; 3], tool_from_base: &Pose) -> Self {
        let corners = points.map(|p| tool_from_base.point(Point3::from(p)).into());
        Self { triangle, corners }
    }

    /// Returns whether it may come nearer than `margin_mm` to the part of the tool between two heights. Conservative:
    /// never false if it does.
    pub fn reaches_into(&self, pin: &RevolvedTool, [low, high]: [f64; 2], margin_mm: f64) -> bool {
        let Some(widest_mm) = pin.radius_between_mm(EVERYWHERE) else { return false };
        let Some([bottom, top]) = self.z_range_within_mm(widest_mm + margin_mm) else {
            return false;
        };
        // The range of the tool that the triangle can reach, extended by the margin.
        let heights = [low.max(bottom - margin_mm), high.min(top + margin_mm)];
        let radius_mm = if heights[0] > heights[1] { None } else { pin.radius_between_mm(heights) };
        radius_mm.is_some_and(|radius_mm| self.axis_distance_mm() < radius_mm + margin_mm)
    }

    /// Returns the lowest and highest point within a square around the axis, mm.
    fn z_range_within_mm(&self, half_mm: f64) -> Option<[f64; 2]> {
        // Sutherland-Hodgman clipping against one side of the square after the other.
        let mut polygon = self.corners.to_vec();
        for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let beyond = |p: [f64; 3]| sign * p[axis] - half_mm;
            let next = polygon.iter().cycle().skip(1);
            let mut inside = Vec::with_capacity(polygon.len() + 1);
            for (&p, &q) in polygon.iter().zip(next) {
                let (u, v) = (beyond(p), beyond(q));
                if u <= 0.0 {
                    inside.push(p);
                }
                if (u <= 0.0) != (v <= 0.0) {
                    let t = u / (u - v);
                    inside.push(std::array::from_fn(|i| p[i] + t * (q[i] - p[i])));
                }
            }
            polygon = inside;
        }
        let heights = polygon.iter().map(|p| [p[2]; 2]);
        heights.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// Returns the distance of the nearest point from the tool's axis, mm.
    pub fn axis_distance_mm(&self) -> f64 {
        let [a, b, c] = self.corners;
        if self.winding_over([0.0; 2]) != 0.0 {
            return 0.0;
        }
        [[a, b], [b, c], [c, a]].map(|[p, q]| to_segment(p, q)).into_iter().fold(f64::MAX, f64::min)
    }

    /// Returns the orientation of the triangle, seen along the tool's axis, if it covers the point: 1 or -1; 0
    /// otherwise.
    fn winding_over(&self, point: [f64; 2]) -> f64 {
        let [a, b, c] = self.corners;
        let side = |p: [f64; 3], q: [f64; 3]| {
            (q[0] - p[0]) * (point[1] - p[1]) - (q[1] - p[1]) * (point[0] - p[0])
        };
        let sides = [side(a, b), side(b, c), side(c, a)];
        if sides.iter().all(|s| *s >= 0.0) {
            1.0
        } else if sides.iter().all(|s| *s <= 0.0) {
            -1.0
        } else {
            0.0
        }
    }

    /// Returns the height of the triangle's plane over a point, mm.
    fn height_over_mm(&self, point: [f64; 2]) -> f64 {
        let [a, b, c] = self.corners;
        let area = self.doubled_area();
        let weight = |p: [f64; 3], q: [f64; 3]| {
            (q[0] - p[0]) * (point[1] - p[1]) - (q[1] - p[1]) * (point[0] - p[0])
        };
        (weight(b, c) * a[2] + weight(c, a) * b[2] + weight(a, b) * c[2]) / area
    }

    /// Returns twice the signed area of its projection along the tool's axis, mm^2.
    fn doubled_area(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }
}

/// Returns the distance of a segment from the axis, mm.
fn to_segment(p: [f64; 3], q: [f64; 3]) -> f64 {
    let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
    let length2 = dx * dx + dy * dy;
    let along = if length2 > 0.0 { -(p[0] * dx + p[1] * dy) / length2 } else { 0.0 };
    let t = along.clamp(0.0, 1.0);
    (p[0] + t * dx).hypot(p[1] + t * dy)
}

impl Cavity {
    /// Collects all triangles of one face that lie within `clear_mm` of the curve or inside it. `None` if they do not
    /// form a simple hole in the face.
    ///
    /// The triangles get the mark `stamp`.
    pub fn new(
        sheet: &mut BaseMesh,
        candidates: &[Candidate],
        curve: &Curve,
        face: u32,
        facing: f64,
        clear_mm: f64,
        stamp: u32,
    ) -> Option<Self> {
        let radius_mm = curve.in_tool.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
        let [x, y, z] = curve.in_tool[0];
        let offset_mm = |c: &Candidate| (c.height_over_mm([x, y]) - z).abs();
        // The search starts at the triangle below (or above) the curve's first point.
        let seed = candidates
            .iter()
            .filter(|c| sheet.faces[c.triangle as usize] == face)
            .filter(|c| c.winding_over([x, y]) == facing && c.doubled_area() != 0.0)
            .min_by(|a, b| offset_mm(a).total_cmp(&offset_mm(b)))?;
        let find = |t: u32| {
            candidates.binary_search_by_key(&t, |c| c.triangle).ok().map(|i| &candidates[i])
        };
        let mut triangles = vec![seed.triangle];
        sheet.stamps[seed.triangle as usize] = stamp;
        let mut rim = Vec::new();
        let mut done = 0;
        while let Some(&t) = triangles.get(done) {
            done += 1;
            for edge in 3 * t..3 * t + 3 {
                let twin = sheet.twins[edge as usize];
                let neighbour = twin / 3;
                if twin != NONE && sheet.stamps[neighbour as usize] == stamp {
                    continue;
                }
                // Triangles that are no candidates are too far away to matter.
                let near = if twin == NONE { None } else { find(neighbour) };
                let distance_mm = near.map_or(f64::MAX, Candidate::axis_distance_mm);
                // The test uses the circle around the curve, which contains all that it encloses.
                if distance_mm >= radius_mm + clear_mm {
                    rim.push(edge);
                } else if sheet.faces[neighbour as usize] == face {
                    sheet.stamps[neighbour as usize] = stamp;
                    triangles.push(neighbour);
                } else if distance_mm >= radius_mm {
                    rim.push(edge);
                } else {
                    return None; // The curve leaves the face.
                }
            }
        }
        let mut flat = triangles.iter().filter_map(|&t| find(t));
        if !flat.all(|c| c.doubled_area() * facing > 0.0) {
            return None; // It folds under itself, seen along the axis.
        }
        Some(Self { triangles, loops: loops(sheet, rim)?, facing, stamp })
    }
}

/// Chains edges to loops. `None` where two loops touch in a vertex.
fn loops(sheet: &BaseMesh, mut rim: Vec<u32>) -> Option<Vec<Vec<u32>>> {
    // Sorted by start vertex, so that the next edge of a loop is found by binary search.
    rim.sort_unstable_by_key(|&edge| sheet.from(edge));
    if rim.windows(2).any(|w| sheet.from(w[0]) == sheet.from(w[1])) {
        return None;
    }
    let mut used = vec![false; rim.len()];
    let mut loops = Vec::new();
    for start in 0..rim.len() {
        let mut chain = Vec::new();
        let mut at = start;
        while !used[at] {
            used[at] = true;
            chain.push(rim[at]);
            at = rim.binary_search_by_key(&sheet.to(rim[at]), |&edge| sheet.from(edge)).ok()?;
        }
        if !chain.is_empty() {
            loops.push(chain);
        }
    }
    Some(loops)
}
