//! Search space of a design's values: its numbers, and the rules broken at a point.

use std::collections::BTreeMap;
use std::rc::Rc;

use fabkit_text::{BrokenRule, NumericParameter, RuleId, SourceKind, ValueKind};

use super::bought::is_bought;
use crate::registry::Trial;

/// Values in place of those in the files, by the index of their number.
pub(super) type Values = BTreeMap<usize, f64>;

/// Result of evaluating the rules at some values.
#[derive(Debug)]
pub(super) struct RuleOutcome {
    /// Broken rules, in the order in which they were checked.
    pub broken: Vec<BrokenRule>,
    /// True if every rule could be checked.
    is_complete: bool,
    /// Every number, including results of expressions.
    pub at: Vec<Option<f64>>,
}

/// State of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RuleState {
    /// Satisfied.
    Satisfied,
    /// Broken, with the size of the violation where it is known.
    Broken(Option<f64>),
    /// Not checked, because something else is too wrong.
    Unknown,
}

impl RuleOutcome {
    /// Returns whether no rule is broken.
    pub fn is_clean(&self) -> bool {
        self.broken.is_empty()
    }

    /// Returns the state of a rule.
    pub fn rule_state(&self, rule: &RuleId) -> RuleState {
        match self.broken.iter().find(|broken| broken.rule == *rule) {
            Some(broken) => RuleState::Broken(broken.excess),
            None if self.is_complete || rule.is_range() => RuleState::Satisfied,
            None => RuleState::Unknown,
        }
    }
}

/// Numbers of a design, with a cache of the outcomes evaluated so far.
pub(super) struct Space {
    trial: Trial,
    /// All numbers.
    pub numbers: Vec<NumericParameter>,
    /// Indices of the numbers that may change: chosen by fabkit, and not of bought things.
    pub free: Vec<usize>,
    known: BTreeMap<Vec<(usize, u64)>, Rc<RuleOutcome>>,
    /// Each rule as it was when it was first broken.
    first: BTreeMap<RuleId, BrokenRule>,
    /// Number of evaluations left. Counting bounds the time in the same way on every machine.
    pub evaluations_left: usize,
}

impl Space {
    /// Creates the space of a design, with a budget of `most` evaluations.
    pub fn new(trial: Trial, most: usize) -> Self {
        let numbers = trial.numbers();
        // A user who sets one size of a camera means another camera, whose other sizes nobody knows: they may change.
        let section = |path: &str| path.split('.').next().map(str::to_owned);
        let exchanged: Vec<Option<String>> = numbers
            .iter()
            .filter(|n| n.source == SourceKind::User && is_bought(&n.path))
            .map(|number| section(&number.path))
            .collect();
        let may_change = |number: &NumericParameter| {
            let is_given = is_bought(&number.path) && !exchanged.contains(&section(&number.path));
            number.source == SourceKind::Chosen && !is_given
        };
        let free = (0..numbers.len()).filter(|i| may_change(&numbers[*i])).collect();
        Self {
            trial,
            numbers,
            free,
            known: BTreeMap::new(),
            first: BTreeMap::new(),
            evaluations_left: most,
        }
    }

    /// Evaluates the rules at these values, or returns the cached outcome. Callers that loop check [`Space::left`].
    pub fn outcome(&mut self, values: &Values) -> Rc<RuleOutcome> {
        // Bit patterns, because floats have no total order as keys of a map.
        let key: Vec<(usize, u64)> = values.iter().map(|(i, v)| (*i, v.to_bits())).collect();
        if let Some(known) = self.known.get(&key) {
            return Rc::clone(known);
        }
        self.evaluations_left = self.evaluations_left.saturating_sub(1);
        let (report, at) = self.trial.evaluate(&self.texts(values), &self.numbers);
        let broken = report.broken_rules();
        for rule in &broken {
            self.first.entry(rule.rule.clone()).or_insert_with(|| rule.clone());
        }
        let outcome = Rc::new(RuleOutcome { broken, is_complete: report.is_read(), at });
        self.known.insert(key, Rc::clone(&outcome));
        outcome
    }

    /// Returns a rule as it was when it was first broken.
    pub fn first_broken(&self, rule: &RuleId) -> Option<&BrokenRule> {
        self.first.get(rule)
    }

    /// Formats values as overrides: path and text.
    pub fn texts(&self, values: &Values) -> BTreeMap<String, String> {
        let text = |(i, value): (&usize, &f64)| {
            let number = &self.numbers[*i];
            (number.path.clone(), number.format_value(*value))
        };
        values.iter().map(text).collect()
    }

