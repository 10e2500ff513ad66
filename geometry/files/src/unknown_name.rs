//! Errors about unknown names.

use crate::{ErrorKind, ErrorSubject, Explained};

/// Error of an unknown name.
///
/// ```
/// use fabkit_files::{Explained, UnknownName};
///
/// let unknown = |name| UnknownName::new("built-in sensor", name, ["rtac0", "digit"]);
/// assert_eq!(unknown("rtac").to_string(), "there is no built-in sensor `rtac`");
/// assert_eq!(unknown("rtac").hint(), "did you mean `rtac0`?");
/// assert_eq!(unknown("lamp").hint(), "known: rtac0, digit");
/// assert_eq!(unknown("lamp").subject().code, "unknown_sensor");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no {what} `{name}`")]
pub struct UnknownName {
    /// Kind of the named thing, for example `part`.
    pub what: &'static str,
    /// Unknown name.
    pub name: String,
    /// Known names, in order.
    pub known: Vec<String>,
    /// Most similar known name, if one is similar enough.
    pub closest: Option<String>,
}

impl UnknownName {
    /// Creates the error and finds the most similar known name.
    pub fn new<'a>(
        what: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let known: Vec<String> = known.into_iter().map(str::to_owned).collect();
        let similar = fabkit_text::find_similar(name, known.iter().map(String::as_str));
        let closest = similar.first().map(|known| (*known).to_owned());
        Self { what, name: name.into(), known, closest }
    }

    /// Returns the suggestion, or the list of known names.
    pub fn hint(&self) -> String {
        match &self.closest {
            Some(closest) => fabkit_text::did_you_mean(&[closest]),
            None => {
                let known: Vec<&str> = self.known.iter().map(String::as_str).collect();
                format!("known: {}", fabkit_text::list_names(&known))
            }
        }
    }
}

impl Explained for UnknownName {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        Some(Self::hint(self))
    }

    /// Returns the code, such as `unknown_sensor` or `unknown_part`, with the known names.
    fn subject(&self) -> ErrorSubject {
        let what = self.what.trim_start_matches("built-in ").replace(' ', "_");
        ErrorSubject {
            written: Some(self.name.clone()),
            choices: self.known.clone(),
            suggestion: self.closest.clone(),
            ..ErrorSubject::new(&format!("unknown_{what}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typo_gets_a_suggestion_and_another_word_the_list() {
        let unknown = |name| UnknownName::new("part", name, ["base", "shell", "diffuser"]);
        assert_eq!(unknown("shel").hint(), "did you mean `shell`?");
        assert_eq!(unknown("difuser").hint(), "did you mean `diffuser`?");
        assert_eq!(unknown("xyzzy").hint(), "known: base, shell, diffuser");
        assert_eq!(unknown("shel").to_string(), "there is no part `shel`");
    }
}
