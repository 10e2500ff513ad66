//! Displacements and pressures of a press at large strain, and the equations that they fulfil.

use fabkit_geometry::{Point3, Vector3};
use faer::Mat;
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::SVector;

use super::element::{UNKNOWNS, strain};
use crate::ElasticError;
use crate::element::Shape;
use crate::mesh::Mesh;
use crate::outcome::Outcome;
use crate::presser::Presser;
use crate::rings::Rings;
use crate::stack::Stack;

/// Over what a presser's slope is measured, mm.
const SLOPE_STEP_MM: f64 = 1e-4;
/// Over what its curvature is, mm; it speeds the iteration up and does not change where it ends.
const CURVATURE_STEP_MM: f64 = 1e-3;
/// How far above and below a moved place its presser is looked for, mm.
const REACH_MM: f64 = 1e3;

/// What may be gone back to.
#[derive(Clone)]
pub(super) struct State {
    /// Radial and axial of each node, mm.
    displacements: Vec<f64>,
    /// Of each ring, along the axis and by area at rest, MPa.
    pressures: Vec<f64>,
    is_held: Vec<bool>,
}

pub(super) struct System<'a> {
    stack: &'a Stack,
    mesh: &'a Mesh,
    rings: &'a Rings,
    shape: Shape,
    /// Row of each displacement, by node: radial and axial.
    rows: Vec<Option<usize>>,
    count: usize,
    state: State,
    /// How many steps were taken.
    iterations: usize,
}

/// A presser above a moved place: along the axis, and how that changes with the radius.
struct Above {
    gap_mm: f64,
    slope: f64,
    curvature: f64,
}

impl<'a> System<'a> {
    pub fn new(stack: &'a Stack) -> Self {
        let (mesh, rings) = (&*stack.mesh, &stack.rings);
        let (mut rows, mut count) = (Vec::with_capacity(2 * mesh.nodes.len()), 0);
        for (node, place) in mesh.nodes.iter().enumerate() {
            for is_still in [place[0] == 0.0, false] {
                let is_still = is_still || mesh.is_fixed[node];
                rows.push((!is_still).then_some(count));
                count += usize::from(!is_still);
            }
        }
        let state = State {
            displacements: vec![0.0; rows.len()],
            pressures: vec![0.0; rings.rings.len()],
            is_held: vec![false; rings.rings.len()],
        };
        Self { stack, mesh, rings, shape: Shape::new(), rows, count, state, iterations: 0 }
    }

    pub fn state(&self) -> State {
        self.state.clone()
    }

    pub fn restore(&mut self, state: State) {
        self.state = state;
    }

    /// Begins with the rings that a press at small strain holds.
    pub fn hold(&mut self, small: &Outcome) {
        for (is_held, node) in self.state.is_held.iter_mut().zip(&small.nodes) {
            *is_held = node.pressure_mpa > 0.0;
        }
    }

    /// # Errors
    /// What does not converge, or turns an element inside out.
    pub fn solve(
        &mut self,
        presser: &dyn Presser,
        shift_mm: &Vector3<f64>,
        tolerance_mm: f64,
        max_iterations: usize,
    ) -> Result<(), ElasticError> {
        let mut last = f64::INFINITY;
        for _ in 0..max_iterations {
            let above = self.above(presser, shift_mm);
            let held: Vec<usize> =
                (0..self.state.is_held.len()).filter(|&ring| self.state.is_held[ring]).collect();
            let Some((steps, pressures)) = self.step(&above, &held)? else { break };
            let largest = steps.iter().fold(0.0, |largest: f64, step| largest.max(step.abs()));
            if !largest.is_finite() {
                break;
            }
            self.advance(&steps);
            self.iterations += 1;
            self.state.pressures.fill(0.0);
            for (&ring, pressure) in held.iter().zip(pressures) {
                self.state.pressures[ring] = pressure;
            }
            last = largest;
            let is_same = !self.regrasp(presser, shift_mm, tolerance_mm);
            if is_same && largest <= tolerance_mm {
                return Ok(());
            }
        }
        Err(ElasticError::NoConvergence {
            what: "the press at large strain",
            iterations: max_iterations,
            residual: last,
            tolerance: tolerance_mm,
        })
    }

    /// Moves by a step, or by so much of it that no element is turned inside out.
    fn advance(&mut self, steps: &[f64]) {
        let before = self.state.displacements.clone();
        let mut part = 1.0;
        for _ in 0..10 {
            for (i, value) in self.state.displacements.iter_mut().enumerate() {
                *value = before[i] + self.rows[i].map_or(0.0, |row| part * steps[row]);
            }
            if self.mesh.elements().all(|element| self.strained(element).is_some()) {
                return;
            }
            part *= 0.5;
        }
    }

    fn strained(&self, element: [usize; 2]) -> Option<super::element::Strained> {
        let nodes = self.mesh.element_nodes(element);
        let moved = SVector::<f64, UNKNOWNS>::from_fn(|i, _| {
            self.state.displacements[2 * nodes[i / 2] + i % 2]
        });
        let material = &self.mesh.materials[self.mesh.layer_of[element[1]]];
        strain(&self.shape, &self.mesh.element_places(element), material, &moved)
    }

