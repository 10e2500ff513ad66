//! Verified hints: each suggestion has been tried and leads to a design that can be built.

use fabkit_text::{BrokenRule, InvalidDesign, Problem, Suggestion};

use super::bought::is_bought;
use super::search::{SearchResult, search};
use super::shrink::{rounded_candidates, shrink};
use super::space::{RuleOutcome, RuleState, Space, Values};
use super::{STATES_TO_BLAME, sensor_overrides};
use crate::{REGISTRY, SensorText};

/// Maximum number of evaluations for the hints of one design.
const MOST_TRIED: usize = 3000;
/// Most ways out that a hint names.
const MOST_SUGGESTED: usize = 3;
/// Maximum number of parameters tried for one problem.
const MOST_CANDIDATES: usize = 6;

/// Codes of problems that still allow to try numbers. A name that nobody knows is none: no rule is asked then, and no
/// number makes the design buildable.
const READABLE: [&str; 5] =
    ["limit_broken", "out_of_range", "rule_broken", "unknown_choice", "unknown_material"];

/// Replaces hints of a design's problems by verified ones where such exist. All suggestions hold together. Values that
/// the user has just changed are tried first, those of bought things never.
///
/// The arguments are those with which [`load`](crate::load) refused the design.
///
/// ```
/// use fabkit_designs::{SensorText, builtin_yaml, fixing::advise, load};
/// let yaml = builtin_yaml("digit-like").ok_or("no such sensor")?;
/// let overrides = ["shell.corner=2.8 mm".to_owned()];
/// let mut invalid = load("mine.yaml", yaml, &overrides, &["fixtures"]).unwrap_err();
/// let text = SensorText::without_bases("mine.yaml", yaml);
/// advise(text, &overrides, &["fixtures"], &mut invalid);
/// // The suggested value has been tried.
/// let tried = invalid.problems[0].facts.suggestion.as_ref().ok_or("no way out")?;
/// let overrides = [format!("{}={}", tried.path, tried.value)];
/// assert!(load("mine.yaml", yaml, &overrides, &["fixtures"]).is_ok());
/// # Ok::<(), &str>(())
/// ```
pub fn advise(
    text: SensorText,
    overrides: &[String],
    others: &[&str],
    invalid: &mut InvalidDesign,
) {
    // Unreadable texts, such as a cycle of expressions, have to be mended first; searching further would only take
    // time.
    let is_unreadable = |code: &str| !READABLE.contains(&code);
    if invalid.problems.iter().any(|problem| is_unreadable(problem.facts.code)) {
        return;
    }
    let mine = sensor_overrides(overrides, others);
    let Ok(trial) = REGISTRY.trial(text, &mine, others) else { return };
    let Ok(report) = REGISTRY.report(text, &mine, others) else { return };
    // Also those that the list had no room for.
    if report.problem_codes().any(is_unreadable) {
        return;
    }
    let mut space = Space::new(trial, MOST_TRIED);
    let set: Vec<usize> =
        mine.iter().filter_map(|text| space.index(text.split_once('=')?.0.trim())).collect();
    for Hint { broken, text, suggestion } in find_hints(&mut space, &report.broken_rules(), &set) {
        let is_same = |p: &&mut Problem| p.path == broken.path && p.message == broken.message;
        if let Some(problem) = invalid.problems.iter_mut().find(is_same) {
            problem.hint = Some(text);
            problem.facts.suggestion = suggestion;
        }
    }
}

/// Value tried in place of a parameter's own.
#[derive(Clone, Copy)]
struct TriedValue {
    number: usize,
    value: f64,
    /// True if larger values work too, as far as is known; otherwise smaller ones do.
    up: bool,
}

/// Hint for a broken rule.
struct Hint {
    broken: BrokenRule,
    /// Text for people.
    text: String,
    /// Suggestion for programs; `None` if more than one value has to change.
    suggestion: Option<Suggestion>,
}

