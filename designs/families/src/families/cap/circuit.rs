//! How the pieces of strip are wired: supply and ground parallel, data from one to the next.

use fabkit_geometry::{Circuit, Connection};

use super::bodies::CAMERA_CABLE;
use super::components::cable_beyond_mm;
use super::parameters::Cap;
use crate::blocks::circuit::{Builder, camera_to_host};

/// An LED of such strips at full white, A (Adafruit's guide to NeoPixels: 60 mA, 20 mA a colour).
const FULL_A: f64 = 0.060;

/// The wires between supply, controller and pieces of strip, and the camera's cable.
pub fn circuit(p: &Cap) -> Circuit {
    // What such strips are made for.
    let mut wired = Builder::wired("led-strips", 5.0);
    let mut connect = |from: String, to: String, carries: &str, color: &str| {
        let (carries, color) = (carries.to_owned(), Some(color.to_owned()));
        wired.connection(Connection { from, to, carries, by: None, length_mm: None, color });
    };
    for piece in 1..=p.leds.count {
        let at = |pad: &str| format!("strip {piece}, {pad}");
        let before = |pad: &str, first: &str| match piece {
            1 => first.to_owned(),
            _ => format!("strip {}, {pad}", piece - 1),
        };
        connect(at("5V"), before("5V", "5 V of the supply"), "5V", "red");
        connect(at("GND"), before("GND", "ground of supply and controller"), "GND", "black");
        connect(at("DIN"), before("DOUT", "digital pin of the controller"), "data", "green");
    }
    wired.draws(FULL_A * f64::from(p.leds.count));
    wired.connection(camera_to_host(
        "camera",
        Some(CAMERA_CABLE),
        Some(cable_beyond_mm(p)),
        "USB 3.0",
    ));
    wired.note("no board is etched: each piece of strip carries its LED with its driver and needs no resistor for its LED");
    wired
        .note("the total current is that of all LEDs in full white; one colour each takes a third");
    wired.done()
}
