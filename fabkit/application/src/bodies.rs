//! Lookup of a sensor's bodies by name.

use fabkit_files::UnknownName;
use fabkit_geometry::{Body, Sensor};

/// Finds the body with this name.
///
/// # Errors
/// [`UnknownName`], which lists the existing names.
pub fn find<'a>(sensor: &'a Sensor, name: &str) -> Result<&'a Body, UnknownName> {
    sensor.body(name).ok_or_else(|| {
        UnknownName::new("part", name, sensor.bodies.iter().map(|body| body.name.as_str()))
    })
}
