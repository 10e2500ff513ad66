//! Three-dimensional slabs of bricks, with cavities, at small strain.

mod brick;

use std::collections::BTreeMap;

use fabkit_geometry::{Point3, Vector3};
use fabkit_sparse::{Factors, RightHandSides, SymmetricPattern};

use self::brick::UNKNOWNS;
use crate::harmonic::factorisation_error;
use crate::{ElasticError, ElasticMaterial};

/// Limit of unknowns, at which a slab still fits into a few GiB.
const MOST_UNKNOWNS: usize = 300_000;
/// Stiffness of cavities relative to the stiffest material: too small to affect results, and enough to keep nodes
/// inside cavities in place.
const CAVITY_STIFFNESS: f64 = 1e-6;
/// Number of loads that are solved for at once.
const LOADS_PER_SOLVE: usize = 32;

/// Contents of one brick of a slab.
#[derive(Clone, Debug, Default)]
pub struct BrickContents {
    /// Material of the brick and the share of its volume that it fills.
    pub solid: Option<(ElasticMaterial, f64)>,
    /// Cavities that reach into the brick, each with its share of the volume.
    pub cavities: Vec<(usize, f64)>,
}

/// A slab of bricks between grid lines along x, y and z, with some nodes fixed.
///
/// ```
/// use fabkit_elastic::{BrickContents, ElasticMaterial, Slab};
///
/// // A column of 1 x 1 x 10 mm on a fixed floor, without lateral contraction, and 0.1 N up on its upper face.
/// let material = ElasticMaterial::new(2.0, 0.0)?;
/// let lines_mm = [vec![0.0, 1.0], vec![0.0, 1.0], (0..=10).map(f64::from).collect()];
/// let cell = |_| BrickContents { solid: Some((material, 1.0)), cavities: vec![] };
/// let slab = Slab::new(lines_mm, 0, cell, |place| place.z == 0.0)?;
/// let top = [[0, 0, 10], [1, 0, 10], [0, 1, 10], [1, 1, 10]].map(|at| slab.node(at));
/// let field = slab.solve(&top.map(|node| (node, 0.025)), &[]);
/// // Stress over modulus times length: 0.1 / 2 x 10 mm.
/// assert!((slab.displacement_mm(&field, top[0]).z - 0.5).abs() < 1e-9);
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
#[derive(Debug)]
pub struct Slab {
    /// Positions of the grid lines along each axis, mm, rising.
    lines_mm: [Vec<f64>; 3],
    /// Index of the first of the three unknowns of each node that moves.
    unknown: Vec<Option<usize>>,
    unknowns: usize,
    factors: Factors,
    /// Volume change of each cavity by the unknowns, mm2, as sparse rows.
    growth: Vec<Vec<(usize, f64)>>,
}

/// Displacements of all nodes of a slab.
#[derive(Clone, Debug)]
pub struct SlabField(Vec<f64>);

impl Slab {
    /// Builds and factorises a slab from grid lines, the contents of each brick (by index along x, y and z) and the
    /// fixed points.
    ///
    /// # Errors
    /// More unknowns than fit into memory, or a slab that is not held.
    pub fn new(
        lines_mm: [Vec<f64>; 3],
        cavities: usize,
        cell: impl Fn([usize; 3]) -> BrickContents,
        is_held: impl Fn(Point3<f64>) -> bool,
    ) -> Result<Self, ElasticError> {
        let counts = [0, 1, 2].map(|axis: usize| lines_mm[axis].len().saturating_sub(1));
        let cells: Vec<([usize; 3], BrickContents)> = places(counts)
            .map(|at| (at, cell(at)))
            // Bricks without solid and cavity are left out entirely.
            .filter(|(_, cell)| cell.solid.is_some() || !cell.cavities.is_empty())
            .collect();
        let mut slab = SlabAssembly {
            unknown: vec![None; lines_mm.iter().map(Vec::len).product()],
            lines_mm,
            unknowns: 0,
        };
        slab.assign_unknowns(&cells, is_held);
        if slab.unknowns > MOST_UNKNOWNS {
            return Err(ElasticError::TooFine { unknowns: slab.unknowns, limit: MOST_UNKNOWNS });
        }
        let growth = slab.growth(&cells, cavities);
        let factors = slab.factors(&cells)?;
        let SlabAssembly { lines_mm, unknown, unknowns } = slab;
        Ok(Self { lines_mm, unknown, unknowns, factors, growth })
    }

    /// Number of unknown displacements.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Grid lines along an axis, mm.
    pub fn lines_mm(&self, axis: usize) -> &[f64] {
        &self.lines_mm[axis]
    }

