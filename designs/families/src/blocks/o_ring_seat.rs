//! What an O-ring is stretched over: the neck between two faces, or the bottom of a groove.

use fabkit_geometry::Length;

use crate::hardware::{ORing, stocked_cords};
use crate::parameters::Report;

/// Width of a groove, in cords: a squeezed cord grows wider.
const GROOVE_CORDS: f64 = 1.3;

/// The seat of a ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ORingSeat {
    /// Diameter of the ring's cord.
    pub cord: Length,
    /// Radius of what it is stretched over, mm.
    pub radius_mm: f64,
}

impl ORingSeat {
    /// A groove whose ring a bore of that radius (mm) squeezes by that share of its cord.
    pub fn squeezed_in(bore_mm: f64, cord: Length, squeeze: f64) -> Self {
        Self { cord, radius_mm: bore_mm - cord.mm() * (1.0 - squeeze) }
    }

    /// Width of the groove, mm.
    pub fn width_mm(&self) -> f64 {
        GROOVE_CORDS * self.cord.mm()
    }

    /// The outline of the groove around a height, in a plug of that radius, mm: upwards.
    pub fn groove(&self, plug_mm: f64, middle_z: f64) -> [[f64; 2]; 4] {
        let half = GROOVE_CORDS / 2.0 * self.cord.mm();
        let (bottom, [low, high]) = (self.radius_mm, [middle_z - half, middle_z + half]);
        [[plug_mm, low], [bottom, low], [bottom, high], [plug_mm, high]]
    }

    /// The ring that is bought for it.
    pub fn ring(&self) -> ORing {
        ORing::or_unstocked(self.cord.mm(), 2.0 * self.radius_mm)
    }

    /// How it is ordered.
    pub fn ordered(&self) -> String {
        let ring = self.ring();
        format!("O-ring {} x {} mm, {}", ring.inside_mm, ring.cord_mm, ring.standard)
    }

    /// Reports a cord, the parameter `path`, of which no ring is stocked for such a `what`, whose
    /// diameter follows from the parameter `from`.
    pub fn check(&self, path: &str, what: &str, from: &str, report: &mut Report) {
        let (cord, diameter) = (self.cord, 2.0 * self.radius_mm);
        let stocked = format!("cords of {} mm are stocked; or change `{from}`", stocked_cords());
        let holds = ORing::on(cord.mm(), diameter).is_some();
        let missing = format!("no O-ring of that cord is stocked for a {what} of {diameter:.2} mm");
        report.require(holds, path, || format!("{path} is {cord}; {missing}"), || stocked);
    }
}
