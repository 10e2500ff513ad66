//! File-name words for materials. They are unique, so that a plate or sheet holds one material only.

use std::collections::{BTreeMap, BTreeSet};

/// Returns a unique word for each material, for use in file names: `black-pla`, `tough-resin-blue`. Materials that
/// differ only in punctuation are numbered in alphabetical order.
pub(super) fn material_words<'a>(
    materials: impl IntoIterator<Item = &'a str>,
) -> BTreeMap<&'a str, String> {
    // Alphabetical, so that the numbering does not depend on the order of the parts.
    let materials: BTreeSet<&str> = materials.into_iter().collect();
    let mut taken = BTreeSet::new();
    let word = |material| {
        let plain = match slug(material) {
            letters if letters.is_empty() => "other".to_owned(),
            letters => letters,
        };
        let numbered = (2..).map(|i| format!("{plain}-no{i}"));
        let free = std::iter::once(plain.clone()).chain(numbered).find(|w| !taken.contains(w));
        let word = free.unwrap_or(plain);
        taken.insert(word.clone());
        (material, word)
    };
    materials.into_iter().map(word).collect()
}

/// Reduces a name to lower-case letters, digits and single hyphens.
fn slug(material: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { ' ' };
    let words: String = material.chars().map(plain).collect();
    words.split_ascii_whitespace().collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_material_has_a_word_of_its_own() {
        let materials = ["PLA, black", "black PLA", "PLA black", "PLA (black)", "樹脂", "レジン"];
        let words = material_words(materials);
        assert_eq!(words["black PLA"], "black-pla");
        let of_pla = ["PLA (black)", "PLA black", "PLA, black"].map(|name| words[name].as_str());
        assert_eq!(of_pla, ["pla-black", "pla-black-no2", "pla-black-no3"]);
        assert_eq!(words.values().collect::<BTreeSet<_>>().len(), materials.len());
        assert_eq!(slug("acrylic, frosted on both sides"), "acrylic-frosted-on-both-sides");
    }
}