/// Returns a hint for each broken rule for which one was found.
fn find_hints(space: &mut Space, broken: &[BrokenRule], set: &[usize]) -> Vec<Hint> {
    let mut values = Values::new();
    let first = space.outcome(&values);
    // Unknown names, units and materials have hints of their own.
    let told = |b: &&BrokenRule| {
        matches!(first.rule_state(&b.rule), RuleState::Broken(_))
            && (b.limit.is_some() || space.index(&b.path).is_some())
    };
    let broken: Vec<&BrokenRule> = broken.iter().filter(told).collect();
    let mut found: Vec<Option<TriedValue>> = Vec::new();
    for problem in &broken {
        let tried = match space.outcome(&values).rule_state(&problem.rule) {
            RuleState::Broken(_) => best(space, &values, problem, set),
            // The values suggested for earlier problems solve this one too.
            _ => None,
        };
        if let Some(tried) = tried {
            values.insert(tried.number, tried.value);
        }
        found.push(tried);
    }
    // Single values are suggested only if all of them together make the design buildable.
    let mut is_solved = space.outcome(&values).is_clean();
    if !is_solved && let Some(tried) = nearest_buildable_override(space, set) {
        values = Values::from([(tried.number, tried.value)]);
        found = broken.iter().map(|_| Some(tried)).collect();
        is_solved = true;
    }
    // A number that was moved for two problems has its last value in both hints.
    for tried in found.iter_mut().flatten() {
        tried.value = values[&tried.number];
    }
    let together = if is_solved { None } else { find_joint_change(space) };
    // Shared by the problems that this one value solves as well.
    let first_tried = found.iter().flatten().next().copied();
    let mut hints = Vec::new();
    for (i, (problem, tried)) in broken.into_iter().zip(found).enumerate() {
        let tried = if is_solved { tried.or(first_tried) } else { None };
        let mut said: Vec<String> = match (tried, &together) {
            (Some(tried), _) => vec![format_hint(space, tried, problem)],
            (None, Some(values)) if i == 0 => {
                let texts = space.texts(values);
                let texts = texts.iter().map(|(path, text)| format!("{text} for `{path}`"));
                vec![format!("write {}", texts.collect::<Vec<_>>().join(" and "))]
            }
            _ => Vec::new(),
        };
        let is_other = |path: &&String| {
            let number = space.index(path);
            let is_said = tried.is_some_and(|tried| Some(tried.number) == number);
            !is_said && (!is_bought(path) || number.is_some_and(|number| set.contains(&number)))
        };
        let own = tried.is_some_and(|tried| space.numbers[tried.number].path != problem.path);
        let own = (own || said.is_empty()).then_some(&problem.path);
        let change: Vec<String> = own
            .into_iter()
            .chain(&problem.inputs)
            .filter(is_other)
            .take(MOST_SUGGESTED - said.len())
            .map(|path| format!("`{path}`"))
            .collect();
        match &change[..] {
            [] => {}
            [one] => said.push(format!("change {one}")),
            [most @ .., last] => said.push(format!("change {} or {last}", most.join(", "))),
        }
        // A value at the end of its plain range already has a hint that says so.
        let is_end = |tried: TriedValue| {
            let number = &space.numbers[tried.number];
            number.path == problem.path && number.range.contains(&tried.value)
        };
        let knows_better = match tried {
            Some(tried) => !(problem.rule.is_range() && is_end(tried)),
            None => together.is_some() || problem.limit.is_some(),
        };
        if knows_better && !said.is_empty() {
            let suggestion = tried.map(|TriedValue { number, value, .. }| {
                let number = &space.numbers[number];
                Suggestion { path: number.path.clone(), value: number.format_value(value) }
            });
            hints.push(Hint { broken: problem.clone(), text: said.join(", or "), suggestion });
        }
    }
    hints
}

/// Formats `write at most 3 mm for ...`.
fn format_hint(
    space: &Space,
    TriedValue { number, value, up }: TriedValue,
    problem: &BrokenRule,
) -> String {
    let number = &space.numbers[number];
    let most = if up { "at least" } else { "at most" };
    if number.path == problem.path {
        format!("write {most} {}", number.format_value(value))
    } else {
        format!("write {most} {} for `{}`", number.format_value(value), number.path)
    }
}

