//! Reading of fitted constants from the files of `fit-light`.

use std::path::{Path, PathBuf};

use fabkit_files::reading::{self, ExpectedFile};
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained};
use fabkit_geometry::Sensor;
use serde_json::Value;

use super::{Constant, LightConstants, Provenance};

/// Name of the file format.
pub(super) const FORMAT: &str = "fabkit-fit-light";

/// Names of the fitted constants, in the order of a fit's parameters.
pub(super) const FITTED: [&str; 4] = ["layer_grey", "ground_grey", "scatter_per_mm", "spread_mm"];

/// Smallest and largest value of each of [`FITTED`] that a file may hold.
///
/// A layer that is thin to its light shows the product of intensity and scattering alone, so the first may be far above
/// 255: a hundred times it, and as far below one step. Stray light cannot exceed white. White paint and skimmed milk scatter
/// 10 to 50 per mm, and a layer of 0.001 per mm sends 0.1 % back from a millimetre. Light that spreads further than 20 mm
/// crosses every sensor's window; a nanometre stands for none.
const RANGES: [[f64; 2]; 4] = [[1e-3, 25_500.0], [0.0, 255.0], [1e-3, 100.0], [1e-6, 20.0]];

/// Hint for files without constants.
const HINT: &str = "`fabkit fit-light` writes such files with -o";

/// A file that holds no constants of light.
#[derive(Debug, thiserror::Error)]
#[error("{} {what}", .file.display())]
pub struct ConstantsError {
    /// Path of the file.
    pub file: PathBuf,
    /// Description of the fault.
    pub what: String,
}

impl Explained for ConstantsError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        Some(HINT.into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new("no_light")
    }
}

/// Reads a unit's constants from a file of `fit-light`. Constants that are not fitted keep the sensor's defaults.
///
/// # Errors
/// Returns an error for a file that cannot be read or is not of this format.
///
/// ```
/// use std::path::Path;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let missing = fabkit_capture::read_constants(&project.design.sensor, Path::new("no-such-light.json"));
/// assert!(missing.unwrap_err().to_string().contains("no-such-light.json"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_constants(sensor: &Sensor, path: &Path) -> Result<LightConstants, Error> {
    let expected = ExpectedFile { what: "constants of light", max_bytes: 1 << 20, hint: HINT };
    let text = reading::read_text(path, expected)?;
    let wrong = |what: &str| ConstantsError { file: path.into(), what: what.to_owned() };
    let document: Value =
        serde_json::from_str(&text).map_err(|error| wrong(&format!("is no JSON: {error}")))?;
    if document["format"] != FORMAT || document["version"] != 1 {
        return Err(wrong("is not of the format fabkit-fit-light 1").into());
    }
    let value = |name: &str, [least, most]: [f64; 2]| {
        let constants = document["constants"].as_array().into_iter().flatten();
        let mut named = constants.filter(|constant| constant["name"] == name);
        let value = named.next().and_then(|constant| constant["value"].as_f64());
        let value = value.ok_or_else(|| wrong(&format!("has no number {name}")))?;
        if (least..=most).contains(&value) {
            return Ok(value);
        }
        Err(wrong(&format!("has {name} {value}; it is between {least} and {most}")))
    };
    let rms = document["held_out_profile_rms_grey"].as_f64();
    let rms = rms.map_or_else(
        || "none was held out".to_owned(),
        |rms| format!("{rms:.1} grey rms are left on those that were held out"),
    );
    // Fits on pads hold the lateral spread constant.
    let is_pad = document["balls"].is_array();
    let (fitted, what) = if is_pad { (&FITTED[..3], "balls") } else { (&FITTED[..], "pins") };
    let source =
        format!("{}: fitted to {} captures of {what}; {rms}", path.display(), document["captures"]);
    let mut constants = LightConstants { middle_grey: None, ..LightConstants::for_sensor(sensor) };
    let parts: [&mut Constant; 4] = [
        &mut constants.layer_grey,
        &mut constants.ground_grey,
        &mut constants.scatter_per_mm,
        &mut constants.spread_mm,
    ];
    for ((constant, name), range) in parts.into_iter().zip(fitted).zip(RANGES) {
        (constant.value, constant.known) = (value(name, range)?, Provenance::Fitted);
        constant.source.clone_from(&source);
        constant.unknown.clear();
    }
    Ok(constants)
}