    /// Returns the scale that changes of a number are measured in: its magnitude, with a lower bound for small values.
    pub fn scale(&self, number: usize) -> f64 {
        let NumericParameter { kind, value, .. } = &self.numbers[number];
        let least = match kind {
            ValueKind::Length => 1.0,
            ValueKind::Angle => 10.0,
            ValueKind::Count => 1.0,
            _ => 0.1,
        };
        value.unwrap_or_default().abs().max(least)
    }

    /// Returns the index of a parameter.
    pub fn index(&self, path: &str) -> Option<usize> {
        self.numbers.iter().position(|number| number.path == path)
    }

    /// Finds the nearest value of a number for which `is_good` holds, going in one direction from its value at
    /// `values`; `None` if there is none. `is_hopeless` may end the search early: it receives the outcomes at a near, a
    /// middle and a far value.
    pub fn nearest(
        &mut self,
        values: &Values,
        number: usize,
        up: bool,
        is_good: &dyn Fn(&RuleOutcome) -> bool,
        is_hopeless: &dyn Fn(&[Rc<RuleOutcome>]) -> bool,
    ) -> Option<f64> {
        let (begin, ladder) = self.ladder(values, number, up)?;
        let (near, far) = (*ladder.first()?, *ladder.last()?);
        let middle = ladder[ladder.len() / 2];
        // Three probes first: they end the search early for a number that has no influence.
        let probes = [near, middle, far].map(|value| self.outcome_with(values, number, value));
        if !probes.iter().any(|outcome| is_good(outcome)) && is_hopeless(&probes) {
            return None;
        }
        let mut before = begin;
        for value in ladder {
            if is_good(&self.outcome_with(values, number, value)) {
                return Some(self.bisect(values, number, (before, value), is_good));
            }
            before = value;
        }
        None
    }

    /// Finds the furthest value of a number up to which `is_good` holds, going in one direction from its value at
    /// `values`.
    pub fn furthest(
        &mut self,
        values: &Values,
        number: usize,
        up: bool,
        is_good: &dyn Fn(&RuleOutcome) -> bool,
    ) -> Option<f64> {
        let (_, ladder) = self.ladder(values, number, up)?;
        let mut last = None;
        for value in ladder {
            if !is_good(&self.outcome_with(values, number, value)) {
                return last.map(|good| self.bisect(values, number, (value, good), is_good));
            }
            last = Some(value);
        }
        last
    }

    /// Evaluates the rules with one more number changed.
    pub fn outcome_with(&mut self, values: &Values, number: usize, value: f64) -> Rc<RuleOutcome> {
        let mut values = values.clone();
        values.insert(number, value);
        self.outcome(&values)
    }

    /// Bisects between a bad and a good value. Returns the good value nearest to the bad one.
    fn bisect(
        &mut self,
        values: &Values,
        number: usize,
        (mut bad, mut good): (f64, f64),
        is_good: &dyn Fn(&RuleOutcome) -> bool,
    ) -> f64 {
        let is_count = self.numbers[number].kind == ValueKind::Count;
        for _ in 0..HALVINGS {
            let half = 0.5 * (bad + good);
            let half = if is_count { half.round() } else { half };
            if half == bad || half == good {
                break;
            }
            if is_good(&self.outcome_with(values, number, half)) { good = half } else { bad = half }
        }
        good
    }

    /// Returns a number's present value and the values to try from there in one direction, up to the end of the allowed
    /// range or the last of the steps.
    fn ladder(&mut self, values: &Values, number: usize, up: bool) -> Option<(f64, Vec<f64>)> {
        // Falls back to the file's value where expressions cannot be evaluated.
        let begin = self.outcome(values).at[number].or(self.numbers[number].value)?;
        let [low, high] = self.numbers[number].range;
        let scale = self.scale(number);
        let steps: Vec<f64> = match self.numbers[number].kind {
            ValueKind::Count => COUNT_STEPS.to_vec(),
            _ => STEPS.map(|step| step * scale).to_vec(),
        };
        let end = if up { high } else { low };
        // A value outside of its range first enters it at the nearest end.
        let entry = begin.max(low).min(high);
        if entry != begin && (entry > begin) != up {
            return None;
        }
        let mut ladder = vec![entry];
        for step in steps {
            let value = if up { entry + step } else { entry - step };
            let is_beyond = if up { value >= end } else { value <= end };
            ladder.push(if is_beyond { end } else { value });
            if is_beyond {
                break;
            }
        }
        // The present value is no change.
        ladder.retain(|value| *value != begin);
        (!ladder.is_empty()).then_some((begin, ladder))
    }
}

/// Step sizes when a number is moved, relative to [`Space::scale`].
const STEPS: [f64; 8] = [0.02, 0.05, 0.1, 0.2, 0.35, 0.6, 1.0, 2.0];
/// Step sizes when a count is moved.
const COUNT_STEPS: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0];
/// Number of bisection steps between two values of the ladder.
const HALVINGS: usize = 9;
