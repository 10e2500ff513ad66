//! Conditions under which parameters count.

/// Condition under which a parameter of a family changes something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Condition {
    /// Word of the family; empty for all families.
    pub family: &'static str,
    /// Dotted path of the parameter, or of its section followed by `.*`.
    pub path: &'static str,
    /// What has to hold, as half a sentence after `if`.
    pub counts_if: &'static str,
}

/// Conditions of all parameters that change nothing in some designs. A test sets every parameter of every family, and
/// fails for one that changes nothing and is not listed here, and for a row here that no family has.
const CONDITIONS: &[Condition] = &[];

/// Returns the conditions of all parameters that change nothing in some designs.
pub fn conditions() -> &'static [Condition] {
    CONDITIONS
}

/// Returns the condition under which a parameter counts, if it is one that does not always.
///
/// ```
/// use fabkit_designs::condition;
/// assert_eq!(condition("dome", "no.such_parameter"), None);
/// ```
pub fn condition(family: &str, path: &str) -> Option<&'static str> {
    let is_section =
        |pattern: &str| pattern.strip_suffix('*').is_some_and(|section| path.starts_with(section));
    let is_it = |one: &&Condition| {
        (one.family.is_empty() || one.family == family)
            && (one.path == path || is_section(one.path))
    };
    CONDITIONS.iter().find(is_it).map(|one| one.counts_if)
}
