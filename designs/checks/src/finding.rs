//! What a rule has to say.

use std::fmt;

use fabkit_geometry::Point3;

use crate::rule::Rule;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The sensor cannot be built as described.
    Error,
    /// It may work, or the description may be incomplete.
    Warning,
    /// Worth knowing.
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

/// What was measured, against what is allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Found.
    pub value: f64,
    /// Allowed, in the same unit.
    pub limit: f64,
    /// For example `mm3`; empty for plain ratios.
    pub unit: &'static str,
}

/// Something that a rule found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Which rule.
    pub rule: Rule,
    /// How bad it is.
    pub severity: Severity,
    /// In which step of the chain, if in one.
    pub step: Option<String>,
    /// In which assembly, if in one.
    pub assembly: Option<String>,
    /// The bodies concerned, the first one most; may be empty.
    pub bodies: Vec<String>,
    /// Where, in the assembly's frame, mm.
    pub place: Option<Point3<f64>>,
    /// The figure that is wrong, if it is one.
    pub measured: Option<Measured>,
    /// What is wrong, as one sentence without a full stop.
    pub message: String,
    /// What to do about it.
    pub fix: String,
}

impl Finding {
    /// An error with nothing but a message; the methods below add the rest.
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

    /// With another severity.
    #[must_use]
    pub fn with_severity(mut self, severity: Severity) -> Self {
        self.severity = severity;
        self
    }

    /// Found in a step of the chain.
    #[must_use]
    pub fn in_step(mut self, step: &str) -> Self {
        self.step = Some(step.into());
        self
    }

    /// Found in an assembly.
    #[must_use]
    pub fn in_assembly(mut self, assembly: &str) -> Self {
        self.assembly = Some(assembly.into());
        self
    }

    /// About these bodies, the first one most.
    #[must_use]
    pub fn of<'a>(mut self, bodies: impl IntoIterator<Item = &'a str>) -> Self {
        self.bodies = bodies.into_iter().map(str::to_owned).collect();
        self
    }

    /// At a place in the assembly's frame, mm.
    #[must_use]
    pub fn at(mut self, place: Option<Point3<f64>>) -> Self {
        self.place = place;
        self
    }

    /// With the figure that is wrong and its limit.
    #[must_use]
    pub fn measured(mut self, value: f64, limit: f64, unit: &'static str) -> Self {
        self.measured = Some(Measured { value, limit, unit });
        self
    }
}
