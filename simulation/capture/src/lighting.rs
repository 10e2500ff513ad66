//! Selection of a sensor's lighting and its optical constants.

use std::path::Path;

use fabkit_files::Error;
use fabkit_fixtures::Project;
use fabkit_geometry::{Lighting, Sensor};

use super::constants_file::read_constants;
use super::{CaptureError, LightConstants, Unit};

/// Finds a sensor's lighting by name, or returns its default lighting.
///
/// # Errors
/// [`CaptureError`] for an unknown name, and for a sensor without lightings.
///
/// ```
/// use fabkit_capture::find_lighting;
///
/// # let yaml = fabkit_designs::builtin_yaml("uvdtact").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("uvdtact.yaml", yaml, &[])?;
/// let sensor = &project.design.sensor;
/// assert_eq!(find_lighting(sensor, None)?.name, "white");
/// // Its inks glow in ultraviolet light, each in its own colour.
/// assert!(find_lighting(sensor, Some("uv"))?.is_colored());
/// assert!(find_lighting(sensor, Some("infrared")).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn find_lighting<'a>(
    sensor: &'a Sensor,
    name: Option<&str>,
) -> Result<&'a Lighting, CaptureError> {
    let Some(name) = name else {
        let missing = || CaptureError::UnknownLighting { sensor: sensor.name.clone() };
        return sensor.lightings.first().ok_or_else(missing);
    };
    let unknown = || CaptureError::NoSuchLighting {
        sensor: sensor.name.clone(),
        light: name.to_owned(),
        known: sensor.lightings.iter().map(|light| light.name).collect(),
    };
    sensor.lightings.iter().find(|light| light.name == name).ok_or_else(unknown)
}

/// Selects a lighting as [`find_lighting`] does, with the constants of a file or else the sensor's own. For a unit, the
/// constants get that unit's deviations.
///
/// # Errors
/// Returns an error for an unknown lighting, and for a file that cannot be read or holds no constants.
///
/// ```
/// use fabkit_capture::{LightConstants, select_lighting};
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let (lighting, constants) = select_lighting(&project, Some("white"), None)?;
/// assert_eq!(lighting.name, "white");
/// // The drawn sensor has the usual constants.
/// assert_eq!(constants, LightConstants::for_sensor(&project.design.sensor));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn select_lighting<'a>(
    project: &'a Project,
    light: Option<&str>,
    constants: Option<&Path>,
) -> Result<(&'a Lighting, LightConstants), Error> {
    let sensor = &project.design.sensor;
    let lighting = find_lighting(sensor, light)?;
    let mut constants = match constants {
        Some(path) => read_constants(sensor, path)?,
        None => LightConstants::for_sensor(sensor),
    };
    if let Some(unit) = &project.unit {
        Unit(unit.number).apply_to_constants(&mut constants);
    }
    Ok((lighting, constants))
}
