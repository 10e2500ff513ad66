//! When steps begin, and what they wait for.

use std::collections::BTreeMap;

use fabkit_geometry::{Action, Step};
use serde::Serialize;

/// Hands-on time of a step, h: chosen, since no paper says it. Cures decide how long a build takes; these only
/// keep steps apart.
fn hands_on_h(action: &Action) -> f64 {
    match action {
        // Printers need no hands; how long they take is a slicer's business.
        Action::Make => 0.0,
        Action::Prepare | Action::Demold(_) | Action::Bond(_) => 0.25,
        Action::Assemble | Action::Spray(_) | Action::Pour(_) => 0.5,
    }
}

const HOURS_A_DAY: f64 = 24.0;

/// When one step is done.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// The step's number, from 1.
    pub step: usize,
    /// Hours after the parts are there.
    pub start_h: f64,
    /// When hands are free again, h.
    pub hands_end_h: f64,
    /// When it has cured, h; the same where nothing cures.
    pub end_h: f64,
    /// Whether the build takes longer when this does.
    pub is_critical: bool,
}

/// One person builds one unit, with all molds there; nights are not left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timeline {
    /// In the order of the steps.
    pub stretches: Vec<Stretch>,
    /// Until all has cured, h.
    pub total_h: f64,
    /// The same in days, rounded up.
    pub days: u32,
    /// What hands-on times rest on.
    pub hands_on: &'static str,
}

impl Timeline {
    /// Of a chain. A step begins when hands are free, and when what it waits for has cured: all that was cast or
    /// glued before, unless it says during which cure it is done.
    pub(crate) fn of(chain: &[Step]) -> Self {
        let numbers: BTreeMap<&str, usize> =
            chain.iter().enumerate().map(|(index, step)| (step.name.as_str(), index)).collect();
        let mut stretches: Vec<Stretch> = Vec::new();
        let mut causes: Vec<Option<usize>> = Vec::new();
        for (index, step) in chain.iter().enumerate() {
            let during = step.during.as_deref().and_then(|name| numbers.get(name).copied());
            // Nothing but the step whose cure is filled is still curing: what cured before that has been waited for.
            let is_waited_for = |earlier: &usize| during.is_none_or(|during| *earlier < during);
            let hands = index.checked_sub(1).map(|before| (before, stretches[before].hands_end_h));
            let cures = (0..index).filter(is_waited_for).map(|i| (i, stretches[i].end_h));
            let cause = hands.into_iter().chain(cures).max_by(|a, b| a.1.total_cmp(&b.1));
            let start_h = cause.map_or(0.0, |(_, end_h)| end_h);
            let hands_end_h = start_h + hands_on_h(&step.action);
            let end_h = hands_end_h + step.cure().map_or(0.0, |cure| cure.hours);
            stretches.push(Stretch {
                step: index + 1,
                start_h,
                hands_end_h,
                end_h,
                is_critical: false,
            });
            causes.push(cause.map(|(cause, _)| cause));
        }
        let total_h = stretches.iter().map(|stretch| stretch.end_h).fold(0.0, f64::max);
        let mut critical = (0..stretches.len()).find(|i| stretches[*i].end_h == total_h);
        while let Some(index) = critical {
            stretches[index].is_critical = true;
            critical = causes[index];
        }
        Self {
            stretches,
            total_h,
            days: (total_h / HOURS_A_DAY).ceil() as u32,
            hands_on: "chosen: a quarter of an hour to prepare, open or glue, half an hour for other steps",
        }
    }
}
