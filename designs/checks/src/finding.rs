//! Findings of rules.

use std::fmt;

use fabkit_geometry::Point3;

use crate::rule::Rule;

/// Severity of a finding.
///
/// ```
/// use fabkit_checks::Severity;
/// // Sorting puts what keeps the sensor from being built first.
/// assert!(Severity::Error < Severity::Warning && Severity::Warning < Severity::Note);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The sensor cannot be built as described.
    Error,
    /// The sensor may work, or its description may be incomplete.
    Warning,
    /// Information that needs no action.
    Note,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
        })
    }
}

/// A measured value and the limit that it is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredValue {
    /// Measured value.
    pub value: f64,
    /// Allowed value, in the same unit.
    pub limit: f64,
    /// Unit, for example `mm3`; empty for plain ratios.
    pub unit: &'static str,
}

/// A finding of a rule.
///
/// ```
/// use fabkit_checks::{Finding, Rule, Severity};
/// let finding = Finding::error(Rule::Fit, "the pin is 0.05 mm too thick", "make it thinner")
///     .about_bodies(["pin", "plate"])
///     .with_measurement(5.05, 5.0, "mm")
///     .with_severity(Severity::Warning);
/// assert_eq!(finding.bodies, ["pin", "plate"]);
/// assert_eq!(finding.severity.to_string(), "warning");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The rule that made the finding.
    pub rule: Rule,
    /// Severity of the finding.
    pub severity: Severity,
    /// Name of the step of the chain, if the finding belongs to one.
    pub step: Option<String>,
    /// Name of the assembly, if the finding belongs to one.
    pub assembly: Option<String>,
    /// Names of the bodies concerned, the most important one first; may be empty.
    pub bodies: Vec<String>,
    /// Position in the assembly's frame, mm.
    pub place: Option<Point3<f64>>,
    /// Measured value with its limit, if the finding is about a number.
    pub measured: Option<MeasuredValue>,
    /// Problem, as one sentence without a full stop.
    pub message: String,
    /// Suggested remedy.
    pub fix: String,
}

impl Finding {
    /// Creates an error with only a message and a remedy; the methods below add the rest.
    pub fn error(rule: Rule, message: impl Into<String>, fix: impl Into<String>) -> Self {
        Self {
            rule,
            severity: Severity::Error,
            step: None,
            assembly: None,
            bodies: Vec::new(),
            place: None,
            measured: None,
            message: message.into(),
            fix: fix.into(),
        }
    }

    /// Sets the severity.
    #[must_use]
    pub fn with_severity(mut self, severity: Severity) -> Self {
        self.severity = severity;
        self
    }

    /// Sets the step of the chain.
    #[must_use]
    pub fn in_step(mut self, step: &str) -> Self {
        self.step = Some(step.into());
        self
    }

    /// Sets the assembly.
    #[must_use]
    pub fn in_assembly(mut self, assembly: &str) -> Self {
        self.assembly = Some(assembly.into());
        self
    }

    /// Sets the bodies concerned, the most important one first.
    #[must_use]
    pub fn about_bodies<'a>(mut self, bodies: impl IntoIterator<Item = &'a str>) -> Self {
        self.bodies = bodies.into_iter().map(str::to_owned).collect();
        self
    }

    /// Sets the position in the assembly's frame, mm.
    #[must_use]
    pub fn at_position(mut self, place: Option<Point3<f64>>) -> Self {
        self.place = place;
        self
    }

    /// Sets the measured value and its limit.
    #[must_use]
    pub fn with_measurement(mut self, value: f64, limit: f64, unit: &'static str) -> Self {
        self.measured = Some(MeasuredValue { value, limit, unit });
        self
    }
}
