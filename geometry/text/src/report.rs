//! Rules that relate several values of a design.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::panic::Location;
use std::sync::Arc;

use crate::limited_quantity::LimitedQuantity;
use crate::parameter_table::find_changed_inputs;
use crate::place::{LocatedProblem, TextPlace, WrittenText, WrittenValue, WrittenValues};
use crate::suggest::join_words;
use crate::{
    InvalidDesign, Parameter, ProblemFacts, SourceKind, TextLayer, UNKNOWN_PARAMETER, to_printable,
};

/// Tolerance when values are compared with limits, for rounding in the computation of a limit.
const TOLERANCE: f64 = 1e-9;

/// Relative changes of parameters that find out what a limit depends on: first a small one, yet far above rounding;
/// then larger ones, for limits that are saturated by something else.
const RELATIVE_CHANGES: [f64; 3] = [1e-5, 0.25, 1.0];

/// States limits, one expression each: the parameter, the limit in its unit, and the reason.
///
/// The parameter's path is its place in the struct, so that message and value always belong to the same parameter.
/// Without a struct, name the variable like the section.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{RuleReport, limits, parameters};
///
/// parameters! {
///     /// A box.
///     pub struct Crate {
///         /// Wall.
///         wall: Length = 0.1..=9.0,
///         /// Width.
///         width: Length = 1.0..=90.0,
///     }
/// }
/// fn check(p: &Crate, report: &mut RuleReport) {
///     limits! { report, p:
///         wall <= p.width.mm() / 2.0, "two walls stand side by side";
///         wall >= 0.4, "a nozzle draws no thinner line";
///     }
/// }
/// # let _ = check;
/// ```
///
/// For a struct that is only part of the file, `report, p, at =>` takes a function from the path in the struct to the
/// path in the file.
#[macro_export]
macro_rules! limits {
    (@one $report:ident, $path:expr, $value:expr, <= $limit:expr, $because:expr) => {
        $report.at_most($path, $value, $limit, $because);
    };
    (@one $report:ident, $path:expr, $value:expr, >= $limit:expr, $because:expr) => {
        $report.at_least($path, $value, $limit, $because);
    };
    ($report:ident, $p:ident, $at:expr => $($first:ident $(.$rest:ident)*
        $(<= $most:expr,)? $(>= $least:expr,)? $because:expr;)+) => {$(
        $crate::limits!(
            @one $report, &$at(concat!(stringify!($first) $(, ".", stringify!($rest))*)),
            $p.$first $(.$rest)*, $(<= $most,)? $(>= $least,)? $because
        );
    )+};
    ($report:ident, $p:ident: $($first:ident $(.$rest:ident)*
        $(<= $most:expr,)? $(>= $least:expr,)? $because:expr;)+) => {$(
        $crate::limits!(
            @one $report, concat!(stringify!($first) $(, ".", stringify!($rest))*),
            $p.$first $(.$rest)*, $(<= $most,)? $(>= $least,)? $because
        );
    )+};
    ($report:ident: $($first:ident $(.$rest:ident)*
        $(<= $most:expr,)? $(>= $least:expr,)? $because:expr;)+) => {$(
        $crate::limits!(
            @one $report, concat!(stringify!($first) $(, ".", stringify!($rest))*),
            $first $(.$rest)*, $(<= $most,)? $(>= $least,)? $because
        );
    )+};
}

/// Most parameters that a message and its hint name.
const MOST_NAMED: usize = 3;

/// Characters of a message, beyond which it names no further parameter.
const MESSAGE_LENGTH: usize = 180;

/// Collector of violated rules, each at the place where the value was written.
#[derive(Clone, Debug)]
pub struct RuleReport {
    written: Arc<WrittenValues>,
    found: Vec<LocatedProblem>,
    limits: BTreeMap<LimitId, f64>,
    /// Problems that come from [`RuleReport::require`] instead of a limit: index of the problem and location of the rule in
    /// the code.
    required: Vec<(usize, &'static Location<'static>)>,
    /// Limit that was stated last.
    last: Option<LimitId>,
    broken: Vec<BrokenLimit>,
}

/// Identity of a stated limit: location in the code, path, and count of earlier ones with the same two.
type LimitId = (&'static Location<'static>, String, usize);

/// Identity of a limit, of a rule, or of the range of one value.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RuleId {
    path: String,
    /// File, line and column of the statement in the code; `None` for the range of one value.
    location: Option<(&'static str, u32, u32)>,
    /// Number among the rules stated at one location for one path.
    nth: usize,
}

