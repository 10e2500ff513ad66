//! Trapped air: the liquid rises, and air leaves a cavity only through openings above it.
//!
//! The cavity is divided into columns along the direction that is up during the cure. Air at the top of a column moves
//! to a neighbouring column of the same void whose top is higher. A column without such a neighbour is a local top and
//! needs an opening. Without one, a bubble stays there, down to the height at which it spills into a neighbouring void.
//! The search is the merge tree of the columns' tops (Carr, Snoeyink and Axen, "Computing Contour Trees in All
//! Dimensions", 2003).

use fabkit_geometry::{CompiledSolid, Point3, Pour, Ray, Vector3};
use rayon::prelude::*;

use crate::declaration::rule;
use crate::finding::Finding;
use crate::memo::{Key, Memo};
use crate::opening;
use crate::outlet;
use crate::rule::Rule;
use crate::rule_input::Place;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::{Caster, basis};
use crate::scene::Assemblies;

rule! {
    /// Air can leave the cavity everywhere.
    TrappedAir = "trapped-air",
    examines: "pours",
    finds: "places from which air cannot rise to an opening",
    limit: "sampled in columns, 320 across the cavity",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let rising: Vec<_> = case.rising_pours().collect();
    let found = rising.iter().flat_map(|(place, pour)| {
        let mut found = examine(place, pour, case.scene, case.memo);
        found.extend(outlet::examine(place, pour, case.scene, case.memo));
        (case.tick)();
        found
    });
    Ok((found.collect(), rising.len()))
}

/// Number of columns along the longer side of the cavity.
pub(crate) const COLUMNS: usize = 320;

/// Largest height difference of column tops that form one plateau, mm.
const LEVEL_MM: f64 = 1e-6;

/// One stretch of a column inside the layer.
#[derive(Clone, Copy, Debug)]
struct Column {
    cell: [usize; 2],
    bottom_mm: f64,
    top_mm: f64,
    top: Point3<f64>,
    /// Whether its top lies on an opening.
    vented: bool,
}

/// A bubble of air that cannot leave.
struct Pocket {
    top: Point3<f64>,
    depth_mm: f64,
    volume_mm3: f64,
}

/// The cavity as columns on a square grid.
struct Columns {
    columns: Vec<Column>,
    /// Index of the first column of each cell, row by row, with the number of columns appended.
    first: Vec<usize>,
    size: [usize; 2],
    cell_mm: f64,
}

/// Finds air pockets of one pour.
pub(crate) fn examine(place: &Place, pour: &Pour, scene: &Assemblies, memo: &Memo) -> Vec<Finding> {
    let Some(layer) = scene.places(place.assembly, &pour.layer).first().copied() else {
        return Vec::new();
    };
    let key = opening::add_to_key(Key::new(3).key(layer.key).vector(&pour.up), &pour.openings);
    let mut findings = Vec::new();
    memo.is_clean(&key, || {
        findings = pockets(place, pour, &layer.body);
        findings.is_empty()
    });
    findings
}

/// Reports the pockets of one layer.
fn pockets(place: &Place, pour: &Pour, layer: &CompiledSolid) -> Vec<Finding> {
    let grid = Columns::new(layer, pour);
    let pockets = grid.pockets();
    pockets
        .into_iter()
        .map(|pocket| {
            Finding::error(
                Rule::TrappedAir,
                format!(
                    "air stays in the {}: a pocket of {:.3} mm3, {:.3} mm deep, has no vent",
                    pour.layer, pocket.volume_mm3, pocket.depth_mm
                ),
                "add a vent there, or cure it another way up",
            )
            .in_step(place.step)
            .in_assembly(place.assembly)
            .about_bodies([pour.layer.as_str()])
            .at_position(Some(pocket.top))
            // The cell size is the limit: the grid does not resolve shallower pockets.
            .with_measurement(pocket.depth_mm, grid.cell_mm, "mm")
        })
        .collect()
}

