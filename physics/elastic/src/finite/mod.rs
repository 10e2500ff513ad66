//! Large strain: presses at the pole by what is symmetric about the axis, step by step.
//!
//! Newton's method on the energy of [`element`], with the same mesh and the same pressures as at small
//! strain. Gaps are those of the moved surface, along the axis; the presser pushes along its own normal,
//! without friction. Contact is found together with displacements: nodes that would pull are let go, nodes
//! that would enter the presser are taken in.

pub(crate) mod element;
mod grip;
mod system;

use fabkit_geometry::Vector3;

use crate::outcome::Outcome;
use crate::presser::{Press, Presser};
use crate::stack::Stack;
use crate::{Body, Division, ElasticError};
use system::System;

/// How far displacements may still move, as a part of the press's depth.
const TOLERANCE: f64 = 1e-8;
const MAX_ITERATIONS: usize = 60;
/// Into how many parts a step is divided before it is given up.
const MAX_HALVINGS: u32 = 6;

/// A body that is pressed with large strain, slowly: the reference for [`Stack`].
#[derive(Debug)]
pub struct FiniteStack {
    /// The same at small strain: where presses begin.
    linear: Stack,
}

impl FiniteStack {
    /// Meshes a body; what the division says of harmonics does not count.
    ///
    /// # Errors
    /// As [`Stack::new`].
    pub fn new(body: &Body, division: &Division) -> Result<Self, ElasticError> {
        let division = Division { max_harmonic: 0, ..*division };
        Ok(Self { linear: Stack::new(body, &division, 1)? })
    }

    /// Presses along the axis to each of several depths below the first touch, mm, rising.
    ///
    /// # Errors A presser that is not symmetric about the axis, starts inside or goes too deep, depths that
    /// do not rise, and what does not converge.
    pub fn press(
        &self,
        presser: &dyn Presser,
        depths_mm: &[f64],
    ) -> Result<Vec<Outcome>, ElasticError> {
        let down = -Vector3::z();
        let touching_mm = self.linear.touching_mm(presser, &down)?;
        let mut system = System::new(&self.linear);
        let (mut outcomes, mut reached_mm) = (Vec::new(), 0.0);
        for &depth_mm in depths_mm {
            if !(depth_mm > reached_mm && depth_mm.is_finite()) {
                let hint = "finite, and more than the depth before";
                return Err(ElasticError::Press { what: "a depth", value: depth_mm, hint });
            }
            // What the press is refused for at small strain, it is refused for here.
            let small = self.linear.press(presser, &Press::along(down, depth_mm)?)?;
            if reached_mm == 0.0 {
                system.hold(&small);
            }
            let shift = |depth_mm: f64| (touching_mm + depth_mm) * down;
            reached_mm = reach(&mut system, presser, reached_mm, depth_mm, &shift)?;
            outcomes.push(system.outcome(depth_mm));
        }
        Ok(outcomes)
    }
}

/// Goes from one depth to the next, in parts where it does not work in one.
fn reach(
    system: &mut System<'_>,
    presser: &dyn Presser,
    from_mm: f64,
    to_mm: f64,
    shift: &dyn Fn(f64) -> Vector3<f64>,
) -> Result<f64, ElasticError> {
    let (mut reached_mm, mut step_mm) = (from_mm, to_mm - from_mm);
    let least_mm = step_mm / f64::from(2_u32.pow(MAX_HALVINGS));
    while reached_mm < to_mm {
        let next_mm =
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
