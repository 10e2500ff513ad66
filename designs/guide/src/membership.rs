//! Membership of bodies in the finished unit.

use fabkit_geometry::{Assembly, Body};

/// Returns whether a body stays in the finished sensor.
pub(crate) fn stays(body: &Body) -> bool {
    let place = Assembly::sensor();
    body.placements.iter().any(|placed| placed.assembly == place)
}
