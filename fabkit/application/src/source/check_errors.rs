//! Errors that `check` finds, for callers that only need to know whether a design passes.

use fabkit_checks::{self as checks, InvalidBody, Severity};
use fabkit_files::Error;

use super::Target;

/// Findings of severity error, summarised.
///
/// ```
/// use fabkit_application::source::CheckErrors;
///
/// let of = |name: &str, messages: &[&str]| {
///     (name.to_owned(), messages.iter().map(|message| (*message).to_owned()).collect())
/// };
/// let errors = CheckErrors { by_design: vec![of("mine", &["the wall is thin", "no air escapes"])] };
/// assert_eq!(errors.count(), 2);
/// let says = "mine does not pass `fabkit check` (2 errors; the first: the wall is thin)";
/// assert_eq!(errors.to_sentence().as_deref(), Some(says));
/// assert_eq!(CheckErrors::default().to_sentence(), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CheckErrors {
    /// Each design with errors, and their messages, at least one.
    pub by_design: Vec<(String, Vec<String>)>,
}

impl CheckErrors {
    /// Returns the number of errors.
    pub fn count(&self) -> usize {
        self.messages().count()
    }

    /// Returns the messages of all designs.
    pub fn messages(&self) -> impl Iterator<Item = &str> {
        self.by_design.iter().flat_map(|(_, messages)| messages).map(String::as_str)
    }

    /// Says which designs do not pass, and the first error; `None` if all do.
    pub fn to_sentence(&self) -> Option<String> {
        let first = self.messages().next()?;
        let names: Vec<&str> = self.by_design.iter().map(|(name, _)| name.as_str()).collect();
        let errors = match self.count() {
            1 => "1 error".to_owned(),
            errors => format!("{errors} errors"),
        };
        Some(format!(
            "{} does not pass `fabkit check` ({errors}; the first: {first})",
            names.join(", ")
        ))
    }
}

impl Target<'_> {
    /// Applies all rules to the sensor or the fixture, and optionally to all fixtures of the sensor, for callers that
    /// only need to know whether it passes. The inner error is an invalid solid.
    ///
    /// # Errors
    /// See [`Target::design`].
    pub fn find_errors(
        &self,
        overrides: &[String],
        with_fixtures: bool,
    ) -> Result<Result<CheckErrors, InvalidBody>, Error> {
        let source = self.source()?;
        let project = source.load(overrides)?;
        let fixtures = match self.fixture {
            Some(name) => vec![name],
            None if with_fixtures => project.fixture_names(),
            None => Vec::new(),
        };
        let mut reports = Vec::new();
        if self.fixture.is_none() {
            // Masses are not computed here: they take a third of the time of some sensors.
            let report = checks::check_variant(&project.design.sensor, &checks::Memo::default());
            reports.push((project.design.sensor.name.clone(), report));
        }
        for name in fixtures {
            let report = project
                .check_fixture(name, &|_, _| {})
                .map_err(|e| source.convert_fixture_error(e))?;
            reports.push((format!("{}/{name}", project.design.sensor.name), report));
        }
        let mut faults = CheckErrors::default();
        for (name, report) in reports {
            let report = match report {
                Ok(report) => report,
                Err(invalid) => return Ok(Err(invalid)),
            };
            let errors = report.findings.into_iter().filter(|f| f.severity == Severity::Error);
            let messages: Vec<String> = errors.map(|finding| finding.message).collect();
            if !messages.is_empty() {
                faults.by_design.push((name, messages));
            }
        }
        Ok(Ok(faults))
    }
}