/// Finds the first input of a rule that satisfies the rule when changed alone, and breaks no other.
fn best(
    space: &mut Space,
    values: &Values,
    problem: &BrokenRule,
    set: &[usize],
) -> Option<TriedValue> {
    let now = space.outcome(values);
    let mends = |outcome: &RuleOutcome| {
        outcome.rule_state(&problem.rule) == RuleState::Satisfied
            && outcome.broken.iter().all(|b| now.broken.iter().any(|was| was.rule == b.rule))
    };
    let own = space.index(&problem.path);
    let inputs: Vec<usize> = problem.inputs.iter().filter_map(|path| space.index(path)).collect();
    // Order: values that the user has just changed and that the problem is about; all others that the user set; the
    // parameter of the problem; then the values that its limit follows from.
    let is_about = |number: &&usize| Some(**number) == own || inputs.contains(number);
    let mut candidates: Vec<usize> = set.iter().filter(is_about).copied().collect();
    candidates.extend(set);
    candidates
        .extend(own.into_iter().chain(inputs).filter(|i| !is_bought(&space.numbers[*i].path)));
    let mut seen = Vec::new();
    candidates.retain(|number| {
        !seen.contains(number) && {
            seen.push(*number);
            true
        }
    });
    for number in candidates.into_iter().take(MOST_CANDIDATES) {
        if space.evaluations_left == 0 {
            return None;
        }
        // First try the limit exactly as the message states it.
        if Some(number) == own
            && let Some(tried) = parse_limit(space, number, problem)
        {
            let mut values = values.clone();
            values.insert(number, tried.value);
            if mends(&space.outcome(&values)) {
                return Some(tried);
            }
        }
        if let Some((value, up)) = nearest_either_way(space, values, number, &mends) {
            return Some(TriedValue { number, value, up });
        }
    }
    None
}

/// Parses the limit in the message as a value.
fn parse_limit(space: &Space, number: usize, problem: &BrokenRule) -> Option<TriedValue> {
    let limit = problem.limit.as_ref()?;
    let (up, text) = match limit.strip_prefix("at least ") {
        Some(text) => (true, text),
        None => (false, limit.strip_prefix("at most ")?),
    };
    let value: f64 = text.split(' ').next()?.parse().ok()?;
    let [low, high] = space.numbers[number].range;
    (low..=high).contains(&value).then_some(TriedValue { number, value, up })
}

/// Finds the nearest good value of a number in either direction, in few digits, and whether values above it count ("at
/// least").
pub(super) fn nearest_either_way(
    space: &mut Space,
    values: &Values,
    number: usize,
    is_good: &dyn Fn(&RuleOutcome) -> bool,
) -> Option<(f64, bool)> {
    let begin = space.outcome(values).at[number]?;
    let mut found: Vec<(f64, bool)> = Vec::new();
    for up in [false, true] {
        let nearest = space.nearest(values, number, up, is_good, &|_| false);
        found.extend(nearest.map(|value| (value, up)));
    }
    found.sort_by(|a, b| (a.0 - begin).abs().total_cmp(&(b.0 - begin).abs()));
    let (value, up) = *found.first()?;
    for rounded in rounded_candidates(space, number, value, up) {
        let mut values = values.clone();
        values.insert(number, rounded);
        if is_good(&space.outcome(&values)) {
            return Some((rounded, up));
        }
    }
    Some((value, up))
}

/// Finds the first override of the user's that alone can be moved to a value with which the design can be built, and
/// the nearest such value.
fn nearest_buildable_override(space: &mut Space, set: &[usize]) -> Option<TriedValue> {
    set.iter().find_map(|&number| {
        let (value, up) = nearest_either_way(space, &Values::new(), number, &|o| o.is_clean())?;
        Some(TriedValue { number, value, up })
    })
}

/// Finds several values that have to change together, by the search of `--fix`.
fn find_joint_change(space: &mut Space) -> Option<Values> {
    let begin = Values::new();
    match search(space, &begin, &[], &|_| true, STATES_TO_BLAME, &mut Vec::new()) {
        SearchResult::Found(values) => Some(shrink(space, &begin, values)),
        SearchResult::Nothing | SearchResult::Unknown => None,
    }
}
