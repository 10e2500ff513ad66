//! Common interface of all errors: kind, subject and hint.
//!
//! Each topic has its own error type that implements [`Explained`]. [`Error`] holds one of them, or several, for
//! callers that use more than one topic. Nothing here names a command-line option or a function argument: the user
//! interfaces do that, since they know how they were called.

use std::error::Error as StdError;
use std::fmt;

use crate::ErrorSubject;

/// Meaning of a failure for the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// Invalid input: unknown names, values out of range, designs that cannot be built.
    BadInput,
    /// Input or output beyond a stated limit.
    Limit,
    /// File that cannot be read or written.
    Io,
    /// Bug in fabkit.
    Bug,
    /// Stop at the caller's request.
    Interrupted,
}

impl ErrorKind {
    /// Returns the word used in documents, for example `bad-input`.
    pub fn word(self) -> &'static str {
        match self {
            Self::BadInput => "bad-input",
            Self::Limit => "limit",
            Self::Io => "io",
            Self::Bug => "bug",
            Self::Interrupted => "interrupted",
        }
    }

    /// Returns the error code for a failure of which only the kind is known.
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

/// Error with a kind, a subject and a hint.
///
/// ```
/// use fabkit_files::{Error, ErrorKind, Explained};
///
/// #[derive(Debug, thiserror::Error)]
/// #[error("the wall is {0} mm; it must be at least 0.4 mm")]
/// struct TooThin(f64);
///
/// impl Explained for TooThin {
///     fn kind(&self) -> ErrorKind {
///         ErrorKind::BadInput
///     }
/// }
/// let error = Error::from(TooThin(0.1));
/// assert_eq!(error.to_string(), "the wall is 0.1 mm; it must be at least 0.4 mm");
/// // What is not stated follows from the kind.
/// assert_eq!((error.subject().code.as_str(), error.hint()), ("bad_input", None));
/// ```
pub trait Explained: StdError {
    /// Returns the meaning for the caller.
    fn kind(&self) -> ErrorKind;

    /// Returns what to do about it, if known.
    fn hint(&self) -> Option<String> {
        None
    }

    /// Returns the code that programs can rely on, and the file, value or name at fault.
    fn subject(&self) -> ErrorSubject {
        ErrorSubject::from_kind(self.kind())
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
pub struct Error(ErrorParts);

/// One or several errors.
enum ErrorParts {
    One(Box<dyn Explained + Send + Sync>),
    /// Several errors, at least two.
    Several(Vec<Error>),
}

/// Violated internal assumption.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Bug(String);

impl Explained for Bug {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Bug
    }
}

impl Error {
    /// Creates an error for a violated internal assumption.
    pub fn bug(what: impl ToString) -> Self {
        Bug(what.to_string()).into()
    }

    /// Joins several errors into one; returns `None` if there are none.
    ///
    /// ```
    /// use fabkit_files::{Error, ErrorKind, UnknownName};
    ///
    /// let unknown = |name| Error::from(UnknownName::new("part", name, ["base"]));
    /// let error = Error::join(vec![unknown("a"), Error::bug("b")]).expect("there are two");
    /// assert_eq!(error.to_string(), "there is no part `a`\nerror: b");
    /// assert_eq!((error.kind(), error.parts().len()), (ErrorKind::BadInput, 2));
    /// assert!(Error::join(vec![unknown("a")]).is_some_and(|error| error.parts().is_empty()));
    /// assert!(Error::join(Vec::new()).is_none());
    /// ```
    pub fn join(mut errors: Vec<Self>) -> Option<Self> {
        if errors.len() > 1 { Some(Self(ErrorParts::Several(errors))) } else { errors.pop() }
    }

    /// Returns the parts of a joined error, each of which may be joined again; empty for a single error.
    pub fn parts(&self) -> &[Self] {
        match &self.0 {
            ErrorParts::One(_) => &[],
            ErrorParts::Several(errors) => errors,
        }
    }

    /// Returns the first error, which decides kind and hint.
    fn first(&self) -> &(dyn Explained + Send + Sync + 'static) {
        match &self.0 {
            ErrorParts::One(error) => &**error,
            // Never empty: see `join`.
            ErrorParts::Several(errors) => errors[0].first(),
        }
    }

    /// Returns the topic's own error, if this is a single error of that type.
    pub fn downcast_ref<T: StdError + 'static>(&self) -> Option<&T> {
        match &self.0 {
            ErrorParts::One(error) => {
                let error: &(dyn StdError + 'static) = &**error;
                error.downcast_ref()
            }
            ErrorParts::Several(_) => None,
        }
    }

    /// Returns the kind of the first error. See [`Explained::kind`].
    pub fn kind(&self) -> ErrorKind {
        self.first().kind()
    }

    /// Returns the hint of the first error. See [`Explained::hint`].
    pub fn hint(&self) -> Option<String> {
        self.first().hint()
    }

    /// Returns the subject of the first error. See [`Explained::subject`].
    pub fn subject(&self) -> ErrorSubject {
        self.first().subject()
    }
}

impl<E: Explained + Send + Sync + 'static> From<E> for Error {
    fn from(error: E) -> Self {
        Self(ErrorParts::One(Box::new(error)))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            ErrorParts::One(error) => error.fmt(f),
            ErrorParts::Several(errors) => f.write_str(&join_messages(errors)),
        }
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            ErrorParts::One(error) => error.fmt(f),
            ErrorParts::Several(errors) => f.debug_list().entries(errors).finish(),
        }
    }
}

impl StdError for Error {
    fn source(&self) -> Option<&(dyn StdError + 'static)> {
        match &self.0 {
            ErrorParts::One(error) => error.source(),
            ErrorParts::Several(_) => None,
        }
    }
}

/// Joins messages as lists are printed: each on a line that begins with `error: `, except the first.
pub fn join_messages(messages: &[impl ToString]) -> String {
    messages.iter().map(ToString::to_string).collect::<Vec<_>>().join("\nerror: ")
}

/// Maximum number of faults listed one by one, a screenful: a user with fifty of them will start with the first.
const MAX_LISTED_FAULTS: usize = 50;

/// Joins the first faults and states the count of the others.
///
/// ```
/// use fabkit_files::join_first_messages;
///
/// let faults: Vec<String> = (1..=52).map(|row| format!("row {row} is empty")).collect();
/// let message = join_first_messages(&faults);
/// assert!(message.starts_with("row 1 is empty\nerror: row 2 is empty\n"));
/// assert!(message.ends_with("\nerror: row 50 is empty\nerror: and 2 more"));
/// ```
pub fn join_first_messages(faults: &[String]) -> String {
    let (count, shown) = (faults.len(), faults.len().min(MAX_LISTED_FAULTS));
    let message = join_messages(&faults[..shown]);
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
    fn joined_errors_print_all_and_take_the_kind_of_the_first() {
        let several = Error::join(vec![unknown("a"), Error::bug("b")]).expect("two are some");
        assert_eq!(several.to_string(), "there is no part `a`\nerror: b");
        assert_eq!(several.kind(), ErrorKind::BadInput);
        assert_eq!(several.parts().len(), 2);
        assert!(several.downcast_ref::<UnknownName>().is_none(), "it is not one");
    }

    #[test]
    fn joining_one_error_returns_it_and_joining_none_returns_none() {
        let one = Error::join(vec![unknown("a")]).expect("one is some");
        assert_eq!(one.downcast_ref::<UnknownName>().map(|e| e.name.as_str()), Some("a"));
        assert!(Error::join(Vec::new()).is_none());
    }
}
