//! `fabkit verify DIR`

use std::path::Path;

use fabkit_application::rereading::{self, FolderFinding, Reread, What};
use serde_json::{Value, json};

use super::Outcome;
use crate::cli::Verify;
use crate::failure::{ErrorKind, Failure};
use crate::table::{grouped, size};

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
    let all = rereading::reread(folder)?;
    let failed = !all.iter().all(Reread::passed);
    let json = json!({
        "format": "fabkit-reread",
        "version": 1,
        "passed": !failed,
        "folders": all.iter().map(json_of).collect::<Vec<_>>(),
    });
    Ok(Outcome { text: all.iter().map(text_of).collect(), json, failed })
}

fn json_of(reread: &Reread) -> Value {
    let findings = reread.findings.iter().map(
        |FolderFinding { file, what, why }| json!({ "file": file, "what": what.word(), "why": why }),
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

fn text_of(reread: &Reread) -> String {
    let folder = reread.folder.display();
    let mut text = String::new();
    for FolderFinding { file, what, why } in &reread.findings {
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
    let count = |wanted: What| reread.findings.iter().filter(|found| found.what == wanted).count();
    let wrong = [
        (What::Damaged, count(What::Damaged)),
        (What::Missing, count(What::Missing)),
        (What::Foreign, count(What::Foreign) + reread.more_foreign),
    ];
    let wrong: Vec<String> = wrong
        .iter()
        .filter(|(_, count)| *count > 0)
        .map(|(what, count)| format!("{count} {}", what.word()))
        .collect();
    let (what, files) = (reread.what, grouped(reread.files as u64));
    text + &if reread.passed() {
        format!("{folder}: {what}, {files} files, {}, all as written\n", size(reread.bytes))
    } else {
        format!("{folder}: {what}, {files} files listed; {}\n", wrong.join(", "))
    }
}