impl Columns {
    fn new(body: &CompiledSolid, pour: &Pour) -> Self {
        let up = pour.up.normalize();
        let [u, v] = basis(&up);
        let bounds = body.bounds();
        let half = 0.5 * (bounds.max - bounds.min);
        let [half_u, half_v] = [u, v].map(|w| w.abs().dot(&half));
        let cell_mm = 2.0 * half_u.max(half_v) / COLUMNS as f64;
        // An offset of an odd fraction of a cell keeps columns off walls at round coordinates.
        // One more cell than needed, so that the offset below leaves no uncovered edge.
        let count = |half_mm: f64| (2.0 * half_mm / cell_mm).ceil() as usize + 1;
        let size = [count(half_u), count(half_v)];
        // A small vent may lie between columns, so openings are widened by half the diagonal of a cell.
        let spread_mm = cell_mm * std::f64::consts::FRAC_1_SQRT_2;
        let place = |i: usize, n: usize| (i as f64 - 0.5 * n as f64 + 0.518) * cell_mm;
        let rows: Vec<Vec<Column>> = (0..size[1])
            .into_par_iter()
            .map(|j| {
                let mut caster = Caster::default();
                let mut row: Vec<Column> = Vec::new();
                for i in 0..size[0] {
                    let offset: Vector3<f64> = place(i, size[0]) * u + place(j, size[1]) * v;
                    let ray = Ray { origin: bounds.centre() + offset, direction: up };
                    // Columns of this cell start here; normals are only computed if one of their tops is near an
                    // opening.
                    let from = row.len();
                    row.extend(caster.intervals(body, &ray).iter().map(|&[bottom_mm, top_mm]| {
                        let top = ray.at(top_mm);
                        Column { cell: [i, j], bottom_mm, top_mm, top, vented: false }
                    }));
                    // Normals are expensive, and only the few columns with tops near an opening need them.
                    let is_near = |column: &Column| {
                        pour.openings.iter().any(|o| opening::is_beside(o, &column.top, spread_mm))
                    };
                    if row[from..].iter().any(is_near) {
                        for (column, stretch) in
                            row[from..].iter_mut().zip(caster.stretches(body, &ray))
                        {
                            let normal = &stretch.exit.normal;
                            let is_open = |o: &_| {
                                opening::contains_surface_point(o, &column.top, normal, spread_mm)
                            };
                            column.vented = pour.openings.iter().any(is_open);
                        }
                    }
                }
                row
            })
            .collect();
        let columns: Vec<Column> = rows.into_iter().flatten().collect();
        let mut first = Vec::with_capacity(size[0] * size[1] + 1);
        let mut next = 0;
        for cell in 0..=size[0] * size[1] {
            let at = [cell % size[0], cell / size[0]];
            // Cells without columns get an empty range.
            while next < columns.len() && is_before(columns[next].cell, at) {
                next += 1;
            }
            first.push(next);
        }
        Self { columns, first, size, cell_mm }
    }

    /// Iterates over columns of the eight surrounding cells whose height range overlaps that of the column `index`.
    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> {
        let column = self.columns[index];
        let range = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
        let [i, j] = column.cell;
        let cells = range(j, self.size[1])
            .flat_map(move |j| range(i, self.size[0]).map(move |i| j * self.size[0] + i));
        cells.flat_map(|cell| self.first[cell]..self.first[cell + 1]).filter(move |&other| {
            let other_column = &self.columns[other];
            other != index
                && other_column.bottom_mm < column.top_mm
                && column.bottom_mm < other_column.top_mm
        })
    }

    /// Sweeps the cavity from its highest tops down and returns the pockets that have no opening.
    fn pockets(&self) -> Vec<Pocket> {
        let mut order: Vec<usize> = (0..self.columns.len()).collect();
        order.sort_unstable_by(|&a, &b| {
            // The index breaks ties, so that the result does not depend on the sort.
            self.columns[b].top_mm.total_cmp(&self.columns[a].top_mm).then(a.cmp(&b))
        });
        let mut voids = Voids::new(&self.columns);
        let mut pockets = Vec::new();
        let mut from = 0;
        while from < order.len() {
            let level_mm = self.columns[order[from]].top_mm;
            // Tops of one plateau are opened together: within it no top is higher than another.
            let below = |&i: &usize| level_mm - self.columns[i].top_mm > LEVEL_MM;
            let to = order[from..].iter().position(below).map_or(order.len(), |n| from + n);
            // A void that meets an opening only at this level held air above it, down to this level.
            for bubble in voids.open_level(&order[from..to], |index| self.neighbours(index)) {
                pockets.extend(self.pocket(&bubble, level_mm));
            }
            from = to;
        }
        // Voids that never met an opening hold air down to the floor.
        let floor_mm = self.columns.iter().map(|c| c.bottom_mm).fold(f64::INFINITY, f64::min);
        for bubble in voids.closed() {
            pockets.extend(self.pocket(&bubble, floor_mm));
        }
        pockets
    }

