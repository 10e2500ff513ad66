//! Seat that an O-ring is stretched over: the neck between two faces, or the bottom of a groove.

use fabkit_geometry::Length;

use crate::hardware::{ORing, stocked_cords};
use crate::parameters::RuleReport;

/// Width of a groove in cord diameters: a squeezed cord gets wider.
const GROOVE_CORDS: f64 = 1.3;

/// Seat of an O-ring.
///
/// ```
/// use fabkit_designs::blocks::ORingSeat;
/// use fabkit_geometry::Length;
/// let cord = Length::from_mm(2.0).ok_or("not finite")?;
/// // A fifth of the cord is squeezed away between the bore of 10 mm and the groove's bottom.
/// let seat = ORingSeat::squeezed_in(10.0, cord, 0.2);
/// assert!((seat.radius_mm - 8.4).abs() < 1e-12);
/// assert_eq!(seat.order_text(), "O-ring 16 x 2 mm, metric stock size");
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ORingSeat {
    /// Diameter of the ring's cord.
    pub cord: Length,
    /// Radius of the seat, mm.
    pub radius_mm: f64,
}

impl ORingSeat {
    /// Creates a groove whose ring is squeezed by a bore of that radius (mm), by a fraction of its cord.
    pub fn squeezed_in(bore_mm: f64, cord: Length, squeeze: f64) -> Self {
        Self { cord, radius_mm: bore_mm - cord.mm() * (1.0 - squeeze) }
    }

    /// Returns the width of the groove, mm.
    pub fn width_mm(&self) -> f64 {
        GROOVE_CORDS * self.cord.mm()
    }

    /// Returns the outline of the groove around a height, in a plug of that radius, mm, from bottom to top.
    pub fn groove(&self, plug_mm: f64, middle_z: f64) -> [[f64; 2]; 4] {
        let half = GROOVE_CORDS / 2.0 * self.cord.mm();
        let (bottom, [low, high]) = (self.radius_mm, [middle_z - half, middle_z + half]);
        [[plug_mm, low], [bottom, low], [bottom, high], [plug_mm, high]]
    }

    /// Returns the O-ring that is bought for the seat.
    pub fn ring(&self) -> ORing {
        ORing::or_unstocked(self.cord.mm(), 2.0 * self.radius_mm)
    }

    /// Returns the text that the ring is ordered by.
    pub fn order_text(&self) -> String {
        let ring = self.ring();
        format!("O-ring {} x {} mm, {}", ring.inside_mm, ring.cord_mm, ring.standard)
    }

    /// Reports a cord, the parameter `path`, for which no ring of the seat's diameter is stocked. `what` names the
    /// seat, `from` is the parameter that sets its diameter.
    pub fn check(&self, path: &str, what: &str, from: &str, report: &mut RuleReport) {
        let (cord, diameter) = (self.cord, 2.0 * self.radius_mm);
        let stocked = format!("cords of {} mm are stocked; or change `{from}`", stocked_cords());
        let holds = ORing::find_stocked(cord.mm(), diameter).is_some();
        let missing = format!("no O-ring of that cord is stocked for a {what} of {diameter:.2} mm");
        report.require(holds, path, || format!("{path} is {cord}; {missing}"), || stocked);
    }
}
