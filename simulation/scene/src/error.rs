//! Errors of ground truth and of viewpoints.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use fabkit_files::{ErrorKind, ErrorSubject, Explained, UnknownName, join_first_messages};
use fabkit_fixtures::PressError;
use fabkit_optics::{InvalidStack, REFRACTION};

use super::{MAX_RAYS, MAX_SAMPLES};
use crate::ground_truth::{InvalidViewpoint, OUTSIDE_IMAGE, SurfaceCoverage};

/// Reason why ground truth cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The sensor has no sensing surface of known shape.
    #[error("{sensor} has no sensing surface of known shape to look at")]
    NoSurface {
        /// Name of the sensor.
        sensor: String,
    },
    /// Bodies that light cannot be traced through.
    #[error(transparent)]
    Light(InvalidStack),
    /// A camera whose view of the surface is blocked completely.
    #[error("the camera sees none of the surface: {}", join_causes(.lost))]
    Hidden {
        /// Blocking bodies or causes, with their shares of the surface's area.
        lost: Vec<(String, f64)>,
    },
    /// A camera that looks away from the surface.
    #[error(
        "the camera sees none of the surface: it lies {:.0} to {:.0} deg off the camera's axis, and \
         the lens reaches {:.0} deg",
        .angles_rad[0].to_degrees(),
        .angles_rad[1].to_degrees(),
        .lens_rad.to_degrees()
    )]
    OutOfView {
        /// Smallest and largest angle between the surface's points and the camera's axis, rad.
        angles_rad: [f64; 2],
        /// Largest angle off the axis that the lens images, rad.
        lens_rad: f64,
    },
    /// A fault in a camera file, in a pose file, or in their combination.
    #[error("{}{source}", .file.iter().map(|f| format!("{}: ", f.display())).collect::<String>())]
    Viewpoint {
        /// Path of the faulty file; `None` for input that did not come from a file.
        file: Option<PathBuf>,
        /// The fault itself.
        source: InvalidViewpoint,
    },
    /// A number of samples per pixel outside its limits.
    #[error("{samples} samples; the limits are 1 and {MAX_SAMPLES}")]
    Samples {
        /// Requested number of rays along each side of a pixel.
        samples: u32,
    },
    /// A length outside its limits.
    #[error("{name}: {value_mm} mm; the limits are {} mm and {} mm", .limits_mm[0], .limits_mm[1])]
    Length {
        /// Name of the length in messages.
        name: &'static str,
        /// Requested value, mm.
        value_mm: f64,
        /// Smallest and largest allowed value, mm.
        limits_mm: [f64; 2],
    },
    /// More rays than one cast may have.
    #[error("{width} x {height} rays are more than {MAX_RAYS}")]
    TooManyRays {
        /// Number of ray columns.
        width: u32,
        /// Number of ray rows.
        height: u32,
    },
    /// A press that does not exist or cannot be built.
    #[error(transparent)]
    Press(PressError),
    /// Presses that reach below the soft layer, one sentence each.
    #[error("{}", join_first_messages(.0))]
    TooDeep(Vec<String>),
    /// Presses that do not touch the surface.
    #[error("{}", join_first_messages(.faults))]
    NoContact {
        /// One sentence for each press.
        faults: Vec<String>,
        /// Identifier of one of the presses at a depth at which it touches, as a suggestion.
        deeper: Option<String>,
    },
    /// Presses of which the camera sees nothing, one sentence each.
    #[error("{}", join_first_messages(.0))]
    PressNotVisible(Vec<String>),
}

impl SceneError {
    pub(super) fn unseen(coverage: &SurfaceCoverage) -> Self {
        // The largest share decides: surface outside the image is a matter of the pose, otherwise a body blocks it.
        let is_beside = coverage.lost.first().is_none_or(|(by, _)| by == OUTSIDE_IMAGE);
        if is_beside {
            Self::OutOfView { angles_rad: coverage.angles_rad, lens_rad: coverage.lens_rad }
        } else {
            Self::Hidden { lost: coverage.lost.clone() }
        }
    }

    /// Creates the error for a fault in `file`, or in input without a file.
    pub fn viewpoint(file: Option<&Path>, source: InvalidViewpoint) -> Self {
        Self::Viewpoint { file: file.map(Path::to_owned), source }
    }
}