    /// Computes the air that columns hold above the height `spill_mm`; `None` if it is too shallow for the grid.
    fn pocket(&self, members: &[usize], spill_mm: f64) -> Option<Pocket> {
        let highest = members
            .iter()
            .copied()
            .max_by(|&a, &b| self.columns[a].top_mm.total_cmp(&self.columns[b].top_mm))?;
        let Column { top_mm, top, .. } = self.columns[highest];
        let heights = members.iter().map(|&i| {
            let column = &self.columns[i];
            column.top_mm - column.bottom_mm.max(spill_mm)
        });
        let volume_mm3 = heights.sum::<f64>() * self.cell_mm * self.cell_mm;
        let depth_mm = top_mm - spill_mm;
        (depth_mm > self.cell_mm).then_some(Pocket { top, depth_mm, volume_mm3 })
    }
}

/// Returns whether cell `a` comes before cell `b`, row by row.
fn is_before(a: [usize; 2], b: [usize; 2]) -> bool {
    (a[1], a[0]) < (b[1], b[0])
}

/// Voids above the current level: a union-find forest of columns that knows whether air can leave each void.
struct Voids {
    /// Union-find parents.
    parent: Vec<usize>,
    /// Number of columns in the tree of each root.
    size: Vec<usize>,
    /// Linked rings through the columns of each void without an opening. Exchanging two links merges two rings, which
    /// avoids a list for each of a hundred thousand columns.
    next: Vec<usize>,
    /// Whether the void of each root has an opening.
    vented: Vec<bool>,
    /// Whether each column has been reached by the sweep.
    is_open: Vec<bool>,
    /// Connections made by the current level. Kept to reuse the allocation.
    links: Vec<(usize, usize)>,
    /// Voids met by the current level, each with whether it had an opening before. Kept to reuse the allocation.
    joined: Vec<(usize, bool)>,
}

impl Voids {
    fn new(columns: &[Column]) -> Self {
        let count = columns.len();
        Self {
            parent: (0..count).collect(),
            size: vec![1; count],
            next: (0..count).collect(),
            vented: columns.iter().map(|c| c.vented).collect(),
            is_open: vec![false; count],
            links: Vec::new(),
            joined: Vec::new(),
        }
    }

    /// Opens the columns of one level and joins the voids that they connect. Returns the voids that met an opening at
    /// this level and had none above it, as lists of columns.
    fn open_level<I: Iterator<Item = usize>>(
        &mut self,
        level: &[usize],
        neighbours: impl Fn(usize) -> I,
    ) -> Vec<Vec<usize>> {
        for &index in level {
            self.is_open[index] = true;
        }
        self.links.clear();
        self.joined.clear();
        for &index in level {
            self.joined.push((index, self.vented[index]));
            for other in neighbours(index) {
                // Lower tops are not reached yet.
                if !self.is_open[other] {
                    continue;
                }
                self.links.push((index, other));
                let root = self.root(other);
                self.joined.push((root, self.vented[root]));
            }
        }
        // Sorted for `dedup`, and so that the order of neighbours does not matter.
        self.joined.sort_unstable();
        self.joined.dedup();
        for link in 0..self.links.len() {
            let (a, b) = self.links[link];
            self.join(a, b);
        }
        let mut freed = Vec::new();
        for void in 0..self.joined.len() {
            let (void, was_vented) = self.joined[void];
            let root = self.root(void);
            // Closed voids keep their ring whole; voids with an opening need it only once, for the list that is
            // returned here.
            if !self.vented[root] {
                if root != void {
                    self.next.swap(void, root);
                }
            } else if !was_vented {
                freed.push(self.members(void));
            }
        }
        freed
    }

    /// Returns the columns of a void without an opening, given any of them.
    fn members(&self, of: usize) -> Vec<usize> {
        let follow = |&index: &usize| Some(self.next[index]).filter(|&next| next != of);
        std::iter::successors(Some(of), follow).collect()
    }

    /// Iterates over voids without any opening after all columns have been opened.
    fn closed(&self) -> impl Iterator<Item = Vec<usize>> {
        let is_closed = |&i: &usize| self.parent[i] == i && !self.vented[i];
        (0..self.parent.len()).filter(is_closed).map(|root| self.members(root))
    }

    /// Merges the trees of two columns.
    fn join(&mut self, a: usize, b: usize) {
        // Union by size.
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            let large = if self.size[a] >= self.size[b] { a } else { b };
            let small = a + b - large;
            self.parent[small] = large;
            self.size[large] += self.size[small];
            self.vented[large] |= self.vented[small];
        }
    }

    /// Finds the root of a column's tree.
    fn root(&mut self, mut index: usize) -> usize {
        while self.parent[index] != index {
            // Path halving.
            self.parent[index] = self.parent[self.parent[index]];
            index = self.parent[index];
        }
        index
    }
}
