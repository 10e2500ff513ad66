//! Files that a user keeps beside sensors: materials and processes, and printer profiles.

use std::path::Path;

use fabkit_designs::UserFile;
use fabkit_designs::profile::ProcessProfile;
use fabkit_files::Error;
use fabkit_files::diagnostics::{DiagnosedDesign, SourceText};
use fabkit_files::reading::{self, ExpectedFile, MAX_YAML_BYTES};

/// Environment variable with the path of the user's file of materials and processes for all sensors.
pub const USER_FILE_VARIABLE: &str = "FABKIT_MATERIALS";

/// Reads the user's file, if the environment names one.
///
/// # Errors
/// A file that cannot be read. Problems in it are reported with the sensor's.
pub fn user_file() -> Result<Option<UserFile>, Error> {
    let Some(name) = std::env::var_os(USER_FILE_VARIABLE).filter(|name| !name.is_empty()) else {
        return Ok(None);
    };
    let path = Path::new(&name);
    let hint = "FABKIT_MATERIALS names a file with `materials:` and `processes:`";
    let expected = ExpectedFile { what: "a file of materials", max_bytes: MAX_YAML_BYTES, hint };
    let text = reading::read_text(path, expected)?;
    Ok(Some(UserFile { file: path.display().to_string(), text }))
}

/// Reads a printer profile.
///
/// # Errors
/// A file that cannot be read, and all problems of the profile.
pub fn read_profile(path: &Path) -> Result<ProcessProfile, Error> {
    let hint = "is it the right file? `fabkit profile` writes one";
    let expected = ExpectedFile { what: "a printer's profile", max_bytes: MAX_YAML_BYTES, hint };
    let (file, text) = (path.display().to_string(), reading::read_text(path, expected)?);
    ProcessProfile::read(&file, &text)
        .map_err(|invalid| DiagnosedDesign::new(invalid, [SourceText { file, text }]).into())
}
