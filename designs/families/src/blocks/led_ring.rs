//! Ring of equal LEDs on an annular board, their lengths along the circle.

use fabkit_geometry::{Body, Length, Order, Placement, Pose, Solid};

use super::{APART_MM, LED, LED_YELLOW, half_chord, ring};
use crate::parameters::{RuleReport, limits};

/// Smallest width of the board beside an LED, mm.
const BOARD_MM: f64 = 0.2;

/// LEDs of a family's section `leds`.
pub struct LedRing<'a> {
    /// Number of LEDs.
    pub count: u32,
    /// Radius of the circle of their centres.
    pub circle_radius: Length,
    /// Length of the package.
    pub length: Length,
    /// Width of the package, along the radius.
    pub width: Length,
    /// Height of the package.
    pub height: Length,
    /// Type of the LEDs.
    pub model: &'a str,
}

/// Creates an [`LedRing`] from the parameters of a family's section `leds`.
macro_rules! led_ring {
    ($leds:expr) => {{
        let leds = &$leds;
        $crate::blocks::LedRing {
            count: leds.count,
            circle_radius: leds.circle_radius,
            length: leds.length,
            width: leds.width,
            height: leds.height,
            model: &leds.model,
        }
    }};
}
pub(crate) use led_ring;

impl LedRing<'_> {
    /// Returns the poses of the LEDs on a board with its top at `z`, the first one turned by `offset` steps: z axis up,
    /// x axis outwards.
    pub fn poses(&self, z: f64, offset: f64) -> Vec<Pose> {
        ring(self.count, offset, Pose::translation(self.circle_radius.mm(), 0.0, z))
    }

    /// Returns the LEDs as a bought body.
    pub fn body(&self, placements: impl IntoIterator<Item = Placement>) -> Body {
        let solid = Solid::cuboid(self.width.mm(), self.length.mm(), self.height.mm());
        LED.bought(self.model, solid, placements)
            .with_order(Order::new(self.model, ""))
            .colored(LED_YELLOW)
            .as_light_source()
            .as_attached()
    }

    /// Reports LEDs that do not fit beside the board's bore, within a radius (mm), or beside each other.
    pub fn check(&self, bore: Length, (within_mm, what): (f64, &str), report: &mut RuleReport) {
        let (leds, half, out) = (self, self.length.mm() / 2.0, self.width.mm() / 2.0);
        limits! { report:
            leds.circle_radius <= half_chord(within_mm - APART_MM, half) - out,
                format!("the LEDs' outer corners must stay inside {what}");
            leds.circle_radius >= bore.mm() + out + BOARD_MM,
                "the LEDs must stand on the board, not over its bore";
            // Neighbours touch first at their inner corners.
            leds.count <= self.most(), "the LEDs must not overlap on their circle";
        }
    }

    /// Returns the number of LEDs that fit on the circle, not rounded.
    fn most(&self) -> f64 {
        let inner = self.circle_radius.mm() - self.width.mm() / 2.0;
        std::f64::consts::PI / ((self.length.mm() + APART_MM) / 2.0).atan2(inner)
    }
}
