//! Layout of a circuit: places parts, routes tracks between them, and prints silk on top.

use fabkit_geometry::Circuit;

use crate::layout::BoardLayout;
use crate::{BoardError, BoardRules, BoardShape, placement, route, silk};

/// Lays out a circuit on its board: places, tracks, mask and silk. The same circuit gives the same board.
///
/// # Errors
/// Fails if there is no room for a part or a track, and names the net and the numbers. The layout is not checked
/// against the rules; see [`crate::check`].
pub fn lay_out(
    circuit: &Circuit,
    board: &BoardShape,
    rules: &BoardRules,
) -> Result<BoardLayout, BoardError> {
    // Narrower tracks are tried if wide ones do not fit, and then all widths again without test points.
    let widths = [
        rules.preferred_track_mm,
        (rules.preferred_track_mm + rules.track_mm) / 2.0,
        rules.track_mm,
    ];
    let mut failed = None;
    for with_test_points in [true, false] {
        for width_mm in widths {
            let mut layout = placement::place_parts(circuit, board, rules, with_test_points)?;
            match route::route(&mut layout, circuit, rules, width_mm) {
                Ok(()) => {
                    silk::print_silk(&mut layout, circuit, rules);
                    return Ok(layout);
                }
                // The first error is that of the preferred width with all test points.
                Err(error) => failed = failed.or(Some(error)),
            }
        }
    }
    Err(failed.expect("each try that did not end failed"))
}