impl Explained for SceneError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::TooManyRays { .. } => ErrorKind::Limit,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::NoSurface { .. }
            | Self::Viewpoint { .. }
            | Self::Samples { .. }
            | Self::Length { .. } => return None,
            Self::Light(error) => return Some(error.hint().to_owned()).filter(|h| !h.is_empty()),
            Self::Hidden { lost } => {
                let pose =
                    "is the pose `camera_from_sensor`, and from the camera's place in this design?";
                // Refraction cannot be cured by a clear material or a wider opening.
                let by = lost.first().map(|(by, _)| by).filter(|by| *by != REFRACTION);
                return Some(by.map_or(pose.to_owned(), |by| {
                    format!(
                        "{pose} as drawn it takes a clear material for {by}, or a wider opening"
                    )
                }));
            }
            Self::OutOfView { .. } => {
                "is the pose `camera_from_sensor`, in mm, and not its inverse?"
            }
            Self::TooManyRays { .. } => "ask for fewer samples",
            Self::Press(error) => return press_hint(error),
            Self::TooDeep(_) => "press less deep, or leave these out",
            Self::NoContact { deeper: Some(id), .. } => {
                return Some(format!("press deeper, for example `{id}`; or allow it"));
            }
            Self::NoContact { .. } => "bring these nearer by as much; or allow it",
            Self::PressNotVisible(_) => "press where the camera looks, or allow it",
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::TooManyRays { .. } => "too_many_rays",
            Self::Press(_) => "unknown_press",
            Self::TooDeep(_) => "too_deep",
            Self::NoContact { .. } => "no_contact",
            Self::PressNotVisible(_) => "nothing_seen",
            Self::Length { .. } | Self::Samples { .. } => "out_of_range",
            _ => "bad_viewpoint",
        })
    }
}

/// Joins causes and their shares of the surface into one sentence.
pub fn join_causes(lost: &[(String, f64)]) -> String {
    fabkit_optics::describe_losses(lost, 1)
}

/// Returns a hint for a press that cannot be built, where one is known.
pub fn press_hint(error: &PressError) -> Option<String> {
    match error {
        PressError::Unknown { id, known, place } => Some(unknown_press_hint(id, known, place)),
        PressError::Unreadable { example, .. } => {
            Some(format!("a place is written like `{example}`: polar angle, azimuth, depth"))
        }
        _ => None,
    }
}

/// Suggests presses for an unknown press `id`: the closest known name, or one example of each kind.
///
/// ```
/// use fabkit_scene::unknown_press_hint;
/// let known = ["semi-dome-001", "semi-dome-002", "ball@"].map(String::from);
/// // A name without a place: the hint shows how a place is written.
/// assert!(unknown_press_hint("bal", &known, "0deg,0deg,1mm").contains("`ball@0deg,0deg,1mm`"));
/// assert!(unknown_press_hint("semi-dome-01", &known, "0deg,0deg,1mm").contains("semi-dome-001"));
/// ```
pub fn unknown_press_hint(id: &str, known: &[String], place: &str) -> String {
    let written =
        |tool: &str| format!("an indenter and its place are written like `{tool}{place}`");
    let unknown = UnknownName::new("press", id, known.iter().map(String::as_str));
    match &unknown.closest {
        // A known name that ends with `@` is an indenter that still needs a place.
        Some(closest) if closest.ends_with('@') => written(closest),
        Some(_) => unknown.hint(),
        None => {
            let listed = one_of_each_kind(known);
            let listed = (!listed.is_empty()).then(|| format!("presses are {}", listed.join(", ")));
            let tools: Vec<&String> = known.iter().filter(|name| name.ends_with('@')).collect();
            let written = tools.first().map(|tool| written(tool));
            listed.into_iter().chain(written).collect::<Vec<_>>().join("; ")
        }
    }
}

/// Returns the first of each group of names that differ in their digits alone.
fn one_of_each_kind(names: &[String]) -> Vec<String> {
    let mut kinds = BTreeSet::new();
    let kind = |name: &str| -> String { name.chars().filter(|c| !c.is_ascii_digit()).collect() };
    let listed = names.iter().filter(|name| !name.ends_with('@'));
    let first = listed.filter(|name| kinds.insert(kind(name)));
    first.map(|name| format!("`{name}`")).collect()
}
