//! The search for values with which all rules are kept.
//!
//! Best first: of the states that were reached, that with the fewest changes and rules left is looked at
//! next. From there each number that may be changed is moved, up and down, as little as it takes to keep
//! the first rule that is broken. Whatever follows from it by expressions follows on its own.

use std::collections::BTreeSet;
use std::rc::Rc;

use fabkit_text::{Kind, Rule};

use super::space::{Fares, Outcome, Space, Values};

/// What a search came to.
pub(super) enum Search {
    /// Values with which the rules are kept.
    Found(Values),
    /// There are none, as far as could be seen.
    Nothing,
    /// The search was too long: nothing is known.
    Unknown,
}

struct State {
    values: Values,
    outcome: Rc<Outcome>,
    /// Changes, and rules left.
    weight: usize,
    /// How far values were moved, each in its own size.
    moved: f64,
}

/// Which rules count.
pub(super) type Counts<'a> = &'a dyn Fn(&Rule) -> bool;

/// Looks for values with which all rules that count are kept; `fixed` is not changed. At most `most` states
/// are looked at. The rules that came up are added to `met`.
pub(super) fn search(
    space: &mut Space,
    begin: &Values,
    fixed: &[usize],
    counts: Counts,
    most: usize,
    met: &mut Vec<Rule>,
) -> Search {
    let mut seen = BTreeSet::new();
    let mut open = Vec::new();
    let mut looked = 0;
    open.push(state(space, begin.clone(), begin, counts));
    while let Some(next) = best(&open) {
        let state_now = open.swap_remove(next);
        let broken: Vec<Rule> = left(&state_now.outcome, counts).cloned().collect();
        for rule in &broken {
            if !met.contains(rule) {
                met.push(rule.clone());
            }
        }
        let Some(rule) = broken.first() else { return Search::Found(state_now.values) };
        if looked == most {
            return Search::Nothing;
        }
        looked += 1;
        let numbers: Vec<usize> =
            space.free.iter().filter(|number| !fixed.contains(number)).copied().collect();
        // One alone; else several, each as far as it helps and breaks nothing.
        for moved in [keep, help] {
            let mut is_moved = false;
            for (&number, up) in numbers.iter().flat_map(|number| [(number, false), (number, true)])
            {
                if space.left == 0 {
                    return Search::Unknown;
                }
                let Some(value) = moved(space, &state_now.values, number, up, rule) else {
                    continue;
                };
                let mut values = state_now.values.clone();
                values.insert(number, value);
                is_moved = true;
                if seen.insert(rounded(&values)) {
                    open.push(state(space, values, begin, counts));
                }
            }
            if is_moved {
                break;
            }
        }
    }
    Search::Nothing
}

/// The furthest value of a number with which a limit is nearer to being kept, and no other is broken.
fn help(space: &mut Space, values: &Values, number: usize, up: bool, rule: &Rule) -> Option<f64> {
    /// What is less than this share of what is missing is no help.
    const LEAST: f64 = 0.05;
    let before = space.outcome(values);
    let Fares::Broken(Some(missing)) = before.fares(rule) else { return None };
    let helps = |outcome: &Outcome| {
        let Fares::Broken(Some(now)) = outcome.fares(rule) else { return false };
        let is_old = |rule: &Rule| before.broken.iter().any(|broken| broken.rule == *rule);
        now < missing && outcome.broken.iter().all(|broken| is_old(&broken.rule))
    };
    let value = space.furthest(values, number, up, &helps)?;
    match space.with(values, number, value).fares(rule) {
        Fares::Broken(Some(now)) if now <= (1.0 - LEAST) * missing => Some(value),
        _ => None,
    }
}

/// The nearest value of a number that keeps a rule.
fn keep(space: &mut Space, values: &Values, number: usize, up: bool, rule: &Rule) -> Option<f64> {
    let before = space.outcome(values).fares(rule);
    let hopeless = |probes: &[Rc<Outcome>]| match before {
        // Of a limit it is known how far it is: what brings it no nearer is left alone.
        Fares::Broken(Some(missing)) => probes.iter().all(|probe| match probe.fares(rule) {
            Fares::Broken(Some(now)) => now >= missing - 1e-9,
            Fares::Broken(None) | Fares::Unknown => true,
            Fares::Kept => false,
        }),
        _ => false,
    };
    let kept = |outcome: &Outcome| outcome.fares(rule) == Fares::Kept;
    space.nearest(values, number, up, &kept, &hopeless)
}

fn left<'a>(outcome: &'a Outcome, counts: Counts<'a>) -> impl Iterator<Item = &'a Rule> {
    outcome.broken.iter().map(|broken| &broken.rule).filter(move |rule| counts(rule))
}

fn state(space: &mut Space, values: Values, begin: &Values, counts: Counts) -> State {
    let outcome = space.outcome(&values);
    let changes = values.iter().filter(|(number, _)| !begin.contains_key(number)).count();
    let weight = changes + left(&outcome, counts).count();
    let moved = values.iter().map(|(number, value)| {
        let from = space.numbers[*number].value.unwrap_or(*value);
        let by = (value - from).abs() / space.scale(*number);
        // Whoever counts has a reason.
        if space.numbers[*number].kind == Kind::Count { by + 0.2 } else { by }
    });
    let moved = moved.sum();
    State { values, outcome, weight, moved }
}

/// The first of the best.
fn best(open: &[State]) -> Option<usize> {
    let key = |i: usize| (open[i].weight, open[i].moved);
    (0..open.len()).reduce(|best, i| {
        let (a, b) = (key(best), key(i));
        let is_better = b.0 < a.0 || (b.0 == a.0 && b.1 < a.1);
        if is_better { i } else { best }
    })
}

/// To a millionth: what differs by less is the same state.
fn rounded(values: &Values) -> Vec<(usize, i64)> {
    values.iter().map(|(number, value)| (*number, (value * 1e6).round() as i64)).collect()
}
