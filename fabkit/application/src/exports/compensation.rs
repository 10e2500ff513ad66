//! Compensation: differences between exported files and the nominal geometry.

use fabkit_designs::kerf_mm;
use fabkit_designs::profile::{ProcessProfile, ProfileMatch};
use fabkit_export::{Compensation, PrintCompensation};
use fabkit_geometry::{Body, Pose, Solid};

use super::ExportOptions;

/// Computes the compensation of a body's files. `is_drawn` is true if laser outlines are among them.
pub(super) fn compute_compensation(
    body: &Body,
    options: &ExportOptions,
    is_drawn: bool,
) -> Compensation {
    let mut found = Compensation { scale: 1.0, kerf_mm: 0.0, print: None, note: "none".into() };
    if !options.has_compensation() {
        return found;
    }
    let mut notes = Vec::new();
    if body.shrinkage != 0.0 {
        // What is cast shrinks by this share, so that its mold must be larger by the reciprocal.
        found.scale = 1.0 / (1.0 - body.shrinkage);
        notes.push(format!(
            "scaled by {:.6} for {} % shrinkage of what is cast in it",
            found.scale,
            percent(body.shrinkage)
        ));
    }
    let by_process = body.process().map_or(0.0, |process| kerf_mm(process, &body.substance));
    // A requested kerf width replaces that of every process with a kerf; other processes stay without one.
    let kerf = if by_process > 0.0 { options.kerf_mm.unwrap_or(by_process) } else { 0.0 };
    if is_drawn && kerf > 0.0 {
        found.kerf_mm = kerf;
        notes.push(format!("outlines widened by {} mm for a kerf of {kerf} mm", kerf / 2.0));
    }
    if let Some(profile) = applicable_profile(body, options) {
        let print = print_compensation(profile);
        let [x, y, z] = print.scale;
        let foot = match print.elephant_foot_left_mm {
            0.0 => String::new(),
            mm => format!("; its foot of {mm} mm is left to the slicer"),
        };
        let other = match profile.match_part(profile.process.process(), &body.material) {
            ProfileMatch::OtherMaterial => format!(", which was measured on {}", profile.material),
            _ => String::new(),
        };
        notes.push(format!(
            "stretched by {x:.5} x {y:.5} x {z:.5} and upright round holes fitted for \
             {}{other}{foot}",
            print.profile
        ));
        found.print = Some(print);
    }
    if !notes.is_empty() {
        found.note = notes.join("; ");
    }
    found
}

/// Returns the printer profile that applies to a body's files, if any.
fn applicable_profile<'a>(body: &Body, options: &'a ExportOptions) -> Option<&'a ProcessProfile> {
    let profile = options.profile.as_ref().filter(|_| options.has_printed_files())?;
    match profile.match_part(body.process()?, &body.material) {
        ProfileMatch::Match => Some(profile),
        ProfileMatch::OtherMaterial => options.profile_for_any_material.then_some(profile),
        ProfileMatch::OtherProcess => None,
    }
}

fn print_compensation(profile: &ProcessProfile) -> PrintCompensation {
    PrintCompensation {
        profile: profile.name.as_str().to_owned(),
        scale: profile.scale(),
        hole_gain: profile.holes.gain,
        hole_offset_mm: profile.holes.offset.mm(),
        holes_fitted: 0,
        holes_left: 0,
        elephant_foot_left_mm: profile.elephant_foot.mm(),
    }
}

/// Returns the solid with its holes resized for the body's printer and records their counts in `compensation`; `None`
/// without a printer profile for the body.
pub(super) fn fit_holes(
    body: &Body,
    bed_from_body: &Pose,
    options: &ExportOptions,
    compensation: &mut Compensation,
) -> Option<Solid> {
    let profile = applicable_profile(body, options)?;
    let (solid, count) = profile.fit_holes(&body.solid, bed_from_body, compensation.scale);
    if let Some(print) = &mut compensation.print {
        (print.holes_fitted, print.holes_left) = (count.fitted, count.unchanged);
    }
    Some(solid)
}

/// Converts a share to percent, rounded to six decimals.
fn percent(share: f64) -> f64 {
    (share * 1e8).round() / 1e6
}
