//! What a family requires of several values together.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::panic::Location;

use fabkit_geometry::{Angle, Length};

use crate::document::changed_above;
use crate::place::{Found, Place, Written, WrittenText};
use crate::suggest::either;
use crate::{Facts, InvalidDesign, Parameter, SourceKind, UNKNOWN_PARAMETER, shown};

/// Values that differ by less are the same: rounding in what a limit is computed from.
const SAME: f64 = 1e-9;

/// How far parameters are moved to see what a limit follows from, as a share: first hardly, which is
/// far above rounding; then far, then twofold, for limits that something has driven to their end.
const SHARES: [f64; 3] = [1e-5, 0.25, 1.0];

/// What limits can be stated for: a number, in the unit that people write it in.
pub trait Quantity: Copy + Display {
    /// Behind the number: ` mm`.
    const UNIT: &'static str;
    /// Values that are recommended are whole multiples of 1 / `STEPS`.
    const STEPS: f64;

    /// The number.
    fn number(self) -> f64;
}

impl Quantity for Length {
    const UNIT: &'static str = " mm";
    const STEPS: f64 = 1e3;

    fn number(self) -> f64 {
        self.mm()
    }
}

impl Quantity for Angle {
    const UNIT: &'static str = " deg";
    const STEPS: f64 = 10.0;

    fn number(self) -> f64 {
        self.deg()
    }
}

impl Quantity for u32 {
    const UNIT: &'static str = "";
    const STEPS: f64 = 1.0;

    fn number(self) -> f64 {
        self.into()
    }
}

impl Quantity for f64 {
    const UNIT: &'static str = "";
    const STEPS: f64 = 1e3;

    fn number(self) -> f64 {
        self
    }
}

/// States limits, one expression each: the parameter, the limit in its unit, and why.
///
/// The parameter's path is its place in the struct, so that message and value cannot be of two
/// parameters. Without a struct, the variable is called as the section is.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{Report, limits, parameters};
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
/// fn check(p: &Crate, report: &mut Report) {
///     limits! { report, p:
///         wall <= p.width.mm() / 2.0, "two walls stand side by side";
///         wall >= 0.4, "a nozzle draws no thinner line";
///     }
/// }
/// # let _ = check;
/// ```
///
/// Of a struct that is not the whole file, `report, p, at =>` takes a function from the path in the
/// struct to that in the file.
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
const MESSAGE_LENGTH: usize = 190;

/// Collects impossible combinations, each at the place where a value was written.
#[derive(Clone, Debug)]
pub struct Report {
    written: BTreeMap<String, Written>,
    found: Vec<Found>,
    limits: BTreeMap<Constraint, f64>,
    /// Of what was found, what is no limit but a rule, and where it is stated.
    required: Vec<(usize, &'static Location<'static>)>,
    /// The limit that was asked for last.
    last: Option<Constraint>,
    broken: Vec<BrokenLimit>,
}

/// A limit that was asked for: where in the code, for which path, and how often before.
type Constraint = (&'static Location<'static>, String, usize);

/// What values have to keep: a limit, a rule, or the range of one value.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rule {
    path: String,
    /// Line and column in the code; nothing for the range of one value.
    stated: Option<(&'static str, u32, u32)>,
    /// Of those that are stated in one place for one path.
    nth: usize,
}

impl Rule {
    /// Whether it limits one value alone, so that it holds whatever else is wrong.
    pub fn is_range(&self) -> bool {
        self.stated.is_none()
    }
}

/// A rule that is not kept, for those who look for other values.
#[derive(Clone, Debug)]
pub struct Broken {
    /// Which.
    pub rule: Rule,
    /// The parameter that is limited.
    pub path: String,
    /// How far it is from being kept, in the unit of the parameter; nothing where a rule is kept or
    /// not.
    pub missing: Option<f64>,
    /// `at most 3 mm`, where the limit is a value.
    pub limit: Option<String>,
    /// Why, where a limit follows from others.
    pub because: Option<String>,
    /// The paths that the limit follows from, as far as that was found out.
    pub from: Vec<String>,
    /// The whole message.
    pub message: String,
    /// Which of the problems it is, in the order in which they were found.
    pub problem: usize,
}

/// A limit that is not kept.
#[derive(Clone, Debug)]
struct BrokenLimit {
    constraint: Constraint,
    value: String,
    /// How far the value is beyond.
    missing: f64,
    /// `at most 3 mm`, where there is such a value.
    limit: Option<String>,
    because: String,
    /// Which of what was found it is.
    found: usize,
    /// What it follows from, where somebody has said so, or it was found out.
    named: Vec<String>,
}

