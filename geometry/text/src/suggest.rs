//! Suggestions of the form "did you mean ...?".

/// Minimum similarity of two words (normalized Damerau-Levenshtein, 0 to 1) for a suggestion. At 0.6 a swap of
/// neighbouring letters still counts (`raduis`), unrelated words of the same length do not.
const MIN_SIMILARITY: f64 = 0.6;

/// Maximum number of suggestions.
const MAX_SUGGESTIONS: usize = 3;

/// Returns the known names that are similar to `written`, best first.
///
/// ```
/// use fabkit_text::find_similar;
///
/// let known = ["radius", "wall_height"];
/// assert_eq!(find_similar("raduis", known), ["radius"]);
/// assert_eq!(find_similar("Wall-Height", known), ["wall_height"]);
/// assert!(find_similar("pitch", known).is_empty());
/// ```
pub fn find_similar<'a>(written: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    find_similar_in(written, known.into_iter().collect())
}

/// Same as [`find_similar`], without type parameters, so that it is compiled once.
fn find_similar_in<'a>(written: &str, known: Vec<&'a str>) -> Vec<&'a str> {
    // The comparison is quadratic in length, and a name this long is no typing error.
    if written.len() > 200 {
        return Vec::new();
    }
    // Known names are in lower case with underscores: case and hyphens are no slips.
    let written = written.to_lowercase().replace(['-', ' '], "_");
    let mut scored: Vec<(f64, &str)> = known
        .into_iter()
        .map(|name| {
            (strsim::normalized_damerau_levenshtein(&written, &name.replace('-', "_")), name)
        })
        .filter(|(score, _)| *score >= MIN_SIMILARITY)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    scored.into_iter().take(MAX_SUGGESTIONS).map(|(_, name)| name).collect()
}

/// Characters that a list of names may take in a hint.
const LIST_LENGTH: usize = 120;

/// Lists names separated by commas, cut after `LIST_LENGTH` characters with the number of the others.
///
/// ```
/// use fabkit_text::list_names;
///
/// assert_eq!(list_names(&["base", "shell"]), "base, shell");
/// let names = ["hexagonal-socket-screw"; 10];
/// assert!(list_names(&names).ends_with(" and 5 more"));
/// ```
pub fn list_names(names: &[&str]) -> String {
    let mut list = String::new();
    for (i, name) in names.iter().enumerate() {
        if !list.is_empty() && list.len() + name.len() > LIST_LENGTH {
            return format!("{list} and {} more", names.len() - i);
        }
        list += if list.is_empty() { "" } else { ", " };
        list += name;
    }
    list
}

/// Writes `did you mean ...?`, or lists all known names if none is similar.
///
/// ```
/// use fabkit_text::suggestion;
///
/// let known = ["base", "shell"];
/// assert_eq!(suggestion("shel", known, "parts"), "did you mean `shell`?");
/// assert_eq!(suggestion("lens", known, "parts"), "parts: base, shell");
/// ```
pub fn suggest_or_list<'a>(
    written: &str,
    known: impl IntoIterator<Item = &'a str>,
    what: &str,
) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    match find_similar_in(written, known.clone()) {
        similar if similar.is_empty() => format!("{what}: {}", list_names(&known)),
        similar => did_you_mean(&similar),
    }
}

/// Writes ``did you mean `a` or `b`?``.
///
/// ```
/// use fabkit_text::did_you_mean;
///
/// assert_eq!(did_you_mean(&["shell"]), "did you mean `shell`?");
/// assert_eq!(did_you_mean(&["a", "b", "c"]), "did you mean `a`, `b` or `c`?");
/// ```
pub fn did_you_mean(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    format!("did you mean {}?", join_words(&quoted, "or"))
}

/// Joins words as `a, b or c`.
pub(crate) fn join_words(words: &[String], conjunction: &str) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} {conjunction} {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggests_misspelt_names_but_not_unrelated_ones() {
        let known = ["radius", "wall_height", "field_of_view"];
        assert_eq!(find_similar("raduis", known), ["radius"]);
        assert_eq!(find_similar("Wall-Height", known), ["wall_height"]);
        assert!(find_similar("pitch", known).is_empty());
        assert!(find_similar(&"r".repeat(1 << 20), known).is_empty());
        assert_eq!(
            suggest_or_list("pitch", known, "known"),
            "known: radius, wall_height, field_of_view"
        );
    }

    #[test]
    fn long_lists_end_with_the_number_of_the_others() {
        let names: Vec<String> = (10..40).map(|i| format!("screw-m{i}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let list = list_names(&names);
        assert!(list.starts_with("screw-m10, screw-m11, ") && list.ends_with(" more"), "{list}");
        assert!(list.len() < LIST_LENGTH + 20);
        assert_eq!(list_names(&names[..2]), "screw-m10, screw-m11");
    }
}