    /// Returns the node at the crossing of three grid lines.
    pub fn node(&self, at: [usize; 3]) -> usize {
        node(&self.lines_mm, at)
    }

    /// Returns a node's position in the undeformed slab, mm.
    pub fn place(&self, at: [usize; 3]) -> Point3<f64> {
        Point3::from([0, 1, 2].map(|axis: usize| self.lines_mm[axis][at[axis]]))
    }

    /// Returns whether a node exists and can move.
    pub fn moves(&self, node: usize) -> bool {
        self.unknown[node].is_some()
    }

    /// Computes the volume change of a cavity, mm3.
    ///
    /// ```
    /// use fabkit_elastic::{BrickContents, ElasticMaterial, Slab};
    ///
    /// // A block of 3 x 3 x 3 bricks of 1 mm on a fixed floor; the brick in its middle is a cavity.
    /// let material = ElasticMaterial::new(0.5, 0.45)?;
    /// let line: Vec<f64> = (0..=3).map(f64::from).collect();
    /// let cell = |at: [usize; 3]| match at {
    ///     [1, 1, 1] => BrickContents { solid: None, cavities: vec![(0, 1.0)] },
    ///     _ => BrickContents { solid: Some((material, 1.0)), cavities: vec![] },
    /// };
    /// let slab = Slab::new([line.clone(), line.clone(), line], 1, cell, |place| place.z == 0.0)?;
    /// // Pressure within blows it up; a force from above squeezes it.
    /// assert!(slab.growth_mm3(0, &slab.solve(&[], &[0.01])) > 0.0);
    /// assert!(slab.growth_mm3(0, &slab.solve(&[(slab.node([1, 1, 3]), -0.1)], &[0.0])) < 0.0);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn growth_mm3(&self, cavity: usize, field: &SlabField) -> f64 {
        self.growth[cavity].iter().map(|(unknown, mm2)| mm2 * field.0[*unknown]).sum()
    }

    /// Returns the displacement of a node, mm; zero for nodes that do not exist or are fixed.
    pub fn displacement_mm(&self, field: &SlabField, node: usize) -> Vector3<f64> {
        self.unknown[node].map_or(Vector3::zeros(), |first| {
            Vector3::new(field.0[first], field.0[first + 1], field.0[first + 2])
        })
    }

    /// Solves for forces along z on nodes, N, and pressures in cavities, MPa.
    pub fn solve(&self, forces_n: &[(usize, f64)], pressures_mpa: &[f64]) -> SlabField {
        let mut loads = RightHandSides::new(self.unknowns, 1);
        let load = loads.column_mut(0);
        for (node, n) in forces_n {
            if let Some(first) = self.unknown[*node] {
                load[first + 2] += n;
            }
        }
        for (growth, mpa) in self.growth.iter().zip(pressures_mpa) {
            for (unknown, mm2) in growth {
                load[*unknown] += mpa * mm2;
            }
        }
        self.factors.solve(&mut loads);
        SlabField(loads.column(0).to_vec())
    }

    /// Solves for a unit force down, N, on each node of `down`, then for a unit pressure, MPa, in each cavity, and
    /// passes each field to `take` in that order.
    pub(crate) fn solve_unit_loads(&self, down: &[usize], mut take: impl FnMut(usize, SlabField)) {
        let all: Vec<usize> = (0..down.len() + self.growth.len()).collect();
        for chunk in all.chunks(LOADS_PER_SOLVE) {
            let mut loads = RightHandSides::new(self.unknowns, chunk.len());
            for (column, &which) in chunk.iter().enumerate() {
                let load = loads.column_mut(column);
                if let Some(&node) = down.get(which) {
                    if let Some(first) = self.unknown[node] {
                        load[first + 2] = -1.0;
                    }
                } else {
                    for (unknown, mm2) in &self.growth[which - down.len()] {
                        load[*unknown] = *mm2;
                    }
                }
            }
            self.factors.solve(&mut loads);
            for (column, &which) in chunk.iter().enumerate() {
                take(which, SlabField(loads.column(column).to_vec()));
            }
        }
    }
}

