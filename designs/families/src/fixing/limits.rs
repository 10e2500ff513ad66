//! Feasible ranges of parameters: `fabkit show --limits`.

use fabkit_text::{InvalidDesign, ValueKind};

use super::search::{SearchResult, search};
use super::sensor_overrides;
use super::space::{Space, Values};
use crate::{REGISTRY, SensorText};

/// Maximum number of evaluations for one parameter: with all others held, and with chosen values following.
const MOST_TRIED: [usize; 2] = [200, 500];
/// Maximum number of states of a search for values that follow.
const STATES: usize = 5;
/// Number of bisection steps between a good and a bad value: with others held, and with others following.
const HALVINGS: [usize; 2] = [12, 4];
/// Steps outward, relative to [`Space::scale`]; then the end of the allowed range.
const STEPS: [f64; 9] = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];

/// Number with its feasible range.
#[derive(Clone, Debug, PartialEq)]
pub struct FeasibleRange {
    /// Dotted path of the parameter.
    pub path: String,
    /// Value in the design, in `unit`.
    pub value: f64,
    /// Unit: `mm`, `deg` or empty.
    pub unit: &'static str,
    /// Feasible range with all other values held.
    pub alone: ValueRange,
    /// Feasible range if chosen values may follow; only if requested.
    pub following: Option<ValueRange>,
}

/// Smallest and largest value with which a design can be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueRange {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// True for each bound that is the end of the range that fabkit allows at all.
    pub is_end: [bool; 2],
}

/// Finds the feasible range of each number, up and down from its value, until the design cannot be built; with `follow`
/// also the range if chosen values may follow.
///
/// `progress(done, count)` is called before each number. The other arguments are as for [`load`](crate::load).
///
/// # Errors
/// Every problem of the design as it is.
pub fn find_feasible_ranges(
    text: SensorText,
    overrides: &[String],
    others: &[&str],
    follow: bool,
    progress: &dyn Fn(usize, usize),
) -> Result<Vec<FeasibleRange>, InvalidDesign> {
    let mine = sensor_overrides(overrides, others);
    REGISTRY.load_text(text, &mine, others)?;
    let trial = REGISTRY.trial(text, &mine, others)?;
    let count = Space::new(trial.clone(), 1).numbers.len();
    let mut all = Vec::new();
    for number in 0..count {
        // A new space for each number: outcomes cached for other numbers' values are of no use here.
        let mut space = Space::new(trial.clone(), MOST_TRIED[0]);
        progress(number, count);
        let Some(value) = space.numbers[number].value else { continue };
        let held =
            extend_range(&mut space, number, [value; 2], HALVINGS[0], &mut |space, value| {
                space.outcome_with(&Values::new(), number, value).is_clean()
            });
        let followed = follow.then(|| {
            space.evaluations_left = MOST_TRIED[1];
            // Values that work with the others held work with the others following, too: continue outward from them.
            let ends = [held.low, held.high];
            extend_range(&mut space, number, ends, HALVINGS[1], &mut |space, value| {
                let begin = Values::from([(number, value)]);
                let met = &mut Vec::new();
                let found = search(space, &begin, &[number], &|_| true, STATES, met);
                matches!(found, SearchResult::Found(_))
            })
        });
        let known = &space.numbers[number];
        let unit = match known.kind {
            ValueKind::Length => "mm",
            ValueKind::Angle => "deg",
            _ => "",
        };
        all.push(FeasibleRange {
            path: known.path.clone(),
            value,
            unit,
            alone: held,
            following: followed,
        });
    }
    Ok(all)
}

/// Extends a range outward from two good values.
fn extend_range(
    space: &mut Space,
    number: usize,
    from: [f64; 2],
    halvings: usize,
    is_good: &mut dyn FnMut(&mut Space, f64) -> bool,
) -> ValueRange {
    let ends = space.numbers[number].range;
    let mut found = from;
    for (i, up) in [(0, false), (1, true)] {
        let end = ends[i];
        let steps = steps(space, number, from[i], end, up);
        let mut bad = None;
        for value in steps {
            if space.evaluations_left == 0 || !is_good(space, value) {
                bad = Some(value);
                break;
            }
            found[i] = value;
        }
        let Some(mut bad) = bad else { continue };
        // The limit lies between the last good and the first bad value.
        for _ in 0..halvings {
            let half = rounded(space, number, 0.5 * (found[i] + bad), up);
            if half == bad || half == found[i] || space.evaluations_left == 0 {
                break;
            }
            if is_good(space, half) { found[i] = half } else { bad = half }
        }
    }
    ValueRange { low: found[0], high: found[1], is_end: [found[0] == ends[0], found[1] == ends[1]] }
}

/// Returns the values to try in one direction, ending with `end`.
fn steps(space: &Space, number: usize, from: f64, end: f64, up: bool) -> Vec<f64> {
    let scale = space.scale(number);
    let mut steps: Vec<f64> = STEPS
        .iter()
        .map(|step| if up { from + step * scale } else { from - step * scale })
        .map(|value| rounded(space, number, value, up))
        .take_while(|value| if up { *value < end } else { *value > end })
        .collect();
    steps.push(end);
    steps.dedup();
    steps.retain(|value| *value != from);
    steps
}

/// Rounds counts outward to whole numbers, other values to a thousandth.
fn rounded(space: &Space, number: usize, value: f64, up: bool) -> f64 {
    match space.numbers[number].kind {
        ValueKind::Count if up => value.ceil(),
        ValueKind::Count => value.floor(),
        _ => (value * 1e3).round() / 1e3,
    }
}
