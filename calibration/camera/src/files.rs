//! Camera files in YAML: fabkit's own format, OpenCV's, ROS's and Kalibr's.
//!
//! [`read`] recognises the format by its keys. Only fabkit's own format keeps everything; [`write()`] refuses another
//! format that would lose something, and names what.
//!
//! | format | keys that tell it | lenses |
//! |---|---|---|
//! | [`CameraFormat::Fabkit`] | `fabkit_camera` | all, with interface and covariance |
//! | [`CameraFormat::OpenCv`] | `camera_matrix` or `K`, each an `!!opencv-matrix` | OpenCV, Kannala-Brandt |
//! | [`CameraFormat::Ros`] | `distortion_model` beside a camera matrix | OpenCV, Kannala-Brandt |
//! | [`CameraFormat::Kalibr`] | `cam0` | OpenCV (4 terms), Kannala-Brandt, double sphere, EUCM |
//!
//! Kalibr's `omni` without distortion is read as the equivalent EUCM.
//!
//! All four formats put pixel centres at integers, so intrinsics are copied unchanged. The code of OpenCV and Kalibr
//! stops at 90 degrees; here the same coefficients describe the same lens beyond that.
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

mod fabkit;
mod fields;
mod kalibr;
mod matrices;
mod pose;

use fabkit_text::{Dialect, YamlContent, YamlNode};
use thiserror::Error;

pub use fabkit_text::YamlFault;

pub use self::pose::{PoseFile, StoredJointCovariance, read_pose};
use crate::estimate::CameraEstimate;
use crate::interface::Interface;

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

/// Reads a camera file of any format in [`CameraFormat`].
///
/// # Errors
/// Reports text above 1 MiB or that is not YAML; a format that is not recognised; missing, misspelt or impossible
/// values. All faults that can be found together are reported together.
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
    parse(text, read_root)
}

/// Recognises the format of a camera file and reads it.
fn read_root(root: &YamlNode) -> Result<CameraEstimate, InvalidCameraFile> {
    // The most specific key first: other formats may use common names.
    let has = |key: &str| root.get(key).is_some();
    if has(fabkit::VERSION_KEY) {
        fabkit::read(root)
    } else if has("cam0") {
        kalibr::read(root)
    } else if matrices::is_recognised(root) {
        matrices::read(root)
    } else {
        Err(YamlFault::new(None, "", "this is no camera file that fabkit knows")
            .hint(
                "expected one of the keys `fabkit_camera` (fabkit), `camera_matrix` or `K` \
                 (OpenCV, ROS), `cam0` (Kalibr)",
            )
            .into())
    }
}

/// Parses a text as YAML, then reads its content with `read`. Duplicate keys are faults too.
fn parse<T>(
    text: &str,
    read: impl Fn(&YamlNode) -> Result<T, InvalidCameraFile>,
) -> Result<T, InvalidCameraFile> {
    const CAMERA: Dialect = Dialect { tags: &["opencv-matrix"], ..Dialect::new("camera", 1, "") };
    // Editors on Windows may write a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // OpenCV's first line, `%YAML:1.0`, is not YAML.
    let commented =
        if text.starts_with("%YAML") { format!("#{}", &text[1..]) } else { text.to_owned() };
    let (root, twice) = fabkit_text::parse(&commented, &CAMERA)?;
    if root.content == YamlContent::Nothing {
        return Err(YamlFault::new(None, "", "the file is empty").into());
    }
    match read(&root) {
        Ok(read) if twice.is_empty() => Ok(read),
        Ok(_) => Err(InvalidCameraFile { faults: twice }),
        Err(InvalidCameraFile { mut faults }) => {
            faults.extend(twice);
            // Duplicate keys are found first, but belong between the other faults.
            faults.sort_by_key(fault_line);
            Err(InvalidCameraFile { faults })
        }
    }
}

/// Returns the line of a fault; faults of the whole file sort first.
fn fault_line(fault: &YamlFault) -> Option<usize> {
    fault.position.map(|at| at.line)
}

/// Writes a camera file that [`read`] restores to the last bit.
///
/// # Errors
/// Fails for any format but fabkit's own if the camera has an interface, a covariance, or a lens that the format cannot
/// hold. To give those up deliberately, create a [`CameraEstimate`] without them.
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
