//! What a family requires of several values together.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::panic::Location;

use fabkit_geometry::Length;

use crate::document::changed_above;
use crate::place::{Found, Written};
use crate::suggest::either;
use crate::{InvalidDesign, Parameter, SourceKind, shown};

/// Lengths that differ by less are the same: rounding in what a limit is computed from.
const SAME_MM: f64 = 1e-9;

/// How far parameters are moved to see what a limit follows from, as a share: first hardly, which is
/// far above rounding; then far, then twofold, for limits that something has driven to their end.
const SHARES: [f64; 3] = [1e-5, 0.25, 1.0];

/// Collects impossible combinations, each at the place where a value was written.
#[derive(Clone, Debug)]
pub struct Report {
    written: BTreeMap<String, Written>,
    found: Vec<Found>,
    limits: BTreeMap<Constraint, f64>,
    /// The limit that was asked for last.
    last: Option<Constraint>,
    broken: Vec<Broken>,
}

/// A limit that was asked for: where in the code, for which path, and how often before.
type Constraint = (&'static Location<'static>, String, usize);

/// A limit that is not kept.
#[derive(Clone, Debug)]
struct Broken {
    constraint: Constraint,
    value: Length,
    /// `at most 3 mm`, where there is such a value.
    limit: Option<String>,
    because: String,
    /// Which of what was found it is.
    found: usize,
    /// What it follows from, where somebody has said so.
    named: Vec<String>,
}

impl Report {
    pub(crate) fn new(written: BTreeMap<String, Written>, found: Vec<Found>) -> Self {
        Self { written, found, limits: BTreeMap::new(), last: None, broken: Vec::new() }
    }

    /// Whether nothing is wrong so far.
    pub fn is_clean(&self) -> bool {
        self.found.is_empty()
    }

    /// Everything that is wrong, in the order of the file, then of the overrides.
    pub fn into_invalid(self) -> InvalidDesign {
        InvalidDesign { problems: Found::sorted(self.found) }
    }

    /// Reports a problem at `path` unless `holds`.
    ///
    /// The message is a whole sentence that names the value and its limit, the hint says what
    /// would work.
    ///
    /// # Panics
    /// If `path` is not a parameter, whether it holds or not: a slip in the family, which the
    /// first sensor that is loaded brings to light.
    pub fn require(
        &mut self,
        holds: bool,
        path: &str,
        message: impl FnOnce() -> String,
        hint: impl FnOnce() -> String,
    ) {
        let written = self.written(path);
        if !holds {
            let found = written.place.problem(path, &written.text.shown(), message());
            self.found.push(found.hint(hint()));
        }
    }

    /// Requires `value`, written at `path`, to be at most `limit_mm`.
    ///
    /// `because` completes the sentence "it must be at most 3 mm, because ...". What the limit
    /// follows from is found by [`Report::trace`].
    ///
    /// # Panics
    /// As [`Report::require`].
    #[track_caller]
    pub fn at_most(&mut self, path: &str, value: Length, limit_mm: f64, because: impl Display) {
        let holds = value.mm() <= limit_mm + SAME_MM;
        // Rounded down to a value that does work.
        let works_mm = ((limit_mm + SAME_MM) * 1e3).floor() / 1e3;
        // Below zero there is no length to recommend: others have left no room.
        let limit = (works_mm > 0.0).then(|| format!("at most {}", mm(works_mm)));
        self.limit(holds, path, value, limit_mm, limit, because);
    }

    /// Requires `value`, written at `path`, to be at least `limit_mm`; else as [`Report::at_most`].
    ///
    /// # Panics
    /// As [`Report::require`].
    #[track_caller]
    pub fn at_least(&mut self, path: &str, value: Length, limit_mm: f64, because: impl Display) {
        let holds = value.mm() >= limit_mm - SAME_MM;
        // Rounded up to a value that does work.
        let works_mm = ((limit_mm - SAME_MM) * 1e3).ceil() / 1e3;
        let limit = Some(format!("at least {}", mm(works_mm)));
        self.limit(holds, path, value, limit_mm, limit, because);
    }

    #[track_caller]
    fn limit(
        &mut self,
        holds: bool,
        path: &str,
        value: Length,
        limit_mm: f64,
        limit: Option<String>,
        because: impl Display,
    ) {
        let mut constraint = (Location::caller(), path.to_owned(), 0);
        while self.limits.contains_key(&constraint) {
            constraint.2 += 1;
        }
        self.limits.insert(constraint.clone(), limit_mm);
        self.last = Some(constraint.clone());
        let found = self.found.len();
        self.require(holds, path, String::new, String::new);
        if !holds {
            let because = because.to_string();
            let named = Vec::new();
            self.broken.push(Broken { constraint, value, limit, because, found, named });
            self.say(self.broken.len() - 1, &[]);
        }
    }

