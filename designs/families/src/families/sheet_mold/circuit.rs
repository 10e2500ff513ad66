//! How the strips of the box are wired, and both cameras.

use fabkit_geometry::Circuit;

use super::bodies::{BOX_CABLE, STAND_CABLE};
use super::cables::lengths_mm;
use super::layout::Layout;
use super::parameters::SheetMold;
use crate::blocks::circuit::{Builder, camera_to_host};

/// Strips: one at each wall.
const STRIPS: u32 = 4;

/// Supply and ground of each strip, and the cameras' cables.
pub fn circuit(p: &SheetMold, layout: &Layout) -> Circuit {
    let mut wired = Builder::wired("led-strips", 5.0);
    wired.strips(STRIPS, "strip", "5 V of the supply");
    let [below, above] = lengths_mm(p, layout);
    wired.connection(camera_to_host("camera in the box", Some(BOX_CABLE), Some(below), "USB"));
    wired.connection(camera_to_host(
        "camera above the display",
        Some(STAND_CABLE),
        Some(above),
        "USB",
    ));
    wired.note("no board is etched: buy strips that bring their resistors for 5 V");
    wired.note("what the strips take together is on their data sheet; all four are parallel");
    wired.done()
}
