//! Why there is no depth.

use std::path::PathBuf;

use fabkit_capture::OtherSize;
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_network::NetworkError;

/// Why there is no depth.
#[derive(Debug, thiserror::Error)]
pub enum ReconstructError {
    /// Light that does not show thickness.
    #[error(
        "depth is reconstructed where light shows how thick layers are, or which way a coat looks; `{sensor}` in `{light}` light shows something else"
    )]
    OtherLight {
        /// The sensor.
        sensor: String,
        /// Its light.
        light: &'static str,
    },
    /// A light in which no marks are followed.
    #[error("{why}")]
    NoMarks {
        /// Why.
        why: String,
    },
    /// A picture at rest without the drawn marks.
    #[error("{}: {found} of the {of} marks that the camera should see are found", .file.display())]
    FewMarks {
        /// The picture.
        file: PathBuf,
        /// How many are found.
        found: usize,
        /// How many are drawn where the camera sees.
        of: usize,
    },
    /// A picture of another size than the camera takes.
    #[error(transparent)]
    OtherSize(#[from] OtherSize),
    /// A grey picture where colours say which way a coat looks, or where marks are.
    #[error("{}: this picture has no colours, by which lamps and layers are told apart", .file.display())]
    NoColors {
        /// The picture.
        file: PathBuf,
    },
    /// A picture at rest in which nothing is lit.
    #[error("{}: the surface is darker than {} grey nearly everywhere: this is no picture of it at rest", .file.display(), .least_grey)]
    Dark {
        /// The picture.
        file: PathBuf,
        /// What is bright enough, grey.
        least_grey: f64,
    },
    /// A file that is no network, or one of other layers than are known.
    #[error("{}: {source}", .file.display())]
    Network {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        source: Box<NetworkError>,
    },
    /// A card that does not say what a network takes and gives.
    #[error("{} {what}", .file.display())]
    Card {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// Pictures whose depth would go into one file.
    #[error("{} and {} would both be written as {}", .first.display(), .second.display(), .name)]
    SameName {
        /// A picture.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// The file.
        name: String,
    },
}

impl Explained for ReconstructError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::OtherLight { .. } => {
                "sensors with translucent layers or coloured lamps have it: rtac0, 9dtact, shadowtac, digit-like"
            }
            Self::OtherSize(error) => return error.hint(),
            Self::NoColors { .. } => "take pictures in colour, as `fabkit capture` makes them",
            Self::NoMarks { .. } => {
                "sensors with dots, dimples, markers or columns have marks: tactip, shadowtac, uvdtact, fluidic, gelsight-like"
            }
            Self::FewMarks { .. } => {
                "take it with the lamps on and nothing that touches; a camera that is far from where it is drawn needs its \
                 calibrated pose"
            }
            Self::Dark { .. } => "take it with the lamps on, and nothing that touches",
            Self::Network { .. } => {
                "export it as one chain of convolutions that keep the picture's size, without batch normalisation: exporters \
                 fold it into the weights"
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
            Self::OtherLight { .. } | Self::NoMarks { .. } => ErrorSubject::new("no_light"),
            Self::OtherSize(error) => error.subject(),
            Self::Dark { file, .. } | Self::NoColors { file } | Self::FewMarks { file, .. } => {
                ErrorSubject::at("bad_picture", file)
            }
            Self::Network { file, .. } | Self::Card { file, .. } => {
                ErrorSubject::at("bad_network", file)
            }
            Self::SameName { first, .. } => ErrorSubject::at("same_name", first),
        }
    }
}
