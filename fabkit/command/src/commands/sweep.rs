//! `fabkit sweep FILE.yaml -o DIR`

use std::path::Path;
use std::time::Instant;

use fabkit_application::documents;
use fabkit_application::progress::ProgressStep;
use fabkit_application::sweep::Status;
use fabkit_application::sweep_runs::{self, SweepResult};

use super::Outcome;
use super::progress::Progress;
use crate::cli::{Global, Sweep};
use crate::failure::Failure;
use crate::interrupt;
use crate::table::group_digits;

pub(super) fn run(args: &Sweep, global: &Global) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let plan = sweep_runs::read_plan(&args.plan, &[])?;
    interrupt::begin_writing()?;
    let progress = Progress::new(global, "computing variants");
    let show = |step: ProgressStep| progress.show(step);
    let sweep = sweep_runs::Sweep { plan: &plan, resume: args.resume, python: None };
    let finished = sweep_runs::run(&args.output, sweep, &show, &interrupt::is_requested);
    drop(progress);
    Ok(report(&args.output, &finished?, start))
}

fn report(folder: &Path, finished: &SweepResult, start: Instant) -> Outcome {
    let SweepResult { variants, found, counts, panicked, on_front, none_left, empty_metrics } =
        finished;
    let folder = folder.display().to_string();
    let seconds = start.elapsed().as_secs_f64();
    let became: Vec<String> = Status::ALL
        .iter()
        .zip(counts)
        .filter(|(_, count)| **count > 0)
        .map(|(status, count)| format!("{} {}", group_digits(*count as u64), status.word()))
        .collect();
    let mut text = format!(
        "{folder}: {} variants: {}{} ({seconds:.1} s, {:.1} variants/s)\n",
        group_digits(*variants as u64),
        became.join(", "),
        if *found > 0 { format!("; {found} rows found") } else { String::new() },
        // Rows of earlier runs took no time in this one.
        (variants - found) as f64 / seconds.max(1e-3),
    );
    if *on_front > 0 {
        text += &format!("Pareto front: {on_front} variants\n");
    }
    if !empty_metrics.is_empty() {
        text += &format!("no variant has {}; report.html says why\n", empty_metrics.join(", "));
    }
    if *panicked > 0 {
        text += &format!(
            "warning: fabkit panicked on variants ({panicked} in all). This is a bug: report it with the plan; the column `reason` says where\n"
        );
    }
    if let Some(why) = none_left {
        text += &format!("error: no variant is left: {why}\n");
    }
    let json = documents::sweep(Path::new(&folder), finished);
    Outcome { text, json, failed: none_left.is_some() }
}
