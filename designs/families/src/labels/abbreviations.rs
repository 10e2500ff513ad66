//! Texts for labels: the names of parts, and abbreviations for small faces.

/// Returns the texts that may be written on a part, best first: its name, its words shortened, their initials.
///
/// An abbreviation is left out if it could also stand for another one of `names`.
pub(super) fn label_texts(name: &str, names: &[String]) -> Vec<String> {
    let others = || names.iter().filter(|other| *other != name);
    let is_own = |text: &String, make: &dyn Fn(&str) -> String| {
        !others().any(|other| make(other) == *text || other == text)
    };
    let shorter: [&dyn Fn(&str) -> String; 3] =
        [&|name| shorten_words(name, 3), &|name| initials(name), &|name| {
            distinguishing_initials(name, names)
        }];
    let mut texts = vec![name.to_owned()];
    for make in shorter {
        let text = make(name);
        let last = texts.last().map_or(0, String::len);
        if is_own(&text, make) && text.len() >= 2 && text.len() < last {
            texts.push(text);
        }
    }
    texts
}

/// Returns the first letters of a word; numbers stay whole.
fn short(word: &str, letters: usize) -> String {
    match word.parse::<u32>() {
        Ok(_) => word.to_owned(),
        Err(_) => word.chars().take(letters).collect(),
    }
}

/// Shortens every word to a number of letters.
fn shorten_words(name: &str, letters: usize) -> String {
    let words: Vec<String> = name.split('-').map(|word| short(word, letters)).collect();
    words.join("-")
}

/// Returns the first letters of all words, or the first two of a single word.
fn initials(name: &str) -> String {
    let letters = if name.contains('-') { 1 } else { 2 };
    name.split('-').map(|word| short(word, letters)).collect()
}

/// Returns the initials, each followed by the first letter that distinguishes its word from those of other names with
/// the same initials.
fn distinguishing_initials(name: &str, names: &[String]) -> String {
    let own: Vec<&str> = name.split('-').collect();
    let is_alike = |other: &&String| *other != name && initials(other) == initials(name);
    let alike: Vec<Vec<&str>> =
        names.iter().filter(is_alike).map(|other| other.split('-').collect()).collect();
    let letters = own.iter().enumerate().map(|(i, word)| {
        let beside = alike.iter().filter_map(|other| other.get(i)).filter(|other| *other != word);
        let beside: Vec<&str> = beside.copied().collect();
        let differs = |at: &usize| {
            let letter = word.as_bytes().get(*at);
            beside.iter().all(|other| other.as_bytes().get(*at) != letter)
        };
        // From the second letter on: the first one is written anyway.
        let told = (1..word.len()).filter(|_| !beside.is_empty()).find(differs);
        let told = told.and_then(|at| word.get(at..=at)).unwrap_or_default();
        let first = short(word, 1);
        if first.len() > 1 { first } else { first + told }
    });
    letters.collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn short_texts_tell_parts_apart() {
        let names = [
            "mold-transparent-gel-a",
            "mold-transparent-gel-b",
            "mold-translucent-gel-a",
            "mold-translucent-gel-b",
            "lid-transparent-gel",
            "lid-translucent-gel",
            "base",
            "bar",
            "pin-12",
            "pin-13",
        ]
        .map(str::to_owned);
        let mut shortest = BTreeSet::new();
        for name in &names {
            let texts = label_texts(name, &names);
            assert_eq!(&texts[0], name);
            let last = texts.last().unwrap();
            assert!(last.len() >= 2 && last.len() <= name.len(), "{texts:?}");
            assert!(shortest.insert(last.clone()), "{name}: {last}");
        }
        assert_eq!(label_texts("base", &names).last().unwrap(), "bs");
        assert_eq!(label_texts("pin-12", &names).last().unwrap(), "p12");
        assert_eq!(label_texts("mold-translucent-gel-b", &names).last().unwrap(), "mtlgb");
    }
}
