//! Why there is no ground truth.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use fabkit_files::{ErrorKind, ErrorSubject, Explained, UnknownName, listed};
use fabkit_fixtures::PressError;
use fabkit_optics::{InvalidStack, REFRACTION};

use super::{MAX_RAYS, MAX_SAMPLES};
use crate::ground_truth::{BESIDE_PICTURE, InvalidViewpoint, SurfaceCoverage};

/// Why there is no ground truth.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Nothing to look at.
    #[error("{sensor} has no sensing surface of known shape to look at")]
    NoSurface {
        /// Its name.
        sensor: String,
    },
    /// Bodies that no light can be followed through.
    #[error(transparent)]
    Light(InvalidStack),
    /// A camera of which all is hidden.
    #[error("the camera sees none of the surface: {}", words(.lost))]
    Hidden {
        /// By what, with shares of the surface.
        lost: Vec<(String, f64)>,
    },
    /// A camera that looks elsewhere.
    #[error(
        "the camera sees none of the surface: it lies {:.0} to {:.0} deg off the camera's axis, and \
         the lens reaches {:.0} deg",
        .angles_rad[0].to_degrees(),
        .angles_rad[1].to_degrees(),
        .lens_rad.to_degrees()
    )]
    Unseen {
        /// Least and most that the surface lies off the camera's axis, rad.
        angles_rad: [f64; 2],
        /// How far off it the lens sees, rad.
        lens_rad: f64,
    },
    /// What a camera file, a pose file, or both together say.
    #[error("{}{source}", .file.iter().map(|f| format!("{}: ", f.display())).collect::<String>())]
    Viewpoint {
        /// Which file; nothing for what was given otherwise.
        file: Option<PathBuf>,
        /// What is wrong.
        source: InvalidViewpoint,
    },
    /// Too many rays for a pixel, or none.
    #[error("{samples} samples; the limits are 1 and {MAX_SAMPLES}")]
    Samples {
        /// Along each side of a pixel.
        samples: u32,
    },
    /// A length outside its limits.
    #[error("{name}: {value_mm} mm; the limits are {} mm and {} mm", .limits_mm[0], .limits_mm[1])]
    Length {
        /// What it is.
        name: &'static str,
        /// Asked for, mm.
        value_mm: f64,
        /// Least and most, mm.
        limits_mm: [f64; 2],
    },
    /// More rays than one cast may have.
    #[error("{width} x {height} rays are more than {MAX_RAYS}")]
    TooManyRays {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A press that cannot be had.
    #[error(transparent)]
    Press(PressError),
    /// Presses that go deeper than the surface is soft, each as a sentence.
    #[error("{}", listed(.0))]
    TooDeep(Vec<String>),
    /// Presses that do not touch the surface.
    #[error("{}", listed(.faults))]
    NoContact {
        /// Each as a sentence.
        faults: Vec<String>,
        /// One of them so much deeper that it touches.
        deeper: Option<String>,
    },
    /// Presses of which the camera sees nothing, each as a sentence.
    #[error("{}", listed(.0))]
    NothingSeen(Vec<String>),
}

impl SceneError {
    pub(super) fn unseen(coverage: &SurfaceCoverage) -> Self {
        // What lies beside the picture is a matter of the pose.
        let is_beside = coverage.lost.first().is_none_or(|(by, _)| by == BESIDE_PICTURE);
        match is_beside {
            true => Self::Unseen { angles_rad: coverage.angles_rad, lens_rad: coverage.lens_rad },
            false => Self::Hidden { lost: coverage.lost.clone() },
        }
    }

    /// What is wrong with a file, or with what was given without one.
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
                let by = lost.first().map(|(by, _)| by).filter(|by| *by != REFRACTION);
                return Some(by.map_or(pose.to_owned(), |by| {
                    format!(
                        "{pose} as drawn it takes a clear material for {by}, or a wider opening"
                    )
                }));
            }
            Self::Unseen { .. } => "is the pose `camera_from_sensor`, in mm, and not its inverse?",
            Self::TooManyRays { .. } => "ask for fewer samples",
            Self::Press(error) => return press_hint(error),
            Self::TooDeep(_) => "press less deep, or leave these out",
            Self::NoContact { deeper: Some(id), .. } => {
                return Some(format!("press deeper, for example `{id}`; or allow it"));
            }
            Self::NoContact { .. } => "bring these nearer by as much; or allow it",
            Self::NothingSeen(_) => "press where the camera looks, or allow it",
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::TooManyRays { .. } => "too_many_rays",
            Self::Press(_) => "unknown_press",
            Self::TooDeep(_) => "too_deep",
            Self::NoContact { .. } => "no_contact",
            Self::NothingSeen(_) => "nothing_seen",
            Self::Length { .. } | Self::Samples { .. } => "out_of_range",
            _ => "bad_viewpoint",
        })
    }
}

/// What hides a surface, as one sentence.
pub fn words(lost: &[(String, f64)]) -> String {
    fabkit_optics::in_words(lost, 1)
}

/// What to do about a press that cannot be had, where that is known.
pub fn press_hint(error: &PressError) -> Option<String> {
    match error {
        PressError::Unknown { id, known, place } => Some(unknown_hint(id, known, place)),
        PressError::Unreadable { example, .. } => {
            Some(format!("a place is written like `{example}`: polar angle, azimuth, depth"))
        }
        _ => None,
    }
}

/// What somebody may have meant who asked for a press that there is not.
pub fn unknown_hint(id: &str, known: &[String], place: &str) -> String {
    let written =
        |tool: &str| format!("an indenter and its place are written like `{tool}{place}`");
    let unknown = UnknownName::new("press", id, known.iter().map(String::as_str));
    match &unknown.closest {
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

/// The first of the names that differ in their numbers alone.
fn one_of_each_kind(names: &[String]) -> Vec<String> {
    let mut kinds = BTreeSet::new();
    let kind = |name: &str| -> String { name.chars().filter(|c| !c.is_ascii_digit()).collect() };
    let listed = names.iter().filter(|name| !name.ends_with('@'));
    let first = listed.filter(|name| kinds.insert(kind(name)));
    first.map(|name| format!("`{name}`")).collect()
}
