//! Kerfs, the widths of a cutter's beam or tool, by which exported outlines are widened.

use fabkit_geometry::{MaterialProperties, Process};

/// Laser kerf of materials that state none, mm: chosen, that of acrylic. Machines differ by more than 0.05 mm: cut ten
/// 20 mm squares side by side, measure how much is missing, and pass that with `--kerf`.
const OTHER_LASER_KERF_MM: f64 = 0.20;

/// Returns the kerf of a process in a material, mm; 0 where the maker of the part compensates (boards are routed to
/// their outline) or nothing is cut along a line.
///
/// ```
/// use fabkit_designs::kerf_mm;
/// use fabkit_geometry::{MaterialProperties, Process};
/// let plywood = MaterialProperties { laser_kerf_mm: Some(0.25), ..Default::default() };
/// assert_eq!(kerf_mm(Process::Laser, &plywood), 0.25);
/// assert_eq!(kerf_mm(Process::Pcb, &plywood), 0.0);
/// assert_eq!(kerf_mm(Process::Laser, &MaterialProperties::default()), 0.20);
/// ```
pub fn kerf_mm(process: Process, material: &MaterialProperties) -> f64 {
    match process {
        Process::Laser => material.laser_kerf_mm.unwrap_or(OTHER_LASER_KERF_MM),
        _ => 0.0,
    }
}
