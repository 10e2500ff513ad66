//! Presses with shear: regions of stick and slip, and tangential tractions.
//!
//! Coulomb's law is applied step by step along the indenter's path. In each step the tangential tractions minimise the
//! energy within the limit of friction times pressure: where the surface sticks it moves with the indenter, where it
//! slips it is dragged against its slip. Pressures and tractions are solved in turn until neither changes. The pressing
//! itself is frictionless, as in Cattaneo's and Mindlin's solution (Johnson, "Contact mechanics", 1985, section 7.2).

use fabkit_geometry::Vector3;

use crate::ElasticError;
use crate::compliance::{ALONG, AROUND, NORMAL};
use crate::contact::{self, Contact};
use crate::indenter::{Indenter, Press};
use crate::patch::{Patch, Workspace};
use crate::stack::ElasticStack;

/// Tolerance of the motion of sticking nodes, relative to the indenter's step.
const TOLERANCE: f64 = 1e-4;
/// Tolerance of the alternating solution: change of pressures relative to the largest, and of the drag relative to the
/// indenter's path.
const TURN_TOLERANCE: f64 = 1e-3;
const MAX_TURNS: usize = 60;
/// Turns in which the contact region follows the dragged surface completely. After them it follows by an ever smaller
/// part, towards the mean.
const FREE_TURNS: usize = 6;
/// Turns after which the contact region stays where it is: at a sharp edge, nodes that come and go would move it for
/// ever.
const FIXED_PRINT_TURNS: usize = 24;
/// Tolerance of the contact region's place once it stays, relative to the indenter's path.
const PRINT_TOLERANCE: f64 = 0.03;
const MAX_ITERATIONS: usize = 3000;
/// Number of previous energies that bound a step's energy (Birgin, Martinez and Raydan, "Nonmonotone spectral projected
/// gradient methods on convex sets", SIAM J. Optim. 10, 2000).
const ENERGY_HISTORY: usize = 10;

/// Tangential tractions of the indenter on the body, MPa: along s and around the axis.
pub(crate) struct Shear {
    pub tractions: [Vec<f64>; 2],
}

/// Indenter, its press and its displacement.
pub(crate) struct ShearPath<'a> {
    pub presser: &'a dyn Indenter,
    pub press: &'a Press,
    /// Displacement of the indenter at the end of pressing, mm.
    pub shift_mm: Vector3<f64>,
    pub depth_mm: f64,
}

/// Shears a press that has been solved without friction.
///
/// # Errors
/// Iterations that do not converge.
pub(crate) fn solve(
    patch: &Patch<'_>,
    way: &ShearPath<'_>,
    mut contact: Contact,
    work: &mut Workspace,
) -> Result<(Contact, Shear), ElasticError> {
    let count = patch.nodes();
    let frames = frames(patch);
    let areas = patch.areas();
    let mut tractions = [vec![0.0; count], vec![0.0; count]];
    let (steps, friction) = (way.press.shear_steps, way.press.friction);
    let step_mm = way.press.shear_mm / steps as f64;
    // Mean drag of the surface in contact, and the tangential displacement that pressing alone causes at each node.
    let mut print_mm = Vector3::zeros();
    let mut before = compute_pressure_displacements(patch, &contact.pressures, work);
    for step in 1..=steps {
        let mut turns = 0;
        loop {
            // The dragged surface keeps its place on the indenter: only the rest of the displacement moves across it.
            let across_mm = way.shift_mm + step as f64 * step_mm - print_mm;
            let mut gaps = patch.stack.gaps(patch, way.presser, &across_mm, way.depth_mm);
            // Tangential tractions lift or lower the surface, which changes the gaps.
            let lifted = compute_shear_displacements(patch, &tractions, NORMAL, work);
            for (i, gap) in gaps.iter_mut().enumerate() {
                *gap += frames[i][0].dot(&print_mm) - lifted[0][i];
            }
            let last = contact.pressures.clone();
            contact = contact::solve(patch, &gaps, way.depth_mm, Some(&last), work)?;
            let pressed = compute_pressure_displacements(patch, &contact.pressures, work);
            // Displacements that tractions must add for the surface to follow the indenter's step.
            let targets: [Vec<f64>; 2] = std::array::from_fn(|k| {
                let target =
                    |i: usize| before[k][i] + step_mm.dot(&frames[i][k + 1]) - pressed[k][i];
                (0..count).map(target).collect()
            });
            let limits: Vec<f64> = contact.pressures.iter().map(|p| friction * p).collect();
            let by_tractions = solve_tractions(
                patch,
                &targets,
                &limits,
                &areas,
                step_mm.norm(),
                &mut tractions,
                work,
            )?;
            let peak = contact.pressures.iter().copied().fold(0.0, f64::max);
            if peak == 0.0 {
                let gap_mm = gaps.iter().copied().fold(f64::INFINITY, f64::min);
                return Err(ElasticError::NoContact { gap_mm });
            }
            let pairs = contact.pressures.iter().zip(&last);
            let of_pressure = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak;
            let now_mm = mean(&frames, &areas, &contact.pressures, &by_tractions);
            let of_way = (now_mm - print_mm).norm() / way.press.shear_mm.norm();
            turns += 1;
            if turns < FREE_TURNS {
                print_mm = now_mm;
            } else if turns < FIXED_PRINT_TURNS {
                print_mm += (now_mm - print_mm) / (turns - FREE_TURNS + 2) as f64;
            }
            // The print no longer moves, so that only its distance from the dragged surface is checked.
            let is_held = turns >= FIXED_PRINT_TURNS && of_way <= PRINT_TOLERANCE;
            let change = if is_held { of_pressure } else { of_pressure.max(of_way) };
            if change <= TURN_TOLERANCE {
                for k in 0..2 {
                    let both = pressed[k].iter().zip(&by_tractions[k]);
                    before[k] = both.map(|(a, b)| a + b).collect();
                }
                break;
            }
            if turns == MAX_TURNS {
                return Err(ElasticError::NoConvergence {
                    what: "turns of pressure and friction",
                    iterations: turns,
                    residual: change,
                    tolerance: TURN_TOLERANCE,
                });
            }
        }
    }
    Ok((contact, Shear { tractions }))
}

