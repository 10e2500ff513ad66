//! Repair of triangles that rounding made degenerate, without opening the mesh or changing its topology.

use super::halfedges::Halfedges;
use crate::halfedges::previous;
use crate::measure::{dot, doubled_area_normal, subtract};

/// Altitude up to which triangles are removed if possible, in `f32` spacings.
const LOW_ULPS: f64 = 1.0;

/// Length up to which edges may collapse, in `f32` spacings.
const SHORT_ULPS: f64 = 8.0;

/// Displacement of a vertex that coincides with another, in `f32` spacings.
const NUDGE_ULPS: f64 = 2.0;

/// Largest number of passes through the mesh: each pass may uncover work for the next.
const PASSES: usize = 16;

/// Repairs the mesh. Returns for each vertex the one it was merged into, or itself.
pub(super) fn repair(mesh: &mut Halfedges, ulp_mm: f64) -> Vec<u32> {
    let mut repair = Repair { moved_to: (0..mesh.positions.len() as u32).collect(), mesh, ulp_mm };
    // Equal vertices that are neighbours mostly collapse; only those that cannot are moved apart.
    let mut part_neighbours = false;
    for _ in 0..PASSES {
        let low: Vec<usize> = repair.mesh.alive().filter(|&t| repair.is_low(t)).collect();
        let has_equals = repair.has_equals();
        let mut changed = has_equals && repair.separate_equal_vertices(part_neighbours);
        for t in low {
            changed |= repair.mesh.is_alive(t) && repair.is_low(t) && repair.remove(t);
        }
        if !changed && (part_neighbours || !has_equals) {
            break;
        }
        part_neighbours = !changed;
    }
    repair.moved_to
}

struct Repair<'a> {
    mesh: &'a mut Halfedges,
    moved_to: Vec<u32>,
    ulp_mm: f64,
}

