//! When steps begin, and what they wait for.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{Action, Sensor, Step};
use serde::Serialize;

use crate::membership::stays;

/// Hands-on time of a step, h: chosen, since no paper says it. Cures decide how long a build takes; these only
/// keep steps apart.
pub(crate) fn hands_on_h(action: &Action) -> f64 {
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
    /// What hands do of it, h.
    pub hands_h: f64,
    /// Numbers of the steps that the whole build waits for, in their order.
    pub critical: Vec<usize>,
    /// What is done while something cures.
    pub meanwhile: Vec<Meanwhile>,
    /// For all units.
    pub units: Series,
    /// What hands-on times rest on.
    pub hands_on: &'static str,
}

/// Steps that fill the time of a cure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Meanwhile {
    /// The number of the step that cures.
    pub during: usize,
    /// The numbers of those that are done in that time.
    pub steps: Vec<usize>,
}

/// Several units, one behind the other through one set of molds and tools.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    /// How many.
    pub count: u32,
    /// Until the last of them has cured, h.
    pub total_h: f64,
    /// What hands do of it, h: molds and tools are made once.
    pub hands_h: f64,
    /// Each unit is so far behind the one before, h.
    pub apart_h: f64,
    /// What keeps the next one waiting: a mold or tool by name; `null` where it is the hands.
    pub waits_for: Option<String>,
}

impl Timeline {
    /// Of a chain. A step begins when hands are free, and when what it waits for has cured: all that was cast or
    /// glued before, unless it says during which cure it is done.
    pub(crate) fn of(sensor: &Sensor, units: u32) -> Self {
        let chain = &sensor.chain;
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
        let critical = stretches.iter().filter(|s| s.is_critical).map(|s| s.step).collect();
        Self {
            units: Series::of(sensor, &stretches, total_h, units),
            critical,
            meanwhile: meanwhile(chain, &numbers),
            hands_h: chain.iter().map(|step| hands_on_h(&step.action)).sum(),
            stretches,
            total_h,
            days: (total_h / HOURS_A_DAY).ceil() as u32,
            hands_on: "chosen: a quarter of an hour to prepare, open or glue, half an hour for other steps",
        }
    }
}

fn meanwhile(chain: &[Step], numbers: &BTreeMap<&str, usize>) -> Vec<Meanwhile> {
    let mut found: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, step) in chain.iter().enumerate() {
        let during = step.during.as_deref().and_then(|name| numbers.get(name));
        if let Some(during) = during {
            found.entry(during + 1).or_default().push(index + 1);
        }
    }
    found.into_iter().map(|(during, steps)| Meanwhile { during, steps }).collect()
}

/// All that a step needs, makes or takes off, by name.
fn touched(step: &Step) -> BTreeSet<&str> {
    let more: Vec<&String> = match &step.action {
        Action::Pour(pour) => pour.walls.iter().chain([&pour.layer]).collect(),
        Action::Spray(spray) => spray.onto.iter().chain([&spray.layer]).collect(),
        Action::Demold(pulls) => pulls.iter().map(|pull| &pull.body).collect(),
        Action::Make | Action::Prepare | Action::Assemble | Action::Bond(_) => Vec::new(),
    };
    step.bodies.iter().chain(more).map(String::as_str).collect()
}

impl Series {
    /// Alike jobs through a row of machines take as long as one, and as often more as the busiest machine works for
    /// each (Johnson, Naval Res. Logist. Q. 1, 1954). Machines are the hands, and whatever is used again: a mold is
    /// busy from the first step of a unit that needs it until the last one has ended.
    fn of(sensor: &Sensor, stretches: &[Stretch], total_h: f64, count: u32) -> Self {
        let is_of_unit = |name: &str| sensor.body(name).is_some_and(stays);
        let mut busy: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
        let (mut once_h, mut each_h) = (0.0, 0.0);
        for (step, stretch) in sensor.chain.iter().zip(stretches) {
            let touched = touched(step);
            let hands_h = hands_on_h(&step.action);
            if !touched.iter().any(|name| is_of_unit(name)) {
                once_h += hands_h;
                continue;
            }
            each_h += hands_h;
            for tool in touched.into_iter().filter(|name| !is_of_unit(name)) {
                let ends = busy.entry(tool).or_insert([stretch.start_h, stretch.end_h]);
                *ends = [ends[0].min(stretch.start_h), ends[1].max(stretch.end_h)];
            }
        }
        let longest = busy.iter().map(|(tool, ends)| (*tool, ends[1] - ends[0]));
        // Of several that are busy as long, the first by name.
        let longest = longest.fold(None, |most: Option<(&str, f64)>, (tool, hours)| match most {
            Some((_, most_h)) if most_h >= hours => most,
            _ => Some((tool, hours)),
        });
        let (apart_h, waits_for) = match longest {
            Some((tool, hours)) if hours > each_h => (hours, Some(tool.to_owned())),
            _ => (each_h, None),
        };
        let further = f64::from(count.saturating_sub(1));
        Self {
            count,
            total_h: total_h + further * apart_h,
            hands_h: once_h + f64::from(count) * each_h,
            apart_h,
            waits_for,
        }
    }
}
