//! Contact of an indenter with a slab on liquid: forces that are never tensile, and channel pressures that follow from
//! the volumes displaced.

use nalgebra::{DMatrix, DVector};

use super::columns::LiquidColumn;
use crate::ElasticError;

/// Iteration limit, far above what any contact has needed.
const MAX_ITERATIONS: usize = 200;
/// Tolerance of the displaced volume, mm3.
const TOLERANCE_MM3: f64 = 1e-9;

/// Linear responses of surface nodes and channels.
#[derive(Debug)]
pub(super) struct LinearResponses {
    /// Downward displacement of a node by a unit force down on another, mm/N.
    pub compliance: DMatrix<f64>,
    /// Liquid that a unit force displaces out of a channel, by channel and node, mm3/N.
    pub squeezed: DMatrix<f64>,
    /// Volume growth of a channel by a unit pressure in another, mm3/MPa.
    pub growth: DMatrix<f64>,
}

/// Contact forces and channel pressures in equilibrium.
#[derive(Debug)]
pub(super) struct Equilibrium {
    /// Downward force on each node, N.
    pub forces_n: DVector<f64>,
    /// Gauge pressure in each channel, MPa.
    pub pressures_mpa: DVector<f64>,
    /// Volume displaced out of each channel, mm3.
    pub squeezed_mm3: DVector<f64>,
}

impl LinearResponses {
    /// Solves for the forces on nodes below which the indenter reaches, by depths in mm. Forces are never tensile.
    ///
    /// # Errors
    /// Iterations that do not converge.
    pub(super) fn solve_equilibrium(
        &self,
        reached_mm: &[f64],
        columns: &[LiquidColumn],
    ) -> Result<Equilibrium, ElasticError> {
        let mut squeezed_mm3 = DVector::zeros(columns.len());
        let mut active: Vec<bool> = reached_mm.iter().map(|mm| *mm > 0.0).collect();
        let mut worst = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            // Newton's method: the air pressure is linearised at the volume displaced so far.
            let tangents: Vec<[f64; 2]> =
                columns.iter().zip(&squeezed_mm3).map(|(c, mm3)| c.pressure_mpa(*mm3)).collect();
            let stiffness = DVector::from_iterator(columns.len(), tangents.iter().map(|t| t[1]));
            let offset = DVector::from_iterator(
                columns.len(),
                tangents.iter().zip(&squeezed_mm3).map(|([mpa, slope], mm3)| mpa - slope * mm3),
            );
            let scaled = |mut matrix: DMatrix<f64>| {
                for (mut row, factor) in matrix.row_iter_mut().zip(&stiffness) {
                    row *= *factor;
                }
                matrix
            };
            // Pressures are eliminated: they are linear in the forces, with the tangent of the air's stiffness.
            let coupled =
                DMatrix::identity(columns.len(), columns.len()) + scaled(self.growth.clone());
            let coupled = coupled.lu();
            let singular = || ElasticError::Factorisation {
                harmonic: 0,
                reason: "the channels' pressures do not follow from their volumes".to_owned(),
            };
            let by_force = coupled.solve(&scaled(self.squeezed.clone())).ok_or_else(singular)?;
            let at_rest = coupled.solve(&offset).ok_or_else(singular)?;
            let compliance = &self.compliance - self.squeezed.tr_mul(&by_force);
            let lifted = self.squeezed.tr_mul(&at_rest);
            let forces_n = solve_contact_forces(&compliance, reached_mm, &lifted, &mut active)?;
            let pressures_mpa = &by_force * &forces_n + &at_rest;
            let next = &self.squeezed * &forces_n - &self.growth * &pressures_mpa;
            worst = (&next - &squeezed_mm3).amax();
            squeezed_mm3 = next;
            if worst < TOLERANCE_MM3 {
                return Ok(Equilibrium { forces_n, pressures_mpa, squeezed_mm3 });
            }
        }
        Err(ElasticError::NoConvergence {
            what: "the pressure of the shut-in air",
            iterations: MAX_ITERATIONS,
            residual: worst,
            tolerance: TOLERANCE_MM3,
        })
    }
}

/// Finds the forces on the nodes that are in contact, and the contact set itself; all other nodes stay below the
/// indenter.
fn solve_contact_forces(
    compliance: &DMatrix<f64>,
    reached_mm: &[f64],
    lifted_mm: &DVector<f64>,
    active: &mut [bool],
) -> Result<DVector<f64>, ElasticError> {
    let count = reached_mm.len();
    let wanted = DVector::from_iterator(
        count,
        reached_mm.iter().zip(lifted_mm).map(|(reached, lifted)| reached + lifted),
    );
    let mut changed = 0;
    for _ in 0..MAX_ITERATIONS {
        let held: Vec<usize> = (0..count).filter(|i| active[*i]).collect();
        // Nodes in contact get exactly the depths of the indenter; all others carry no force.
        let part = compliance.select_rows(&held).select_columns(&held);
        let factors = part.cholesky().ok_or_else(|| ElasticError::Factorisation {
            harmonic: 0,
            reason: "nodes of the surface cannot be held one by one".to_owned(),
        })?;
        let solved = factors.solve(&wanted.select_rows(&held));
        let mut forces = DVector::zeros(count);
        for (&node, force) in held.iter().zip(&solved) {
            forces[node] = *force;
        }
        let moved = compliance * &forces;
        let next: Vec<bool> = (0..count)
            // A node leaves when its force would pull, and joins when it lies above the indenter.
            .map(|i| if active[i] { forces[i] > 0.0 } else { moved[i] < wanted[i] - 1e-9 })
            .collect();
        changed = next.iter().zip(active.iter()).filter(|(a, b)| a != b).count();
        if changed == 0 {
            return Ok(forces);
        }
        active.copy_from_slice(&next);
    }
    Err(ElasticError::NoConvergence {
        what: "the contact of indenter and surface",
        iterations: MAX_ITERATIONS,
        residual: changed as f64,
        tolerance: 0.0,
    })
}
