//! Unknowns and equations of a press at large strain.

use fabkit_geometry::Vector3;
use fabkit_sparse::solve_general;
use nalgebra::SVector;

use super::contact_constraint::{ContactConstraint, IndenterGap, contact_constraints};
use super::element::{ElementState, UNKNOWNS, compute_element};
use crate::ElasticError;
use crate::element::Shape;
use crate::harmonic::factorisation_error;
use crate::indenter::Indenter;
use crate::mesh::Mesh;
use crate::outcome::PressOutcome;
use crate::stack::ElasticStack;

/// Coefficients, by column, of three times the slope of axial displacement on the axis, which is constrained to zero: a
/// smooth surface stays horizontal there.
///
/// Under pressures of several times its shear modulus an element with pressures of its own is softer than the continuum
/// (Auricchio, Beirao da Veiga, Lovadina and Reali, "A stability study of some mixed finite elements for large
/// deformation elasticity problems", Comput. Methods Appl. Mech. Eng. 194, 2005). The surface's node on the axis, which
/// no pressure acts on, would sink away first.
const POLE_SLOPE: [(usize, f64); 3] = [(0, -3.0), (1, 4.0), (2, -1.0)];
/// Iterations in which the contact region may change before displacements have settled.
const EAGER_ITERATIONS: usize = 8;
/// Step size below which displacements have settled, in tolerances.
const SETTLED: f64 = 1e3;

/// State of the iteration, which can be restored.
#[derive(Clone)]
pub(super) struct State {
    /// Radial and axial displacement of each node, mm.
    displacements: Vec<f64>,
    /// Pressure of each ring, along the axis and per undeformed area, MPa.
    pressures: Vec<f64>,
    is_held: Vec<bool>,
    /// Pressure coefficients of each element, MPa.
    amounts: Vec<Vector3<f64>>,
}

/// Newton iteration of a press at large strain.
pub(super) struct System<'a> {
    stack: &'a ElasticStack,
    mesh: &'a Mesh,
    grips: Vec<ContactConstraint>,
    shape: Shape,
    /// Equation of each displacement, by node: radial and axial. `None` for displacements that are fixed.
    rows: Vec<Option<usize>>,
    count: usize,
    state: State,
    /// Number of Newton steps taken.
    iterations: usize,
}

/// A step of Newton's method.
struct Step {
    /// Displacement step by unknown, mm.
    displacements: Vec<f64>,
    /// New pressures of the rings in contact, MPa.
    pressures: Vec<f64>,
}

impl<'a> System<'a> {
    /// Numbers the unknowns; on the axis nothing moves radially.
    pub fn new(stack: &'a ElasticStack) -> Self {
        let (mesh, grips) = (&*stack.mesh, contact_constraints(&stack.rings));
        let (mut rows, mut count) = (Vec::with_capacity(2 * mesh.nodes.len()), 0);
        for (node, place) in mesh.nodes.iter().enumerate() {
            // Radial first, which vanishes on the axis; then axial.
            for is_still in [place[0] == 0.0, false] {
                let is_still = is_still || mesh.is_fixed[node];
                rows.push((!is_still).then_some(count));
                count += usize::from(!is_still);
            }
        }
        let state = State {
            displacements: vec![0.0; rows.len()],
            pressures: vec![0.0; grips.len()],
            is_held: vec![false; grips.len()],
            amounts: vec![Vector3::zeros(); mesh.elements().count()],
        };
        Self { stack, mesh, grips, shape: Shape::new(), rows, count, state, iterations: 0 }
    }

    pub fn state(&self) -> State {
        self.state.clone()
    }

    pub fn restore(&mut self, state: State) {
        self.state = state;
    }

    /// Starts with the contact region of a press at small strain.
    pub fn start_contact_from(&mut self, small: &PressOutcome) {
        for (is_held, node) in self.state.is_held.iter_mut().zip(&small.nodes[1..]) {
            *is_held = node.pressure_mpa > 0.0;
        }
    }

