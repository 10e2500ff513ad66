//! Bodies of a sensor by their names.

use fabkit_files::UnknownName;
use fabkit_geometry::{Body, Sensor};

/// Finds the body of that name.
///
/// # Errors
/// [`UnknownName`] with the names that there are.
pub fn find<'a>(sensor: &'a Sensor, name: &str) -> Result<&'a Body, UnknownName> {
    sensor.body(name).ok_or_else(|| {
        UnknownName::new("part", name, sensor.bodies.iter().map(|body| body.name.as_str()))
    })
}
