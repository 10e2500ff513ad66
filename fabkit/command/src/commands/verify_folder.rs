//! `fabkit verify DIR`

use std::path::Path;

use fabkit_application::verify_folder::{self, DifferenceKind, FileDifference, VerifiedFolder};
use serde_json::{Value, json};

use super::Outcome;
use crate::cli::Verify;
use crate::failure::{ErrorKind, Failure};
use crate::table::{format_size, group_digits};

pub(super) fn run(args: &Verify, folder: &Path) -> Result<Outcome, Failure> {
    let for_sensors = [
        ("--set", !args.set.is_empty()),
        ("--part", !args.parts.is_empty()),
        ("--kernel", !args.kernels.is_empty()),
        ("--limit", args.limit.is_some()),
        ("--report", args.report.is_some()),
        ("--keep", args.keep.is_some()),
    ];
    let given: Vec<&str> =
        for_sensors.iter().filter(|(_, is_given)| *is_given).map(|(option, _)| *option).collect();
    if !given.is_empty() {
        let shown = folder.display();
        let message =
            format!("{shown} is a folder, and {} only goes with a sensor", given.join(", "));
        let hint = format!("write `fabkit verify {shown}` to read the folder again");
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    let all = verify_folder::verify_folder(folder)?;
    let failed = !all.iter().all(VerifiedFolder::passed);
    let json = json!({
        "format": "fabkit-reread",
        "version": 1,
        "passed": !failed,
        "folders": all.iter().map(json_of).collect::<Vec<_>>(),
    });
    Ok(Outcome { text: all.iter().map(text_of).collect(), json, failed })
}

fn json_of(reread: &VerifiedFolder) -> Value {
    let findings = reread.findings.iter().map(
        |FileDifference { file, what, why }| json!({ "file": file, "what": what.word(), "why": why }),
    );
    json!({
        "folder": reread.folder.display().to_string(),
        "what": reread.what,
        "passed": reread.passed(),
        "files": reread.files,
        "bytes": reread.bytes,
        "findings": findings.collect::<Vec<_>>(),
        "more_foreign": reread.more_foreign,
        "note": reread.note,
    })
}

fn text_of(reread: &VerifiedFolder) -> String {
    let folder = reread.folder.display();
    let mut text = String::new();
    for FileDifference { file, what, why } in &reread.findings {
        // File names may contain control characters, which must not reach the terminal.
        let file: String = file.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        text += &format!("{}  {file}: {why}\n", what.word());
    }
    if reread.more_foreign > 0 {
        text += &format!("and {} more foreign files\n", reread.more_foreign);
    }
    if let Some(note) = reread.note {
        text += &format!("warning: {note}\n");
    }
    let count = |wanted: DifferenceKind| {
        reread.findings.iter().filter(|found| found.what == wanted).count()
    };
    let wrong = [
        (DifferenceKind::Damaged, count(DifferenceKind::Damaged)),
        (DifferenceKind::Missing, count(DifferenceKind::Missing)),
        (DifferenceKind::Foreign, count(DifferenceKind::Foreign) + reread.more_foreign),
    ];
    let wrong: Vec<String> = wrong
        .iter()
        .filter(|(_, count)| *count > 0)
        .map(|(what, count)| format!("{count} {}", what.word()))
        .collect();
    let (what, files) = (reread.what, group_digits(reread.files as u64));
    text + &if reread.passed() {
        format!("{folder}: {what}, {files} files, {}, all as written\n", format_size(reread.bytes))
    } else {
        format!("{folder}: {what}, {files} files listed; {}\n", wrong.join(", "))
    }
}
