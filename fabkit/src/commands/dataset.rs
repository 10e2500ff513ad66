//! `fabkit dataset SENSOR -o DIR`

mod probes;
mod room;

use std::path::Path;
use std::time::Instant;

use fabkit::dataset::{
    self, Captures, DatasetError, InvalidCaptures, Job, NamedPresses, NoPatterns, Plan,
    SampleError, Written,
};
use fabkit::depth::truth::{Seam, Surface};
use fabkit::export::png;
use fabkit::fixtures::SEAM_NORMAL;
use fabkit::identity::design_hash;
use fabkit::staging::write_each;
use fabkit::text::InvalidDesign;
use serde_json::json;

use self::room::Room;
use super::progress::Progress;
use super::{Report, view};
use crate::cli::{Dataset, Global};
use crate::diagnostics::SourceText;
use crate::failure::{Exit, Failure};
use crate::interrupt;
use crate::reading::{self, Expected};
use crate::roles::{Roles, has_ending};
use crate::scene::{MOST_FAULTS, Scene, press_failure};
use crate::source::MAX_YAML_BYTES;
use crate::table::grouped;

pub(super) fn run(args: &Dataset, global: &Global) -> Result<Report, Failure> {
    let start = Instant::now();
    roles(args).check()?;
    let scene = view::scene(&args.design, &args.view)?;
    if args.probes {
        return probes::run(args, &scene);
    }
    let order = Order {
        presses: args.presses.as_deref(),
        captures: args.captures.as_deref(),
        membrane_mm: args.view.membrane,
        seam_margin_mm: args.seam_margin,
        allow_no_contact: args.allow_no_contact,
        seed: args.seed,
        materialise: args.materialise,
        resume: args.resume,
    };
    prepare(&scene, &args.design.sensor, &order, |job| {
        let sheet = args.contact_sheet.as_deref();
        let sheet = sheet.map(|path| Ok::<_, Failure>((path, sheet_of(path, job, args.seed)?)));
        let sheet = sheet.transpose()?;
        interrupt::begin_writing()?;
        let progress = Progress::new(global, "files");
        let show = |done, found, all| progress.show(done, found, all);
        let room = Room::new(&scene, &order, job.patterns.len(), args.contact_sheet.is_some());
        let written = room.work(|| {
            dataset::write(&args.output, job, &show, &interrupt::requested).map_err(failure)
        });
        progress.clear();
        let written = written?;
        // Nothing is replaced for a data set that does not come about.
        if let Some((path, bytes)) = sheet {
            write_each([(path.to_owned(), &bytes[..])], &|| false)?;
        }
        Ok(report(args, &scene, job.plan, &written, start))
    })
}

fn roles(args: &Dataset) -> Roles {
    let is_capture = |name: &str| name.to_ascii_lowercase().ends_with(".png");
    let is_half = |name: &str| name.ends_with("-left.png") || name.ends_with("-right.png");
    let captures = args.captures.as_deref();
    let is_folder = captures.is_some_and(Path::is_dir);
    view::roles(&args.design, &args.view)
        .reads("--presses", &args.presses)
        .reads_all("--captures", captures, |n| if is_folder { is_half(n) } else { is_capture(n) })
        .writes("-o", args.probes.then_some(&args.output))
        .writes("--contact-sheet", &args.contact_sheet)
}

/// What a data set is made of, besides what the camera sees.
#[derive(Clone, Debug)]
pub struct Order<'a> {
    /// List of patterns; all semi-domes without it.
    pub presses: Option<&'a Path>,
    /// Pictures of the halves.
    pub captures: Option<&'a Path>,
    /// Radius of the transition around contacts, mm.
    pub membrane_mm: f64,
    /// What is left out on either side of the seam, mm.
    pub seam_margin_mm: f64,
    /// Whether presses may miss the surface.
    pub allow_no_contact: bool,
    /// Which patterns are for what.
    pub seed: u64,
    /// Write the stitched samples too.
    pub materialise: bool,
    /// Go on where an earlier run was stopped.
    pub resume: bool,
}

