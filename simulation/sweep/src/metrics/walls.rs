//! Metric of the thinnest wall of printed parts.

use fabkit_checks::{part_limits, thinnest_wall};
use fabkit_geometry::{CompiledSolid, InvalidSolid, Sensor};

use super::ComputedMetrics;

/// Largest wall thickness that is reported, mm: thicker walls are no problem.
const LIMIT_MM: f64 = 5.0;
/// Number of lines through each part in each of three directions: walls narrower than a thirtieth of the part may be
/// missed.
const LINES: usize = 600;

/// Computes the group's metric; nothing without printed parts.
pub(super) fn compute(sensor: &Sensor, computed: &mut ComputedMetrics) -> Result<(), InvalidSolid> {
    let mut smallest_mm: Option<f64> = None;
    for part in sensor.parts().filter(|part| part_limits(part).is_some()) {
        let found = thinnest_wall(&CompiledSolid::new(&part.solid)?, LIMIT_MM, LINES);
        // A part without any wall below the limit counts with the limit.
        let wall_mm = found.map_or(LIMIT_MM, |(wall_mm, _)| wall_mm);
        smallest_mm = Some(smallest_mm.map_or(wall_mm, |smallest| smallest.min(wall_mm)));
    }
    if let Some(smallest_mm) = smallest_mm {
        computed.put("smallest_wall_mm", smallest_mm);
    }
    Ok(())
}
