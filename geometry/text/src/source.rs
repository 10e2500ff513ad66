//! Where numbers come from.

use std::fmt;

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// Stated in the paper.
    Paper,
    /// Stated by the maker of what is bought: in a data sheet.
    Maker,
    /// Measured from published files.
    Measured,
    /// Chosen by fabkit's authors.
    Chosen,
    /// Given by the user: in their own file without a source, or on the command line.
    User,
}

impl SourceKind {
    /// Every kind, in the order in which messages name them.
    pub const ALL: [Self; 5] = [Self::Paper, Self::Maker, Self::Measured, Self::Chosen, Self::User];

    /// As written in YAML.
    pub fn word(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Maker => "maker",
            Self::Measured => "measured",
            Self::Chosen => "chosen",
            Self::User => "user",
        }
    }
}

impl fmt::Display for SourceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// The source of one value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// What kind.
    pub kind: SourceKind,
    /// Section, file or reason.
    pub note: String,
    /// How far what is made may be from it, either way, as written; of lengths and angles.
    pub tolerance: Option<String>,
}

impl Source {
    /// Of a value that the user gave; nothing more is known of it.
    pub fn user(note: impl Into<String>) -> Self {
        Self { kind: SourceKind::User, note: note.into(), tolerance: None }
    }
}
