//! What a rule has to say.

use std::fmt;

use fabkit_geometry::Point3;

/// A rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// The chain names what exists, in an order that works.
    Chain,
    /// Bodies of one assembly overlap only where a press fit is declared.
    Interference,
    /// The closed cavity of a pour is the layer.
    Casting,
    /// Air can leave the cavity everywhere.
    TrappedAir,
    /// Tools come off what was cast.
    Demolding,
    /// The camera sees what it is there to see.
    Sight,
    /// No daylight falls on what the camera looks at.
    Leak,
    /// No lamp is mirrored into the picture.
    Glare,
    /// Every body gets to its place past what stands there already.
    Motion,
    /// Hands and tools have room where they work.
    Access,
    /// What goes into each other by hand does so, and no two of them meet.
    Fit,
    /// Pins and mates come to rest where they are said to.
    Seating,
    /// A pattern of features cannot be taken for another one.
    Pattern,
    /// The printer can make it.
    Printability,
    /// Layers stick to what they are cast onto.
    Bonding,
    /// One tool shapes what is touched, without a seam.
    Parting,
    /// What is poured cures against what it touches, and does not grow together with its mold.
    Chemistry,
    /// Soft where it must give way, firm where it must hold.
    Softness,
    /// A closed mold lets its surplus out.
    Flow,
    /// Every body of the finished sensor is held in every direction, and bears its load.
    Held,
    /// Lamps shine and do not burn, nets connect, boards are there.
    Circuit,
    /// Printed parts can be told apart, and letters are where they do no harm.
    Labels,
    /// Printed parts stand while they grow, and resin leaves them.
    Standing,
    /// What a printer must support is told to whoever prints it.
    Overhang,
    /// What is measured tells what it is measured for.
    Observability,
    /// What presses does so to the depth that is stated.
    Pressing,
    /// Samples cover what is to be learned.
    Coverage,
}

impl Rule {
    /// The rules of [`check`](crate::check) for every sensor and every kit of parts, in the order
    /// of reports.
    pub const ALL: [Self; 21] = [
        Self::Chain,
        Self::Interference,
        Self::Casting,
        Self::TrappedAir,
        Self::Demolding,
        Self::Parting,
        Self::Flow,
        Self::Sight,
        Self::Leak,
        Self::Glare,
        Self::Motion,
        Self::Access,
        Self::Bonding,
        Self::Chemistry,
        Self::Softness,
        Self::Held,
        Self::Circuit,
        Self::Labels,
        Self::Printability,
        Self::Standing,
        Self::Overhang,
    ];

    /// The rules that calibration hardware applies besides, each as far as it makes sense; walls and
    /// holes are measured of all its printed parts, not of those alone whose machine a file names.
    pub const HARDWARE: [Self; 7] = [
        Self::Fit,
        Self::Seating,
        Self::Pattern,
        Self::Printability,
        Self::Observability,
        Self::Pressing,
        Self::Coverage,
    ];

    /// The word used on the command line and in documents.
    pub fn word(self) -> &'static str {
        match self {
            Self::Chain => "chain",
            Self::Interference => "interference",
            Self::Casting => "casting",
            Self::TrappedAir => "trapped-air",
            Self::Demolding => "demolding",
            Self::Sight => "sight",
            Self::Leak => "leak",
            Self::Glare => "glare",
            Self::Motion => "motion",
            Self::Access => "access",
            Self::Fit => "fit",
            Self::Seating => "seating",
            Self::Pattern => "pattern",
            Self::Printability => "printability",
            Self::Bonding => "bonding",
            Self::Parting => "parting",
            Self::Chemistry => "chemistry",
            Self::Softness => "softness",
            Self::Flow => "flow",
            Self::Held => "held",
            Self::Circuit => "circuit",
            Self::Labels => "labels",
            Self::Standing => "standing",
            Self::Overhang => "overhang",
            Self::Observability => "observability",
            Self::Pressing => "pressing",
            Self::Coverage => "coverage",
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

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
