//! Archives and messages of `fabkit export --all` and `--zip`.

use std::fs;
use std::path::PathBuf;

use fabkit_application::designs::Design;
use fabkit_application::exports::Exported;
use fabkit_application::packaging;
use fabkit_application::source::Target;
use fabkit_application::staging::write_each;
use serde_json::json;

use super::Outcome;
use crate::cli::Export;
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::FileRoles;
use crate::table::format_size;

/// Writes one archive of all folders. An existing file is replaced only by force, because nothing tells whose it is.
pub(super) fn write_archive(
    args: &Export,
    target: &Target,
    design: &Design,
    exports: Vec<(PathBuf, &Exported)>,
) -> Result<Outcome, Failure> {
    let Some(place) = &args.zip else { return Err(Failure::bug("no archive is asked for")) };
    let shown = place.display();
    FileRoles::default()
        .reads("SENSOR", target.files())
        .reads("--process", &args.process)
        .writes("--zip", [place])
        .check()?;
    if !args.force && fs::symlink_metadata(place).is_ok() {
        let hint = "choose another file, or let --force replace it";
        return Err(Failure::new(ErrorKind::BadInput, format!("{shown} is there already"), hint));
    }
    let name = &design.sensor.name;
    let within = |folder: PathBuf| {
        let below: String =
            folder.iter().map(|part| format!("/{}", part.to_string_lossy())).collect();
        format!("{name}{below}")
    };
    let files: usize = exports.iter().map(|(_, exported)| exported.files.len()).sum();
    let exports: Vec<(String, &Exported)> =
        exports.into_iter().map(|(folder, exported)| (within(folder), exported)).collect();
    let bytes = packaging::archive(&shown.to_string(), &exports)?;
    interrupt::begin_writing()?;
    write_each([(place.clone(), &bytes[..])], &interrupt::is_requested)?;
    let manifest = &exports[0].1.manifest;
    Ok(Outcome {
        text: format!("{shown}: {files} files, {}\n", format_size(bytes.len() as u64)),
        json: json!({
            "format": "fabkit-archive",
            "version": 1,
            "file": shown.to_string(),
            "bytes": bytes.len(),
            "blake3": packaging::hash_hex(&bytes),
            "files": files,
            "design_hash": manifest.design_hash,
        }),
        failed: false,
    })
}

/// Formats the warning about a package without a sensor file.
pub(super) fn missing_file_warning(design: &Design) -> String {
    let name = &design.sensor.name;
    format!(
        "warning: without {name}.yaml, because one text cannot say all of its parameters; the manifest lists \
         them, and you may add your own files\n"
    )
}
