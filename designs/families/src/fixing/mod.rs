//! Automatic repair of designs that cannot be built: `--fix`.
//!
//! Values set by the user stay; values chosen by fabkit change, as few and as little as possible. If no such change
//! exists, the smallest set of contradicting rules is reported.

mod advice;
mod bought;
mod limits;
mod search;
mod shrink;
mod space;

use fabkit_text::{BrokenRule, InvalidDesign, Problem, RuleId};

pub use advice::advise;
pub use bought::is_bought;
pub use limits::{FeasibleRange, ValueRange, find_feasible_ranges};
use search::{SearchResult, search};
use shrink::shrink;
use space::{Space, Values};

use crate::{REGISTRY, SensorText};

/// Maximum number of states that a search expands.
const STATES: usize = 40;
/// Maximum number of states of each search that finds out which rules contradict.
const STATES_TO_BLAME: usize = 12;
/// Maximum number of evaluations to fix a design.
const MOST_TRIED: usize = 4000;
/// Maximum number of evaluations to find a contradiction.
const MOST_TRIED_TO_BLAME: usize = 3000;
/// Maximum number of rules among which a contradiction is sought: the first that were broken.
const MOST_BLAMED: usize = 24;

/// Change of one value.
///
/// ```
/// use fabkit_designs::fixing::ValueChange;
/// let change = ValueChange {
///     path: "tube.wall".into(),
///     from: "1 mm".into(),
///     to: "1.2 mm".into(),
///     because: "thinner glass breaks".into(),
/// };
/// assert_eq!(change.as_override(), "tube.wall=1.2 mm");
/// assert_eq!(change.to_string(), "tube.wall 1 mm -> 1.2 mm: because thinner glass breaks");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ValueChange {
    /// Dotted path of the parameter.
    pub path: String,
    /// Old value, as it would be written.
    pub from: String,
    /// New value, as it would be written.
    pub to: String,
    /// First rule that is broken without the change, as half a sentence.
    pub because: String,
}

impl ValueChange {
    /// Returns the change as an override: `path=value`.
    pub fn as_override(&self) -> String {
        format!("{}={}", self.path, self.to)
    }
}

impl std::fmt::Display for ValueChange {
    /// Formats `tube.wall 1 mm -> 1.2 mm: because ...`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {} -> {}: because {}", self.path, self.from, self.to, self.because)
    }
}

/// Finds the fewest and smallest changes of chosen values with which a design satisfies all rules; none if it already
/// does.
///
/// `overrides` and `others` are as for [`load`](crate::load). Values whose source is `paper`, `measured` or the user
/// stay, and so do those of bought things.
///
/// # Errors
/// Texts that cannot be read, reported as by [`load`](crate::load); or one problem that names the rules that contradict
/// each other.
///
/// ```
/// use fabkit_designs::{SensorText, builtin_yaml, fixing::fix, load};
/// let yaml = builtin_yaml("digit-like").ok_or("no such sensor")?;
/// let mut overrides = vec!["mold.floor=5.6 mm".to_owned()];
/// assert!(load("mine.yaml", yaml, &overrides, &["fixtures"]).is_err());
/// // The floor stays as asked for; a thicker pad makes room for its dowels.
/// let text = SensorText::without_bases("mine.yaml", yaml);
/// let changes = fix(text, &overrides, &["fixtures"])?;
/// assert_eq!(changes[0].path, "pad.thickness");
/// overrides.push(changes[0].as_override());
/// assert!(load("mine.yaml", yaml, &overrides, &["fixtures"]).is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fix(
    text: SensorText,
    overrides: &[String],
    others: &[&str],
) -> Result<Vec<ValueChange>, InvalidDesign> {
    let mine = sensor_overrides(overrides, others);
    let trial = REGISTRY.trial(text, &mine, others)?;
    let mut space = Space::new(trial, MOST_TRIED);
    let begin = Values::new();
    let first = space.outcome(&begin);
    if first.is_clean() {
        return Ok(Vec::new());
    }
    let as_it_is = || REGISTRY.load_text(text, &mine, others).err();
    // Unknown names, units and materials cannot be fixed by changing a number.
    let is_readable = |broken: &BrokenRule| {
        !broken.rule.is_range() || space.index(&broken.path).is_some_and(|i| first.at[i].is_some())
    };
    if let (false, Some(invalid)) = (first.broken.iter().all(is_readable), as_it_is()) {
        return Err(invalid);
    }
    let mut met = Vec::new();
    match search(&mut space, &begin, &[], &|_| true, STATES, &mut met) {
        SearchResult::Found(values) => {
            let values = shrink(&mut space, &begin, values);
            Ok(changes(&mut space, &values))
        }
        SearchResult::Nothing | SearchResult::Unknown => {
            let rules = find_contradiction(&mut space, met);
            Err(contradiction_problem(&mut space, &rules, &mine, as_it_is()))
        }
    }
}

/// Returns the overrides of the sensor itself, without those of other crates' sections.
pub(crate) fn sensor_overrides(overrides: &[String], others: &[&str]) -> Vec<String> {
    let is_other = |text: &String| {
        others.iter().any(|key| text.strip_prefix(key).is_some_and(|rest| rest.starts_with('.')))
    };
    overrides.iter().filter(|text| !is_other(text)).cloned().collect()
}