    /// The presser above each column of the moved surface.
    fn above(&self, presser: &dyn Presser, shift_mm: &Vector3<f64>) -> Vec<Above> {
        let at = |column: usize| {
            let node = column * self.mesh.rows;
            let [r, z] = self.mesh.nodes[node];
            let moved = &self.state.displacements[2 * node..2 * node + 2];
            let gap = |by_mm: f64| {
                let place = Point3::new(r + moved[0] + by_mm, 0.0, z + moved[1]) - shift_mm;
                presser.gap_mm(&place, &Vector3::z(), REACH_MM)
            };
            let here = gap(0.0);
            let (inner, outer) = (gap(-SLOPE_STEP_MM), gap(SLOPE_STEP_MM));
            let (far_in, far_out) = (gap(-CURVATURE_STEP_MM), gap(CURVATURE_STEP_MM));
            let curvature = (far_in - 2.0 * here + far_out) / CURVATURE_STEP_MM.powi(2);
            Above {
                gap_mm: here,
                slope: (outer - inner) / (2.0 * SLOPE_STEP_MM),
                curvature: if curvature.is_finite() { curvature } else { 0.0 },
            }
        };
        (0..self.mesh.columns).map(at).collect()
    }

    /// The mean gap around a ring, mm; infinite at the presser's edge and beside it.
    fn gap(&self, above: &[Above], ring: usize) -> f64 {
        let ring = &self.rings.rings[ring];
        let sum: f64 =
            ring.shares.iter().map(|&(column, share)| share * above[column].gap_mm).sum();
        let is_whole = ring.shares.iter().all(|&(column, _)| above[column].slope.is_finite());
        if is_whole && sum.is_finite() { sum / ring.weight } else { f64::INFINITY }
    }

    /// Lets go of rings that pull, takes in those that have entered the presser; whether any did.
    fn regrasp(
        &mut self,
        presser: &dyn Presser,
        shift_mm: &Vector3<f64>,
        tolerance_mm: f64,
    ) -> bool {
        let above = self.above(presser, shift_mm);
        let mut has_changed = false;
        for ring in 0..self.state.is_held.len() {
            let gap_mm = self.gap(&above, ring);
            let holds = match self.state.is_held[ring] {
                true => self.state.pressures[ring] > 0.0 && gap_mm.is_finite(),
                false => gap_mm < -tolerance_mm,
            };
            has_changed |= holds != self.state.is_held[ring];
            self.state.is_held[ring] = holds;
        }
        has_changed
    }

    /// Steps of displacements and new pressures of held rings; `None` where an element is inside out.
    fn step(
        &self,
        above: &[Above],
        held: &[usize],
    ) -> Result<Option<(Vec<f64>, Vec<f64>)>, ElasticError> {
        let size = self.count + held.len();
        let mut right = Mat::zeros(size, 1);
        let mut entries = Vec::new();
        for element in self.mesh.elements() {
            let Some(strained) = self.strained(element) else { return Ok(None) };
            let nodes = self.mesh.element_nodes(element);
            for i in 0..UNKNOWNS {
                let Some(row) = self.rows[2 * nodes[i / 2] + i % 2] else { continue };
                right[(row, 0)] -= strained.forces[i];
                for j in 0..UNKNOWNS {
                    if let Some(column) = self.rows[2 * nodes[j / 2] + j % 2] {
                        entries.push(Triplet::new(row, column, strained.tangent[(i, j)]));
                    }
                }
            }
        }
        for (k, &ring) in held.iter().enumerate() {
            let constraint = self.count + k;
            for &(column, share) in &self.rings.rings[ring].shares {
                let (node, above) = (2 * column * self.mesh.rows, &above[column]);
                right[(constraint, 0)] += share * above.gap_mm;
                for (displacement, by) in [(node, above.slope), (node + 1, -1.0)] {
                    if let Some(row) = self.rows[displacement] {
                        entries.push(Triplet::new(row, constraint, -share * by));
                        entries.push(Triplet::new(constraint, row, -share * by));
                    }
                }
                if let Some(row) = self.rows[node] {
                    let bent = -share * self.state.pressures[ring] * above.curvature;
                    entries.push(Triplet::new(row, row, bent));
                }
            }
        }
        let failed = |reason: String| ElasticError::Factorisation { harmonic: 0, reason };
        let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(size, size, &entries)
            .map_err(|error| failed(error.to_string()))?;
        let factors = matrix.sp_lu().map_err(|error| failed(error.to_string()))?;
        factors.solve_in_place(right.as_mut());
        let all: Vec<f64> = (0..size).map(|i| right[(i, 0)]).collect();
        Ok(Some((all[..self.count].to_vec(), all[self.count..].to_vec())))
    }

    /// What the press has done so far.
    pub fn outcome(&self, depth_mm: f64) -> Outcome {
        let mut growth_mm3 = vec![0.0; self.mesh.materials.len()];
        let (around, mut energy_nmm) = (2.0 * std::f64::consts::PI, 0.0);
        for element in self.mesh.elements() {
            // Where the iteration has ended, no element is inside out.
            if let Some(strained) = self.strained(element) {
                growth_mm3[self.mesh.layer_of[element[1]]] += around * strained.growth;
                energy_nmm += around * strained.energy;
            }
        }
        let State { displacements, pressures, .. } = &self.state;
        Outcome::finite(
            self.stack,
            displacements,
            pressures,
            growth_mm3,
            [depth_mm, energy_nmm],
            self.iterations,
        )
    }
}
