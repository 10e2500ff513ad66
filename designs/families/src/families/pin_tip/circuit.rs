//! What is soldered to the ring of LEDs, and what leads to it.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{BoardPlace, BoardSide, Circuit};

use super::bodies::*;
use super::body::led_poses;
use super::layout::Layout;
use super::parameters::PinTip;
use crate::blocks::circuit::{
    Builder, CHIP_0402, LedPackage, TO_SUPPLY, Wire, all_around, along_y, camera_to_host,
};
use crate::blocks::{LED, turn};

/// A wire's pad around the ring, mm.
const PAD_LENGTH_MM: f64 = 1.4;
/// A wire's pad across the ring at most, mm: it stays off the board's inner edge and off the ledge.
const PAD_WIDTH_MM: f64 = 0.8;
/// Between a pad and the board's edge or the ledge, mm.
const BESIDE_MM: f64 = 0.21;

/// LEDs between supply and ground, each with its resistor; wires on the lower side.
pub fn circuit(p: &PinTip, layout: &Layout) -> Circuit {
    let mut board = Builder::on(LED_BOARD, &p.leds.electric);
    let package = LedPackage::Chip([p.leds.length.mm(), p.leds.width.mm()]);
    board.each_with_resistor(
        &p.leds.electric,
        (&p.leds.model, package, LED),
        along_y(&led_poses(p, layout)),
        CHIP_0402,
        "leds.current_ma, or leds.resistor_ohms where that is not 0",
    );
    let inner = p.led_board.bore_radius.mm() + BESIDE_MM;
    let ledge = layout.shaft_bore_radius_mm.min(layout.board_radius_mm - BESIDE_MM);
    let width = (ledge - inner).min(PAD_WIDTH_MM);
    let radius = inner + width / 2.0;
    for (step, wire) in [0.5, -0.5].into_iter().zip(TO_SUPPLY) {
        // Between two LEDs, one wire on each side of the one at the cable's slot.
        let angle = turn(0, p.leds.count, step).rad();
        let place = BoardPlace {
            at_mm: [radius * angle.cos(), radius * angle.sin()],
            turn_rad: angle + FRAC_PI_2,
            side: BoardSide::Bottom,
        };
        board.wire(wire.0, Wire::undrawn(place, [PAD_LENGTH_MM, width], wire));
    }
    let ledge = all_around([layout.shaft_bore_radius_mm, layout.board_radius_mm + 1.0]);
    board.keep_out(BoardSide::Bottom, ledge, "the ledge of the body");
    board.test_points();
    board.connection(camera_to_host(
        "camera",
        Some(CAMERA_CABLE),
        None,
        "SPI and supply, eight wires",
    ));
    board.note("solder the wires to the lower side and lead them down the shaft");
    board.done()
}
