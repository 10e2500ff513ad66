//! Warnings about common failures in a lab: rules over liquids, the bodies they touch, and temperatures.
//!
//! Problems that the design has solved are reported too, with the step that solves them, so that nobody skips this step
//! unaware.

mod liquids;
mod safety;

pub(crate) use liquids::handling_time_h;

use fabkit_geometry::Sensor;
use serde::Serialize;

use crate::{StepMix, Timeline};

/// Warning for whoever builds the sensor.
///
/// ```
/// # use fabkit_guide::{Guide, NoShop, Request};
/// use fabkit_geometry::CureMechanism;
/// # let mut sensor = fabkit_checks::example::puck();
/// // Resin that keeps platinum silicone from curing.
/// sensor.bodies[2].substance.cure_mechanism = Some(CureMechanism::Platinum);
/// sensor.bodies[0].substance.inhibited_cures = Some(vec![CureMechanism::Platinum]);
/// # let stages = fabkit_checks::stages(&sensor)?;
/// # let (density, shop, calibration) = (&|_: &str| None, &NoShop, None);
/// # let request = Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
/// let warnings = Guide::new(&sensor, &request)?.warnings;
/// let warning = warnings.iter().find(|one| one.rule == "inhibition").ok_or("no warning")?;
/// assert!(warning.bodies.contains(&"dish".to_owned()));
/// assert_eq!(warning.dealt_with_in, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// Rule: `inhibition`, `gloves`, `release`, `primer`, `loose`, `heat`, `pot-life` or `safety`.
    pub rule: &'static str,
    /// Numbers of the steps in which it matters.
    pub steps: Vec<usize>,
    /// Names of the layers and parts concerned.
    pub bodies: Vec<String>,
    /// Failure and its cause.
    pub why: String,
    /// Action to take.
    pub do_this: String,
    /// Source of the warning.
    pub source: String,
    /// Number of the step that solves the problem; `null` if that is left to the reader.
    pub dealt_with_in: Option<usize>,
}

impl Warning {
    fn new(rule: &'static str, why: impl Into<String>, do_this: impl Into<String>) -> Self {
        Self {
            rule,
            steps: Vec::new(),
            bodies: Vec::new(),
            why: why.into(),
            do_this: do_this.into(),
            source: String::new(),
            dealt_with_in: None,
        }
    }

    fn in_steps(self, steps: impl IntoIterator<Item = usize>) -> Self {
        Self { steps: steps.into_iter().collect(), ..self }
    }

    fn with_bodies<'a>(self, bodies: impl IntoIterator<Item = &'a str>) -> Self {
        Self { bodies: bodies.into_iter().map(str::to_owned).collect(), ..self }
    }

    fn with_source(self, source: impl Into<String>) -> Self {
        Self { source: source.into(), ..self }
    }

    fn with_solution(self, step: Option<usize>) -> Self {
        Self { dealt_with_in: step, ..self }
    }
}

/// Returns all warnings: unsolved ones first, each group in the order of the steps.
pub(crate) fn warnings(sensor: &Sensor, mixes: &[StepMix], timeline: &Timeline) -> Vec<Warning> {
    let mut all = liquids::wall_warnings(sensor);
    all.extend(liquids::primers(sensor));
    all.extend(liquids::heat(sensor));
    all.extend(liquids::pot_lives(mixes, timeline));
    all.extend(liquids::gloves(sensor));
    all.extend(safety::handling(sensor));
    all.sort_by_key(|warning| (warning.dealt_with_in.is_some(), warning.steps.first().copied()));
    all
}