    /// Names what a limit follows from that was just asked for and is not kept: where
    /// [`Report::trace`] would take too long to find it out. Nothing where it is kept.
    pub fn follows_from(&mut self, paths: &[&str]) {
        let is_last = |broken: &Broken| self.last.as_ref() == Some(&broken.constraint);
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
            for (input, neighbour) in parameters.neighbours(path, &(), share) {
                let mut report = Self::new(self.written.clone(), Vec::new());
                check(&neighbour, &mut report);
                for &i in &unknown {
                    let constraint = &self.broken[i].constraint;
                    let is_known = constraint.1 == input || from[i].last() == Some(&input);
                    if !is_known && self.is_moved(&report, constraint) {
                        from[i].push(input.clone());
                    }
                }
            }
        }
        for (i, from) in from.iter_mut().enumerate() {
            self.add_changed(i, from);
            // What the user has just written is what they will look at first.
            from.sort_by_key(|path| self.written(path).source.kind != SourceKind::User);
            self.say(i, from);
        }
    }

    /// Whether another report has another limit for the same constraint.
    fn is_moved(&self, other: &Self, constraint: &Constraint) -> bool {
        let limits_mm = (self.limits.get(constraint), other.limits.get(constraint));
        let (Some(was_mm), Some(is_mm)) = limits_mm else { return false };
        let moved_mm = (was_mm - is_mm).abs();
        // What is no number has no difference to itself either.
        was_mm.to_bits() != is_mm.to_bits() && (moved_mm > SAME_MM || moved_mm.is_nan())
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
        let Broken { constraint: (_, path, _), value, limit, because, found, .. } =
            &self.broken[broken];
        let related: Vec<String> = from.iter().map(|path| self.related(path)).collect();
        let follows = match related.is_empty() {
            true => String::new(),
            false => format!(" ({})", related.join(", ")),
        };
        let must = match limit {
            Some(limit) => format!("it must be {limit}"),
            None => "no value works".into(),
        };
        let formula = match &self.written(path).formula {
            Some(formula) => format!(" (`{}`)", shown(&formula.text)),
            None => String::new(),
        };
        let message = format!("{path} is {value}{formula}; {must}, because {because}{follows}");
        let paths: Vec<String> = from.iter().map(|path| format!("`{path}`")).collect();
        let change = either(&paths, "or");
        let hint = match (limit, paths.is_empty()) {
            (Some(limit), true) => format!("write {limit}"),
            (Some(limit), false) => format!("write {limit}, or change {change}"),
            (None, _) => format!("change {change}"),
        };
        let hint = (limit.is_some() || !paths.is_empty()).then_some(hint);
        let problem = &mut self.found[*found].problem;
        (problem.message, problem.hint) = (message, hint);
    }

    /// `surface.radius is 15.0 mm in rtac0.yaml:9`.
    fn related(&self, path: &str) -> String {
        let written = self.written(path);
        let line = written.place.position.map(|p| format!(":{}", p.line)).unwrap_or_default();
        let file = &written.place.file;
        match &written.formula {
            Some(formula) => {
                let (value, text) = (written.text.shown(), shown(&formula.text));
                format!("{path} is {value}, from `{text}` in {file}{line}")
            }
            None => format!("{path} is {} in {file}{line}", written.text.shown()),
        }
    }

    fn written(&self, path: &str) -> &Written {
        let written = self.written.get(path);
        written.unwrap_or_else(|| panic!("`{path}` is not a parameter of this family"))
    }
}

