//! `fabkit render SENSOR[/PART] -o FILE.png`

use fabkit_application::bodies;
use fabkit_application::memory::{self, Less};
use fabkit_application::pictures::{self, MAX_PIXELS, Shot};
use fabkit_application::progress::Step;
use fabkit_application::reading::has_ending;
use fabkit_application::source::Target;
use fabkit_application::staging::write_each;
use serde_json::json;

use super::Outcome;
use super::progress::Progress;
use crate::cli::{Global, Render};
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::Roles;
use crate::table::size;

/// A picture, the same filtered, and a file of at most that, bytes for each pixel.
const PIXEL_BYTES: u64 = 9;
/// Tiles that threads are drawing.
const TILES_BYTES: u64 = 200 * memory::MB;

pub(super) fn run(args: &Render, global: &Global) -> Result<Outcome, Failure> {
    let target = Target::new(&args.sensor).with_preset(args.preset.as_deref());
    let part = target.part;
    let [width_px, height_px] = args.size;
    if u64::from(width_px) * u64::from(height_px) > MAX_PIXELS {
        let message =
            format!("a picture of {width_px} x {height_px} has more than {MAX_PIXELS} px");
        return Err(Failure::new(ErrorKind::Limit, message, "ask for a smaller --size"));
    }
    memory::admit(
        &format!("a picture of {width_px} x {height_px} px"),
        PIXEL_BYTES * u64::from(width_px) * u64::from(height_px) + TILES_BYTES,
        Less::Pixels,
    )?;
    if !has_ending(&args.output, "png") {
        let message = format!("{} does not name a .png file", args.output.display());
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    Roles::default().reads("SENSOR", target.files()).writes("-o", [&args.output]).check()?;
    if part.is_some() && (args.exploded || args.assembly.is_some()) {
        let message = "--exploded and --assembly are for whole assemblies, not for one part";
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }

    let shot = Shot { size_px: args.size, section: args.section, from: args.view };
    let design = target.design(&args.set)?;
    let progress = Progress::new(global, format!("drawing {}", args.sensor));
    let show = |step: Step| progress.show(step);
    let bytes = match part {
        Some(part) => pictures::picture_of_body(bodies::find(&design.sensor, part)?, shot, &show)?,
        None => {
            let assembly = args.assembly.clone();
            let assembly = assembly.unwrap_or_else(|| pictures::default_assembly(&design.sensor));
            pictures::picture_of_assembly(&design.sensor, &assembly, args.exploded, shot, &show)?
        }
    };
    drop(progress);

    let count = bytes.len() as u64;
    interrupt::begin_writing()?;
    write_each([(args.output.clone(), &bytes[..])], &interrupt::requested)?;
    let shown = args.output.display().to_string();
    let json = json!({
        "format": "fabkit-render",
        "version": 1,
        "file": shown,
        "width_px": width_px,
        "height_px": height_px,
        "bytes": count,
    });
    let text = format!("{shown}: {width_px} x {height_px} px, {}\n", size(count));
    Ok(Outcome { text, json, failed: false })
}
