//! How exported copies differ from the nominal geometry.

use fabkit_designs::kerf_mm;
use fabkit_export::Compensation;

use super::ExportOptions;
use crate::bodies::BodyRef;

/// What the files of a body make up for. `is_drawn` says whether outlines are among them.
pub(super) fn compensation(
    body: &BodyRef,
    options: &ExportOptions,
    is_drawn: bool,
) -> Compensation {
    let mut found = Compensation { scale: 1.0, kerf_mm: 0.0, note: "none".into() };
    if options.nominal {
        return found;
    }
    let mut notes = Vec::new();
    if body.shrinkage != 0.0 {
        found.scale = 1.0 / (1.0 - body.shrinkage);
        notes.push(format!(
            "scaled by {:.6} for {} % shrinkage of what is cast in it",
            found.scale,
            percent(body.shrinkage)
        ));
    }
    let by_process = body.process.map_or(0.0, |process| kerf_mm(process, body.material));
    // A width asked for goes for everything that has a kerf at all.
    let kerf = if by_process > 0.0 { options.kerf_mm.unwrap_or(by_process) } else { 0.0 };
    if is_drawn && kerf > 0.0 {
        found.kerf_mm = kerf;
        notes.push(format!("outlines widened by {} mm for a kerf of {kerf} mm", kerf / 2.0));
    }
    if !notes.is_empty() {
        found.note = notes.join("; ");
    }
    found
}

/// Without the digits that rounding adds.
fn percent(share: f64) -> f64 {
    (share * 1e8).round() / 1e6
}
