//! What a file extends: a built-in sensor by its name, or another file of the user's.
//!
//! This crate reads no files. Whoever does hands over, beside a sensor's text, those that it extends.

use fabkit_text::{Found, Place, TextLayer, mapping_of, shown, similar, suggestion, take_word};

use super::{Registry, SENSOR};
use crate::own::UserFile;

/// How many files of the user's one file extends at most, one through the other.
const MOST_FILES: usize = 16;

/// A sensor's file, with the user's files that it extends.
#[derive(Clone, Copy, Debug)]
pub struct SensorText<'a> {
    /// What messages call it.
    pub file: &'a str,
    /// What it says.
    pub yaml: &'a str,
    /// What it extends and what these extend, each once, as far as they are files.
    pub bases: &'a [BaseFile],
    /// What the user keeps for all sensors.
    pub user: Option<&'a UserFile>,
}

impl<'a> SensorText<'a> {
    /// A file that extends no other file.
    pub fn alone(file: &'a str, yaml: &'a str) -> Self {
        Self { file, yaml, bases: &[], user: None }
    }
}

/// A file that another one extends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BaseFile {
    /// The file that extends it, as messages call that one.
    pub by: String,
    /// What stands behind `extends:` there.
    pub word: String,
    /// What messages call it; the same wherever the same file is meant.
    pub file: String,
    /// What it says.
    pub text: String,
}

/// Which file a sensor's file extends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extends {
    /// A path, relative to the folder of the file that names it.
    pub word: String,
    /// The line that names it, from 1.
    pub line: usize,
}

/// The file that a sensor's file extends; nothing if it extends a built-in sensor, or none, or cannot
/// be read.
pub fn extended_file(yaml: &str) -> Option<Extends> {
    let place = Place::new(TextLayer::File, "", &SENSOR);
    let mut found = Vec::new();
    let mut entries = mapping_of(yaml, &place, &mut found)?;
    let (word, at) = take_word(&mut entries, "extends", &place, &mut found)?;
    is_file(&word).then_some(Extends { line: at.position?.line, word })
}

fn is_file(word: &str) -> bool {
    let word = word.to_ascii_lowercase();
    word.ends_with(".yaml") || word.ends_with(".yml")
}

impl Registry {
    /// Text and place of what stands behind `extends:` at a place in the last file of `above`, which
    /// extend each other; `None` after reporting why it cannot be had.
    pub(super) fn extended<'a>(
        &self,
        word: &str,
        at: &Place,
        above: &[&Place],
        bases: &'a [BaseFile],
        found: &mut Vec<Found>,
    ) -> Option<(&'a str, Place)> {
        let mut refuse = |message: String, hint: String| {
            found.push(at.problem("extends", &shown(word), message).hint(hint));
        };
        // `a.yaml -> b.yaml -> a.yaml`
        let chain = |last: &str| {
            let files = above.iter().map(|place| &*place.file).chain([last]);
            files.collect::<Vec<_>>().join(" -> ")
        };
        let (text, file, layer) = if is_file(word) {
            let Some(base) = bases.iter().find(|b| b.by == *at.file && b.word == word) else {
                let message = format!("extends `{}`, a file that is not at hand here", shown(word));
                refuse(message, "load the sensor from its file, or extend a built-in one".into());
                return None;
            };
            let steps = above.iter().filter(|place| place.layer != TextLayer::Base).count();
            if steps > MOST_FILES && above.iter().all(|place| *place.file != *base.file) {
                let message = format!(
                    "more than {MOST_FILES} files extend each other: {}",
                    chain(&base.file)
                );
                let hint = format!("put some of them together: at most {MOST_FILES} may");
                refuse(message, hint);
                return None;
            }
            let steps = u8::try_from(steps).unwrap_or(u8::MAX);
            (&*base.text, base.file.clone(), TextLayer::Extended(steps))
        } else if let Some(text) = self.builtin_yaml(word) {
            (text, format!("{word}.yaml (built-in)"), TextLayer::Base)
        } else {
            let message = format!("extends `{}`, which is not a built-in sensor", shown(word));
            let mut hint = suggestion(word, self.builtin_names(), "the built-in sensors are");
            if !hint.starts_with("did") {
                hint += "; a file of your own ends in .yaml";
            }
            let refused =
                at.problem("extends", &shown(word), message).hint(hint).code("unknown_sensor");
            found.push(match similar(word, self.builtin_names()).first() {
                Some(meant) => refused.suggest("extends", meant),
                None => refused,
            });
            return None;
        };
        if above.iter().any(|place| *place.file == *file) {
            let message =
                format!("extends `{}`, which extends itself: {}", shown(word), chain(&file));
            refuse(message, "extend another sensor in one of these files".into());
            return None;
        }
        Some((text, Place::new(layer, &file, &SENSOR)))
    }
}
