//! Camera files: fabkit's own, and those of other programs.
//!
//! [`read_file`] recognises the notation by its keys; [`NOTATIONS`] lists them. Only fabkit's own format keeps everything;
//! [`write()`] refuses another format that would lose something, and names what.
//!
//! | notation | keys that tell it | lenses |
//! |---|---|---|
//! | fabkit | `fabkit_camera` | all, with interface and covariance |
//! | Kalibr | `cam0` | OpenCV (4 terms), Kannala-Brandt, double sphere, EUCM |
//! | COLMAP | lines `1 OPENCV 640 480` | OpenCV, Kannala-Brandt |
//! | mrcal | `lensmodel` | OpenCV, stereographic as EUCM |
//! | camodocal | `model_type` | OpenCV, Kannala-Brandt, MEI without distortion as EUCM |
//! | ORB-SLAM | `Camera.fx`, `Camera1.fx` | OpenCV, Kannala-Brandt |
//! | OpenCV, ROS | `camera_matrix`, `K`, ...: YAML, JSON, XML, ini | OpenCV, Kannala-Brandt |
//!
//! Kalibr's `omni` without distortion is read as the equivalent EUCM.
//!
//! All of them but COLMAP put pixel centres at integers, so intrinsics are copied unchanged; half a pixel is subtracted
//! from COLMAP's principal point. The code of OpenCV and Kalibr stops at 90 degrees; here the same coefficients describe
//! the same lens beyond that.
//!
//! Every camera is compared with its image when it is read ([`plausibility`](crate::plausibility)): impossible ones are
//! refused, unusual ones come with [`CameraFile::warnings`].
//!
//! ```
//! use fabkit_camera::files::{self, CameraFormat};
//! use fabkit_camera::{Camera, CameraEstimate};
//!
//! let camera = Camera::equidistant(640, 480, 160f64.to_radians())?;
//! let estimate = CameraEstimate::new(camera, None)?;
//! let text = files::write(&estimate, CameraFormat::Ros)?;
//! assert!(text.contains("distortion_model: equidistant"));
//! assert_eq!(files::read(&text)?, estimate);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod camodocal;
mod colmap;
mod fabkit;
mod fields;
mod ini;
mod kalibr;
mod location;
mod matrices;
mod mrcal;
mod notations;
mod orb_slam;
mod pose;
mod python_literal;
mod regions;
mod xml;
mod yaml;

use thiserror::Error;

pub use fabkit_text::YamlFault;

pub use self::location::split_camera_name;
pub use self::notations::{MAX_FILE_BYTES, NOTATIONS, Notation};
pub use self::pose::{PoseFile, StoredJointCovariance, read_pose};
use crate::estimate::CameraEstimate;
use crate::interface::Interface;
use crate::plausibility::{CameraFinding, plausibility};

/// Format of a camera file.
///
/// ```
/// use fabkit_camera::files::CameraFormat;
/// let named = |name: &str| CameraFormat::ALL.into_iter().find(|format| format.name() == name);
/// assert_eq!(named("kalibr"), Some(CameraFormat::Kalibr));
/// assert_eq!(named("matlab"), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraFormat {
    /// fabkit's own YAML: lossless, with interface and covariance.
    Fabkit,
    /// YAML of `cv::FileStorage` with `camera_matrix` and `distortion_coefficients`.
    OpenCv,
    /// YAML of ROS's `camera_info_manager`.
    Ros,
    /// Kalibr's `camchain.yaml` with one camera.
    Kalibr,
}

impl CameraFormat {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Fabkit, Self::OpenCv, Self::Ros, Self::Kalibr];

    /// Name on the command line: `fabkit`, `opencv`, `ros` or `kalibr`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fabkit => "fabkit",
            Self::OpenCv => "opencv",
            Self::Ros => "ros",
            Self::Kalibr => "kalibr",
        }
    }
}

