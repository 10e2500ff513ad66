//! Kerfs, the widths of a cutter's beam or tool: the single table by which exported outlines are widened.

use fabkit_geometry::Process;

/// Laser kerfs by words of the material's name, mm; the first match counts.
///
/// Chosen for CO2 lasers with the common 2 inch lens at the thickness of these sensors (2 to 6 mm): acrylic evaporates
/// cleanly, wood chars a little wider, film and paper are thin enough for the focus alone. Machines differ by more than
/// 0.05 mm: cut ten 20 mm squares side by side, measure how much is missing, and pass that with `--kerf`.
const LASER_KERFS_MM: &[(&[&str], f64)] = &[
    (&["acrylic", "pmma", "plexiglas"], 0.20),
    (&["wood", "mdf", "birch"], 0.25),
    (&["film", "paper", "card"], 0.10),
];

/// Laser kerf of materials that the table does not name, mm.
const OTHER_LASER_KERF_MM: f64 = 0.20;

/// Returns the kerf of a process in a material, mm; 0 where the maker of the part compensates (boards are routed to
/// their outline) or nothing is cut along a line.
///
/// ```
/// use fabkit_designs::kerf_mm;
/// use fabkit_geometry::Process;
/// assert_eq!(kerf_mm(Process::Laser, "birch plywood"), 0.25);
/// assert_eq!(kerf_mm(Process::Pcb, "FR4"), 0.0);
/// ```
pub fn kerf_mm(process: Process, material: &str) -> f64 {
    if process != Process::Laser {
        return 0.0;
    }
    let material = material.to_ascii_lowercase();
    let named = |(words, _): &&(&[&str], f64)| words.iter().any(|word| material.contains(word));
    LASER_KERFS_MM.iter().find(named).map_or(OTHER_LASER_KERF_MM, |(_, kerf_mm)| *kerf_mm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_are_found_by_any_of_their_words() {
        assert_eq!(kerf_mm(Process::Laser, "Frosted PMMA"), 0.20);
        assert_eq!(kerf_mm(Process::Laser, "MDF"), 0.25);
        assert_eq!(kerf_mm(Process::Laser, "polyester film"), 0.10);
        assert_eq!(kerf_mm(Process::Laser, "unobtainium"), OTHER_LASER_KERF_MM);
        assert_eq!(kerf_mm(Process::Fdm, "PMMA"), 0.0);
    }
}
