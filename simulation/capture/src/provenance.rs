//! Numbers that say where they come from.

use fabkit_checks::UnknownProperty;

/// Provenance of a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Provenance {
    /// Not known; a plausible value.
    Chosen,
    /// Measured.
    Measured,
    /// Fitted; the constant's source states to which data.
    Fitted,
    /// Stated of a material; the constant's source says by whom.
    Stated,
}

impl Provenance {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Chosen => "chosen",
            Self::Measured => "measured",
            Self::Fitted => "fitted",
            Self::Stated => "stated",
        }
    }
}

/// A constant with its provenance.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Name with unit, as in outputs.
    pub name: &'static str,
    /// Numeric value.
    pub value: f64,
    /// Provenance of the value.
    pub known: Provenance,
    /// Description of the source.
    pub source: String,
    /// Properties of drawn materials that no source states, for which the value stands.
    pub unknown: Vec<UnknownProperty>,
}