/// All faults of a camera file.
///
/// ```
/// use fabkit_camera::files;
/// let text = "cam0:\n  camera_model: eucm\n  intrinsics: [0.6, 1.1, -300, three, 319.5, 239.5]\n  \
///             distortion_model: none\n  distortion_coeffs: []\n  resolution: [640, 0]\n";
/// // All at once, each with its line.
/// let wrong = files::read(text).unwrap_err();
/// let lines: Vec<_> = wrong.faults.iter().map(|fault| fault.position.unwrap().line).collect();
/// assert_eq!(lines, [3, 3, 6]);
/// assert!(wrong.to_string().contains("line 3: intrinsics: `three` is not a finite number"));
/// assert!(wrong.to_string().contains("line 6: height_px: is 0, but must be at least 1"));
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", faults.iter().map(YamlFault::to_string).collect::<Vec<_>>().join("\n"))]
pub struct InvalidCameraFile {
    /// Faults, at least one, in the order of the file where lines are known.
    pub faults: Vec<YamlFault>,
}

impl From<YamlFault> for InvalidCameraFile {
    fn from(fault: YamlFault) -> Self {
        Self { faults: vec![fault] }
    }
}

/// Error of a format that cannot hold a camera without loss.
///
/// ```
/// use fabkit_camera::files::{self, CameraFormat};
/// use fabkit_camera::{Camera, FlatInterface, Interface};
/// let lens = *Camera::equidistant(640, 480, 2.5)?.lens();
/// let gel = Interface::Flat(FlatInterface::bare_in_air(5.0, 1.41));
/// let estimate = Camera::new(640, 480, lens, gel)?.into();
/// let refused = files::write(&estimate, CameraFormat::OpenCv).unwrap_err();
/// assert_eq!(refused.lost, ["the refractive interface (flat)"]);
/// // fabkit's own format holds everything.
/// assert_eq!(files::read(&files::write(&estimate, CameraFormat::Fabkit)?)?, estimate);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[error("a camera file of format `{}` would lose {}", format.name(), lost.join(" and "))]
pub struct LossyConversion {
    /// Requested format.
    pub format: CameraFormat,
    /// Parts of the camera that the format cannot hold, in words.
    pub lost: Vec<String>,
}

/// Camera as read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraFile {
    /// Camera with its covariance.
    pub estimate: CameraEstimate,
    /// Unusual values of the camera.
    pub findings: Vec<CameraFinding>,
    /// Parts of the file that were not used, and assumptions, each a sentence.
    pub notes: Vec<String>,
}

impl CameraFile {
    /// Returns findings and notes as sentences for people.
    pub fn warnings(&self) -> Vec<String> {
        let findings = self.findings.iter().map(|found| format!("{found} ({})", found.hint()));
        findings.chain(self.notes.iter().cloned()).collect()
    }
}

impl From<CameraEstimate> for CameraFile {
    /// Wraps a camera that comes from no file.
    fn from(estimate: CameraEstimate) -> Self {
        Self { estimate, findings: Vec::new(), notes: Vec::new() }
    }
}

/// Reads the only camera of a file in any of the [`NOTATIONS`], and drops its warnings; see [`read_file`].
///
/// # Errors
/// Fails as [`read_file`] without a name.
///
/// ```
/// use fabkit_camera::files;
/// let kalibr = "cam0:\n  camera_model: eucm\n  intrinsics: [0.6, 1.1, 300, 301, 319.5, 239.5]\n  \
///               distortion_model: none\n  distortion_coeffs: []\n  resolution: [640, 480]\n";
/// let estimate = files::read(kalibr)?;
/// assert_eq!(estimate.camera().lens().model_name(), "eucm");
/// assert_eq!(estimate.camera().lens().intrinsics().fy_px, 301.0);
/// assert_eq!(estimate.covariance(), None);
/// # Ok::<(), files::InvalidCameraFile>(())
/// ```
pub fn read(text: &str) -> Result<CameraEstimate, InvalidCameraFile> {
    read_file(text, None).map(|file| file.estimate)
}

