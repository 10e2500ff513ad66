//! Resolution of `extends:`: a built-in sensor by its name, or another file of the user's.
//!
//! This crate reads no files. The caller passes the text of a sensor together with the texts of the files it extends.

use fabkit_text::{
    LocatedProblem, TextLayer, TextPlace, find_similar, read_mapping, suggestion, take_word,
    to_printable,
};

use super::{Registry, SENSOR};
use crate::user_catalogue::UserFile;

/// Maximum number of user files that one file extends, one through the other.
const MOST_FILES: usize = 16;

/// Text of a sensor's file, with the user's files that it extends.
#[derive(Clone, Copy, Debug)]
pub struct SensorText<'a> {
    /// Name of the file in messages.
    pub file: &'a str,
    /// YAML text of the file.
    pub yaml: &'a str,
    /// User files that it extends, directly or through others, each once.
    pub bases: &'a [BaseFile],
    /// User's file with settings for all sensors.
    pub user: Option<&'a UserFile>,
    /// Path of one value that is read as if the user had not set it, to see what it changes.
    pub omitted: Option<&'a str>,
}

impl<'a> SensorText<'a> {
    /// Creates the text of a file that extends no other file.
    pub fn without_bases(file: &'a str, yaml: &'a str) -> Self {
        Self { file, yaml, bases: &[], user: None, omitted: None }
    }
}

/// File that another one extends.
///
/// ```
/// use fabkit_designs::{BaseFile, SensorText, fixing::fix};
/// let base = BaseFile {
///     extending_file: "mine.yaml".into(),
///     word: "lab.yaml".into(),
///     file: "lab.yaml".into(),
///     text: "format: 1\nextends: rtac0\nname: lab\n".into(),
/// };
/// let yaml = "format: 1\nextends: lab.yaml\nname: mine\n";
/// let text = SensorText { bases: &[base], ..SensorText::without_bases("mine.yaml", yaml) };
/// // The two files together can be built: no value has to change.
/// assert_eq!(fix(text, &[], &["fixtures"])?, []);
/// # Ok::<(), fabkit_designs::parameters::InvalidDesign>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BaseFile {
    /// Extending file, by its name in messages.
    pub extending_file: String,
    /// Word behind `extends:` in the extending file.
    pub word: String,
    /// Name of the file in messages; the same however the file is referred to.
    pub file: String,
    /// YAML text of the file.
    pub text: String,
}

/// Reference from a sensor's file to the file it extends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BaseReference {
    /// Path relative to the folder of the extending file.
    pub word: String,
    /// Line of the reference, from 1.
    pub line: usize,
}

/// Finds the file that a sensor's file extends. Returns `None` if it extends a built-in sensor or nothing, or cannot be
/// read.
///
/// ```
/// use fabkit_designs::extended_file;
/// let base = extended_file("format: 1\nextends: ../lab.yaml\n").ok_or("no file")?;
/// assert_eq!((&*base.word, base.line), ("../lab.yaml", 2));
/// // A built-in sensor is no file.
/// assert!(extended_file("format: 1\nextends: rtac0\n").is_none());
/// # Ok::<(), &str>(())
/// ```
pub fn extended_file(yaml: &str) -> Option<BaseReference> {
    let place = TextPlace::new(TextLayer::File, "", &SENSOR);
    let mut found = Vec::new();
    let mut entries = read_mapping(yaml, &place, &mut found)?;
    let (word, at) = take_word(&mut entries, "extends", &place, &mut found)?;
    is_file(&word).then_some(BaseReference { line: at.position?.line, word })
}

/// Returns whether a word behind `extends:` is a path of a file.
fn is_file(word: &str) -> bool {
    let word = word.to_ascii_lowercase();
    word.ends_with(".yaml") || word.ends_with(".yml")
}

impl Registry {
    /// Returns text and place of the file named by `extends:` at a place in the last file of `above`, a chain in which
    /// each file extends the next; `None` after reporting why it is unavailable.
    pub(super) fn resolve_base<'a>(
        &self,
        word: &str,
        at: &TextPlace,
        above: &[&TextPlace],
        bases: &'a [BaseFile],
        found: &mut Vec<LocatedProblem>,
    ) -> Option<(&'a str, TextPlace)> {
        let mut refuse = |message: String, hint: String| {
            found.push(at.problem("extends", &to_printable(word), message).hint(hint));
        };
        // Formats the chain of files, such as `a.yaml -> b.yaml -> a.yaml`.
        let chain = |last: &str| {
            let files = above.iter().map(|place| &*place.file).chain([last]);
            files.collect::<Vec<_>>().join(" -> ")
        };
        let (text, file, layer) = if is_file(word) {
            let Some(base) = bases.iter().find(|b| b.extending_file == *at.file && b.word == word)
            else {
                let message =
                    format!("extends `{}`, a file that is not at hand here", to_printable(word));
                refuse(message, "load the sensor from its file, or extend a built-in one".into());
                return None;
            };
            // The sensor's own file counts too, so that `steps` is 1 for the first file it extends.
            let steps = above.iter().filter(|place| place.layer != TextLayer::Base).count();
            // A cycle is reported as such below, not as too many files.
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
            let message =
                format!("extends `{}`, which is not a built-in sensor", to_printable(word));
            let mut hint = suggestion(word, self.builtin_names(), "the built-in sensors are");
            if !hint.starts_with("did") {
                hint += "; a file of your own ends in .yaml";
            }
            let refused = at
                .problem("extends", &to_printable(word), message)
                .hint(hint)
                .code("unknown_sensor");
            found.push(match find_similar(word, self.builtin_names()).first() {
                Some(meant) => refused.suggest("extends", meant),
                None => refused,
            });
            return None;
        };
        if above.iter().any(|place| *place.file == *file) {
            let message =
                format!("extends `{}`, which extends itself: {}", to_printable(word), chain(&file));
            refuse(message, "extend another sensor in one of these files".into());
            return None;
        }
        Some((text, TextPlace::new(layer, &file, &SENSOR)))
    }
}
