//! Why something was not done: one error for all that can go wrong, and what kind of failure it is.
//!
//! Each topic has its own enum; [`Error`] holds any of them, so that whoever shows failures to people has
//! one type to look into. What is said here names no option of a command and no argument of a function:
//! that is for those who know which door their user came through.

use fabkit_elastic::BallTestError;

use crate::authored::NotReplaced;
use crate::benching::BenchError;
use crate::bodies::UnknownName;
use crate::calibrating::CalibratingError;
use crate::capturing::CaptureError;
use crate::dataset::{DatasetError, DatasetRequestError, SampleError};
use crate::diagnostics::Diagnosed;
use crate::exporting::{self, ExportFailure};
use crate::fitting_light::FitLightError;
use crate::memory::MemoryError;
use crate::pictures::PictureError;
use crate::pressing::PressingError;
use crate::reading::ReadError;
use crate::reconstructing::ReconstructError;
use crate::rereading::RereadError;
use crate::resumable::FolderError;
use crate::scene::SceneError;
use crate::slicing::SlicingError;
use crate::source::SourceError;
use crate::staging::StagingError;
use crate::sweeping::SweepError;
use crate::verifier::VerifierError;

/// What a failure means for those who asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// Unknown names, values out of range, designs that cannot be.
    BadInput,
    /// Input or output beyond what fabkit is willing to handle.
    Limit,
    /// Files that cannot be read or written.
    Io,
    /// A bug in fabkit.
    Bug,
    /// The caller asked to stop.
    Interrupted,
}

impl ErrorKind {
    /// The word in documents, for example `bad-input`.
    pub fn word(self) -> &'static str {
        match self {
            Self::BadInput => "bad-input",
            Self::Limit => "limit",
            Self::Io => "io",
            Self::Bug => "bug",
            Self::Interrupted => "interrupted",
        }
    }
}

/// An error that says what it means and what to do.
pub trait Explained: std::error::Error {
    /// What it means for those who asked.
    fn kind(&self) -> ErrorKind;

    /// What to do about it, where that is known.
    fn hint(&self) -> Option<String> {
        None
    }
}

/// Anything that can go wrong.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub enum Error {
    /// Texts with problems: a sensor, a plan, a list of presses.
    Invalid(#[from] Diagnosed),
    /// A name that is not there.
    Unknown(#[from] UnknownName),
    /// A file that cannot be read.
    Read(#[from] ReadError),
    /// More memory than is allowed.
    Memory(#[from] MemoryError),
    /// Files that cannot be written.
    Staging(#[from] StagingError),
    /// A folder that cannot be filled piece by piece, or read.
    Folder(#[from] FolderError),
    /// A file that somebody edited would be replaced.
    Authored(#[from] NotReplaced),
    /// A sensor or a fixture that is not there.
    Source(#[from] SourceError),
    /// An export that cannot be made.
    Export(#[from] ExportFailure),
    /// An export that cannot be written.
    ExportFolder(#[from] exporting::FolderError),
    /// A picture that cannot be drawn.
    Picture(#[from] PictureError),
    /// Other kernels that do not answer.
    Verifier(#[from] VerifierError),
    /// Figures that a bench does not give.
    Bench(#[from] BenchError),
    /// Ground truth that cannot be cast.
    Scene(#[from] SceneError),
    /// A press that has no result.
    Pressing(#[from] PressingError),
    /// Captures that tell no constants of light.
    FitLight(#[from] FitLightError),
    /// No depth from pictures.
    #[error(transparent)]
    Reconstruct(#[from] ReconstructError),
    /// A picture that a camera would take, of a sensor whose light nobody knows.
    Capture(#[from] CaptureError),
    /// Readings of a gel that give no modulus.
    Gel(#[from] BallTestError),
    /// What a data set cannot be made of.
    DatasetRequest(#[from] DatasetRequestError),
    /// A data set that cannot be written.
    Dataset(#[from] DatasetError),
    /// A data set that cannot be read.
    Sample(#[from] SampleError),
    /// A sweep that cannot be carried out.
    Sweep(#[from] SweepError),
    /// A calibration that does not come about.
    Calibrating(#[from] CalibratingError),
    /// Parts that no slicer slices.
    Slicing(#[from] SlicingError),
    /// A folder that cannot be read again.
    Reread(#[from] RereadError),
    /// Several at once, of one kind; at least one.
    #[error("{}", joined(.0))]
    Several(Vec<Error>),
    /// Something that must not happen.
    #[error("{0}")]
    Bug(String),
}

impl Error {
    /// Something that must not happen.
    pub fn bug(what: impl ToString) -> Self {
        Self::Bug(what.to_string())
    }

    /// Several as one; `None` for none.
    pub fn all(mut errors: Vec<Self>) -> Option<Self> {
        if errors.len() > 1 { Some(Self::Several(errors)) } else { errors.pop() }
    }

    fn topic(&self) -> Option<&dyn Explained> {
        Some(match self {
            Self::Invalid(error) => error,
            Self::Unknown(error) => error,
            Self::Read(error) => error,
            Self::Memory(error) => error,
            Self::Staging(error) => error,
            Self::Folder(error) => error,
            Self::Authored(error) => error,
            Self::Source(error) => error,
            Self::Export(error) => error,
            Self::ExportFolder(error) => error,
            Self::Picture(error) => error,
            Self::Verifier(error) => error,
            Self::Bench(error) => error,
            Self::Scene(error) => error,
            Self::Pressing(error) => error,
            Self::Capture(error) => error,
            Self::FitLight(error) => error,
            Self::Reconstruct(error) => error,
            Self::Gel(error) => error,
            Self::DatasetRequest(error) => error,
            Self::Dataset(error) => error,
            Self::Sample(error) => error,
            Self::Sweep(error) => error,
            Self::Calibrating(error) => error,
            Self::Slicing(error) => error,
            Self::Reread(error) => error,
            Self::Several(errors) => errors.first()?,
            Self::Bug(_) => return None,
        })
    }
}

impl Explained for Error {
    fn kind(&self) -> ErrorKind {
        self.topic().map_or(ErrorKind::Bug, Explained::kind)
    }

    fn hint(&self) -> Option<String> {
        self.topic().and_then(Explained::hint)
    }
}

/// Each with its own message, as people are shown lists.
pub(crate) fn joined(messages: &[impl ToString]) -> String {
    messages.iter().map(ToString::to_string).collect::<Vec<_>>().join("\nerror: ")
}

/// Faults that are listed one by one.
const MOST_FAULTS: usize = 50;

/// The first of many faults, and how many more there are.
pub(crate) fn listed(faults: &[String]) -> String {
    let (count, shown) = (faults.len(), faults.len().min(MOST_FAULTS));
    let message = joined(&faults[..shown]);
    match count - shown {
        0 => message,
        more => format!("{message}\nerror: and {more} more"),
    }
}
