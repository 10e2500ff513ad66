//! Suggestions of the form "did you mean ...?".

/// Minimum similarity of two words (normalized Damerau-Levenshtein, 0 to 1) for a suggestion. At 0.6 a swap of
/// neighbouring letters still counts (`raduis`), unrelated words of the same length do not.
const LIKENESS: f64 = 0.6;

/// Maximum number of suggestions.
const MOST: usize = 3;

/// Returns the known names that are similar to `written`, best first.
pub fn similar<'a>(written: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    similar_of(written, known.into_iter().collect())
}

/// Same as [`similar`], without type parameters, so that it is compiled once.
fn similar_of<'a>(written: &str, known: Vec<&'a str>) -> Vec<&'a str> {
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
        .filter(|(score, _)| *score >= LIKENESS)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    scored.into_iter().take(MOST).map(|(_, name)| name).collect()
}

/// Writes `did you mean ...?`, or lists all known names if none is similar.
pub fn hint<'a>(written: &str, known: impl IntoIterator<Item = &'a str>, what: &str) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let list = || format!("{what}: {}", known.join(", "));
    match similar_of(written, known.clone()) {
        similar if similar.is_empty() => list(),
        similar => did_you_mean(&similar),
    }
}

/// Writes ``did you mean `a` or `b`?``.
pub fn did_you_mean(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    format!("did you mean {}?", either(&quoted, "or"))
}

/// Joins words as `a, b or c`.
pub(crate) fn either(words: &[String], conjunction: &str) -> String {
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
    fn suggests_slips_but_not_strangers() {
        let known = ["radius", "wall_height", "field_of_view"];
        assert_eq!(similar("raduis", known), ["radius"]);
        assert_eq!(similar("Wall-Height", known), ["wall_height"]);
        assert!(similar("pitch", known).is_empty());
        assert!(similar(&"r".repeat(1 << 20), known).is_empty());
        assert_eq!(hint("pitch", known, "known"), "known: radius, wall_height, field_of_view");
    }
}