impl Report {
    pub(crate) fn new(written: BTreeMap<String, Written>, found: Vec<Found>) -> Self {
        Self {
            written,
            found,
            limits: BTreeMap::new(),
            required: Vec::new(),
            last: None,
            broken: Vec::new(),
        }
    }

    /// Whether nothing is wrong so far.
    pub fn is_clean(&self) -> bool {
        self.found.is_empty()
    }

    /// Whether a name was not known. A default then stands in for what its author meant, so that limits between values
    /// would be computed from something that nobody wrote.
    pub fn has_unknown_names(&self) -> bool {
        self.found.iter().any(|found| found.problem.facts.code == UNKNOWN_PARAMETER)
    }

    /// Whether all values could be read, so that what they must keep together was looked at.
    pub fn is_read(&self) -> bool {
        !self.limits.is_empty() || !self.required.is_empty() || self.found.is_empty()
    }

    /// The rules that are not kept, in the order in which they were looked at.
    pub fn broken_rules(&self) -> Vec<Broken> {
        let stated = |at: &'static Location<'static>| Some((at.file(), at.line(), at.column()));
        let mut rules: Vec<Broken> = Vec::new();
        for (problem, Found { problem: said, .. }) in self.found.iter().enumerate() {
            let path = said.path.clone();
            let message = said.message.clone();
            let limit = self.broken.iter().find(|limit| limit.found == problem);
            let required = self.required.iter().find(|(found, _)| *found == problem);
            rules.push(match (limit, required) {
                (Some(broken), _) => {
                    let (at, _, nth) = &broken.constraint;
                    let rule = Rule { path: path.clone(), stated: stated(at), nth: *nth };
                    let (limit, from) = (broken.limit.clone(), broken.named.clone());
                    let (missing, because) = (Some(broken.missing), Some(broken.because.clone()));
                    Broken { rule, path, missing, limit, because, from, message, problem }
                }
                (None, at) => {
                    let stated = at.and_then(|(_, at)| stated(at));
                    let same = |b: &&Broken| b.path == path && b.rule.stated == stated;
                    let nth = rules.iter().filter(same).count();
                    let rule = Rule { path: path.clone(), stated, nth };
                    let (missing, limit, because, from) = (None, None, None, Vec::new());
                    Broken { rule, path, missing, limit, because, from, message, problem }
                }
            });
        }
        rules
    }

    /// Writes other hints at some of the problems, each by its number ([`Broken::problem`]).
    pub fn set_hints(&mut self, hints: impl IntoIterator<Item = (usize, String)>) {
        for (problem, hint) in hints {
            if let Some(found) = self.found.get_mut(problem) {
                found.problem.hint = Some(hint);
            }
        }
    }

    /// Everything that is wrong, in the order of the file, then of the overrides.
    pub fn into_invalid(self) -> InvalidDesign {
        InvalidDesign { problems: Found::sorted(self.found) }
    }

    /// Reports a problem at `path` unless `holds`.
    ///
    /// The message is a whole sentence that names the value and its limit, the hint says what
    /// would work. Of a list, `dimples.polar[3]` is the fourth item.
    ///
    /// # Panics
    /// If `path` is not a parameter, whether it holds or not: a slip in the family, which the
    /// first sensor that is loaded brings to light.
    #[track_caller]
    pub fn require(
        &mut self,
        holds: bool,
        path: &str,
        message: impl FnOnce() -> String,
        hint: impl FnOnce() -> String,
    ) {
        let (place, text) = self.item(path);
        if !holds {
            let found = place.problem(path, &text, message());
            self.required.push((self.found.len(), Location::caller()));
            self.found.push(found.hint(hint()).code("rule_broken"));
        }
    }

    /// Requires `value`, written at `path`, to be at most `limit`, in the value's own unit.
    ///
    /// `because` completes the sentence "it must be at most 3 mm, because ...". What the limit
    /// follows from is found by [`Report::trace`]. Several limits are stated with
    /// [`limits!`](crate::limits!).
    ///
    /// # Panics
    /// As [`Report::require`].
    #[track_caller]
    pub fn at_most<Q: Quantity>(
        &mut self,
        path: &str,
        value: Q,
        limit: f64,
        because: impl Display,
    ) {
        let holds = value.number() <= limit + SAME;
        // Rounded down to a value that does work.
        let works = ((limit + SAME) * Q::STEPS).floor() / Q::STEPS;
        // Below zero there is nothing to recommend: others have left no room.
        let offer = (works > 0.0).then(|| format!("at most {}", in_unit::<Q>(works)));
        let missing = value.number() - limit;
        self.limit((holds, missing), path, value.to_string(), limit, offer, because);
    }

