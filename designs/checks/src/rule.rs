//! Names of rules.

use std::fmt;

/// A rule, identified by the word that the command line and documents use.
///
/// ```
/// use fabkit_checks::Rule;
/// assert_eq!(Rule::Casting.word(), "casting");
/// let named = Rule::ALL.into_iter().find(|rule| rule.word() == "casting");
/// assert_eq!(named, Some(Rule::Casting));
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Rule(pub(crate) &'static str);

#[allow(non_upper_case_globals, reason = "rules are told apart as kinds are")]
impl Rule {
    /// Parts that are joined by hand have play, and no two of them overlap.
    pub const Fit: Self = Self("fit");
    /// Pins and mating parts come to rest at their intended places.
    pub const Seating: Self = Self("seating");
    /// A pattern of features cannot be confused with another one.
    pub const Pattern: Self = Self("pattern");
    /// The measurements determine the parameters that they are made for.
    pub const Observability: Self = Self("observability");
    /// Indenters press to the depth that is stated.
    pub const Pressing: Self = Self("pressing");
    /// Samples cover the range that is to be learned.
    pub const Coverage: Self = Self("coverage");

    /// Additional rules for calibration hardware; each is applied where it makes sense. [`Rule::Printability`] measures
    /// walls and holes of all printed parts of the hardware, not only of parts whose printer is named in a file.
    pub const HARDWARE: [Self; 7] = [
        Self::Fit,
        Self::Seating,
        Self::Pattern,
        Self::Printability,
        Self::Observability,
        Self::Pressing,
        Self::Coverage,
    ];

    /// Returns the word used on the command line and in documents.
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
