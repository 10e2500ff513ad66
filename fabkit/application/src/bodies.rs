//! Lookup of a sensor's bodies by name.

use fabkit_files::UnknownName;
use fabkit_fixtures::fixture_names;
use fabkit_geometry::{Body, Sensor};

/// Finds the body with this name.
///
/// # Errors
/// [`UnknownName`], which lists the existing names.
///
/// ```
/// use fabkit_application::{bodies::find, source::Target};
///
/// let design = Target::new("rtac0").design(&[])?;
/// assert_eq!(find(&design.sensor, "base").map(|body| &*body.name), Ok("base"));
/// let unknown = find(&design.sensor, "bass").unwrap_err();
/// assert_eq!(unknown.closest.as_deref(), Some("base"));
/// # Ok::<(), fabkit_application::Error>(())
/// ```
pub fn find<'a>(sensor: &'a Sensor, name: &str) -> Result<&'a Body, UnknownName> {
    sensor.body(name).ok_or_else(|| {
        UnknownName::new("part", name, sensor.bodies.iter().map(|body| body.name.as_str()))
    })
}

/// Finds the body of a target `SENSOR/NAME`.
///
/// # Errors
/// [`UnknownName`], which may suggest a fixture, because fixtures are written the same way.
pub fn find_target<'a>(sensor: &'a Sensor, name: &str) -> Result<&'a Body, UnknownName> {
    find(sensor, name).map_err(|unknown| match unknown.closest {
        Some(_) => unknown,
        None => {
            let fixtures = fixture_names().map(str::to_owned);
            let all: Vec<String> = unknown.known.iter().cloned().chain(fixtures).collect();
            UnknownName::new("part or fixture", name, all.iter().map(String::as_str))
        }
    })
}
