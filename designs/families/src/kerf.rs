//! How wide a cutter's beam or tool is: the one table that exported outlines are widened by.

use fabkit_geometry::Process;

/// Kerfs by a word of the material's name, mm; the first that fits counts.
///
/// Chosen for CO2 lasers with the common 2 inch lens at the thickness of these sensors (2 to 6 mm):
/// acrylic evaporates cleanly, wood chars a little wider, film and paper are thin enough for the
/// focus alone. Machines differ by more than 0.05 mm: cut ten 20 mm squares side by side, measure
/// what is missing, and say so with `--kerf`.
const LASER_KERFS_MM: &[(&[&str], f64)] = &[
    (&["acrylic", "pmma", "plexiglas"], 0.20),
    (&["wood", "mdf", "birch"], 0.25),
    (&["film", "paper", "card"], 0.10),
];

/// For what the table does not name.
const OTHER_LASER_KERF_MM: f64 = 0.20;

/// Width of the cut that a process makes in a material, mm; 0 where the maker of the part
/// compensates (boards are routed to their outline) or where nothing is cut along a line.
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
