//! Errors of fits of light.

use std::path::PathBuf;

use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_geometry::{Lighting, Sensor, VisibleEffect};

/// Reason why constants cannot be fitted.
#[derive(Debug, thiserror::Error)]
pub enum FitLightError {
    /// Too few pins or captures.
    #[error(
        "{found} pins are seen whole in {captures} captures; a fit needs {least} in 3 at least"
    )]
    TooFew {
        /// Number of pins that are seen completely.
        found: usize,
        /// Number of their captures.
        captures: usize,
        /// Minimum number of pins.
        least: usize,
    },
    /// A fit to pins of a sensor that is not a dome.
    #[error("pins are fitted on domes, and `{sensor}` has no dome")]
    NoDome {
        /// Name of the sensor.
        sensor: String,
    },
    /// A lighting that shows something other than the thickness of layers.
    #[error("only translucent layers can be fitted; `{light}` light of `{sensor}` shows {shows}")]
    NoThickness {
        /// Name of the sensor.
        sensor: String,
        /// Name of the lighting.
        light: &'static str,
        /// What it shows.
        shows: &'static str,
    },
    /// A capture without a dark place.
    #[error("{} shows no ball: no intensity is {least} below that at rest", .file.display())]
    NoBall {
        /// Path of the image.
        file: PathBuf,
        /// Minimum loss of intensity.
        least: f64,
    },
    /// A ball at the edge of the image or the pad.
    #[error(
        "the ball of {} is too near to the side: around {:.1}, {:.1} mm less than {least_mm:.1} mm are seen whole",
        .file.display(), .at_mm[0], .at_mm[1]
    )]
    BallAtEdge {
        /// Path of the image.
        file: PathBuf,
        /// Centre of the ball, sensor frame, mm.
        at_mm: [f64; 2],
        /// Radius around it that must be visible, mm.
        least_mm: f64,
    },
    /// Several contacts in one image.
    #[error("{} shows more than one ball", .file.display())]
    SeveralBalls {
        /// Path of the image.
        file: PathBuf,
    },
    /// The fit does not converge.
    #[error("no constants explain these captures: the fit does not end")]
    NoFit,
}

impl Explained for FitLightError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoFit => ErrorKind::Limit,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::TooFew { .. } => "take more captures, with pins in full view",
            Self::NoDome { .. } => "press one ball in each capture, and leave out landmarks",
            Self::NoThickness { .. } => {
                "fit a sensor with translucent layers: rtac0, 9dtact; others take their lamps and coats from the design"
            }
            Self::NoBall { .. } => "press deeper; keep the image at rest apart from the others",
            Self::BallAtEdge { .. } => {
                "press nearer to the middle of the pad, or give the size of a pixel if images are straight"
            }
            Self::SeveralBalls { .. } => "press one ball in each capture",
            Self::NoFit => "look at the captures: is the reference of the same exposure?",
        };
        Some(hint.to_owned())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new("no_light")
    }
}

/// Checks that a lighting shows the thickness of layers, whose constants are fitted.
pub(super) fn check_shows_thickness(
    sensor: &Sensor,
    lighting: &Lighting,
) -> Result<(), FitLightError> {
    let shows = match &lighting.effect {
        VisibleEffect::Thickness { .. } => return Ok(()),
        VisibleEffect::Slopes { .. } => "slopes of a coat under coloured lamps",
        VisibleEffect::Fluorescence { .. } => "glowing layers",
        VisibleEffect::Markers { .. } => "markers",
        VisibleEffect::LiquidColumns { .. } => "liquid columns",
    };
    let (sensor, light) = (sensor.name.clone(), lighting.name);
    Err(FitLightError::NoThickness { sensor, light, shows })
}
