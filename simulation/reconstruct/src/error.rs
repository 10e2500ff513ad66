//! Errors of reconstruction.

use std::path::PathBuf;

use fabkit_calibration::significance::LeftOut;
use fabkit_capture::SizeMismatch;
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_network::NetworkError;

/// Reason why an image cannot be reconstructed.
#[derive(Debug, thiserror::Error)]
pub enum ReconstructError {
    /// A lighting that shows neither thickness nor slopes.
    #[error(
        "depth needs light that shows the thickness of layers or the slope of a coat; `{light}` light of `{sensor}` shows neither"
    )]
    DepthNotShown {
        /// Name of the sensor.
        sensor: String,
        /// Name of the lighting.
        light: &'static str,
    },
    /// A lighting in which no markers can be tracked.
    #[error("{why}")]
    NoMarkersShown {
        /// Explanation.
        why: String,
    },
    /// An image at rest without enough of the expected markers.
    #[error(
        "{}: only {found} of {of} markers in view are found, at least half are needed{}",
        .file.display(), left_out_clause(.left_out)
    )]
    TooFewMarkers {
        /// Path of the image.
        file: PathBuf,
        /// Number of markers found.
        found: usize,
        /// Number of markers expected in view.
        of: usize,
        /// Spots that were left out.
        left_out: LeftOut,
    },
    /// An image whose size differs from the camera's.
    #[error(transparent)]
    SizeMismatch(#[from] SizeMismatch),
    /// A greyscale image where colours are needed for slopes or markers.
    #[error("{}: this image has no colours, which tell light sources and layers apart", .file.display())]
    NoColors {
        /// Path of the image.
        file: PathBuf,
    },
    /// An image at rest in which nearly nothing is lit.
    #[error("{}: nearly all intensities are below {}: this is no image of the lit surface at rest", .file.display(), .least_grey)]
    TooDark {
        /// Path of the image.
        file: PathBuf,
        /// Minimum intensity of a lit pixel.
        least_grey: f64,
    },
    /// A file that holds no network, or one with unsupported layers.
    #[error("{}: {source}", .file.display())]
    Network {
        /// Path of the file.
        file: PathBuf,
        /// The fault itself.
        source: Box<NetworkError>,
    },
    /// A network whose output contains infinite values or no numbers.
    #[error(
        "{}: {count} of {of} depths that this network gives for {} are no finite numbers; the first is {value}, at pixel {}, {}",
        .file.display(), .picture.display(), .at_px[0], .at_px[1]
    )]
    NetworkNotFinite {
        /// Path of the network.
        file: PathBuf,
        /// Path of the image.
        picture: PathBuf,
        /// Number of such depths.
        count: usize,
        /// Number of all depths.
        of: usize,
        /// Column and row of the first.
        at_px: [usize; 2],
        /// The first such value.
        value: f32,
    },
    /// A card that does not describe a network's input and output.
    #[error("{} {what}", .file.display())]
    Card {
        /// Path of the file.
        file: PathBuf,
        /// Description of the fault.
        what: String,
    },
    /// Two images whose results would have the same file name.
    #[error("{} and {} would both be written as {}", .first.display(), .second.display(), .name)]
    SameName {
        /// Path of one image.
        first: PathBuf,
        /// Path of the other image.
        second: PathBuf,
        /// Common name of the result.
        name: String,
    },
}

fn left_out_clause(left_out: &LeftOut) -> String {
    match left_out.count {
        0 => String::new(),
        _ => format!(
            "; {left_out}: they do not stand out of noise and uneven light as markers in their pattern do"
        ),
    }
}

impl Explained for ReconstructError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::DepthNotShown { .. } => {
                "sensors with translucent layers or coloured light sources have it: rtac0, 9dtact, shadowtac, digit-like"
            }
            Self::SizeMismatch(error) => return error.hint(),
            Self::NoColors { .. } => "take images in colour, as `fabkit capture` makes them",
            Self::NoMarkersShown { .. } => {
                "sensors with dots, dimples, slots, pins or liquid columns have markers: tactip, shadowtac, uvdtact, fluidic, gelsight-like"
            }
            Self::TooFewMarkers { .. } => {
                "take it with the light on and without contact; a camera far from its drawn place needs its calibrated pose"
            }
            Self::TooDark { .. } => "take it with the light on and without contact",
            Self::Network { .. } => {
                "export it as one chain of convolutions that keep the image's size, without batch normalisation: exporters \
                 fold it into the weights"
            }
            Self::NetworkNotFinite { .. } => {
                "look for divisions by zero and for weights that are no numbers; train or export it again"
            }
            Self::Card { .. } => {
                "`fabkit bench rtac0` writes one beside its network; without a card a network is taken for R-Tac0's published one"
            }
            Self::SameName { .. } => "rename one of them, or write them into folders of their own",
        };
        Some(hint.to_owned())
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::DepthNotShown { .. } | Self::NoMarkersShown { .. } => {
                ErrorSubject::new("no_light")
            }
            Self::SizeMismatch(error) => error.subject(),
            Self::TooDark { file, .. }
            | Self::NoColors { file }
            | Self::TooFewMarkers { file, .. } => ErrorSubject::from_path("bad_picture", file),
            Self::Network { file, .. }
            | Self::NetworkNotFinite { file, .. }
            | Self::Card { file, .. } => ErrorSubject::from_path("bad_network", file),
            Self::SameName { first, .. } => ErrorSubject::from_path("same_name", first),
        }
    }
}
