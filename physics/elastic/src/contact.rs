//! Frictionless contact: contact region and pressures.
//!
//! Pressures that are never tensile and minimise the energy are found by conjugate gradients. Nodes that would pull are
//! released, nodes that would enter the indenter are added (Polonsky and Keer, "A numerical method for solving rough
//! contact problems", Wear 231, 1999). Here the indenter's displacement is prescribed, not its force.

use crate::ElasticError;
use crate::compliance::NORMAL;
use crate::patch::{Patch, Workspace};

/// Tolerance of nodes' distances from the indenter, relative to the depth of the press.
pub(crate) const TOLERANCE: f64 = 1e-7;
/// Iteration limit, far above what any contact has needed; a contact that reaches it does not converge.
const MAX_ITERATIONS: usize = 3000;

/// Pressures of a solved contact.
pub(crate) struct Contact {
    /// Pressure at each node of the patch, MPa.
    pub pressures: Vec<f64>,
    pub iterations: usize,
}

/// Solves for the pressures on a patch from the gaps of its nodes, mm; a gap is infinite where nothing can touch.
///
/// `start` is an initial guess of the pressures.
///
/// # Errors
/// Iterations that do not converge.
pub(crate) fn solve(
    patch: &Patch<'_>,
    gaps: &[f64],
    depth_mm: f64,
    start: Option<&[f64]>,
    work: &mut Workspace,
) -> Result<Contact, ElasticError> {
    let areas = patch.areas();
    let count = gaps.len();
    let can_touch: Vec<bool> = gaps.iter().map(|gap| gap.is_finite()).collect();
    let mut pressures = match start {
        Some(start) => start.to_vec(),
        // Any small positive pressure marks a node as in contact; the first step sets its size.
        None => (0..count).map(|i| if gaps[i] < 0.0 { 1e-3 } else { 0.0 }).collect(),
    };
    let (mut distances, mut moved) = (vec![0.0; count], vec![0.0; count]);
    let (mut direction, mut last, mut keeps) = (vec![0.0; count], 1.0, false);
    let tolerance = TOLERANCE * depth_mm;
    let mut worst = f64::INFINITY;
    for iterations in 0..MAX_ITERATIONS {
        // Recomputed from the pressures each time, so that released nodes leave no rounding errors behind.
        product(patch, &pressures, &mut distances, work);
        for i in 0..count {
            distances[i] += gaps[i];
        }
        worst = 0.0;
        for i in 0..count {
            if pressures[i] > 0.0 {
                worst = f64::max(worst, distances[i].abs());
            } else if can_touch[i] {
                worst = worst.max(-distances[i]);
            }
        }
        if worst <= tolerance && iterations > 0 {
            return Ok(Contact { pressures, iterations });
        }
        let norm: f64 = (0..count)
            .filter(|&i| pressures[i] > 0.0)
            .map(|i| areas[i] * distances[i] * distances[i])
            .sum();
        // Conjugacy holds only while the contact region does not grow.
        let factor = if keeps { norm / last } else { 0.0 };
        last = norm;
        for i in 0..count {
            let here = if pressures[i] > 0.0 { distances[i] } else { 0.0 };
            direction[i] = if pressures[i] > 0.0 { here + factor * direction[i] } else { 0.0 };
        }
        product(patch, &direction, &mut moved, work);
        let (mut along, mut energy) = (0.0, 0.0);
        for i in 0..count {
            if pressures[i] > 0.0 {
                along += areas[i] * distances[i] * direction[i];
                energy += areas[i] * moved[i] * direction[i];
            }
        }
        let step = if energy > 0.0 { along / energy } else { 0.0 };
        keeps = true;
        for i in 0..count {
            let was_free = pressures[i] == 0.0;
            pressures[i] = (pressures[i] - step * direction[i]).max(0.0);
            if was_free && can_touch[i] && distances[i] < 0.0 {
                // Without any contact there is no step size yet; any small pressure starts one.
                pressures[i] = if step > 0.0 { -step * distances[i] } else { 1e-6 };
                keeps = false;
            }
        }
    }
    let what = "the contact of indenter and surface";
    Err(ElasticError::NoConvergence {
        what,
        iterations: MAX_ITERATIONS,
        residual: worst,
        tolerance,
    })
}

/// Computes the inward displacements that pressures cause, mm.
fn product(patch: &Patch<'_>, pressures: &[f64], moved: &mut [f64], work: &mut Workspace) {
    let mut loads = [None; 3];
    loads[NORMAL] = Some(pressures);
    patch.apply(loads, [Some(moved), None, None], work);
}
