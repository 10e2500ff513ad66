//! What is soldered to the LED board, and what leads to it.

use std::f64::consts::PI;

use fabkit_geometry::{BoardPlace, BoardSide, Circuit, KeepOutRegion};

use super::bodies::*;
use super::housing::{BAFFLE_FLANGE_MM, led_poses};
use super::layout::Layout;
use super::parameters::Dome;
use super::wiring;
use crate::blocks::circuit::{
    Builder, CHIP_0603, LedPackage, TO_SUPPLY, Wire, all_around, along_y, camera_to_host,
};
use crate::blocks::{LED, turn};

/// A wire's pad along and across the way out, mm.
const PAD_MM: [f64; 2] = [1.5, 0.8];

/// LEDs between supply and ground, each with its resistor; two wires; the camera's cable.
pub fn circuit(p: &Dome, layout: &Layout) -> Circuit {
    let mut board = Builder::on(LED_BOARD, &p.leds.electric);
    let package = LedPackage::Chip([p.leds.length.mm(), p.leds.width.mm()]);
    board.each_with_resistor(
        &p.leds.electric,
        (&p.leds.model, package, LED),
        along_y(&led_poses(p, layout)),
        CHIP_0603,
        "leds.resistor_ohms, or leds.current_ma where that is 0",
    );
    let drawn = wiring::is_aside(p);
    let by = drawn.then_some(LED_WIRE);
    let length_mm = drawn.then(|| wiring::led_wire(p, layout).length_mm());
    let holes = wiring::hole_centres(p);
    for (at_mm, (net, color, to)) in holes.into_iter().zip(TO_SUPPLY) {
        let out = at_mm[1].atan2(at_mm[0]);
        // Away from the LEDs' circle where the holes are outside of it.
        let is_outside = at_mm[0].hypot(at_mm[1]) > p.leds.circle_radius.mm();
        let way = if drawn { p.base.exit_angle.rad() } else { out };
        board.wire(
            net,
            Wire {
                place: BoardPlace {
                    at_mm,
                    turn_rad: if is_outside { way + PI } else { way },
                    side: BoardSide::Top,
                },
                hole_mm: Some(p.led_board.wire_hole_diameter.mm()),
                pad_mm: PAD_MM,
                by,
                to,
                length_mm,
                color,
            },
        );
    }
    let baffle = p.led_board.bore_radius.mm() + BAFFLE_FLANGE_MM;
    if p.baffle.wall.mm() > 0.0 {
        board.keep_out(BoardSide::Top, all_around([0.0, baffle]), "the baffle's flange");
    }
    for rib in 0..p.shell.ribs {
        // Its width is an angle at the bore; a tenth beside it.
        let half = (p.shell.rib_width.mm() / 2.0 / layout.shell_bore_radius_mm).asin();
        let region = KeepOutRegion::Sector {
            inner_mm: layout.rib_radius_mm - 0.1,
            outer_mm: layout.shell_radius_mm,
            middle_rad: turn(rib, p.shell.ribs, 0.0).rad(),
            half_rad: half + 0.01,
        };
        board.keep_out(BoardSide::Top, region, "a rib of the shell");
    }
    board.test_points();
    let length_mm = drawn.then(|| wiring::camera_cable(p, layout).length_mm());
    board.connection(camera_to_host("camera", drawn.then_some(CAMERA_CABLE), length_mm, "USB"));
    board.note("push each wire's strand through its hole from below, bend it over and solder it to the pad beside it");
    board.note("no part stands on the lower side: the base lies against it");
    board.done()
}
