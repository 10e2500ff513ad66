//! `SENSOR` and `SENSOR/PART`: where a design's text comes from.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use fabkit::bodies::UnknownName;
use fabkit::designs::{self, Design};

use crate::diagnostics::SourceText;
use crate::failure::{Exit, Failure};

/// Longest sensor file.
pub const MAX_YAML_BYTES: u64 = 1 << 20;

/// Splits `SENSOR/PART`. Paths have slashes too: a name that is a file, or looks like one, is a
/// path as a whole.
pub fn split_part(sensor: &str) -> (&str, Option<&str>) {
    if is_path(sensor) {
        return (sensor, None);
    }
    match sensor.rsplit_once('/') {
        Some((sensor, part)) if !sensor.is_empty() => (sensor, Some(part)),
        _ => (sensor, None),
    }
}

fn is_path(sensor: &str) -> bool {
    let path = Path::new(sensor);
    let yaml = path.extension().is_some_and(|e| e == "yaml" || e == "yml");
    yaml || (sensor.contains('/') && path.exists() && !path.is_dir())
}

/// Reads and builds a design with its overrides.
///
/// # Errors
/// Unknown names, unreadable or oversized files, and all problems of the design.
pub fn load(sensor: &str, overrides: &[String]) -> Result<Design, Failure> {
    let builtins = designs::builtin_names().into_iter().filter_map(builtin);
    let (source, others): (SourceText, Vec<SourceText>) = if is_path(sensor) {
        // It may extend a built-in sensor, and problems may lie there.
        (
            SourceText { file: sensor.into(), text: read_yaml(Path::new(sensor))? },
            builtins.collect(),
        )
    } else if let Some(source) = builtin(sensor) {
        (source, Vec::new())
    } else {
        let unknown = UnknownName::new("sensor", sensor, designs::builtin_names());
        let hint = format!("{}; a file of your own ends in .yaml", unknown.hint());
        return Err(Failure::new(Exit::BadInput, unknown, hint));
    };
    designs::load(&source.file, &source.text, overrides).map_err(|invalid| {
        Failure::Design(invalid, std::iter::once(source).chain(others).collect())
    })
}

/// The text of a built-in sensor, named as the designs crate names it in messages.
fn builtin(name: &str) -> Option<SourceText> {
    let text = designs::builtin_yaml(name)?;
    Some(SourceText { file: format!("{name}.yaml (built-in)"), text: text.into() })
}

/// Refuses what is too large or no file before reading it: a pipe may never end.
fn read_yaml(path: &Path) -> Result<String, Failure> {
    let shown = path.display();
    let unreadable = |error: io::Error| {
        let exit = match error.kind() {
            io::ErrorKind::NotFound => Exit::BadInput,
            _ => Exit::Io,
        };
        Failure::plain(exit, format!("cannot read {shown}: {error}"))
    };
    let too_large = |found: &str| {
        Failure::new(
            Exit::Limit,
            format!("{shown} has {found} bytes; a sensor's file has at most {MAX_YAML_BYTES}"),
            "is it the right file? `fabkit show rtac0` shows what one holds",
        )
    };
    let found = fs::metadata(path).map_err(unreadable)?;
    if !found.is_file() {
        let what = if found.is_dir() { "a folder" } else { "a device or a pipe" };
        return Err(Failure::plain(Exit::BadInput, format!("{shown} is {what}, not a file")));
    }
    if found.len() > MAX_YAML_BYTES {
        return Err(too_large(&found.len().to_string()));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    // It may have grown since.
    file.take(MAX_YAML_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_YAML_BYTES {
        return Err(too_large("too many"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid].iter().filter(|b| **b == b'\n').count();
        let message = format!("{shown}:{line}: not UTF-8 text (byte {})", valid + 1);
        Failure::new(Exit::BadInput, message, "save the file as UTF-8")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_follows_a_name_or_a_path() {
        assert_eq!(split_part("rtac0"), ("rtac0", None));
        assert_eq!(split_part("rtac0/shell"), ("rtac0", Some("shell")));
        assert_eq!(split_part("a/b/my.yaml"), ("a/b/my.yaml", None));
        assert_eq!(split_part("a/b/my.yaml/shell"), ("a/b/my.yaml", Some("shell")));
        assert_eq!(split_part("./my.yml/shell"), ("./my.yml", Some("shell")));
        assert_eq!(split_part("/shell"), ("/shell", None));
    }
}
