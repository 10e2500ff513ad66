//! Dimensional errors of one printer, measured on a coupon.
//!
//! Every size comes out as `gain * designed + offset`. Shrinkage reduces lengths in proportion; holes also lose an
//! offset, because the molten line is dragged towards their middle. A profile holds both and inverts them for exported
//! copies: the nominal geometry, and all that is derived from it, stays as designed.

mod coupon;
mod gel_coupon;
mod hole_compensation;
mod linear_fit;
mod profile_file;
mod profile_match;

pub use coupon::{Coupon, CouponGroup, CouponRow, MeasuredProfile};
pub use gel_coupon::{GelCoupon, GelReading};
pub use hole_compensation::HoleCount;
pub use linear_fit::LinearFit;
pub use profile_match::ProfileMatch;

use fabkit_geometry::{Length, Process};

use crate::parameters::FileSafeName;
use crate::{choices, parameters};

choices! {
    /// Printing process whose dimensional errors a coupon can show.
    pub enum PrintProcess {
        /// Filament printing.
        Fdm = "fdm",
        /// Resin printing.
        Sla = "sla",
        /// Printing with jetted resin.
        PolyJet = "polyjet",
    }
}

impl PrintProcess {
    /// Returns the printing process that corresponds to a process; `None` for parts that are not printed.
    ///
    /// ```
    /// use fabkit_designs::profile::PrintProcess;
    /// use fabkit_geometry::Process;
    /// assert_eq!(PrintProcess::from_process(Process::Sla), Some(PrintProcess::Sla));
    /// assert_eq!(PrintProcess::from_process(Process::Laser), None);
    /// ```
    pub fn from_process(process: Process) -> Option<Self> {
        [Self::Fdm, Self::Sla, Self::PolyJet].into_iter().find(|known| known.process() == process)
    }

    /// Returns the process of the geometry crate.
    pub fn process(self) -> Process {
        match self {
            Self::Fdm => Process::Fdm,
            Self::Sla => Process::Sla,
            Self::PolyJet => Process::PolyJet,
        }
    }
}

parameters! {
    /// Relative difference by which printed lengths are smaller than designed ones, percent.
    pub struct Shrinkage {
        /// Shrinkage along the bed's x, percent.
        x: f64 = -5.0..=5.0,
        /// Shrinkage along the bed's y, percent.
        y: f64 = -5.0..=5.0,
        /// Shrinkage in the vertical direction, percent.
        z: f64 = -5.0..=5.0,
    }
}

parameters! {
    /// Linear fit of printed diameters: `gain` times the designed diameter, plus `offset`.
    pub struct DiameterFit {
        /// Offset that is added to the diameter.
        offset: Length = -2.0..=2.0,
        /// Factor by which the designed diameter is multiplied.
        gain: f64 = 0.8..=1.2,
        /// Smallest designed diameter that was measured.
        smallest: Length = 0.1..=100.0,
        /// Largest designed diameter that was measured.
        largest: Length = 0.1..=200.0,
    }
}

parameters! {
    /// Dimensional errors of one printer.
    pub struct ProcessProfile {
        /// Name of the printer.
        name: FileSafeName,
        /// Process by which the coupon was printed; the profile applies to parts printed in the same way.
        process: PrintProcess,
        /// Material of the coupon; the profile applies to parts of the same material.
        material: String = 1..=80,
        /// Relative difference by which printed lengths are smaller than designed ones, percent.
        shrinkage_percent: Shrinkage,
        /// Linear fit of the diameters of upright round holes.
        holes: DiameterFit,
        /// Linear fit of the diameters of upright round pins.
        pins: DiameterFit,
        /// Distance by which the first layer spreads beyond those above, on each side.
        elephant_foot: Length = 0.0..=2.0,
    }
}

impl ProcessProfile {
    /// Returns the factors along the bed's axes that compensate for shrinkage.
    ///
    /// ```
    /// use fabkit_designs::profile::ProcessProfile;
    /// let yaml = "
    /// format: 1
    /// name: my-printer
    /// process: fdm
    /// material: PLA
    /// shrinkage_percent: {x: 0.5, y: 0.0, z: 0.0}
    /// holes: {offset: -0.2 mm, gain: 0.995, smallest: 2 mm, largest: 12 mm}
    /// pins: {offset: 0.1 mm, gain: 0.995, smallest: 2 mm, largest: 8 mm}
    /// elephant_foot: 0.1 mm
    /// ";
    /// let profile = ProcessProfile::read("my-printer.yaml", yaml)?;
    /// assert!((profile.scale()[0] - 1.0 / 0.995).abs() < 1e-12);
    /// // A hole that should come out with 5 mm.
    /// assert!((profile.hole_mm(5.0) - 5.2 / 0.995).abs() < 1e-12);
    /// # Ok::<(), fabkit_designs::parameters::InvalidDesign>(())
    /// ```
    pub fn scale(&self) -> [f64; 3] {
        let Shrinkage { x, y, z } = self.shrinkage_percent;
        [x, y, z].map(|percent| 1.0 / (1.0 - percent / 100.0))
    }

    /// Returns the diameter to write to a file for a hole that comes out of the printer as `wanted_mm`.
    pub fn hole_mm(&self, wanted_mm: f64) -> f64 {
        (wanted_mm - self.holes.offset.mm()) / self.holes.gain
    }
}
