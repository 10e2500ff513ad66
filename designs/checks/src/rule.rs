//! What a rule is called.

use std::fmt;

/// A rule, by its word.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Rule(pub(crate) &'static str);

#[allow(non_upper_case_globals, reason = "rules are told apart as kinds are")]
impl Rule {
    /// What goes into each other by hand does so, and no two of them meet.
    pub const Fit: Self = Self("fit");
    /// Pins and mates come to rest where they are said to.
    pub const Seating: Self = Self("seating");
    /// A pattern of features cannot be taken for another one.
    pub const Pattern: Self = Self("pattern");
    /// What is measured tells what it is measured for.
    pub const Observability: Self = Self("observability");
    /// What presses does so to the depth that is stated.
    pub const Pressing: Self = Self("pressing");
    /// Samples cover what is to be learned.
    pub const Coverage: Self = Self("coverage");

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
        self.0
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

impl fmt::Debug for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}