impl RuleId {
    /// Returns whether it limits a single value, so that it holds whatever else is wrong.
    pub fn is_range(&self) -> bool {
        self.location.is_none()
    }
}

/// Violated rule, for searches that try other values.
#[derive(Clone, Debug)]
pub struct BrokenRule {
    /// Identity of the rule.
    pub rule: RuleId,
    /// Path of the limited parameter.
    pub path: String,
    /// Distance to the limit, in the parameter's unit; `None` for rules that only hold or do not.
    pub excess: Option<f64>,
    /// Limit in words, such as `at most 3 mm`, if it can be met.
    pub limit: Option<String>,
    /// Reason of the limit, if it depends on other values.
    pub because: Option<String>,
    /// Paths that the limit depends on, as far as they have been found.
    pub inputs: Vec<String>,
    /// Whole message.
    pub message: String,
    /// Index of the problem, in the order of discovery.
    pub problem: usize,
}

/// Violated limit.
#[derive(Clone, Debug)]
struct BrokenLimit {
    constraint: LimitId,
    value: String,
    /// Distance of the value beyond the limit.
    excess: f64,
    /// Limit in words, such as `at most 3 mm`, if it can be met.
    limit: Option<String>,
    because: String,
    /// Index of its problem.
    found: usize,
    /// Paths that the limit depends on, if stated or found.
    inputs: Vec<String>,
}

impl RuleReport {
    /// Creates a report from the values and the problems found while reading.
    pub(crate) fn new(written: WrittenValues, found: Vec<LocatedProblem>) -> Self {
        Self::with_shared(Arc::new(written), found)
    }

    /// Creates a report from values that other reports have, too.
    fn with_shared(written: Arc<WrittenValues>, found: Vec<LocatedProblem>) -> Self {
        Self {
            written,
            found,
            limits: BTreeMap::new(),
            required: Vec::new(),
            last: None,
            broken: Vec::new(),
        }
    }

    /// Returns whether there are no problems so far.
    pub fn is_clean(&self) -> bool {
        self.found.is_empty()
    }

    /// Whether a name was not known. A default then stands in for what its author meant, so that limits between values
    /// would be computed from something that nobody wrote.
    pub fn has_unknown_names(&self) -> bool {
        self.problem_codes().any(|code| code == UNKNOWN_PARAMETER)
    }

