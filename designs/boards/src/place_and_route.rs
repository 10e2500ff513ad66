//! From a circuit to a laid-out board: parts in their places, tracks between them, print on top.

use fabkit_geometry::Circuit;

use crate::layout::Layout;
use crate::{BoardError, BoardShape, Rules, place, route, silk};

/// Lays a circuit out on its board: places, tracks, masks, silk. The same circuit gives the same board.
///
/// # Errors
/// Parts or tracks that find no room, with the net and the numbers. What is laid out is not judged; see
/// [`crate::check`].
pub fn lay_out(circuit: &Circuit, board: &BoardShape, rules: &Rules) -> Result<Layout, BoardError> {
    let widths =
        [rules.usual_track_mm, (rules.usual_track_mm + rules.track_mm) / 2.0, rules.track_mm];
    let mut failed = None;
    for with_test_points in [true, false] {
        for width_mm in widths {
            let mut layout = place::placed(circuit, board, rules, with_test_points)?;
            match route::route(&mut layout, circuit, rules, width_mm) {
                Ok(()) => {
                    silk::print(&mut layout, circuit, rules);
                    return Ok(layout);
                }
                Err(error) => failed = failed.or(Some(error)),
            }
        }
    }
    Err(failed.expect("each try that did not end failed"))
}