/// Returns outward normal, direction along s and direction around the axis at each node of a patch.
pub(crate) fn frames(patch: &Patch<'_>) -> Vec<[Vector3<f64>; 3]> {
    let rings = patch.rings.clone();
    let of_ring =
        |ring: usize| (0..patch.stack.rings.rings[ring].count).map(move |node| (ring, node));
    rings.flat_map(of_ring).map(|(ring, node)| frame(patch.stack, ring, node)).collect()
}

fn frame(stack: &ElasticStack, ring: usize, node: usize) -> [Vector3<f64>; 3] {
    let (sin, cos) = stack.rings.azimuth(ring, node).sin_cos();
    let frame = &stack.mesh.frames[ring];
    let [normal, along] =
        [frame.normal, frame.tangent].map(|[r, z]| Vector3::new(r * cos, r * sin, z));
    [normal, along, Vector3::new(-sin, cos, 0.0)]
}

/// Computes the displacements along s and around the axis that pressures alone cause, mm.
fn compute_pressure_displacements(
    patch: &Patch<'_>,
    pressures: &[f64],
    work: &mut Workspace,
) -> [Vec<f64>; 2] {
    let pushed: Vec<f64> = pressures.iter().map(|pressure| -pressure).collect();
    let (mut along, mut around) = (vec![0.0; pushed.len()], vec![0.0; pushed.len()]);
    patch.apply([Some(&pushed), None, None], [None, Some(&mut along), Some(&mut around)], work);
    [along, around]
}

/// Computes the displacements that tangential tractions cause, mm: along the normal (in the first array; the second
/// stays zero), or along s and around the axis.
fn compute_shear_displacements(
    patch: &Patch<'_>,
    by: &[Vec<f64>; 2],
    component: usize,
    work: &mut Workspace,
) -> [Vec<f64>; 2] {
    let (mut first, mut second) = (vec![0.0; by[0].len()], vec![0.0; by[0].len()]);
    let loads = [None, Some(by[0].as_slice()), Some(by[1].as_slice())];
    match component {
        NORMAL => patch.apply(loads, [Some(&mut first), None, None], work),
        ALONG | AROUND => {
            patch.apply(loads, [None, Some(&mut first), Some(&mut second)], work);
        }
        _ => {}
    }
    [first, second]
}

/// Mean tangential displacement, weighted by normal force, mm.
fn mean(
    frames: &[[Vector3<f64>; 3]],
    areas: &[f64],
    pressures: &[f64],
    moved: &[Vec<f64>; 2],
) -> Vector3<f64> {
    let (mut sum, mut force) = (Vector3::zeros(), 0.0);
    for (i, [_, along, around]) in frames.iter().enumerate() {
        let weight = areas[i] * pressures[i];
        sum += weight * (moved[0][i] * along + moved[1][i] * around);
        force += weight;
    }
    if force > 0.0 { sum / force } else { sum }
}

