//! `fabkit dataset SENSOR -o DIR`

mod probes;

use std::path::Path;
use std::time::Instant;

use fabkit_application::capturing::Unit;
use fabkit_application::dataset::{self, DatasetJob, WrittenDataset};
use fabkit_application::documents;
use fabkit_application::export::png;
use fabkit_application::image::has_image_extension as is_image;
use fabkit_application::progress::ProgressStep;
use fabkit_application::reading::has_extension;
use fabkit_application::scene::SensorView;
use fabkit_application::source::convert_press_error;
use fabkit_application::staging::write_each;
use serde_json::json;

use super::progress::Progress;
use super::{Outcome, view};
use crate::cli::{Dataset, Global};
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::FileRoles;
use crate::table::group_digits;

pub(super) fn run(args: &Dataset, global: &Global) -> Result<Outcome, Failure> {
    let start = Instant::now();
    roles(args).check()?;
    let scene =
        view::build_unit_scene(&args.design, &args.view.camera, args.options.unit.map(Unit))?;
    if args.probes {
        return probes::run(args, &scene);
    }
    let order = args.options.request(&args.view.contact)?;
    dataset::prepare_job(
        &scene,
        &|error| convert_press_error(&args.design.sensor, error),
        &order,
        |job, room| {
            let sheet = args.contact_sheet.as_deref();
            let sheet = sheet
                .map(|path| Ok::<_, Failure>((path, contact_sheet(path, job, args.options.seed)?)));
            let sheet = sheet.transpose()?;
            interrupt::begin_writing()?;
            let progress = Progress::new(global, "writing files");
            let show = |step: ProgressStep| progress.show(step);
            let room = if args.contact_sheet.is_some() { room.with_contact_sheet() } else { room };
            let written = room.run(|| {
                let written = dataset::write(&args.output, job, &show, &interrupt::is_requested);
                written.map_err(Failure::from)
            });
            drop(progress);
            let written = written?;
            // A contact sheet is replaced only once the data set is complete.
            if let Some((path, bytes)) = sheet {
                write_each([(path.to_owned(), &bytes[..])], &|| false)?;
            }
            Ok(report(args, &scene, job, &written, start))
        },
    )
}

fn roles(args: &Dataset) -> FileRoles {
    let is_half = |name: &str| {
        let stem = name.rsplit_once('.').map_or("", |(stem, _)| stem);
        is_image(name) && (stem.ends_with("-left") || stem.ends_with("-right"))
    };
    let captures = args.options.captures.as_deref();
    let is_folder = captures.is_some_and(Path::is_dir);
    view::roles(&args.design, &args.view.camera)
        .reads("--presses", &args.options.presses)
        .reads("--constants", &args.options.constants)
        .reads_all("--captures", captures, |n| if is_folder { is_half(n) } else { is_image(n) })
        // Only probes are one file; the folder of a data set is checked when it is opened.
        .writes("-o", args.probes.then_some(&args.output))
        .writes("--contact-sheet", &args.contact_sheet)
}

fn contact_sheet(path: &Path, job: &DatasetJob, seed: u64) -> Result<Vec<u8>, Failure> {
    if !has_extension(path, "png") {
        let message = format!("{} does not name a .png file", path.display());
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    let sheet = dataset::render_contact_sheet(job, seed)?;
    png(sheet.width_px, sheet.height_px, &sheet.rgb).map_err(Failure::bug)
}

fn report(
    args: &Dataset,
    scene: &SensorView,
    job: &DatasetJob,
    written: &WrittenDataset,
    start: Instant,
) -> Outcome {
    let folder = args.output.display().to_string();
    let WrittenDataset {
        halves,
        samples,
        existing_files: found,
        written_files: made,
        damaged,
        halves_without_contact: untouched,
    } = written;
    let kind = if args.options.materialise { "written" } else { "listed" };
    let mut text = format!(
        "{folder}: {halves} halves, {} samples {kind}; {} files made{} ({:.2} s)\n",
        group_digits(*samples as u64),
        made,
        if *found > 0 { format!(", {found} found") } else { String::new() },
        start.elapsed().as_secs_f64(),
    );
    if !damaged.is_empty() {
        let count = damaged.len();
        text += &format!("warning: damaged files, made again ({count}): {}\n", damaged.join(", "));
    }
    text += &view::coverage_text(&scene.coverage);
    if !untouched.is_empty() {
        text += &format!(
            "warning: halves whose contact the camera does not see on their side ({}): {}\n",
            untouched.len(),
            untouched.join(", ")
        );
    }
    let mut json = json!({
        "format": "fabkit-dataset-report",
        "version": 1,
        "folder": folder,
        "patterns": job.plan.patterns.len(),
        "halves": halves,
        "samples": samples,
        "materialised": args.options.materialise,
        "files_made": made,
        "files_found": found,
        "files_damaged": damaged,
        "halves_without_contact": untouched,
        "surface_seen": scene.coverage.to_json(),
    });
    if let Some(images) = job.captures {
        json["not_known"] = images.not_known().iter().map(documents::unknown_property).collect();
    }
    Outcome { text, json, failed: false }
}
