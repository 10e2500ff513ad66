//! `fabkit guide SENSOR[/FIXTURE] -o DIR`

use fabkit_application::progress::ProgressStep;
use fabkit_application::source::Target;
use fabkit_application::staging::{OutputFile, write_all};
use fabkit_application::{guides, slicing};
use serde_json::json;

use super::progress::Progress;
use super::{Outcome, typed};
use crate::cli::{Global, Guide};
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::FileRoles;
use crate::table::format_count;

pub(super) fn run(args: &Guide, global: &Global) -> Result<Outcome, Failure> {
    let target = Target::new(&args.design.sensor).with_preset(args.design.preset.as_deref());
    if let Some(part) = target.part {
        let message = format!("a guide is of a whole sensor or fixture, not of its {part}");
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    let outputs = guides::FILES.map(|name| args.output.join(name));
    FileRoles::default().reads("SENSOR", target.files()).writes("-o", &outputs).check()?;
    let project = target.project(&args.design.set)?;
    let design = target.design(&args.design.set)?;
    let slicer = args.slice.then(slicing::find_slicer).transpose()?;
    let lines = |names: &[&str], pins_in: Option<&str>| {
        typed::calibration_commands(names, pins_in, target, &args.design.set)
    };
    let calibration = guides::describe_calibration(&project, target, &lines);
    let progress = Progress::new(global, format!("drawing {}", args.design.sensor));
    let stages = guides::find_stages(&design).map_err(Failure::bug)?;
    let faults = target.find_errors(&args.design.set, false)?.map_err(Failure::bug)?;
    let calibration = calibration.as_ref();
    let mut guide = guides::collect_facts(&design, &stages, calibration, args.units, &faults)
        .map_err(Failure::bug)?;
    if let Some(slicer) = slicer {
        let show = |step: ProgressStep| progress.show(step);
        slicing::slice_parts(&design, &mut guide, &slicer, &interrupt::poll_interrupt, &show)?;
        // The slicer's processes and temporary files are gone, so an interrupt may end the process at once again.
        interrupt::finish_watching()?;
    }
    let files = guides::files(&design, &stages, &guide, &|step: ProgressStep| progress.show(step))?;
    drop(progress);
    interrupt::begin_writing()?;
    write_all(&args.output, &files, &interrupt::is_requested)?;
    let folder = args.output.display();
    let made: u32 = guide.made.iter().map(|part| part.quantity).sum();
    let bought: u32 = guide.bought.iter().map(|piece| piece.quantity).sum();
    let mut json = guide.to_json();
    json["folder"] = json!(folder.to_string());
    let file = |file: &OutputFile| json!({ "file": file.name, "bytes": file.bytes.len() });
    json["files"] = files.iter().map(file).collect();
    let warning = faults.to_sentence().map(|sentence| format!("warning: {sentence}\n"));
    Ok(Outcome {
        text: format!(
            "{}{folder}: {}; open {}\n{} to make, {} to buy, {}, {}{}\n",
            warning.unwrap_or_default(),
            format_count(files.len(), "file"),
            outputs[0].display(),
            format_count(made as usize, "part"),
            format_count(bought as usize, "piece"),
            format_count(guide.mixes.len(), "mix"),
            format_count(guide.steps.len(), "step"),
            if guide.timeline.days == 0 {
                String::new()
            } else {
                format!(" in {}", format_count(guide.timeline.days as usize, "day"))
            },
        ),
        json,
        failed: false,
    })
}