    /// Iterates until displacements and contact region agree.
    ///
    /// # Errors
    /// No convergence, or an element that is inverted.
    pub fn solve(
        &mut self,
        indenter: &dyn Indenter,
        shift_mm: &Vector3<f64>,
        tolerance_mm: f64,
        max_iterations: usize,
    ) -> Result<(), ElasticError> {
        let mut last = f64::INFINITY;
        for iteration in 0..max_iterations {
            let above = self.indenter_gaps(indenter, shift_mm);
            let held: Vec<usize> =
                (0..self.state.is_held.len()).filter(|&ring| self.state.is_held[ring]).collect();
            let Some(step) = self.step(&above, &held)? else { break };
            let steps = &step.displacements;
            let largest = steps.iter().fold(0.0, |largest: f64, step| largest.max(step.abs()));
            if !largest.is_finite() {
                break;
            }
            self.advance(steps);
            self.iterations += 1;
            self.state.pressures.fill(0.0);
            for (&ring, pressure) in held.iter().zip(step.pressures) {
                self.state.pressures[ring] = pressure;
            }
            last = largest;
            // At first the contact region changes as a whole, which is quick but may cycle. Later, each time the
            // displacements have settled, only the first ring that must change does so, which terminates (Murty, "Note
            // on a Bard-type scheme for solving the complementarity problem", Opsearch 11, 1974).
            let is_eager = iteration < EAGER_ITERATIONS;
            let may_change = is_eager || largest <= SETTLED * tolerance_mm;
            let is_same =
                !(may_change && self.update_contact(indenter, shift_mm, tolerance_mm, is_eager));
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

    /// Adds a step to the displacements, shortened until no element is inverted.
    fn advance(&mut self, steps: &[f64]) {
        let before = self.state.displacements.clone();
        let mut part = 1.0;
        // Predicted before displacements change.
        let targets: Vec<Option<Vector3<f64>>> = self
            .mesh
            .elements()
            .enumerate()
            .map(|each| self.predict_pressures(each, steps))
            .collect();
        for _ in 0..10 {
            for (i, value) in self.state.displacements.iter_mut().enumerate() {
                *value = before[i] + self.rows[i].map_or(0.0, |row| part * steps[row]);
            }
            if self.mesh.elements().enumerate().all(|each| self.element_state(each).is_some()) {
                break;
            }
            part *= 0.5;
        }
        for (amounts, target) in self.state.amounts.iter_mut().zip(targets) {
            if let Some(target) = target {
                *amounts += part * (target - *amounts);
            }
        }
    }

    /// Predicts the pressure coefficients of an element after a step, by its tangent.
    fn predict_pressures(&self, each: (usize, [usize; 2]), steps: &[f64]) -> Option<Vector3<f64>> {
        let strained = self.element_state(each)?;
        let nodes = self.mesh.element_nodes(each.1);
        let step = |i: usize| self.rows[2 * nodes[i / 2] + i % 2].map_or(0.0, |row| steps[row]);
        let step = SVector::<f64, UNKNOWNS>::from_fn(|i, _| step(i));
        Some(strained.pressures + strained.pressures_by * step)
    }

    /// Computes an element at the current displacements; `None` where it is inverted.
    fn element_state(&self, (number, element): (usize, [usize; 2])) -> Option<ElementState> {
        let nodes = self.mesh.element_nodes(element);
        let moved = SVector::<f64, UNKNOWNS>::from_fn(|i, _| {
            self.state.displacements[2 * nodes[i / 2] + i % 2]
        });
        let material = &self.mesh.materials[self.mesh.layer_by_row[element[1]]];
        compute_element(
            &self.shape,
            &self.mesh.element_places(element),
            material,
            &moved,
            &self.state.amounts[number],
        )
    }

    /// Measures the indenter above each column of the deformed surface.
    fn indenter_gaps(&self, indenter: &dyn Indenter, shift_mm: &Vector3<f64>) -> Vec<IndenterGap> {
        let at = |column: usize| {
            let node = column * self.mesh.rows;
            let moved = &self.state.displacements[2 * node..2 * node + 2];
            let place: [f64; 2] = std::array::from_fn(|k| self.mesh.nodes[node][k] + moved[k]);
            IndenterGap::new(indenter, place, shift_mm)
        };
        (0..self.mesh.columns).map(at).collect()
    }

    /// Releases rings that pull and adds those that have entered the indenter, either all of them or the first. Returns
    /// whether any changed.
    fn update_contact(
        &mut self,
        indenter: &dyn Indenter,
        shift_mm: &Vector3<f64>,
        tolerance_mm: f64,
        all: bool,
    ) -> bool {
        let above = self.indenter_gaps(indenter, shift_mm);
        let mut has_changed = false;
        for ring in 0..self.state.is_held.len() {
            let gap_mm = self.grips[ring].gap_mm(&above);
            let holds = match self.state.is_held[ring] {
                // At the indenter's edge the mean gap is infinite and nothing can hold the ring.
                true => self.state.pressures[ring] > 0.0 && gap_mm.is_finite(),
                false => gap_mm < -tolerance_mm,
            };
            if holds != self.state.is_held[ring] {
                self.state.is_held[ring] = holds;
                has_changed = true;
                if !all {
                    break;
                }
            }
        }
        has_changed
    }

    /// Solves for displacement steps and new pressures of the rings in contact; `None` where an element is inverted.
    fn step(&self, above: &[IndenterGap], held: &[usize]) -> Result<Option<Step>, ElasticError> {
        // Unknowns: displacements, one pressure per ring in contact, and the multiplier of the `LEVEL` constraint.
        let level = self.count + held.len();
        let size = level + 1;
        let mut right = vec![0.0; size];
        let mut entries = Vec::new();
        for (number, element) in self.mesh.elements().enumerate() {
            let Some(strained) = self.element_state((number, element)) else { return Ok(None) };
            let nodes = self.mesh.element_nodes(element);
            for i in 0..UNKNOWNS {
                let Some(row) = self.rows[2 * nodes[i / 2] + i % 2] else { continue };
                right[row] -= strained.forces[i];
                for j in 0..UNKNOWNS {
                    if let Some(column) = self.rows[2 * nodes[j / 2] + j % 2] {
                        entries.push((row, column, strained.tangent[(i, j)]));
                    }
                }
            }
        }
        for (k, &ring) in held.iter().enumerate() {
            let constraint = self.count + k;
            for &(column, share) in &self.grips[ring].shares {
                let (node, above) = (2 * column * self.mesh.rows, &above[column]);
                right[constraint] += share * above.gap_mm;
                for (displacement, by) in [(node, above.slope), (node + 1, -1.0)] {
                    if let Some(row) = self.rows[displacement] {
                        entries.push((row, constraint, -share * by));
                        entries.push((constraint, row, -share * by));
                    }
                }
                if let Some(row) = self.rows[node] {
                    // The indenter's curvature changes the direction of its force; it speeds up the iteration.
                    let bent = -share * self.state.pressures[ring] * above.curvature;
                    entries.push((row, row, bent));
                }
            }
        }
        for (column, by) in POLE_SLOPE {
            let displacement = 2 * column * self.mesh.rows + 1;
            right[level] -= by * self.state.displacements[displacement];
            if let Some(row) = self.rows[displacement] {
                entries.push((row, level, by));
                entries.push((level, row, by));
            }
        }
        solve_general(&entries, &mut right).map_err(factorisation_error(0))?;
        Ok(Some(Step {
            displacements: right[..self.count].to_vec(),
            pressures: right[self.count..level].to_vec(),
        }))
    }

    /// Returns the result of the press so far.
    pub fn outcome(&self, depth_mm: f64) -> PressOutcome {
        let mut growth_mm3 = vec![0.0; self.mesh.materials.len()];
        let (around, mut energy_nmm) = (2.0 * std::f64::consts::PI, 0.0);
        for (number, element) in self.mesh.elements().enumerate() {
            // Once the iteration has converged, no element is inverted.
            if let Some(strained) = self.element_state((number, element)) {
                growth_mm3[self.mesh.layer_by_row[element[1]]] += around * strained.growth;
                energy_nmm += around * strained.energy;
            }
        }
        let State { displacements, pressures, .. } = &self.state;
        // The pole has the pressure of the first ring, to which it belongs.
        let of_rings = [&pressures[..1], pressures].concat();
        PressOutcome::from_finite_strain(
            self.stack,
            displacements,
            &of_rings,
            growth_mm3,
            [depth_mm, energy_nmm],
            self.iterations,
        )
    }
}
