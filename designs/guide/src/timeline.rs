//! Schedule: the times of the steps, and the steps that they wait for.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{Action, Sensor, Step};
use serde::Serialize;

use crate::membership::is_in_sensor;

/// Returns the hands-on time of a step, h: chosen, since no paper states it. Cures dominate the duration of a build;
/// these times only keep steps apart.
pub(crate) fn hands_on_h(action: &Action) -> f64 {
    match action {
        // Printers need no hands; the print time is a slicer's business.
        Action::Make => 0.0,
        Action::Prepare | Action::Demold(_) | Action::Bond(_) => 0.25,
        Action::Assemble | Action::Spray(_) | Action::Pour(_) => 0.5,
    }
}

const HOURS_A_DAY: f64 = 24.0;

/// Time interval of one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepInterval {
    /// Number of the step, from 1.
    pub step: usize,
    /// Start, in hours after all parts are made.
    pub start_h: f64,
    /// End of the hands-on work, h.
    pub hands_end_h: f64,
    /// End of the cure, h; equal to the end of the hands-on work if nothing cures.
    pub end_h: f64,
    /// True if a delay of this step delays the build.
    pub is_critical: bool,
}

/// Schedule of one person who builds one unit with all molds at hand; nights are not left out.
///
/// ```
/// # use fabkit_guide::{Guide, NoShop, Request};
/// # let sensor = fabkit_checks::example::puck();
/// # let stages = fabkit_checks::stages(&sensor)?;
/// # let (density, shop, calibration) = (&|_: &str| None, &NoShop, None);
/// # let request = Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
/// let timeline = Guide::new(&sensor, &request)?.timeline;
/// // Half an hour to pour, 4 h of cure, a quarter of an hour to open the mold.
/// assert_eq!((timeline.total_h, timeline.hands_h), (4.75, 0.75));
/// assert_eq!(timeline.critical, [1, 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timeline {
    /// Intervals in the order of the steps.
    pub stretches: Vec<StepInterval>,
    /// Time until everything has cured, h.
    pub total_h: f64,
    /// Total time in days, rounded up.
    pub days: u32,
    /// Hands-on time, h.
    pub hands_h: f64,
    /// Numbers of the steps on the critical path, in order.
    pub critical: Vec<usize>,
    /// Steps that are done while something cures.
    pub meanwhile: Vec<ParallelSteps>,
    /// Schedule for all units.
    pub units: UnitSeries,
    /// Source of the hands-on times.
    pub hands_on: &'static str,
}

/// Steps that are done during a cure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParallelSteps {
    /// Number of the step that cures.
    pub during: usize,
    /// Numbers of the steps that are done meanwhile.
    pub steps: Vec<usize>,
}

/// Several units, one after the other with one set of molds and tools.
///
/// ```
/// # use fabkit_guide::{Guide, NoShop, Request};
/// use fabkit_geometry::{Assembly, Placement};
/// # let mut sensor = fabkit_checks::example::puck();
/// // The puck stays in the sensor, so each unit needs one of its own.
/// sensor.bodies[2].placements.push(Placement::in_place(Assembly::sensor()));
/// # let stages = fabkit_checks::stages(&sensor)?;
/// # let (density, shop, calibration) = (&|_: &str| None, &NoShop, None);
/// # let request = Request { design_hash: "00", units: 3, density, shop, stages: &stages, calibration };
/// let units = Guide::new(&sensor, &request)?.timeline.units;
/// // With a single mold, three pucks cure for 4 h each, one after the other.
/// assert_eq!(units.waits_for.as_deref(), Some("dish"));
/// assert!(units.total_h > 3.0 * 4.0);
/// // Each is poured in half an hour and opened in a quarter.
/// assert_eq!(units.hands_h, 3.0 * 0.75);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnitSeries {
    /// Number of units.
    pub count: u32,
    /// Time until the last unit has cured, h.
    pub total_h: f64,
    /// Hands-on time, h; molds and tools are made once.
    pub hands_h: f64,
    /// Time between the starts of consecutive units, h.
    pub apart_h: f64,
    /// Bottleneck: name of a mold or tool; `null` for the hands.
    pub waits_for: Option<String>,
}

