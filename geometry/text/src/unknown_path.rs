//! Guesses for a path that no parameter has.

use crate::find_similar;

/// Finds up to three known paths that may be meant: the same or a similar section with a similar last word; otherwise
/// the same last word elsewhere. Returns nothing for far-fetched matches.
pub(crate) fn find_similar_paths<'a>(path: &str, known: &'a [String]) -> Vec<&'a str> {
    /// Maximum number of suggestions.
    const MAX_SUGGESTIONS: usize = 3;
    let (section, word) = path.rsplit_once('.').unwrap_or(("", path));
    // A path below a value, such as `surface.radius.value`.
    if let Some(above) = known.iter().find(|known| *known == section) {
        return vec![above];
    }
    let sections: Vec<&str> = known.iter().map(|path| split_section(path).0).collect();
    let section = if sections.contains(&section) {
        Some(section)
    } else {
        find_similar(section, sections).first().copied()
    };
    if let Some(section) = section.filter(|section| !section.is_empty()) {
        let of_section = || known.iter().filter(|path| split_section(path).0 == section);
        let words = find_similar(word, of_section().map(|path| split_section(path).1));
        let is_near = |path: &&String| words.contains(&split_section(path).1);
        let mut near: Vec<&str> = of_section().filter(is_near).map(String::as_str).collect();
        near.sort_by_key(|path| words.iter().position(|word| *word == split_section(path).1));
        if !near.is_empty() {
            return near;
        }
    }
    // Fixtures have a `count` and a `depth` of nearly everything.
    let is_fixture = |path: &str| path.starts_with("fixtures.");
    let is_same =
        |other: &&str| split_section(other).1 == word && is_fixture(other) == is_fixture(path);
    let same: Vec<&str> =
        known.iter().map(String::as_str).filter(is_same).take(MAX_SUGGESTIONS).collect();
    if !same.is_empty() || path.contains('.') {
        return same;
    }
    // A word without a section may be a section's or a parameter's.
    match find_similar(word, known.iter().map(|path| split_section(path).1)).first() {
        Some(best) => {
            let is_best = |path: &&str| split_section(path).1 == *best;
            known.iter().map(String::as_str).filter(is_best).take(MAX_SUGGESTIONS).collect()
        }
        None => Vec::new(),
    }
}

/// Describes what exists instead of a path that resembles nothing: why there is no such parameter, and the keys of its
/// section.
pub(crate) fn describe_alternatives(
    path: &str,
    known: &[String],
    absent: &[(&str, &str)],
) -> String {
    let (section, word) = split_section(path);
    let why = absent.iter().find(|(name, _)| *name == word || *name == path);
    let why = why.map(|(_, why)| format!(": {why}")).unwrap_or_default();
    let of_section: Vec<&str> = known
        .iter()
        .filter(|path| !section.is_empty() && split_section(path).0 == section)
        .map(|path| split_section(path).1)
        .collect();
    if of_section.is_empty() {
        format!("fabkit has no such parameter{why}; `fabkit show` lists every parameter")
    } else {
        format!(
            "fabkit has no such parameter{why}; those of {section} are {}",
            of_section.join(", ")
        )
    }
}

/// Splits a path into section and last word.
fn split_section(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or(("", path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_paths_are_found_and_unknown_ones_get_a_list() {
        let known = ["base.height", "base.mount_radius", "camera.depth", "surface.radius"];
        let known = known.map(str::to_owned);
        assert_eq!(find_similar_paths("surface.raduis", &known), ["surface.radius"]);
        assert_eq!(find_similar_paths("surfce.radius", &known), ["surface.radius"]);
        assert_eq!(find_similar_paths("raduis", &known), ["surface.radius"]);
        assert_eq!(find_similar_paths("shell.depth", &known), ["camera.depth"]);
        for stranger in ["base.flange", "camera.focal_length", "base.weight_limit", "infill"] {
            assert!(find_similar_paths(stranger, &known).is_empty(), "{stranger}");
        }
        let absent = [("flange", "it is screwed on")];
        assert_eq!(
            describe_alternatives("base.flange", &known, &absent),
            "fabkit has no such parameter: it is screwed on; those of base are height, mount_radius"
        );
    }
}
