//! Failures of every topic, seen alike: what kind they are, what they are about and what to do.
//!
//! Each topic has an error type of its own that implements [`Explained`]. [`Error`] holds one of them, or
//! several, for callers that pass through more than one topic. Nothing here names an option of a command
//! or an argument of a function: that is for the doors, which know how their user came in.

use std::error::Error as StdError;
use std::fmt;

use crate::ErrorSubject;

/// What a failure means for the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// Unknown names, values out of range, designs that cannot be built.
    BadInput,
    /// Input or output beyond a stated limit.
    Limit,
    /// Files that cannot be read or written.
    Io,
    /// A bug in fabkit.
    Bug,
    /// The caller asked to stop.
    Interrupted,
}

impl ErrorKind {
    /// The word in documents, for example `bad-input`.
    pub fn word(self) -> &'static str {
        match self {
            Self::BadInput => "bad-input",
            Self::Limit => "limit",
            Self::Io => "io",
            Self::Bug => "bug",
            Self::Interrupted => "interrupted",
        }
    }

    /// The code of a failure of which nothing more is known.
    pub fn code(self) -> &'static str {
        match self {
            Self::BadInput => "bad_input",
            Self::Limit => "limit_exceeded",
            Self::Io => "io",
            Self::Bug => "bug",
            Self::Interrupted => "interrupted",
        }
    }
}

/// An error that says what it means, what it is about and what to do.
pub trait Explained: StdError {
    /// What it means for the caller.
    fn kind(&self) -> ErrorKind;

    /// What to do about it, where that is known.
    fn hint(&self) -> Option<String> {
        None
    }

    /// A code that programs can rely on, and the file, value or name that is wrong.
    fn subject(&self) -> ErrorSubject {
        ErrorSubject::of_kind(self.kind())
    }
}

/// One failure of any topic, or several at once.
///
/// ```
/// use fabkit_files::{Error, ErrorKind, UnknownName};
///
/// let error = Error::from(UnknownName::new("part", "shel", ["base", "shell"]));
/// assert_eq!(error.kind(), ErrorKind::BadInput);
/// assert_eq!(error.hint().as_deref(), Some("did you mean `shell`?"));
/// assert_eq!(error.subject().code, "unknown_part");
/// assert!(error.downcast_ref::<UnknownName>().is_some());
/// ```
pub struct Error(Failures);

enum Failures {
    One(Box<dyn Explained + Send + Sync>),
    /// At least two.
    Several(Vec<Error>),
}

/// Something that must not happen.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Bug(String);

impl Explained for Bug {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Bug
    }
}

impl Error {
    /// Something that must not happen.
    pub fn bug(what: impl ToString) -> Self {
        Bug(what.to_string()).into()
    }

    /// Joins several; `None` for none.
    pub fn all(mut errors: Vec<Self>) -> Option<Self> {
        if errors.len() > 1 { Some(Self(Failures::Several(errors))) } else { errors.pop() }
    }

    /// The parts of several, each of which may be several again; nothing for a single one.
    pub fn parts(&self) -> &[Self] {
        match &self.0 {
            Failures::One(_) => &[],
            Failures::Several(errors) => errors,
        }
    }

    /// The first failure, which decides kind and hint of all.
    fn first(&self) -> &(dyn Explained + Send + Sync + 'static) {
        match &self.0 {
            Failures::One(error) => &**error,
            Failures::Several(errors) => errors[0].first(),
        }
    }

    /// The topic's own error, if this is one failure of that type.
    pub fn downcast_ref<T: StdError + 'static>(&self) -> Option<&T> {
        match &self.0 {
            Failures::One(error) => {
                let error: &(dyn StdError + 'static) = &**error;
                error.downcast_ref()
            }
            Failures::Several(_) => None,
        }
    }

    /// As [`Explained::kind`], of the first failure.
    pub fn kind(&self) -> ErrorKind {
        self.first().kind()
    }

    /// As [`Explained::hint`], of the first failure.
    pub fn hint(&self) -> Option<String> {
        self.first().hint()
    }

    /// As [`Explained::subject`], of the first failure.
    pub fn subject(&self) -> ErrorSubject {
        self.first().subject()
    }
}

impl<E: Explained + Send + Sync + 'static> From<E> for Error {
    fn from(error: E) -> Self {
        Self(Failures::One(Box::new(error)))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Failures::One(error) => error.fmt(f),
            Failures::Several(errors) => f.write_str(&joined(errors)),
        }
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Failures::One(error) => error.fmt(f),
            Failures::Several(errors) => f.debug_list().entries(errors).finish(),
        }
    }
}

impl StdError for Error {
    fn source(&self) -> Option<&(dyn StdError + 'static)> {
        match &self.0 {
            Failures::One(error) => error.source(),
            Failures::Several(_) => None,
        }
    }
}

/// Joins messages as people are shown lists: each on a line that begins with `error: `, the first without.
pub fn joined(messages: &[impl ToString]) -> String {
    messages.iter().map(ToString::to_string).collect::<Vec<_>>().join("\nerror: ")
}

/// Most faults that are listed one by one: a screenful; who sees fifty mends the first.
const MOST_FAULTS: usize = 50;

/// Joins the first of many faults, and says how many more there are.
pub fn listed(faults: &[String]) -> String {
    let (count, shown) = (faults.len(), faults.len().min(MOST_FAULTS));
    let message = joined(&faults[..shown]);
    match count - shown {
        0 => message,
        more => format!("{message}\nerror: and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::UnknownName;

    fn unknown(name: &str) -> Error {
        UnknownName::new("part", name, ["base"]).into()
    }

    #[test]
    fn several_say_all_and_count_as_their_first() {
        let several = Error::all(vec![unknown("a"), Error::bug("b")]).expect("two are some");
        assert_eq!(several.to_string(), "there is no part `a`\nerror: b");
        assert_eq!(several.kind(), ErrorKind::BadInput);
        assert_eq!(several.parts().len(), 2);
        assert!(several.downcast_ref::<UnknownName>().is_none(), "it is not one");
    }

    #[test]
    fn one_of_one_is_itself_and_none_is_none() {
        let one = Error::all(vec![unknown("a")]).expect("one is some");
        assert_eq!(one.downcast_ref::<UnknownName>().map(|e| e.name.as_str()), Some("a"));
        assert!(Error::all(Vec::new()).is_none());
    }
}