    /// The same of what may be absent, which 0 says: that is offered where there is no room at all.
    ///
    /// # Panics
    /// As [`Report::require`].
    #[track_caller]
    pub fn at_most_if_any<Q: Quantity>(
        &mut self,
        path: &str,
        value: Q,
        limit: f64,
        because: impl Display,
    ) {
        let limit = limit.max(0.0);
        let holds = value.number() <= limit + SAME;
        let works = ((limit + SAME) * Q::STEPS).floor() / Q::STEPS;
        let offer = Some(format!("at most {}", in_unit::<Q>(works)));
        let missing = value.number() - limit;
        self.limit((holds, missing), path, value.to_string(), limit, offer, because);
    }

    /// Requires `value`, written at `path`, to be at least `limit`; else as [`Report::at_most`].
    ///
    /// # Panics
    /// As [`Report::require`].
    #[track_caller]
    pub fn at_least<Q: Quantity>(
        &mut self,
        path: &str,
        value: Q,
        limit: f64,
        because: impl Display,
    ) {
        let holds = value.number() >= limit - SAME;
        // Rounded up to a value that does work.
        let works = ((limit - SAME) * Q::STEPS).ceil() / Q::STEPS;
        let offer = Some(format!("at least {}", in_unit::<Q>(works)));
        let missing = limit - value.number();
        self.limit((holds, missing), path, value.to_string(), limit, offer, because);
    }

    #[track_caller]
    fn limit(
        &mut self,
        (holds, missing): (bool, f64),
        path: &str,
        value: String,
        limit: f64,
        offer: Option<String>,
        because: impl Display,
    ) {
        let mut constraint = (Location::caller(), path.to_owned(), 0);
        while self.limits.contains_key(&constraint) {
            constraint.2 += 1;
        }
        self.limits.insert(constraint.clone(), limit);
        self.last = Some(constraint.clone());
        let found = self.found.len();
        self.require(holds, path, String::new, String::new);
        if !holds {
            let because = because.to_string();
            let named = Vec::new();
            self.broken.push(BrokenLimit {
                constraint,
                value,
                missing,
                limit: offer,
                because,
                found,
                named,
            });
            self.say(self.broken.len() - 1, &[]);
        }
    }

    /// Names what a limit follows from that was just asked for and is not kept: where
    /// [`Report::trace`] would take too long to find it out. Nothing where it is kept.
    pub fn follows_from(&mut self, paths: &[&str]) {
        let is_last = |broken: &BrokenLimit| self.last.as_ref() == Some(&broken.constraint);
        if let Some(i) = self.broken.iter().position(is_last) {
            let named: Vec<String> = paths.iter().map(|path| (*path).to_owned()).collect();
            self.broken[i].named.clone_from(&named);
            self.say(i, &named);
        }
    }

    /// Names, in the message of every limit that is not kept, what that limit follows from.
    ///
    /// No list of inputs is kept by hand, which could be incomplete: `check` is asked once more for
    /// each neighbour of the parameters ([`Parameter::neighbours`]), and a limit follows from what
    /// moves it. Of two limits of which the smaller counts, only what moves the smaller is named.
    pub fn trace<P: Parameter<Limits = ()>>(
        &mut self,
        path: &str,
        parameters: &P,
        check: impl Fn(&P, &mut Self),
    ) {
        if self.broken.is_empty() {
            return;
        }
        let mut from: Vec<_> = self.broken.iter().map(|broken| broken.named.clone()).collect();
        for share in SHARES {
            let unknown: Vec<usize> = (0..from.len()).filter(|i| from[*i].is_empty()).collect();
            if unknown.is_empty() {
                break;
            }
            parameters.neighbours(path, &(), share, &mut |input, neighbour| {
                let mut report = Self::new(self.written.clone(), Vec::new());
                check(&neighbour, &mut report);
                self.add_moved(&report, input, &unknown, &mut from);
            });
        }
        self.name_inputs(from);
    }

