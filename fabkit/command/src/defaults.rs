//! Defaults file `fabkit.yaml` in the working folder: settings for options that are not given.

use std::path::{Path, PathBuf};

use fabkit_application::diagnostics::{DiagnosedDesign, SourceText};
use fabkit_application::reading::{self, ExpectedFile};
use fabkit_application::source::MAX_YAML_BYTES;
use fabkit_application::text::{
    Dialect, NodeReader, TextLayer, TextPlace, YamlEntry, read_mapping, suggestion, take_format,
    to_printable,
};

use crate::cli;
use crate::failure::Failure;

/// Name of the defaults file.
pub(crate) const FILE: &str = "fabkit.yaml";

/// Keys of the file, with the option that each stands for, and an example.
const DEFAULT_KEYS: [(&str, &str, &str); 6] = [
    ("bed", "--bed", "prusa-mk4"),
    ("stock", "--stock", "600x300mm"),
    ("profile", "--process", "my-printer.yaml"),
    ("tolerance", "--tolerance", "0.01 mm"),
    ("kerf", "--kerf", "0.15 mm"),
    ("output", "-o", "out"),
];

const DEFAULTS: Dialect = Dialect::new("file of defaults", 1, "");

/// Content of the defaults file.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Defaults {
    /// Width and depth of the printer's bed, mm.
    pub(crate) bed_mm: Option<[f64; 2]>,
    /// Width and depth of stock sheets, mm.
    pub(crate) stock_mm: Option<[f64; 2]>,
    /// Path of the printer's profile.
    pub(crate) profile: Option<PathBuf>,
    /// Largest distance between triangles and the exact surface, mm.
    pub(crate) tolerance_mm: Option<f64>,
    /// Kerf of the laser, mm.
    pub(crate) kerf_mm: Option<f64>,
    /// Folder in which folders of exports are made.
    pub(crate) output: Option<PathBuf>,
}

impl Defaults {
    /// Reads the defaults file of the working folder; without a file, nothing is set.
    ///
    /// # Errors
    /// A file that cannot be read, and all problems in it, with their lines.
    pub(crate) fn read() -> Result<Self, Failure> {
        let path = Path::new(FILE);
        if std::fs::symlink_metadata(path).is_err() {
            return Ok(Self::default());
        }
        let hint = "it holds defaults of options of `fabkit export`, and nothing else";
        let expected = ExpectedFile { what: "a file of defaults", max_bytes: MAX_YAML_BYTES, hint };
        Self::from_yaml(&reading::read_text(path, expected)?)
    }

    fn from_yaml(text: &str) -> Result<Self, Failure> {
        let mut reading = NodeReader::new(TextPlace::new(TextLayer::File, FILE, &DEFAULTS));
        let mut defaults = Self::default();
        let NodeReader { place, found } = &mut reading;
        if let Some(mut entries) = read_mapping(text, place, found) {
            take_format(&mut entries, place, found);
            entries.iter().for_each(|entry| defaults.read_entry(&mut reading, entry));
        }
        reading.finish(Some(defaults)).map_err(|invalid| {
            DiagnosedDesign::new(invalid, [SourceText { file: FILE.into(), text: text.into() }])
                .into()
        })
    }

    fn read_entry(
        &mut self,
        reading: &mut NodeReader,
        YamlEntry { key, key_position, value }: &YamlEntry,
    ) {
        let Some((_, option, example)) = DEFAULT_KEYS.iter().find(|(known, ..)| known == key)
        else {
            let message = format!("`{}` is not a key of a file of defaults", to_printable(key));
            let hint = suggestion(key, DEFAULT_KEYS.map(|(known, ..)| known), "the keys are");
            return reading.report_problem(*key_position, key, key, message, hint);
        };
        let Some(text) = reading.read_scalar(key, value) else { return };
        let read = match key.as_str() {
            "bed" => cli::bed(text).map(|size| self.bed_mm = Some(size)),
            "stock" => cli::bed(text).map(|size| self.stock_mm = Some(size)),
            "tolerance" => cli::tolerance(text).map(|mm| self.tolerance_mm = Some(mm)),
            "kerf" => cli::kerf(text).map(|mm| self.kerf_mm = Some(mm)),
            _ if text.is_empty() => Err("nothing is written there".into()),
            "profile" => {
                self.profile = Some(text.into());
                Ok(())
            }
            _ => {
                self.output = Some(text.into());
                Ok(())
            }
        };
        if let Err(why) = read {
            let message = format!("{key} is `{}`: {why}", to_printable(text));
            let hint = format!("write it as behind {option}, for example `{key}: {example}`");
            reading.report_problem(value.position, key, text, message, hint);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_read_and_its_example_is_one() {
        let lines = DEFAULT_KEYS.map(|(key, _, example)| format!("{key}: {example}\n")).concat();
        let read = Defaults::from_yaml(&format!("format: 1\n{lines}")).unwrap();
        let expected = Defaults {
            bed_mm: Some([250.0, 210.0]),
            stock_mm: Some([600.0, 300.0]),
            profile: Some("my-printer.yaml".into()),
            tolerance_mm: Some(0.01),
            kerf_mm: Some(0.15),
            output: Some("out".into()),
        };
        assert_eq!(read, expected);
    }
}