/// Finds the tangential tractions of least energy within the friction limits by spectral projected gradients, starting
/// from the given ones. Returns the displacements that they cause, mm.
///
/// # Errors
/// Iterations that do not converge.
fn solve_tractions(
    patch: &Patch<'_>,
    targets: &[Vec<f64>; 2],
    limits: &[f64],
    areas: &[f64],
    way_mm: f64,
    tractions: &mut [Vec<f64>; 2],
    work: &mut Workspace,
) -> Result<[Vec<f64>; 2], ElasticError> {
    let count = limits.len();
    let held: Vec<usize> = (0..count).filter(|&i| limits[i] > 0.0).collect();
    let product = |a: &[Vec<f64>; 2], b: &[Vec<f64>; 2]| {
        held.iter().map(|&i| areas[i] * (a[0][i] * b[0][i] + a[1][i] * b[1][i])).sum::<f64>()
    };
    let clip = |[x, y]: [f64; 2], limit: f64| {
        let length = x.hypot(y);
        if length > limit { [x * limit / length, y * limit / length] } else { [x, y] }
    };
    for i in 0..count {
        let clipped = clip([tractions[0][i], tractions[1][i]], limits[i]);
        (tractions[0][i], tractions[1][i]) = (clipped[0], clipped[1]);
    }
    if held.is_empty() {
        return Ok(compute_shear_displacements(patch, tractions, ALONG, work));
    }
    // Uniform drag is the softest motion: its compliance is about the largest one, and its inverse a safe step.
    let only_held: [Vec<f64>; 2] = std::array::from_fn(|k| {
        (0..count).map(|i| if limits[i] > 0.0 { targets[k][i] } else { 0.0 }).collect()
    });
    let size = product(&only_held, &only_held);
    let softest = product(&only_held, &compute_shear_displacements(patch, &only_held, ALONG, work));
    let stiffness = if softest > 0.0 { size / softest } else { 1.0 };
    let mut gradient = compute_shear_displacements(patch, tractions, ALONG, work);
    for k in 0..2 {
        for i in 0..count {
            gradient[k][i] -= targets[k][i];
        }
    }
    let (mut energies, mut energy, mut stride) = (Vec::new(), 0.0, stiffness);
    let tolerance = TOLERANCE * way_mm;
    let mut worst = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let towards = |stride: f64| {
            let mut way = [vec![0.0; count], vec![0.0; count]];
            for &i in &held {
                let there = [0, 1].map(|k| tractions[k][i] - stride * gradient[k][i]);
                let there = clip(there, limits[i]);
                (way[0][i], way[1][i]) = (there[0] - tractions[0][i], there[1] - tractions[1][i]);
            }
            way
        };
        // The projected gradient at this fixed step measures the error, in mm.
        let least = towards(stiffness);
        worst =
            held.iter().map(|&i| least[0][i].hypot(least[1][i]) / stiffness).fold(0.0, f64::max);
        if worst <= tolerance {
            // Slipping nodes end exactly at their limit, not short of it by rounding.
            for k in 0..2 {
                for &i in &held {
                    tractions[k][i] += least[k][i];
                }
            }
            return Ok(compute_shear_displacements(patch, tractions, ALONG, work));
        }
        let way = towards(stride);
        let by_way = compute_shear_displacements(patch, &way, ALONG, work);
        let (slope, bend) = (product(&gradient, &way), product(&way, &by_way));
        energies.push(energy);
        let highest =
            energies.iter().rev().take(ENERGY_HISTORY).copied().fold(f64::NEG_INFINITY, f64::max);
        // Nonmonotone line search on the exact quadratic energy.
        let whole = energy + slope + 0.5 * bend;
        let part = if whole <= highest + 1e-4 * slope || bend <= 0.0 {
            1.0
        } else {
            (-slope / bend).min(1.0)
        };
        energy += part * slope + 0.5 * part * part * bend;
        for k in 0..2 {
            for i in 0..count {
                tractions[k][i] += part * way[k][i];
                gradient[k][i] += part * by_way[k][i];
            }
        }
        let length = product(&way, &way);
        // Barzilai and Borwein's step.
        stride = if bend > 0.0 { length / bend } else { stiffness };
    }
    Err(ElasticError::NoConvergence {
        what: "friction between indenter and surface",
        iterations: MAX_ITERATIONS,
        residual: worst,
        tolerance,
    })
}