/// Pairs each change with the rule that is broken without it.
fn changes(space: &mut Space, values: &Values) -> Vec<ValueChange> {
    let mut changes = Vec::new();
    for (&number, &value) in values {
        let mut without = values.clone();
        without.remove(&number);
        let outcome = space.outcome(&without);
        let known = &space.numbers[number];
        let because = outcome.broken.first().map(|rule| reason(rule, &known.path));
        changes.push(ValueChange {
            path: known.path.clone(),
            from: outcome.at[number].map(|from| known.format_value(tidy(from))).unwrap_or_default(),
            to: known.format_value(value),
            because: because.unwrap_or_default(),
        });
    }
    changes
}

/// Rounds to a ten-thousandth: results of expressions may have many digits.
fn tidy(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// Returns the reason of a change, as half a sentence after "because".
fn reason(broken: &BrokenRule, path: &str) -> String {
    match (&broken.because, &broken.limit) {
        (Some(because), _) if broken.path == path => because.clone(),
        (Some(because), Some(limit)) => {
            format!("{} must be {limit}: {because}", broken.path)
        }
        _ => broken.message.clone(),
    }
}

/// Finds a minimal set of these rules that cannot be satisfied together: without any one of them, the others can.
fn find_contradiction(space: &mut Space, met: Vec<RuleId>) -> Vec<RuleId> {
    let begin = Values::new();
    let mut met = met;
    met.truncate(MOST_BLAMED);
    // The repair may have used up its budget: the search for the contradiction has its own.
    space.evaluations_left = MOST_TRIED_TO_BLAME;
    // Most often a single rule cannot be satisfied on its own.
    for rule in &met {
        let counts = |other: &RuleId| other == rule;
        let found = search(space, &begin, &[], &counts, STATES_TO_BLAME, &mut Vec::new());
        if matches!(found, SearchResult::Nothing) {
            return vec![rule.clone()];
        }
    }
    let mut rules = met;
    let mut i = rules.len();
    // Rules that came up last are the least likely to belong to the contradiction, so they are removed first.
    while i > 0 {
        i -= 1;
        let mut fewer = rules.clone();
        fewer.remove(i);
        if fewer.is_empty() {
            break;
        }
        let counts = |rule: &RuleId| fewer.contains(rule);
        let found = search(space, &begin, &[], &counts, STATES_TO_BLAME, &mut Vec::new());
        if matches!(found, SearchResult::Nothing) {
            rules = fewer;
        }
    }
    rules
}

/// Returns one problem that names the rules, with a hint which of the user's values to change.
fn contradiction_problem(
    space: &mut Space,
    rules: &[RuleId],
    overrides: &[String],
    as_it_is: Option<InvalidDesign>,
) -> InvalidDesign {
    let said: Vec<String> = rules.iter().filter_map(|rule| space.rule_text(rule)).collect();
    let set: Vec<&str> =
        overrides.iter().filter_map(|text| Some(text.split_once('=')?.0.trim())).collect();
    let begin = Values::new();
    // For each value set by the user, the nearest one with which the design can be built.
    let mut instead = Vec::new();
    for path in &set {
        let Some(number) = space.index(path) else { continue };
        if let Some((value, up)) =
            advice::nearest_either_way(space, &begin, number, &|o| o.is_clean())
        {
            let most = if up { "at least" } else { "at most" };
            instead.push(format!(
                "write {most} {} for `{path}`",
                space.numbers[number].format_value(value)
            ));
        }
    }
    let kept: Vec<String> = set.iter().map(|path| format!("`{path}`")).collect();
    let given = if kept.is_empty() {
        "whatever the chosen values are".to_owned()
    } else {
        format!("with {} as set, whatever the chosen values are", kept.join(", "))
    };
    let message = match &said[..] {
        [one] => format!("a contradiction: {one}; that cannot be kept {given}"),
        _ => format!(
            "a contradiction: {}; these cannot be kept together {given}",
            said.join("; and ")
        ),
    };
    // The new problem keeps the place of the first one in the file.
    let first = as_it_is.and_then(|invalid| invalid.problems.into_iter().next());
    let Some(first) = first else { return InvalidDesign::new(Vec::new()) };
    let hint = if instead.is_empty() {
        first.hint.clone().filter(|_| set.is_empty())
    } else {
        Some(instead.join(", or "))
    };
    let hint = hint.or_else(|| Some(format!("take back one of {}", kept.join(", "))));
    InvalidDesign::new(vec![Problem { message, hint, ..first }])
}

impl Space {
    /// Returns the text of a rule as it was when it was first broken.
    fn rule_text(&self, rule: &RuleId) -> Option<String> {
        let broken = self.first_broken(rule)?;
        Some(match (&broken.limit, &broken.because) {
            (Some(limit), Some(because)) => {
                format!("{} must be {limit}, because {because}", broken.path)
            }
            _ => broken.message.clone(),
        })
    }
}