impl Timeline {
    /// Schedules a chain. A step starts when the hands are free and everything cast or glued before has cured, except
    /// the cure of the step that it names in `during`.
    pub(crate) fn new(sensor: &Sensor, units: u32) -> Self {
        let chain = &sensor.chain;
        let numbers: BTreeMap<&str, usize> =
            chain.iter().enumerate().map(|(index, step)| (step.name.as_str(), index)).collect();
        let mut stretches: Vec<StepInterval> = Vec::new();
        let mut causes: Vec<Option<usize>> = Vec::new();
        for (index, step) in chain.iter().enumerate() {
            let during = step.during_cure_of.as_deref().and_then(|name| numbers.get(name).copied());
            // Everything before the step named in `during` has already been waited for.
            let is_waited_for = |earlier: &usize| during.is_none_or(|during| *earlier < during);
            let hands = index.checked_sub(1).map(|before| (before, stretches[before].hands_end_h));
            let cures = (0..index).filter(is_waited_for).map(|i| (i, stretches[i].end_h));
            let cause = hands.into_iter().chain(cures).max_by(|a, b| a.1.total_cmp(&b.1));
            let start_h = cause.map_or(0.0, |(_, end_h)| end_h);
            let hands_end_h = start_h + hands_on_h(&step.action);
            let end_h = hands_end_h + step.cure().map_or(0.0, |cure| cure.hours);
            stretches.push(StepInterval {
                step: index + 1,
                start_h,
                hands_end_h,
                end_h,
                is_critical: false,
            });
            causes.push(cause.map(|(cause, _)| cause));
        }
        let total_h = stretches.iter().map(|stretch| stretch.end_h).fold(0.0, f64::max);
        // The critical path runs backwards from the step that ends last, along whatever each step waited for.
        let mut critical = (0..stretches.len()).find(|i| stretches[*i].end_h == total_h);
        while let Some(index) = critical {
            stretches[index].is_critical = true;
            critical = causes[index];
        }
        let critical = stretches.iter().filter(|s| s.is_critical).map(|s| s.step).collect();
        Self {
            units: UnitSeries::new(sensor, &stretches, total_h, units),
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

/// Returns the steps that are done during each cure.
fn meanwhile(chain: &[Step], numbers: &BTreeMap<&str, usize>) -> Vec<ParallelSteps> {
    let mut found: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, step) in chain.iter().enumerate() {
        let during = step.during_cure_of.as_deref().and_then(|name| numbers.get(name));
        if let Some(during) = during {
            found.entry(during + 1).or_default().push(index + 1);
        }
    }
    found.into_iter().map(|(during, steps)| ParallelSteps { during, steps }).collect()
}

/// Returns the names of all bodies that a step needs, makes or takes off. `before` are the steps before it.
fn touched<'a>(step: &'a Step, before: &'a [Step]) -> BTreeSet<&'a str> {
    let more: Vec<&String> = match &step.action {
        Action::Pour(pour) => pour.walls.iter().chain([&pour.layer]).collect(),
        Action::Spray(spray) => spray.onto.iter().chain([&spray.layer]).collect(),
        // Tools are taken off what was cast in their assembly, which the step itself does not name.
        Action::Demold(pulls) => {
            let cast = before.iter().filter(|earlier| earlier.assembly == step.assembly);
            let layers = cast.filter_map(|earlier| match &earlier.action {
                Action::Pour(pour) => Some(&pour.layer),
                _ => None,
            });
            pulls.iter().map(|pull| &pull.body).chain(layers).collect()
        }
        Action::Make | Action::Prepare | Action::Assemble | Action::Bond(_) => Vec::new(),
    };
    step.bodies.iter().chain(more).map(String::as_str).collect()
}

impl UnitSeries {
    /// Schedules several units: identical jobs through a row of machines take as long as one job, plus the load of the
    /// busiest machine for each further job (Johnson, Naval Res. Logist. Q. 1, 1954). The machines are the hands and
    /// everything that is used again: a mold is busy from the first step of a unit that needs it until the last one has
    /// ended.
    fn new(sensor: &Sensor, stretches: &[StepInterval], total_h: f64, count: u32) -> Self {
        let is_of_unit = |name: &str| sensor.body(name).is_some_and(is_in_sensor);
        let mut busy: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
        // Steps that concern tools alone are done once, all others for each unit.
        let (mut once_h, mut each_h) = (0.0, 0.0);
        for (index, (step, stretch)) in sensor.chain.iter().zip(stretches).enumerate() {
            let touched = touched(step, &sensor.chain[..index]);
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
        // Among equally busy tools, the first by name.
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