/// Reads what an order names, casts the surface, and hands the job over.
///
/// # Errors
/// Presses and captures that cannot be had, and what `work` says.
pub fn prepare<R>(
    scene: &Scene,
    sensor: &str,
    order: &Order,
    work: impl FnOnce(&Job) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let named = patterns(order, sensor, scene)?;
    Room::new(scene, order, named.len(), false).work(|| Ok(()))?;
    let presses =
        named.iter().flat_map(|of| of.presses.iter().map(|press| (of.name.as_str(), press)));
    scene.check_contacts(presses, order.allow_no_contact)?;
    let patterns = named.iter().map(NamedPresses::prepare).collect::<Result<Vec<_>, _>>();
    let patterns = patterns.map_err(Failure::bug)?;
    let rays = scene.viewpoint.rays(1);
    let surface = Surface::cast(scene.touch()?, &rays).map_err(Failure::bug)?;
    let seam = Seam::new(&surface, SEAM_NORMAL, order.seam_margin_mm);
    let captures = captures(order, &named, [rays.width_px(), rays.height_px()])?;
    let plan = Plan::new(&patterns, order.seed, about(order, scene, &named, captures.as_ref()));
    work(&Job {
        surface: &surface,
        seam: &seam,
        patterns: &patterns,
        membrane_mm: order.membrane_mm,
        plan: &plan,
        captures: captures.as_ref(),
        materialise: order.materialise,
        resume: order.resume,
    })
}

fn sheet_of(path: &Path, job: &Job, seed: u64) -> Result<Vec<u8>, Failure> {
    if !has_ending(path, "png") {
        let message = format!("{} does not name a .png file", path.display());
        return Err(Failure::plain(Exit::BadInput, message));
    }
    let sheet = dataset::sheet(job, seed).map_err(|error| Failure::plain(Exit::Limit, error))?;
    png(sheet.width_px, sheet.height_px, &sheet.rgb).map_err(Failure::bug)
}

fn patterns(order: &Order, sensor: &str, scene: &Scene) -> Result<Vec<NamedPresses>, Failure> {
    let Some(path) = order.presses else {
        return dataset::semi_domes(&scene.project).map_err(|error| match error {
            NoPatterns::Press(error) => press_failure(sensor, error),
            other => {
                let hint = "list presses in a text file and name it with --presses";
                Failure::new(Exit::BadInput, other, hint)
            }
        });
    };
    let hint = "is it the right file? It has one pattern on a line";
    let expected = Expected { what: "a list of presses", max_bytes: MAX_YAML_BYTES, hint };
    let text = reading::text(path, expected)?;
    let patterns = dataset::read_patterns(&text, &scene.project);
    patterns.map_err(|error| match error {
        NoPatterns::File(faults) => {
            let file = path.display().to_string();
            let problems = faults.into_iter().map(|fault| fault.in_file(&file)).collect();
            Failure::Design(InvalidDesign { problems }, vec![SourceText { file, text }])
        }
        NoPatterns::Press(error) => press_failure(sensor, error),
        NoPatterns::NoSemiDomes { .. } => Failure::plain(Exit::BadInput, error),
    })
}

fn captures(
    order: &Order,
    named: &[NamedPresses],
    size_px: [u32; 2],
) -> Result<Option<Captures>, Failure> {
    let Some(place) = order.captures else { return Ok(None) };
    let names: Vec<String> = named.iter().map(|pattern| pattern.name.clone()).collect();
    let captures = Captures::read(place, &names, size_px).map_err(|InvalidCaptures(faults)| {
        let (count, shown) = (faults.len(), faults.len().min(MOST_FAULTS));
        let mut message = faults[..shown].join("\nerror: ");
        if count > shown {
            message += &format!("\nerror: and {} more", count - shown);
        }
        let hint = "a folder holds `PATTERN-left.png` and `PATTERN-right.png` for each pattern; \
                    a CSV file has the columns pattern, side, file";
        Failure::new(Exit::BadInput, message, hint)
    })?;
    Ok(Some(captures))
}