/// Iterates over all indices of a grid, x fastest.
fn places([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
}

fn node(lines_mm: &[Vec<f64>; 3], [i, j, k]: [usize; 3]) -> usize {
    i + lines_mm[0].len() * (j + lines_mm[1].len() * k)
}

/// A slab before its stiffness is factorised.
struct SlabAssembly {
    lines_mm: [Vec<f64>; 3],
    unknown: Vec<Option<usize>>,
    unknowns: usize,
}

impl SlabAssembly {
    fn nodes(&self, [i, j, k]: [usize; 3]) -> [usize; 8] {
        let at = |n: usize| [i + (n & 1), j + (n >> 1 & 1), k + (n >> 2 & 1)];
        std::array::from_fn(|n| node(&self.lines_mm, at(n)))
    }

    fn edges_mm(&self, at: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis: usize| {
            let line = &self.lines_mm[axis];
            line[at[axis] + 1] - line[at[axis]]
        })
    }

    /// Assigns unknowns to the nodes of bricks, except where they are fixed.
    fn assign_unknowns(
        &mut self,
        cells: &[([usize; 3], BrickContents)],
        is_held: impl Fn(Point3<f64>) -> bool,
    ) {
        let mut is_used = vec![false; self.unknown.len()];
        for (at, _) in cells {
            for node in self.nodes(*at) {
                is_used[node] = true;
            }
        }
        let counts = [0, 1, 2].map(|axis: usize| self.lines_mm[axis].len());
        for at in places(counts) {
            let place = Point3::from([0, 1, 2].map(|axis: usize| self.lines_mm[axis][at[axis]]));
            let node = node(&self.lines_mm, at);
            if is_used[node] && !is_held(place) {
                self.unknown[node] = Some(self.unknowns);
                self.unknowns += 3;
            }
        }
    }

    /// Computes the volume change of each cavity by each unknown.
    fn growth(
        &self,
        cells: &[([usize; 3], BrickContents)],
        cavities: usize,
    ) -> Vec<Vec<(usize, f64)>> {
        let mut growth = vec![BTreeMap::<usize, f64>::new(); cavities];
        // Liquid pushes on solid parts only. Nodes inside cavities and on openings are left out: the forces of the
        // bricks around them cancel except for rounding, and hardly any stiffness would resist it.
        let mut is_solid = vec![false; self.unknown.len()];
        for (at, _) in cells.iter().filter(|(_, cell)| cell.solid.is_some()) {
            for node in self.nodes(*at) {
                is_solid[node] = true;
            }
        }
        for (at, cell) in cells {
            let (nodes, dilation) = (self.nodes(*at), brick::dilation(self.edges_mm(*at)));
            for (cavity, share) in &cell.cavities {
                for (i, mm2) in dilation.iter().enumerate() {
                    let node = nodes[i / 3];
                    if let Some(first) = self.unknown[node].filter(|_| is_solid[node]) {
                        *growth[*cavity].entry(first + i % 3).or_default() += share * mm2;
                    }
                }
            }
        }
        growth.into_iter().map(|entries| entries.into_iter().collect()).collect()
    }

    /// Assembles the stiffness on and below the diagonal and factorises it.
    fn factors(&self, cells: &[([usize; 3], BrickContents)]) -> Result<Factors, ElasticError> {
        let (mut places, mut values) = (Vec::new(), Vec::new());
        let stiffest = cells.iter().filter_map(|(_, cell)| cell.solid);
        let stiffest = stiffest.map(|(material, _)| material.young_mpa()).fold(0.0, f64::max);
        let soft = ElasticMaterial::new(CAVITY_STIFFNESS * stiffest, 0.0)?;
        // Bricks come in few sizes and materials: each stiffness is computed once.
        let mut known: BTreeMap<[u64; 5], Box<[[f64; UNKNOWNS]; UNKNOWNS]>> = BTreeMap::new();
        for (at, cell) in cells {
            let (nodes, edges_mm) = (self.nodes(*at), self.edges_mm(*at));
            let open = (soft, 1.0);
            let share = cell.solid.map_or(0.0, |(_, share)| share);
            // The part of a brick that the material leaves free is filled with the cavity's stiffness.
            let parts = cell.solid.into_iter().chain((share < 1.0).then_some(open));
            for (material, share) in parts {
                let [x, y, z] = edges_mm.map(f64::to_bits);
                let key = [x, y, z, material.young_mpa().to_bits(), material.poisson().to_bits()];
                let stiffness = known
                    .entry(key)
                    .or_insert_with(|| Box::new(brick::stiffness(edges_mm, &material)));
                for (i, entries) in stiffness.iter().enumerate() {
                    let Some(row) = self.unknown[nodes[i / 3]].map(|first| first + i % 3) else {
                        continue;
                    };
                    for (j, entry) in entries.iter().enumerate() {
                        let column = self.unknown[nodes[j / 3]].map(|first| first + j % 3);
                        if let Some(column) = column.filter(|column| *column <= row) {
                            places.push([row, column]);
                            values.push(share * entry);
                        }
                    }
                }
            }
        }
        let matrix =
            SymmetricPattern::new(self.unknowns, places).map_err(factorisation_error(0))?;
        matrix.factorise(&values).map_err(factorisation_error(0))
    }
}
