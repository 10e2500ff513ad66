//! Membership of bodies in the finished unit.

use fabkit_geometry::{Assembly, Body};

/// Returns whether a body stays in the finished sensor.
pub(crate) fn is_in_sensor(body: &Body) -> bool {
    let place = Assembly::sensor();
    body.placements.iter().any(|placed| placed.assembly == place)
}
