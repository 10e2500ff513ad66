//! Circuit of the LEDs of a chamber.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{BoardPlacement, BoardSide, Circuit, KeepOutRegion};

use super::{ChamberLight, LED_BOARD, LedPosition};
use crate::blocks::circuit::{
    BoardWire, CHIP_0603, CircuitBuilder, LedPackage, TO_SUPPLY, along_x, camera_to_host,
};
use crate::blocks::{LED, PRINTED_WALL_MM};

/// Size of a wire's pad along and across the wire, mm.
const PAD_MM: [f64; 2] = [1.6, 1.2];
/// Smallest distance of each of the two pads from the middle of the board's edge, mm.
const BESIDE_MM: f64 = 1.0;
/// Distance between a pad and the board's edge, mm.
const EDGE_MM: f64 = 0.5;

impl ChamberLight<'_> {
    /// Returns the circuit. From below: LEDs between supply and ground, each with its resistor. From the sides: strips
    /// connected to their supply.
    pub fn circuit(&self) -> Circuit {
        match self.leds.from {
            LedPosition::Below => self.board_circuit(),
            LedPosition::Sides => self.strips(),
        }
    }

    /// Returns the circuit of the LED board.
    fn board_circuit(&self) -> Circuit {
        let leds = self.leds;
        let mut board = CircuitBuilder::new_on_board(LED_BOARD, &leds.electric);
        let package = LedPackage::Chip([leds.pitch.mm(), leds.width.mm()]);
        board.add_leds_with_resistors(
            &leds.electric,
            (&leds.model, package, LED),
            along_x(&self.poses()),
            CHIP_0603,
            "leds.resistor_ohms, or leds.current_ma where that is 0",
        );
        // Wire pads lie on the lower side at the middle of the long edge, where the camera's wires leave.
        let (rect, bore_mm) = self.board_rect();
        let long = self.chamber.longer();
        let out = rect.half[1 - long] - EDGE_MM - PAD_MM[0] / 2.0;
        // Where the rim beside the hole is narrow, the pads move apart until their inner corners are on the board.
        let inner_mm = out - PAD_MM[0] / 2.0;
        let clear_mm = ((bore_mm + EDGE_MM).powi(2) - inner_mm.powi(2)).max(0.0).sqrt();
        let beside_mm =
            if clear_mm > 0.0 { BESIDE_MM.max(clear_mm + PAD_MM[1] / 2.0) } else { BESIDE_MM };
        for (along, wire) in [-beside_mm, beside_mm].into_iter().zip(TO_SUPPLY) {
            let at_mm = if long == 0 { [along, -out] } else { [out, along] };
            let turn_rad = if long == 0 { -FRAC_PI_2 } else { 0.0 };
            let place = BoardPlacement { at_mm, turn_rad, side: BoardSide::Bottom };
            board.wire(wire.0, BoardWire::without_body(place, PAD_MM, wire));
        }
        let half_mm = self.chamber.half.map(|half| half - PRINTED_WALL_MM / 2.0);
        board.keep_out(BoardSide::Top, KeepOutRegion::BeyondRect { half_mm }, "the shell's step");
        board.test_points();
        board.connection(camera_to_host("camera", None, None, "USB"));
        board.build()
    }

    /// Returns the circuit of the LED strips.
    fn strips(&self) -> Circuit {
        let leds = self.leds;
        let mut wired = CircuitBuilder::new_wired("led-strips", leds.electric.supply_volts);
        wired.strips(leds.count.min(4), "strip at wall", "supply of the strip's voltage");
        let each = leds.electric.current_a();
        wired.add_current(each * self.poses().len() as f64);
        wired.connection(camera_to_host("camera", None, None, "USB"));
        wired.note(
            "buy strips with resistors of their own for the supply's voltage, or put one into each strip's line",
        );
        wired.build()
    }
}