/// Reads a camera file in any of the [`NOTATIONS`]. `name` selects one of several cameras.
///
/// ```
/// use fabkit_camera::files;
///
/// // COLMAP puts the centre of the first pixel at (0.5, 0.5), fabkit at (0, 0).
/// let text = "# Camera list\n1 SIMPLE_PINHOLE 640 480 500 320 240\n2 PINHOLE 64 48 50 50 32 24\n";
/// let file = files::read_file(text, Some("1"))?;
/// assert_eq!(file.estimate.camera().lens().intrinsics().cx_px, 319.5);
/// assert!(file.warnings().is_empty());
///
/// let error = files::read_file(text, None).unwrap_err().to_string();
/// assert!(error.contains("holds 2 cameras: `1`, `2`"), "{error}");
/// # Ok::<(), files::InvalidCameraFile>(())
/// ```
///
/// # Errors
/// Reports text above 1 MiB (mrcal: [`MAX_FILE_BYTES`]) or that cannot be parsed; a notation that is not recognised; several cameras without a
/// name; missing, misspelt or impossible values. All faults that can be found together are reported together.
pub fn read_file(text: &str, name: Option<&str>) -> Result<CameraFile, InvalidCameraFile> {
    notations::read(text, name)
}

/// Writes a camera file that [`read`] restores to the last bit.
///
/// # Errors
/// Fails for any format but fabkit's own if the camera has an interface, a covariance, or a lens that the format cannot
/// hold, or values that only a file of fabkit's own may declare as right. To give those up deliberately, create a
/// [`CameraEstimate`] without them.
///
/// ```
/// use fabkit_camera::Camera;
/// use fabkit_camera::files::{self, CameraFormat};
/// let estimate = Camera::equidistant(640, 480, 2.5)?.into();
/// let text = files::write(&estimate, CameraFormat::Fabkit)?;
/// assert!(text.contains("width_px: 640\nheight_px: 480\nlens:\n  model: kannala-brandt\n"));
/// assert_eq!(files::read(&text)?, estimate);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(estimate: &CameraEstimate, format: CameraFormat) -> Result<String, LossyConversion> {
    if format == CameraFormat::Fabkit {
        return Ok(fabkit::write(estimate));
    }
    let camera = estimate.camera();
    let text = match format {
        CameraFormat::Kalibr => kalibr::write(camera),
        CameraFormat::Ros => matrices::write_ros(camera),
        _ => matrices::write_opencv(camera),
    };
    let mut lost = Vec::new();
    match camera.interface() {
        // A lens without interface is what all formats hold.
        Interface::None | Interface::FromDrawing => {}
        other => lost.push(format!("the refractive interface ({})", other.kind_name())),
    }
    if estimate.covariance().is_some() {
        lost.push("the covariance of the parameters".to_owned());
    }
    if let Some(found) = plausibility(camera).iter().find(|found| found.is_impossible()) {
        lost.push(format!("that its values are meant so: {found}"));
    }
    match text {
        Ok(text) if lost.is_empty() => Ok(text),
        Ok(_) => Err(LossyConversion { format, lost }),
        Err(lens) => {
            lost.insert(0, lens);
            Err(LossyConversion { format, lost })
        }
    }
}

/// Formats numbers as a YAML list, each in the shortest form that reads back as the same number, in fabkit and in
/// Python.
///
/// ```
/// use fabkit_camera::files::list;
/// assert_eq!(list([640.0, 0.1, -1e-17]), "[640.0, 0.1, -1.0e-17]");
/// ```
pub fn list(values: impl IntoIterator<Item = f64>) -> String {
    let numbers: Vec<String> = values.into_iter().map(number).collect();
    format!("[{}]", numbers.join(", "))
}

/// Formats a number in the shortest form that reads back as the same number, in fabkit and in Python.
///
/// YAML 1.1, which PyYAML follows, reads `1e-17` as a string: a number with an exponent needs a decimal point, and the
/// exponent a sign.
fn number(value: f64) -> String {
    let shortest = format!("{value:?}");
    let Some((mantissa, exponent)) = shortest.split_once('e') else { return shortest };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{mantissa}{point}e{sign}{exponent}")
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_are_numbers_in_every_yaml() {
        for (value, expected) in [
            (-1e-17, "-1.0e-17"),
            (1.5e300, "1.5e+300"),
            (1e16, "1.0e+16"),
            (-0.25971254, "-0.25971254"),
            (640.0, "640.0"),
        ] {
            assert_eq!(super::number(value), expected);
            assert_eq!(expected.parse(), Ok(value));
        }
    }
}
