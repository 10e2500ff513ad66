//! Clearances by process: the single table that every part takes its fits from.

use fabkit_geometry::Process;

/// Fit between two parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// Holds by friction; pushed in by hand or with a vice.
    Press,
    /// Located with negligible play; pushed in by hand.
    Snug,
    /// Moves freely, stays centred.
    Slide,
    /// Never touches: passages for bolts, cables, moving parts.
    Free,
}

/// Returns the gap per side, mm, between a hole made by `process` and a body of the hole's nominal size; negative where
/// the two overlap.
///
/// The values are chosen for ordinary machines: a 0.4 mm nozzle closes holes by 0.1 to 0.2 mm, resin and laser stay
/// within 0.05 mm, routed board edges within 0.1 mm. A lab replaces them by the measurements of its own coupon.
///
/// ```
/// use fabkit_designs::{Fit, gap_mm};
/// use fabkit_geometry::Process;
/// // A shaft of 5 mm slides in a hole that is drawn with 5.4 mm and printed from filament.
/// let hole_mm = 5.0 + 2.0 * gap_mm(Process::Fdm, Fit::Slide);
/// assert_eq!(hole_mm, 5.4);
/// assert!(gap_mm(Process::Fdm, Fit::Press) < 0.0);
/// ```
pub fn gap_mm(process: Process, fit: Fit) -> f64 {
    let [press, snug, slide, free] = match process {
        Process::Fdm => [-0.05, 0.10, 0.20, 0.35],
        Process::Sla | Process::Cast => [-0.03, 0.05, 0.10, 0.20],
        // Two jetted materials bleed into each other, and support leaves a rough face.
        Process::PolyJet => [-0.03, 0.08, 0.15, 0.25],
        Process::Laser => [-0.03, 0.05, 0.10, 0.15],
        Process::Cnc => [-0.01, 0.02, 0.05, 0.10],
        Process::Pcb => [-0.05, 0.05, 0.10, 0.15],
    };
    match fit {
        Fit::Press => press,
        Fit::Snug => snug,
        Fit::Slide => slide,
        Fit::Free => free,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_loosen_in_order() {
        use Process::*;
        for process in [Fdm, Sla, PolyJet, Laser, Cnc, Cast, Pcb] {
            let gaps = [Fit::Press, Fit::Snug, Fit::Slide, Fit::Free].map(|f| gap_mm(process, f));
            assert!(gaps[0] < 0.0 && gaps.windows(2).all(|w| w[0] < w[1]), "{process}: {gaps:?}");
        }
    }
}