    /// Returns the code of each problem, also of those that a list of problems has no room for.
    pub fn problem_codes(&self) -> impl Iterator<Item = &'static str> {
        self.found.iter().map(|found| found.problem.facts.code)
    }

    /// Returns whether all values could be read, so that the rules have been checked.
    pub fn is_read(&self) -> bool {
        !self.limits.is_empty() || !self.required.is_empty() || self.found.is_empty()
    }

    /// Lists the violated rules, in the order of checking.
    pub fn broken_rules(&self) -> Vec<BrokenRule> {
        let mut rules: Vec<BrokenRule> = Vec::new();
        // Counted in a map: texts may have thousands of problems, and searches ask thousands of times.
        let mut stated: BTreeMap<RuleId, usize> = BTreeMap::new();
        for (problem, LocatedProblem { problem: said, .. }) in self.found.iter().enumerate() {
            let path = said.path.clone();
            let limit = self.limit_of_problem(problem);
            let location = match limit {
                Some(broken) => Some(broken.constraint.0),
                // Not a limit: a rule of `require`, or a range error that the reader found.
                None => self.rule_location(problem),
            };
            let location = location.map(|at| (at.file(), at.line(), at.column()));
            let mut rule = RuleId { path: path.clone(), location, nth: 0 };
            let earlier = stated.entry(rule.clone()).or_default();
            rule.nth = limit.map_or(*earlier, |broken| broken.constraint.2);
            *earlier += 1;
            rules.push(BrokenRule {
                rule,
                path,
                excess: limit.map(|broken| broken.excess),
                limit: limit.and_then(|broken| broken.limit.clone()),
                because: limit.map(|broken| broken.because.clone()),
                inputs: limit.map(|broken| broken.inputs.clone()).unwrap_or_default(),
                message: said.message.clone(),
                problem,
            });
        }
        rules
    }

    /// Returns the violated limit that a problem reports. Both lists are in the order of discovery.
    fn limit_of_problem(&self, problem: usize) -> Option<&BrokenLimit> {
        let i = self.broken.binary_search_by_key(&problem, |limit| limit.found).ok()?;
        Some(&self.broken[i])
    }

    /// Returns where the rule stands that a problem reports; `None` if the reader found it.
    fn rule_location(&self, problem: usize) -> Option<&'static Location<'static>> {
        let i = self.required.binary_search_by_key(&problem, |(found, _)| *found).ok()?;
        Some(self.required[i].1)
    }

    /// Replaces the hints of some problems, each given by its index ([`BrokenRule::problem`]).
    pub fn set_hints(&mut self, hints: impl IntoIterator<Item = (usize, String)>) {
        for (problem, hint) in hints {
            if let Some(found) = self.found.get_mut(problem) {
                found.problem.hint = Some(hint);
            }
        }
    }

    /// Returns all problems, those of the file in its order, then those of the overrides.
    pub fn into_invalid(self) -> InvalidDesign {
        InvalidDesign::new(LocatedProblem::sort(self.found))
    }

    /// Reports a problem at `path` unless `holds`.
    ///
    /// The message is a whole sentence that names the value and its limit; the hint says what would work. Items of
    /// lists are addressed as `dimples.polar[3]`, the fourth item.
    ///
    /// # Panics
    /// If `path` is not a parameter, whether or not the rule holds: a mistake in the family's code, which shows with
    /// the first sensor that is loaded.
    #[track_caller]
    pub fn require(
        &mut self,
        holds: bool,
        path: &str,
        message: impl FnOnce() -> String,
        hint: impl FnOnce() -> String,
    ) {
        // Looked up even if the rule holds, so that a wrong path panics in any case.
        let (place, text) = self.find_item(path);
        if !holds {
            let found = place.problem(path, &text.to_printable(), message());
            self.required.push((self.found.len(), Location::caller()));
            self.found.push(found.hint(hint()).code("rule_broken"));
        }
    }

    /// Requires `value`, written at `path`, to be at most `limit`, in the unit of the value.
    ///
    /// `because` completes the sentence "it must be at most 3 mm, because ...". [`RuleReport::find_limit_inputs`] finds the parameters
    /// that the limit depends on. Several limits are stated with [`limits!`](crate::limits!).
    ///
    /// # Panics
    /// As [`RuleReport::require`].
    #[track_caller]
    pub fn at_most<Q: LimitedQuantity>(
        &mut self,
        path: &str,
        value: Q,
        limit: f64,
        because: impl Display,
    ) {
        let holds = value.value() <= limit + TOLERANCE;
        // Rounded down, so that the recommended value satisfies the limit.
        let works = ((limit + TOLERANCE) * Q::STEPS_PER_UNIT).floor() / Q::STEPS_PER_UNIT;
        // A limit of 0 or less cannot be recommended: other values have left no room.
        let offer = || (works > 0.0).then(|| format!("at most {}", format_with_unit::<Q>(works)));
        let missing = value.value() - limit;
        self.check_limit((holds, missing), path, value, limit, offer, because);
    }

    /// Requires `value` to be at most `limit`, where 0 means that the part is absent. With no room at all, 0 is
    /// recommended.
    ///
    /// # Panics
    /// As [`RuleReport::require`].
    #[track_caller]
    pub fn at_most_or_absent<Q: LimitedQuantity>(
        &mut self,
        path: &str,
        value: Q,
        limit: f64,
        because: impl Display,
    ) {
        let limit = limit.max(0.0);
        let holds = value.value() <= limit + TOLERANCE;
        let works = ((limit + TOLERANCE) * Q::STEPS_PER_UNIT).floor() / Q::STEPS_PER_UNIT;
        let offer = || Some(format!("at most {}", format_with_unit::<Q>(works)));
        let missing = value.value() - limit;
        self.check_limit((holds, missing), path, value, limit, offer, because);
    }

    /// Requires `value`, written at `path`, to be at least `limit`; otherwise like [`RuleReport::at_most`].
    ///
    /// # Panics
    /// As [`RuleReport::require`].
    #[track_caller]
    pub fn at_least<Q: LimitedQuantity>(
        &mut self,
        path: &str,
        value: Q,
        limit: f64,
        because: impl Display,
    ) {
        let holds = value.value() >= limit - TOLERANCE;
        // Rounded up, so that the recommended value satisfies the limit.
        let works = ((limit - TOLERANCE) * Q::STEPS_PER_UNIT).ceil() / Q::STEPS_PER_UNIT;
        let offer = || Some(format!("at least {}", format_with_unit::<Q>(works)));
        let missing = limit - value.value();
        self.check_limit((holds, missing), path, value, limit, offer, because);
    }

    /// Checks a limit and records it, whether or not it holds. `missing` is the distance beyond the limit.
    #[track_caller]
    fn check_limit(
        &mut self,
        (holds, missing): (bool, f64),
        path: &str,
        value: impl Display,
        limit: f64,
        offer: impl FnOnce() -> Option<String>,
        because: impl Display,
    ) {
        let mut constraint = (Location::caller(), path.to_owned(), 0);
        // A rule may be stated in a loop: the same location and path then count up.
        while self.limits.contains_key(&constraint) {
            constraint.2 += 1;
        }
        self.limits.insert(constraint.clone(), limit);
        self.last = Some(constraint.clone());
        let found = self.found.len();
        // Message and hint are written below, and again when the inputs are known.
        self.require(holds, path, String::new, String::new);
        if !holds {
            let because = because.to_string();
            let named = Vec::new();
            self.broken.push(BrokenLimit {
                constraint,
                value: value.to_string(),
                excess: missing,
                limit: offer(),
                because,
                found,
                inputs: named,
            });
            self.write_message(self.broken.len() - 1, &[]);
        }
    }

    /// States the paths that the last limit depends on, for limits where [`RuleReport::find_limit_inputs`] would take too long. Does
    /// nothing if that limit holds.
    pub fn set_inputs_of_last_limit(&mut self, paths: &[&str]) {
        let is_last = |broken: &BrokenLimit| self.last.as_ref() == Some(&broken.constraint);
        if let Some(i) = self.broken.iter().position(is_last) {
            let named: Vec<String> = paths.iter().map(|path| (*path).to_owned()).collect();
            self.broken[i].inputs.clone_from(&named);
            self.write_message(i, &named);
        }
    }

    /// Finds what each violated limit depends on, and names it in the message.
    ///
    /// No list of inputs is kept by hand, which could be incomplete. Instead `check` is run once more for each
    /// neighbour of the parameters ([`Parameter::neighbours`]), and a limit depends on every parameter whose change
    /// moves it. Of a minimum of two limits, only inputs of the smaller are found.
    pub fn find_limit_inputs<P: Parameter<Limits = ()>>(
        &mut self,
        path: &str,
        parameters: &P,
        check: impl Fn(&P, &mut Self),
    ) {
        if self.broken.is_empty() {
            return;
        }
        let mut from: Vec<_> = self.broken.iter().map(|broken| broken.inputs.clone()).collect();
        // Larger changes are tried only for limits that smaller ones have not explained.
        for share in RELATIVE_CHANGES {
            let unknown: Vec<usize> = (0..from.len()).filter(|i| from[*i].is_empty()).collect();
            if unknown.is_empty() {
                break;
            }
            parameters.neighbours(path, &(), share, &mut |input, neighbour| {
                let mut report = Self::with_shared(Arc::clone(&self.written), Vec::new());
                check(&neighbour, &mut report);
                self.add_moved_input(&report, input, &unknown, &mut from);
            });
        }
        self.name_inputs(from);
    }

    /// Adds `input` to the dependencies of those limits that have moved in `other`.
    fn add_moved_input(
        &self,
        other: &Self,
        input: &str,
        unknown: &[usize],
        from: &mut [Vec<String>],
    ) {
        for &i in unknown {
            let constraint = &self.broken[i].constraint;
            // A limit cannot depend on its own value, and neighbours of one input follow each other.
            let is_known =
                constraint.1 == input || from[i].last().is_some_and(|last| last == input);
            if !is_known && self.limit_differs(other, constraint) {
                from[i].push(input.to_owned());
            }
        }
    }

    /// Writes the messages of all violated limits with their dependencies.
    fn name_inputs(&mut self, mut from: Vec<Vec<String>>) {
        for (i, from) in from.iter_mut().enumerate() {
            self.add_changed_inputs(i, from);
            // Parameters that the user has written come first: they will look there first.
            from.sort_by_key(|path| self.written(path).source.kind != SourceKind::User);
            self.write_message(i, from);
            self.broken[i].inputs.clone_from(from);
        }
    }

    /// Returns whether `other` has a different limit for the same constraint.
    fn limit_differs(&self, other: &Self, constraint: &LimitId) -> bool {
        let limits = (self.limits.get(constraint), other.limits.get(constraint));
        let (Some(was), Some(is)) = limits else { return false };
        let moved = (was - is).abs();
        // NaN differs from itself, so bits are compared first.
        was.to_bits() != is.to_bits() && (moved > TOLERANCE || moved.is_nan())
    }

    /// Adds values that the user has changed and that reach the limit through expressions.
    fn add_changed_inputs(&self, broken: usize, from: &mut Vec<String>) {
        let own = &self.broken[broken].constraint.1;
        let formulas: Vec<_> = std::iter::once(own)
            .chain(from.iter())
            .filter_map(|path| self.written(path).formula.as_ref())
            .collect();
        let changed: BTreeSet<String> = formulas
            .iter()
            .flat_map(|formula| find_changed_inputs(&self.written, formula))
            .collect();
        for path in changed {
            if path != *own && !from.contains(&path) {
                from.push(path);
            }
        }
    }

    /// Writes message and hint of a violated limit.
    fn write_message(&mut self, broken: usize, from: &[String]) {
        let BrokenLimit { constraint: (_, path, _), value, limit, because, found, .. } =
            &self.broken[broken];
        let must = match limit {
            Some(limit) => format!("it must be {limit}"),
            None => "no value works".into(),
        };
        let sentence = format!("{path} is {value}; {must}, because {because}");
        let message = self.with_inputs(sentence, from);
        let paths: Vec<String> =
            from.iter().take(MOST_NAMED).map(|path| format!("`{path}`")).collect();
        let change = join_words(&paths, "or");
        let hint = match (limit, paths.is_empty()) {
            (Some(limit), true) => format!("write {limit}"),
            (Some(limit), false) => format!("write {limit}, or change {change}"),
            (None, _) => format!("change {change}"),
        };
        let hint = (limit.is_some() || !paths.is_empty()).then_some(hint);
        let facts = ProblemFacts::from_limit(path, limit.as_deref());
        let problem = &mut self.found[*found].problem;
        (problem.message, problem.hint, problem.facts) = (message, hint, facts);
    }

    /// Appends the values that a limit follows from, as many as a line has room for.
    fn with_inputs(&self, sentence: String, from: &[String]) -> String {
        let mut inputs = String::new();
        for path in from.iter().take(MOST_NAMED) {
            let input = self.describe_input(path);
            if !inputs.is_empty() && sentence.len() + inputs.len() + input.len() > MESSAGE_LENGTH {
                break;
            }
            inputs += if inputs.is_empty() { "" } else { ", " };
            inputs += &input;
        }
        if inputs.is_empty() { sentence } else { format!("{sentence} ({inputs})") }
    }

    /// Describes a value and its place: `surface.radius is 15.0 mm in rtac0.yaml:9`.
    fn describe_input(&self, path: &str) -> String {
        let written = self.written(path);
        let value = written.text.to_printable();
        if matches!(written.place.layer, TextLayer::Base | TextLayer::Default) {
            return format!("{path} is {value}");
        }
        let line = written.place.position.map(|p| format!(":{}", p.line)).unwrap_or_default();
        format!("{path} is {value} in {}{line}", written.place.file)
    }

    /// Returns place and text of a value, or of an item of a list.
    fn find_item(&self, path: &str) -> (&TextPlace, ItemText<'_>) {
        let item = path.strip_suffix(']').and_then(|path| path.rsplit_once('['));
        if let Some((list, index)) = item
            && let WrittenText::List(items) = &self.written(list).text
            && let Some((text, place)) = index.parse().ok().and_then(|i: usize| items.get(i))
        {
            return (place, ItemText::Item(text));
        }
        let written = self.written(path);
        (&written.place, ItemText::Whole(&written.text))
    }

    /// Returns the value at a path; panics if there is none.
    fn written(&self, path: &str) -> &WrittenValue {
        let written = self.written.get(path);
        written.unwrap_or_else(|| panic!("`{path}` is not a parameter of this family"))
    }
}

/// Text of a value, or of an item of a list.
enum ItemText<'a> {
    Item(&'a str),
    Whole(&'a WrittenText),
}

impl ItemText<'_> {
    /// Formats the text on one line.
    fn to_printable(&self) -> String {
        match self {
            Self::Item(text) => to_printable(text),
            Self::Whole(text) => text.to_printable(),
        }
    }
}

/// Formats a number with the unit of `Q`.
fn format_with_unit<Q: LimitedQuantity>(number: f64) -> String {
    // Adding 0 turns `-0` into `0`.
    format!("{}{}", number + 0.0, Q::UNIT)
}

#[cfg(test)]
mod tests;