/// What the folder says about itself besides its patterns.
fn about(
    order: &Order,
    scene: &Scene,
    named: &[NamedPresses],
    captures: Option<&Captures>,
) -> serde_json::Value {
    let design = &scene.project.design;
    json!({
        "fabkit": fabkit::export::VERSION,
        "sensor": design.sensor.name,
        "design_hash": design_hash(design),
        "presses_hash": dataset::presses_hash(named),
        "captures_hash": captures.map(Captures::hash),
        "viewpoint": scene.viewpoint.to_json(),
        "surface_seen": scene.coverage_json(),
        "seed": order.seed,
        "seam": {
            "left_to_right_in_sensor": <[f64; 3]>::from(SEAM_NORMAL),
            "margin_mm": order.seam_margin_mm,
        },
        "membrane_mm": order.membrane_mm,
        "contact": if order.membrane_mm > 0.0 { "membrane" } else { "rigid" },
        "units": { "length": "mm", "angle": "rad", "pixel": "px, centres at integers" },
        "frames": {
            "sensor": "right-handed; origin at the centre of the surface's base circle, +z toward \
                       the tip",
            "camera": "right-handed; +z forward, +x right, +y down",
        },
    })
}

fn report(args: &Dataset, scene: &Scene, plan: &Plan, written: &Written, start: Instant) -> Report {
    let folder = args.output.display().to_string();
    let Written { halves, samples, found, made, damaged, untouched } = written;
    let kind = if args.materialise { "written" } else { "listed" };
    let mut text = format!(
        "{folder}: {halves} halves, {} samples {kind}; {} files made{} ({:.2} s)\n",
        grouped(*samples as u64),
        made,
        if *found > 0 { format!(", {found} found") } else { String::new() },
        start.elapsed().as_secs_f64(),
    );
    if !damaged.is_empty() {
        let count = damaged.len();
        text += &format!(
            "warning: {count} files were damaged and are made again: {}\n",
            damaged.join(", ")
        );
    }
    text += &scene.coverage_text();
    if !untouched.is_empty() {
        text += &format!(
            "warning: {} halves press nothing that the camera sees on their side: {}\n",
            untouched.len(),
            untouched.join(", ")
        );
    }
    let json = json!({
        "format": "fabkit-dataset-report",
        "version": 1,
        "folder": folder,
        "patterns": plan.patterns.len(),
        "halves": halves,
        "samples": samples,
        "materialised": args.materialise,
        "files_made": made,
        "files_found": found,
        "files_damaged": damaged,
        "halves_without_contact": untouched,
        "surface_seen": scene.coverage_json(),
    });
    Report { text, json, failed: false }
}

/// Why a data set was not written, for people.
pub fn failure(error: DatasetError) -> Failure {
    match error {
        DatasetError::Read(error) => read_failure(error),
        DatasetError::Folder(error) => error.into(),
        DatasetError::Cancelled => {
            Failure::new(Exit::Interrupted, "interrupted", "--resume goes on from here")
        }
        DatasetError::Stranger { .. } => {
            Failure::new(Exit::Io, error, "do all workers have this version of fabkit?")
        }
        DatasetError::Export(_) => Failure::bug(error),
    }
}

/// Why a data set cannot be read, for people.
pub fn read_failure(error: SampleError) -> Failure {
    match error {
        SampleError::Folder(error) => error.into(),
        SampleError::Io(error) => Failure::plain(Exit::Io, error),
        SampleError::Absent { is_begun: true, .. } => Failure::new(
            Exit::Io,
            error,
            "it is not finished: run the same `fabkit dataset` with --resume",
        ),
        SampleError::Absent { .. } => {
            Failure::new(Exit::Io, error, "`fabkit dataset SENSOR -o DIR` writes one")
        }
        SampleError::Damaged { .. } => {
            Failure::new(Exit::Io, error, "delete that file and run `fabkit dataset --resume`")
        }
        SampleError::Foreign { .. } => {
            Failure::new(Exit::BadInput, error, "read it with the Python package `zarr`")
        }
        SampleError::OutOfRange { .. } => Failure::plain(Exit::BadInput, error),
    }
}
