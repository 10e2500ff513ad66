//! Contact without friction: where the presser holds the surface, and with what pressure.
//!
//! The least energy under pressures that only push is found by conjugate gradients that let go of nodes that
//! would pull, and take in those that would enter the presser (Polonsky and Keer, "A numerical method for
//! solving rough contact problems", Wear 231, 1999), here with the presser's place given, not its force.

use crate::ElasticError;
use crate::compliance::NORMAL;
use crate::patch::{Patch, Work};

/// How far nodes may be from where the presser holds them, as a part of the press's depth.
pub(crate) const TOLERANCE: f64 = 1e-7;
/// More than any contact has needed by far; what comes here does not converge.
const MAX_ITERATIONS: usize = 3000;

/// Pressures that hold the surface where the presser is.
pub(crate) struct Contact {
    /// By node of the patch, MPa.
    pub pressures: Vec<f64>,
    pub iterations: usize,
}

/// Solves for pressures on a patch from the gaps of its nodes, mm; infinite where nothing can touch.
///
/// `start` is a guess of the pressures.
///
/// # Errors
/// What does not converge.
pub(crate) fn solve(
    patch: &Patch<'_>,
    gaps: &[f64],
    depth_mm: f64,
    start: Option<&[f64]>,
    work: &mut Work,
) -> Result<Contact, ElasticError> {
    let areas = patch.areas();
    let count = gaps.len();
    let can_touch: Vec<bool> = gaps.iter().map(|gap| gap.is_finite()).collect();
    let mut pressures = match start {
        Some(start) => start.to_vec(),
        None => (0..count).map(|i| if gaps[i] < 0.0 { 1e-3 } else { 0.0 }).collect(),
    };
    let (mut distances, mut moved) = (vec![0.0; count], vec![0.0; count]);
    let (mut direction, mut last, mut keeps) = (vec![0.0; count], 1.0, false);
    let tolerance = TOLERANCE * depth_mm;
    let mut worst = f64::INFINITY;
    for iterations in 0..MAX_ITERATIONS {
        // From pressures anew each time: what is let go of must not leave rounding behind.
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
                // Without any contact there is no step to go by; any small pressure starts one.
                pressures[i] = if step > 0.0 { -step * distances[i] } else { 1e-6 };
                keeps = false;
            }
        }
    }
    let what = "the contact of presser and surface";
    Err(ElasticError::NoConvergence {
        what,
        iterations: MAX_ITERATIONS,
        residual: worst,
        tolerance,
    })
}

/// Inward displacements by pressures, mm.
fn product(patch: &Patch<'_>, pressures: &[f64], moved: &mut [f64], work: &mut Work) {
    let mut loads = [None; 3];
    loads[NORMAL] = Some(pressures);
    patch.apply(loads, [Some(moved), None, None], work);
}
