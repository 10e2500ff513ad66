//! Best-first search for values that satisfy all rules.
//!
//! Of the states reached so far, the one with the fewest changes plus broken rules is expanded next. From it, each
//! number that may change is moved, up and down, by as little as satisfies the first broken rule. Values that are
//! expressions of it follow.

use std::collections::BTreeSet;
use std::rc::Rc;

use fabkit_text::{RuleId, ValueKind};

use super::space::{RuleOutcome, RuleState, Space, Values};

/// Result of a search.
pub(super) enum SearchResult {
    /// Values that satisfy the rules.
    Found(Values),
    /// No such values, as far as the search reached.
    Nothing,
    /// Search stopped at the limit of evaluations: nothing is known.
    Unknown,
}

/// Node of the search.
struct State {
    values: Values,
    outcome: Rc<RuleOutcome>,
    /// Number of changes plus number of broken rules.
    weight: usize,
    /// Sum of the relative changes of the values, in units of [`Space::scale`].
    moved: f64,
}

/// Predicate that selects the rules to satisfy.
pub(super) type RuleFilter<'a> = &'a dyn Fn(&RuleId) -> bool;

/// Searches for values that satisfy all rules that `counts` selects; numbers in `fixed` stay. Expands at most `most`
/// states. Adds each broken rule that it encounters to `met`.
pub(super) fn search(
    space: &mut Space,
    begin: &Values,
    fixed: &[usize],
    counts: RuleFilter,
    most: usize,
    met: &mut Vec<RuleId>,
) -> SearchResult {
    let mut seen = BTreeSet::new();
    let mut open = Vec::new();
    let mut looked = 0;
    open.push(state(space, begin.clone(), begin, counts));
    while let Some(next) = best(&open) {
        let state_now = open.swap_remove(next);
        let broken: Vec<RuleId> = broken_rules(&state_now.outcome, counts).cloned().collect();
        for rule in &broken {
            if !met.contains(rule) {
                met.push(rule.clone());
            }
        }
        let Some(rule) = broken.first() else { return SearchResult::Found(state_now.values) };
        // The budget of states is used up: treated as if there were no solution.
        if looked == most {
            return SearchResult::Nothing;
        }
        looked += 1;
        let numbers: Vec<usize> =
            space.free.iter().filter(|number| !fixed.contains(number)).copied().collect();
        // First try to satisfy the rule with one number. Only if none can, move several, each as far as it helps
        // without breaking another rule.
        for moved in [nearest_satisfying, furthest_helpful] {
            let mut is_moved = false;
            for (&number, up) in numbers.iter().flat_map(|number| [(number, false), (number, true)])
            {
                // The budget of evaluations is used up: the remaining states stay unknown.
                if space.evaluations_left == 0 {
                    return SearchResult::Unknown;
                }
                let Some(value) = moved(space, &state_now.values, number, up, rule) else {
                    continue;
                };
                let mut values = state_now.values.clone();
                values.insert(number, value);
                is_moved = true;
                // The same values are also reached by changing the numbers in another order.
                if seen.insert(rounded(&values)) {
                    open.push(state(space, values, begin, counts));
                }
            }
            // A single number can satisfy the rule: moving several is the last resort.
            if is_moved {
                break;
            }
        }
    }
    SearchResult::Nothing
}

/// Returns the furthest value of a number up to which a limit comes closer to being satisfied and no other rule breaks.
fn furthest_helpful(
    space: &mut Space,
    values: &Values,
    number: usize,
    up: bool,
    rule: &RuleId,
) -> Option<f64> {
    /// Smallest reduction of the violation that counts as help, as a fraction of it.
    const LEAST: f64 = 0.05;
    let before = space.outcome(values);
    let RuleState::Broken(Some(missing)) = before.rule_state(rule) else { return None };
    let helps = |outcome: &RuleOutcome| {
        let RuleState::Broken(Some(now)) = outcome.rule_state(rule) else { return false };
        let is_old = |rule: &RuleId| before.broken.iter().any(|broken| broken.rule == *rule);
        now < missing && outcome.broken.iter().all(|broken| is_old(&broken.rule))
    };
    let value = space.furthest(values, number, up, &helps)?;
    match space.outcome_with(values, number, value).rule_state(rule) {
        RuleState::Broken(Some(now)) if now <= (1.0 - LEAST) * missing => Some(value),
        _ => None,
    }
}

/// Returns the nearest value of a number that satisfies a rule.
fn nearest_satisfying(
    space: &mut Space,
    values: &Values,
    number: usize,
    up: bool,
    rule: &RuleId,
) -> Option<f64> {
    let before = space.outcome(values).rule_state(rule);
    let hopeless = |probes: &[Rc<RuleOutcome>]| match before {
        // The violation of a limit is a number: if none of the probes reduces it, this direction is given up. The
        // margin 1e-9 ignores rounding.
        RuleState::Broken(Some(missing)) => {
            probes.iter().all(|probe| match probe.rule_state(rule) {
                RuleState::Broken(Some(now)) => now >= missing - 1e-9,
                RuleState::Broken(None) | RuleState::Unknown => true,
                RuleState::Satisfied => false,
            })
        }
        _ => false,
    };
    let kept = |outcome: &RuleOutcome| outcome.rule_state(rule) == RuleState::Satisfied;
    space.nearest(values, number, up, &kept, &hopeless)
}

/// Returns the broken rules that count.
fn broken_rules<'a>(
    outcome: &'a RuleOutcome,
    counts: RuleFilter<'a>,
) -> impl Iterator<Item = &'a RuleId> {
    outcome.broken.iter().map(|broken| &broken.rule).filter(move |rule| counts(rule))
}

/// Evaluates values and rates them.
fn state(space: &mut Space, values: Values, begin: &Values, counts: RuleFilter) -> State {
    let outcome = space.outcome(&values);
    let changes = values.iter().filter(|(number, _)| !begin.contains_key(number)).count();
    // Broken rules count like changes, as an estimate of the changes still needed.
    let weight = changes + broken_rules(&outcome, counts).count();
    let moved = values.iter().map(|(number, value)| {
        let from = space.numbers[*number].value.unwrap_or(*value);
        let by = (value - from).abs() / space.scale(*number);
        // Counts are chosen for a reason, so changing one costs 0.2 more.
        if space.numbers[*number].kind == ValueKind::Count { by + 0.2 } else { by }
    });
    let moved = moved.sum();
    State { values, outcome, weight, moved }
}

/// Returns the index of the best state; the first one of several.
fn best(open: &[State]) -> Option<usize> {
    let key = |i: usize| (open[i].weight, open[i].moved);
    (0..open.len()).reduce(|best, i| {
        let (a, b) = (key(best), key(i));
        let is_better = b.0 < a.0 || (b.0 == a.0 && b.1 < a.1);
        if is_better { i } else { best }
    })
}

/// Rounds values to a millionth: states that differ by less are the same.
fn rounded(values: &Values) -> Vec<(usize, i64)> {
    values.iter().map(|(number, value)| (*number, (value * 1e6).round() as i64)).collect()
}
