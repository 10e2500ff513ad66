//! `fabkit dataset SENSOR --probes -o FILE.csv`

use fabkit_application::ground_truth::probes::sample_probes;
use fabkit_application::reading::has_extension;
use fabkit_application::scene::SensorView;
use fabkit_application::staging::write_each;
use serde_json::json;

use super::super::{Outcome, view};
use crate::cli::Dataset;
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::table::{format_size, group_digits};

/// Default largest indentation of probes, mm: UVDtact's.
const DEFAULT_INDENTATION_MM: f64 = 1.6;

pub(super) fn run(args: &Dataset, scene: &SensorView) -> Result<Outcome, Failure> {
    if !has_extension(&args.output, "csv") {
        let message = format!("{} does not name a .csv file", args.output.display());
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    let touch = scene.touch()?;
    let deepest_mm = args.depth.unwrap_or(DEFAULT_INDENTATION_MM.min(touch.max_indentation_mm()));
    if deepest_mm > touch.max_indentation_mm() {
        let message = format!(
            "probes of {deepest_mm} mm are too deep: presses of this surface are simulated to {} mm",
            touch.max_indentation_mm()
        );
        return Err(Failure::new(ErrorKind::BadInput, message, "ask for a smaller --depth"));
    }
    let probes = sample_probes(
        touch,
        &scene.viewpoint,
        scene.sights(),
        args.count,
        deepest_mm,
        args.options.seed,
    );
    let probes = probes.map_err(Failure::bug)?;
    if probes.visible_tips == 0 && !args.options.allow_no_contact {
        let message =
            format!("the camera sees none of the {} probes' tips", group_digits(args.count.into()));
        let hint = "ask for a larger --count, or allow it with --allow-no-contact";
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    let bytes = probes.csv.into_bytes();
    let count = bytes.len() as u64;
    interrupt::begin_writing()?;
    write_each([(args.output.clone(), &bytes[..])], &interrupt::is_requested)?;
    let shown = args.output.display().to_string();
    let text = format!(
        "{shown}: {} probes to {deepest_mm} mm, the camera sees {} of their tips, {}\n{}",
        group_digits(args.count.into()),
        group_digits(probes.visible_tips.into()),
        format_size(count),
        view::coverage_text(&scene.coverage),
    );
    let json = json!({
        "format": "fabkit-probes",
        "version": 1,
        "file": shown,
        "bytes": count,
        "probes": args.count,
        "probes_seen": probes.visible_tips,
        "deepest_mm": deepest_mm,
        "seed": args.options.seed,
        "viewpoint": scene.viewpoint.to_json(),
        "surface_seen": scene.coverage.to_json(),
    });
    Ok(Outcome { text, json, failed: false })
}