    /// Adds an input to what those limits follow from that another value of it has moved.
    fn add_moved(&self, other: &Self, input: &str, unknown: &[usize], from: &mut [Vec<String>]) {
        for &i in unknown {
            let constraint = &self.broken[i].constraint;
            let is_known =
                constraint.1 == input || from[i].last().is_some_and(|last| last == input);
            if !is_known && self.is_moved(other, constraint) {
                from[i].push(input.to_owned());
            }
        }
    }

    /// Says of each limit that is not kept what it follows from.
    fn name_inputs(&mut self, mut from: Vec<Vec<String>>) {
        for (i, from) in from.iter_mut().enumerate() {
            self.add_changed(i, from);
            // What the user has just written is what they will look at first.
            from.sort_by_key(|path| self.written(path).source.kind != SourceKind::User);
            self.say(i, from);
            self.broken[i].named.clone_from(from);
        }
    }

    /// Whether another report has another limit for the same constraint.
    fn is_moved(&self, other: &Self, constraint: &Constraint) -> bool {
        let limits = (self.limits.get(constraint), other.limits.get(constraint));
        let (Some(was), Some(is)) = limits else { return false };
        let moved = (was - is).abs();
        // What is no number has no difference to itself either.
        was.to_bits() != is.to_bits() && (moved > SAME || moved.is_nan())
    }

    /// Adds what the user has changed, where it reaches a limit by way of expressions.
    fn add_changed(&self, broken: usize, from: &mut Vec<String>) {
        let own = &self.broken[broken].constraint.1;
        let formulas: Vec<_> = std::iter::once(own)
            .chain(from.iter())
            .filter_map(|path| self.written(path).formula.as_ref())
            .collect();
        let changed: BTreeSet<String> =
            formulas.iter().flat_map(|formula| changed_above(&self.written, formula)).collect();
        for path in changed {
            if path != *own && !from.contains(&path) {
                from.push(path);
            }
        }
    }

    /// Message and hint of a limit that is not kept.
    fn say(&mut self, broken: usize, from: &[String]) {
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
        let change = either(&paths, "or");
        let hint = match (limit, paths.is_empty()) {
            (Some(limit), true) => format!("write {limit}"),
            (Some(limit), false) => format!("write {limit}, or change {change}"),
            (None, _) => format!("change {change}"),
        };
        let hint = (limit.is_some() || !paths.is_empty()).then_some(hint);
        let facts = Facts::of_limit(path, limit.as_deref());
        let problem = &mut self.found[*found].problem;
        (problem.message, problem.hint, problem.facts) = (message, hint, facts);
    }

    /// Appends the values that a limit follows from, as many as a line has room for.
    fn with_inputs(&self, sentence: String, from: &[String]) -> String {
        let mut inputs = String::new();
        for path in from.iter().take(MOST_NAMED) {
            let input = self.related(path);
            if !inputs.is_empty() && sentence.len() + inputs.len() + input.len() > MESSAGE_LENGTH {
                break;
            }
            inputs += if inputs.is_empty() { "" } else { ", " };
            inputs += &input;
        }
        if inputs.is_empty() { sentence } else { format!("{sentence} ({inputs})") }
    }

    /// `surface.radius is 15.0 mm`, with file and line where its user wrote it.
    fn related(&self, path: &str) -> String {
        let written = self.written(path);
        let value = written.text.shown();
        if written.source.kind != SourceKind::User {
            return format!("{path} is {value}");
        }
        let line = written.place.position.map(|p| format!(":{}", p.line)).unwrap_or_default();
        format!("{path} is {value} in {}{line}", written.place.file)
    }

    /// Where a value stands, or an item of a list, and its text on one line.
    fn item(&self, path: &str) -> (&Place, String) {
        let item = path.strip_suffix(']').and_then(|path| path.rsplit_once('['));
        if let Some((list, index)) = item
            && let WrittenText::List(items) = &self.written(list).text
            && let Some((text, place)) = index.parse().ok().and_then(|i: usize| items.get(i))
        {
            return (place, shown(text));
        }
        let written = self.written(path);
        (&written.place, written.text.shown())
    }

    fn written(&self, path: &str) -> &Written {
        let written = self.written.get(path);
        written.unwrap_or_else(|| panic!("`{path}` is not a parameter of this family"))
    }
}

fn in_unit<Q: Quantity>(number: f64) -> String {
    // `-0` reads badly.
    format!("{}{}", number + 0.0, Q::UNIT)
}

#[cfg(test)]
mod tests;
