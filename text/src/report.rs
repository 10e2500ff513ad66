//! What a family requires of several values together.

use std::collections::BTreeMap;
use std::fmt::Display;

use fabkit_geometry::Length;

use crate::InvalidDesign;
use crate::place::{Found, Written};
use crate::suggest::either;

/// Lengths that differ by less are the same: rounding in what a limit is computed from.
const SAME_MM: f64 = 1e-9;

/// Collects impossible combinations, each at the place where a value was written.
#[derive(Clone, Debug)]
pub struct Report {
    written: BTreeMap<String, Written>,
    found: Vec<Found>,
}

impl Report {
    pub(crate) fn new(written: BTreeMap<String, Written>, found: Vec<Found>) -> Self {
        Self { written, found }
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
    /// `because` completes the sentence "it must be at most 3 mm, because ..."; `from` are the
    /// paths that the limit follows from, which the message names with their values.
    ///
    /// # Panics
    /// As [`Report::require`].
    pub fn at_most(
        &mut self,
        path: &str,
        value: Length,
        limit_mm: f64,
        because: impl Display,
        from: &[&str],
    ) {
        let holds = value.mm() <= limit_mm + SAME_MM;
        // Rounded down to a value that does work.
        let works_mm = ((limit_mm + SAME_MM) * 1e3).floor() / 1e3;
        // Below zero there is no length to recommend: others have left no room.
        let limit = (works_mm > 0.0).then(|| format!("at most {}", mm(works_mm)));
        self.limit(holds, path, value, limit, because, from);
    }

    /// Requires `value`, written at `path`, to be at least `limit_mm`; else as
    /// [`Report::at_most`].
    ///
    /// # Panics
    /// As [`Report::require`].
    pub fn at_least(
        &mut self,
        path: &str,
        value: Length,
        limit_mm: f64,
        because: impl Display,
        from: &[&str],
    ) {
        let holds = value.mm() >= limit_mm - SAME_MM;
        // Rounded up to a value that does work.
        let works_mm = ((limit_mm - SAME_MM) * 1e3).ceil() / 1e3;
        self.limit(holds, path, value, Some(format!("at least {}", mm(works_mm))), because, from);
    }

    fn limit(
        &mut self,
        holds: bool,
        path: &str,
        value: Length,
        limit: Option<String>,
        because: impl Display,
        from: &[&str],
    ) {
        let related: Vec<String> = from.iter().map(|path| self.related(path)).collect();
        self.require(
            holds,
            path,
            || {
                let follows = match related.is_empty() {
                    true => String::new(),
                    false => format!(" ({})", related.join(", ")),
                };
                let must = match &limit {
                    Some(limit) => format!("it must be {limit}"),
                    None => "no value works".into(),
                };
                format!("{path} is {value}; {must}, because {because}{follows}")
            },
            || {
                let paths: Vec<String> = from.iter().map(|path| format!("`{path}`")).collect();
                let change = either(&paths, "or");
                match (&limit, paths.is_empty()) {
                    (Some(limit), true) => format!("write {limit}"),
                    (Some(limit), false) => format!("write {limit}, or change {change}"),
                    (None, _) => format!("change {change}"),
                }
            },
        );
    }

    /// `surface.radius is 15.0 mm in rtac0.yaml:9`.
    fn related(&self, path: &str) -> String {
        let written = self.written(path);
        let line = written.place.position.map(|p| format!(":{}", p.line)).unwrap_or_default();
        format!("{path} is {} in {}{line}", written.text.shown(), written.place.file)
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
    use crate::{Dialect, Source, SourceKind};

    fn report() -> Report {
        let place = Place::new(Layer::File, "x.yaml", &const { Dialect::new("thing", 1, "") });
        let text = WrittenText::Scalar("1 mm".into());
        let source = Source { kind: SourceKind::User, note: String::new() };
        let written = BTreeMap::from([("wall".to_owned(), Written { place, text, source })]);
        Report::new(written, Vec::new())
    }

    fn length(mm: f64) -> Length {
        Length::from_mm(mm).unwrap()
    }

    #[test]
    fn the_limit_that_is_offered_is_itself_accepted() {
        for limit_mm in [1.0 / 3.0, 0.1 + 0.2, 2.0, 1e-4, 0.0] {
            let mut report = report();
            report.at_least("wall", length(-1.0), limit_mm, "it must hold", &[]);
            let hint = report.found[0].problem.hint.clone().unwrap();
            let offered: Length = hint.trim_start_matches("write at least ").parse().unwrap();
            assert!(offered.mm() - limit_mm < 1e-3, "{hint}");
            let mut report = self::report();
            report.at_least("wall", offered, limit_mm, "it must hold", &[]);
            assert!(report.is_clean(), "{hint}");
        }
        // 0.1 + 0.2 is a little more than 0.3, which still counts as 0.3.
        let mut report = report();
        report.at_least("wall", length(0.3), 0.1 + 0.2, "it must hold", &[]);
        report.at_most("wall", length(0.1 + 0.2), 0.3, "it must fit", &[]);
        assert!(report.is_clean());
        // A limit that came out as NaN is never met.
        report.at_most("wall", length(0.3), f64::NAN, "it must fit", &[]);
        report.at_least("wall", length(0.3), f64::NAN, "it must fit", &[]);
        assert_eq!(report.found.len(), 2);
    }

    #[test]
    #[should_panic(expected = "`wal` is not a parameter")]
    fn a_slip_in_a_path_shows_even_if_the_condition_holds() {
        report().require(true, "wal", String::new, String::new);
    }
}