fn mm(mm: f64) -> String {
    // `-0` reads badly.
    format!("{} mm", mm + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::place::{Layer, Place, WrittenText};
    use crate::{Dialect, Source};

    fn report() -> Report {
        let place = Place::new(Layer::File, "x.yaml", &const { Dialect::new("thing", 1, "") });
        let text = WrittenText::Scalar("1 mm".into());
        let source = Source { kind: SourceKind::User, note: String::new() };
        let written = BTreeMap::from([("wall".to_owned(), Written::new(place, text, source))]);
        Report::new(written, Vec::new())
    }

    fn length(mm: f64) -> Length {
        Length::from_mm(mm).unwrap()
    }

    #[test]
    fn the_limit_that_is_offered_is_itself_accepted() {
        for limit_mm in [1.0 / 3.0, 0.1 + 0.2, 2.0, 1e-4, 0.0] {
            let mut report = report();
            report.at_least("wall", length(-1.0), limit_mm, "it must hold");
            let hint = report.found[0].problem.hint.clone().unwrap();
            let offered: Length = hint.trim_start_matches("write at least ").parse().unwrap();
            assert!(offered.mm() - limit_mm < 1e-3, "{hint}");
            let mut report = self::report();
            report.at_least("wall", offered, limit_mm, "it must hold");
            assert!(report.is_clean(), "{hint}");
        }
        // 0.1 + 0.2 is a little more than 0.3, which still counts as 0.3.
        let mut report = report();
        report.at_least("wall", length(0.3), 0.1 + 0.2, "it must hold");
        report.at_most("wall", length(0.1 + 0.2), 0.3, "it must fit");
        assert!(report.is_clean());
        // A limit that came out as NaN is never met.
        report.at_most("wall", length(0.3), f64::NAN, "it must fit");
        report.at_least("wall", length(0.3), f64::NAN, "it must fit");
        assert_eq!(report.found.len(), 2);
    }

    crate::choices! {
        /// Of the box.
        pub enum Lid {
            /// It takes room.
            Thick = "thick",
            /// It does not.
            Thin = "thin",
        }
    }
    crate::parameters! {
        /// Test.
        pub struct Crate {
            /// Wall.
            wall: Length = 0.0..=9.0,
            /// Width.
            width: Length = 0.0..=90.0,
            /// Ribs.
            ribs: u32 = 1..=9,
            /// Gaps.
            gaps: Vec<Length> = (1..=3, 0.0..=5.0),
            /// Lid.
            lid: Lid,
            /// Label, which says nothing of the wall.
            label: String = 0..=9,
            /// Weight, which does not either.
            weight: f64 = 0.0..=9.0,
        }
    }

    fn check(p: &Crate, report: &mut Report) {
        let lid_mm = if p.lid == Lid::Thick { 1.0 } else { 0.0 };
        let gaps_mm: f64 = p.gaps.iter().map(|gap| gap.mm()).sum();
        // The wall itself cancels out; the weight would matter if it were larger.
        let room_mm = p.wall.mm() + p.width.mm() - gaps_mm - lid_mm - p.wall.mm();
        report.at_most(
            "wall",
            p.wall,
            (room_mm / f64::from(p.ribs)).max(0.01 * p.weight),
            "it fits",
        );
    }

    #[test]
    fn a_limit_names_all_that_it_follows_from_and_nothing_else() {
        let place = Place::new(Layer::File, "x.yaml", &const { Dialect::new("thing", 1, "") });
        let source = Source { kind: SourceKind::User, note: String::new() };
        let written = <Crate as crate::Section>::fields().into_iter().map(|field| {
            let text = WrittenText::Scalar("1".into());
            let written = Written::new(place.clone(), text, source.clone());
            (field.name.to_owned(), written)
        });
        let mut report = Report::new(written.collect(), Vec::new());
        let p = Crate {
            wall: length(5.0),
            width: length(9.0),
            ribs: 2,
            gaps: vec![length(1.0), length(0.5)],
            lid: Lid::Thick,
            label: "a".into(),
            weight: 1.0,
        };
        check(&p, &mut report);
        report.trace("", &p, check);
        let problem = &report.found[0].problem;
        let hint = "write at most 3.25 mm, or change `width`, `ribs`, `gaps` or `lid`";
        assert_eq!(problem.hint.as_deref(), Some(hint));
        let follows =
            "(width is 1 in x.yaml, ribs is 1 in x.yaml, gaps is 1 in x.yaml, lid is 1 in x.yaml)";
        assert!(problem.message.ends_with(follows), "{}", problem.message);

        // Driven to its end, a limit is moved by nothing near; what drove it there is still named.
        let drained = |p: &Crate, report: &mut Report| {
            let room_mm = (p.width.mm() - 10.0).max(0.0);
            report.at_most("wall", p.wall, room_mm, "it fits");
        };
        let mut report = Report::new(report.written, Vec::new());
        drained(&p, &mut report);
        report.trace("", &p, drained);
        assert_eq!(report.found[0].problem.hint.as_deref(), Some("change `width`"));
    }

    #[test]
    #[should_panic(expected = "`wal` is not a parameter")]
    fn a_slip_in_a_path_shows_even_if_the_condition_holds() {
        report().require(true, "wal", String::new, String::new);
    }
}
