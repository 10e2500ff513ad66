//! What lights a sensor, and what its light rests on.

use std::path::Path;

use fabkit_files::Error;
use fabkit_fixtures::Project;
use fabkit_geometry::{Lighting, Sensor};

use super::constants_file::read_constants;
use super::{CaptureError, LightConstants, Unit};

/// A sensor's light by its name, or its usual one.
///
/// # Errors
/// [`CaptureError`]: none of that name, or none at all.
pub fn lighting<'a>(sensor: &'a Sensor, name: Option<&str>) -> Result<&'a Lighting, CaptureError> {
    let Some(name) = name else {
        let missing = || CaptureError::OtherLight { sensor: sensor.name.clone() };
        return sensor.lightings.first().ok_or_else(missing);
    };
    let unknown = || CaptureError::UnknownLight {
        sensor: sensor.name.clone(),
        light: name.to_owned(),
        known: sensor.lightings.iter().map(|light| light.name).collect(),
    };
    sensor.lightings.iter().find(|light| light.name == name).ok_or_else(unknown)
}

/// A light of a sensor as for [`lighting`], and the constants of a file or the sensor's own; of a unit as they
/// came out in it.
///
/// # Errors
/// A light that the sensor has not; a file that cannot be read, or holds no constants.
pub fn lit<'a>(
    project: &'a Project,
    light: Option<&str>,
    constants: Option<&Path>,
) -> Result<(&'a Lighting, LightConstants), Error> {
    let sensor = &project.design.sensor;
    let lighting = lighting(sensor, light)?;
    let mut constants = match constants {
        Some(path) => read_constants(sensor, path)?,
        None => LightConstants::of(sensor),
    };
    if let Some(unit) = &project.unit {
        Unit(unit.number).change(&mut constants);
    }
    Ok((lighting, constants))
}
