//! Axisymmetric presses at the pole at large strain, step by step.
//!
//! Newton's method on the energy of [`element`], with the mesh and the pressures of the small-strain model. Gaps are
//! those of the deformed surface, along the axis. The indenter pushes along its own normal, without friction. The
//! contact region is found together with the displacements: nodes that would pull are released, nodes that would enter
//! the indenter are added.

mod contact_constraint;
pub(crate) mod element;
mod system;

use fabkit_geometry::Vector3;

use crate::indenter::{Indenter, Press};
use crate::outcome::PressOutcome;
use crate::stack::ElasticStack;
use crate::{ElasticError, LayeredBody, MeshDensity};
use system::System;

/// Tolerance of the last displacement step, relative to the depth of the press.
const TOLERANCE: f64 = 1e-8;
const MAX_ITERATIONS: usize = 60;
/// Maximum number of times that a load step is halved before it fails.
const MAX_HALVINGS: u32 = 6;

/// A body under large strain. It is slow and serves as the reference for [`ElasticStack`].
///
/// ```
/// use fabkit_elastic::{BallIndenter, ElasticLayer, ElasticMaterial, FiniteStack, LayeredBody};
/// use fabkit_elastic::{MeshDensity, StrainTheory};
/// use fabkit_geometry::Point3;
///
/// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
/// let pad = LayeredBody::pad(6.0, vec![(gel, 2.0)]);
/// let stack = FiniteStack::new(&pad, &MeshDensity::around_pole(0.25, 1.5, 0))?;
/// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 3.0)?;
/// // One outcome for each depth; the work done on the gel grows with it.
/// let outcomes = stack.press(&ball, &[0.2, 0.4])?;
/// assert!(outcomes[0].energy_nmm < outcomes[1].energy_nmm);
/// assert_eq!(outcomes[1].level, StrainTheory::Finite);
/// // Depths must rise.
/// assert!(stack.press(&ball, &[0.4, 0.2]).is_err());
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
#[derive(Debug)]
pub struct FiniteStack {
    /// The small-strain model of the same body: it checks presses and gives the initial contact region.
    linear: ElasticStack,
}

impl FiniteStack {
    /// Meshes a body. The division's number of harmonics is ignored.
    ///
    /// # Errors
    /// As [`ElasticStack::new`].
    pub fn new(body: &LayeredBody, division: &MeshDensity) -> Result<Self, ElasticError> {
        let division = MeshDensity { max_harmonic: 0, ..*division };
        Ok(Self { linear: ElasticStack::new(body, &division, 1)? })
    }

    /// Presses along the axis to each of several rising depths below the first touch, mm.
    ///
    /// # Errors
    /// An indenter that is not axisymmetric, starts inside or goes too deep; depths that do not rise; no convergence.
    pub fn press(
        &self,
        presser: &dyn Indenter,
        depths_mm: &[f64],
    ) -> Result<Vec<PressOutcome>, ElasticError> {
        let down = -Vector3::z();
        let touching_mm = self.linear.touching_mm(presser, &down)?;
        let mut system = System::new(&self.linear);
        let (mut outcomes, mut reached_mm) = (Vec::new(), 0.0);
        for &depth_mm in depths_mm {
            if !(depth_mm > reached_mm && depth_mm.is_finite()) {
                let hint = "finite, and more than the depth before";
                return Err(ElasticError::Press { what: "a depth", value: depth_mm, hint });
            }
            // A press that is rejected at small strain is rejected here too.
            let small = self.linear.press(presser, &Press::along(down, depth_mm)?)?;
            if reached_mm == 0.0 {
                system.start_contact_from(&small);
            }
            let shift = |depth_mm: f64| (touching_mm + depth_mm) * down;
            reached_mm = advance_to(&mut system, presser, reached_mm, depth_mm, &shift)?;
            outcomes.push(system.outcome(depth_mm));
        }
        Ok(outcomes)
    }
}

/// Advances from one depth to the next, in smaller steps where one does not converge.
fn advance_to(
    system: &mut System<'_>,
    presser: &dyn Indenter,
    from_mm: f64,
    to_mm: f64,
    shift: &dyn Fn(f64) -> Vector3<f64>,
) -> Result<f64, ElasticError> {
    let (mut reached_mm, mut step_mm) = (from_mm, to_mm - from_mm);
    let least_mm = step_mm / f64::from(2_u32.pow(MAX_HALVINGS));
    while reached_mm < to_mm {
        let next_mm =
            // Rounding must not leave a tiny last step.
            if reached_mm + step_mm > to_mm - 1e-12 { to_mm } else { reached_mm + step_mm };
        let before = system.state();
        match system.solve(presser, &shift(next_mm), TOLERANCE * to_mm, MAX_ITERATIONS) {
            Ok(_) => reached_mm = next_mm,
            Err(error) if 0.5 * step_mm < least_mm => return Err(error),
            Err(_) => {
                system.restore(before);
                step_mm *= 0.5;
            }
        }
    }
    Ok(reached_mm)
}