impl Repair<'_> {
    /// Returns whether a triangle's altitude over its longest edge is at most [`LOW_ULPS`].
    fn is_low(&self, t: usize) -> bool {
        let points = self.mesh.points(t);
        let longest = (0..3).map(|i| distance2(points[i], points[(i + 1) % 3])).fold(0.0, f64::max);
        let low_mm = LOW_ULPS * self.ulp_mm;
        norm2(doubled_area_normal(points)) <= longest * low_mm * low_mm
    }

    /// Removes one low triangle: a needle by collapsing its short edge, a cap by flipping its long one. Returns whether
    /// it succeeded.
    fn remove(&mut self, t: usize) -> bool {
        let length2 = |e: usize| {
            let [a, b] = [self.mesh.from(e), self.mesh.to(e)].map(|v| v as usize);
            distance2(self.mesh.positions[a], self.mesh.positions[b])
        };
        let mut edges = [3 * t, 3 * t + 1, 3 * t + 2];
        edges.sort_by(|&a, &b| length2(a).total_cmp(&length2(b)));
        let short_mm = SHORT_ULPS * self.ulp_mm;
        let [shortest, middle, longest] = edges;
        let short = edges.map(|e| length2(e) <= short_mm * short_mm);
        // A needle collapses, a cap flips; longer edges collapse only if neither succeeds.
        (short[0] && self.collapse_either_way(shortest))
            || self.flip(longest)
            || (short[1] && self.collapse_either_way(middle))
            || (short[2] && self.collapse_either_way(longest))
    }

    fn collapse_either_way(&mut self, edge: usize) -> bool {
        let twin = self.mesh.twin(edge);
        self.collapse(edge) || self.collapse(twin)
    }

    fn collapse(&mut self, edge: usize) -> bool {
        let mesh = &*self.mesh;
        let twin = mesh.twin(edge);
        let (moved, kept) = (mesh.from(edge), mesh.to(edge));
        let (around, other) = (mesh.neighbours(edge), mesh.neighbours(twin));
        let common = around.iter().filter(|v| other.binary_search(v).is_ok()).count();
        if common != 2 || around.len() + other.len() < 8 {
            return false; // It would pinch the surface, or fold a tetrahedron flat.
        }
        let target = mesh.positions[kept as usize];
        let keeps_its_side = |e: usize| {
            let t = e / 3;
            if t == edge / 3 || t == twin / 3 {
                return true;
            }
            let old = mesh.points(t);
            let mut new = old;
            new[e % 3] = target;
            let (before, after) = (doubled_area_normal(old), doubled_area_normal(new));
            // A low triangle may turn over: its own normal is noise.
            norm2(after) > 0.0 && (dot(before, after) > 0.0 || self.is_low(t))
        };
        if !mesh.around(edge).all(keeps_its_side) {
            return false;
        }
        self.mesh.collapse(edge);
        self.moved_to[moved as usize] = kept;
        true
    }

    fn flip(&mut self, edge: usize) -> bool {
        let mesh = &*self.mesh;
        let twin = mesh.twin(edge);
        let (a, b) = (mesh.from(edge), mesh.to(edge));
        let (c, d) = (mesh.from(previous(edge)), mesh.from(previous(twin)));
        // The new edge must not exist already, which would make it non-manifold.
        if c == d || mesh.neighbours(previous(edge)).binary_search(&d).is_ok() {
            return false;
        }
        let points = |corners: [u32; 3]| corners.map(|v| mesh.positions[v as usize]);
        // The neighbour's normal tells where outside is: that of the low triangle is noise.
        let outside = doubled_area_normal(mesh.points(twin / 3));
        let after = [points([d, b, c]), points([c, a, d])].map(doubled_area_normal);
        let lowest_before = self.height2(edge / 3).min(self.height2(twin / 3));
        let better = [points([d, b, c]), points([c, a, d])].map(height2);
        let improves = better.into_iter().all(|h| h > lowest_before);
        if !improves || !after.iter().all(|n| dot(*n, outside) > 0.0) {
            return false;
        }
        self.mesh.flip(edge);
        true
    }

    fn height2(&self, t: usize) -> f64 {
        height2(self.mesh.points(t))
    }

    /// Returns whether any two positions are equal, including those of removed vertices.
    fn has_equals(&self) -> bool {
        // Adding 0.0 turns -0.0 into 0.0, so that equal values have equal bits.
        let bits = |c: f64| u128::from((c as f32 + 0.0).to_bits());
        let key = |&[x, y, z]: &[f64; 3]| bits(x) << 64 | bits(y) << 32 | bits(z);
        let mut keys: Vec<u128> = self.mesh.positions.iter().map(key).collect();
        keys.sort_unstable();
        keys.windows(2).any(|pair| pair[0] == pair[1])
    }

    /// Moves vertices with equal positions apart: two parts of the surface that touch. Each moves into its own side of
    /// the solid.
    fn separate_equal_vertices(&mut self, neighbours_too: bool) -> bool {
        let mut start = vec![usize::MAX; self.mesh.positions.len()];
        for t in self.mesh.alive() {
            for e in 3 * t..3 * t + 3 {
                start[self.mesh.from(e) as usize] = e;
            }
        }
        let bits = |v: u32| self.mesh.positions[v as usize].map(|c| (c + 0.0).to_bits());
        let mut order: Vec<u32> = (0..self.mesh.positions.len() as u32)
            .filter(|&v| start[v as usize] != usize::MAX)
            .collect();
        order.sort_unstable_by_key(|&v| (bits(v), v));
        let are_neighbours =
            |a: u32, b: u32| self.mesh.neighbours(start[a as usize]).binary_search(&b).is_ok();
        let equals: Vec<u32> = order
            .windows(2)
            .filter(|w| bits(w[0]) == bits(w[1]))
            .filter(|w| neighbours_too || !are_neighbours(w[0], w[1]))
            .map(|w| w[1])
            .collect();
        for &v in &equals {
            self.nudge(v, start[v as usize]);
        }
        !equals.is_empty()
    }

    fn nudge(&mut self, vertex: u32, edge: usize) {
        let mut outward = [0.0; 3];
        for e in self.mesh.around(edge) {
            let normal = doubled_area_normal(self.mesh.points(e / 3));
            let length = norm2(normal).sqrt().max(f64::MIN_POSITIVE);
            outward = std::array::from_fn(|i| outward[i] + normal[i] / length);
        }
        let length = norm2(outward).sqrt().max(f64::MIN_POSITIVE);
        let position = &mut self.mesh.positions[vertex as usize];
        for i in 0..3 {
            // Against the outward normal, into the solid.
            let step_mm = NUDGE_ULPS * self.ulp_mm * outward[i] / length;
            position[i] = f64::from((position[i] - step_mm) as f32);
        }
    }
}

/// Computes the square of the altitude over the longest edge, mm^2.
fn height2(points: [[f64; 3]; 3]) -> f64 {
    let longest = (0..3).map(|i| distance2(points[i], points[(i + 1) % 3])).fold(0.0, f64::max);
    if longest == 0.0 { 0.0 } else { norm2(doubled_area_normal(points)) / longest }
}

fn norm2(v: [f64; 3]) -> f64 {
    dot(v, v)
}

fn distance2(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm2(subtract(a, b))
}
