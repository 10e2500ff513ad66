//! Writing of a data set's files: missing ones are made, existing ones are counted.

use std::sync::atomic::{AtomicUsize, Ordering};

use fabkit_depth::RenderError;
use fabkit_export::ExportError;
use fabkit_files::progress::{ProgressCallback, ProgressStep};
use fabkit_files::resumable::{
    FolderKind, ResumableFolder, ResumableFolderError, SAME_VERSION_HINT,
};
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_scene::press_simulation::PressingError;
use serde_json::Map;

use super::read::SampleError;

/// Kind of a data set's folder. Version 1 had no checksums.
pub const KIND: FolderKind = FolderKind { what: "data set", name: "dataset", version: 2 };

/// Reason why a data set cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// The folder belongs to something else, is in use, or cannot be written to.
    #[error(transparent)]
    Folder(#[from] ResumableFolderError),
    /// A file cannot be made.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A half that an earlier run wrote cannot be read.
    #[error(transparent)]
    Read(#[from] SampleError),
    /// A press has no contact solution.
    #[error("`{half}`: {error}")]
    Press {
        /// Name of the half.
        half: String,
        /// Reason.
        error: PressingError,
    },
    /// A contact sheet cannot be drawn.
    #[error(transparent)]
    Sheet(#[from] RenderError),
    /// An image cannot be rendered.
    #[error(transparent)]
    Image(Box<fabkit_files::Error>),
    /// A worker sent a file that does not belong to this data set.
    #[error("a worker sent `{name}`, {what}")]
    ForeignFile {
        /// Name of the file as sent.
        name: String,
        /// Description of the problem.
        what: String,
    },
    /// The caller cancelled the run.
    #[error("interrupted")]
    Cancelled,
}

impl Explained for DatasetError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Folder(error) => error.kind(),
            Self::Read(error) => error.kind(),
            Self::Press { error, .. } => error.kind(),
            Self::Image(error) => error.kind(),
            Self::ForeignFile { .. } => ErrorKind::Io,
            Self::Cancelled => ErrorKind::Interrupted,
            Self::Sheet(RenderError::NoPixels { .. }) => ErrorKind::BadInput,
            Self::Sheet(RenderError::TooLarge { .. }) => ErrorKind::Limit,
            Self::Sheet(_) | Self::Export(_) => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Folder(error) => error.hint(),
            Self::Read(error) => error.hint(),
            Self::Press { error, .. } => error.hint(),
            Self::Image(error) => error.hint(),
            Self::ForeignFile { .. } => Some(SAME_VERSION_HINT.into()),
            Self::Cancelled => Some("what is finished stays, and can be gone on with".into()),
            Self::Sheet(RenderError::TooLarge { .. }) => Some("ask for a smaller image".into()),
            Self::Sheet(_) | Self::Export(_) => None,
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Folder(error) => error.subject(),
            Self::Read(error) => error.subject(),
            other => ErrorSubject::from_kind(other.kind()),
        }
    }
}

/// Writer of all files, with progress and cancellation.
pub(super) struct Store<'a> {
    folder: &'a ResumableFolder,
    files: usize,
    found: AtomicUsize,
    made: AtomicUsize,
    progress: ProgressCallback<'a>,
    cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Store<'a> {
    /// Creates a writer for a known number of files.
    pub(super) fn new(
        folder: &'a ResumableFolder,
        files: usize,
        progress: ProgressCallback<'a>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        let (found, made) = (AtomicUsize::new(0), AtomicUsize::new(0));
        Self { folder, files, found, made, progress, cancelled }
    }

    /// Folder of the data set.
    pub(super) fn folder(&self) -> &ResumableFolder {
        self.folder
    }

    /// Returns whether an earlier run finished a file.
    pub(super) fn has(&self, name: &str) -> bool {
        self.folder.is_finished(name)
    }

    /// Writes a file unless it exists; `bytes` computes its content.
    pub(super) fn put(
        &self,
        name: &str,
        bytes: impl FnOnce() -> Result<Vec<u8>, DatasetError>,
    ) -> Result<(), DatasetError> {
        if (self.cancelled)() {
            return Err(DatasetError::Cancelled);
        }
        if self.has(name) {
            self.found.fetch_add(1, Ordering::Relaxed);
        } else {
            self.folder.put(name, &bytes()?)?;
            self.made.fetch_add(1, Ordering::Relaxed);
        }
        let found = self.found.load(Ordering::Relaxed);
        let done = found + self.made.load(Ordering::Relaxed);
        (self.progress)(ProgressStep { done, resumed: found, total: self.files, last_name: name });
        Ok(())
    }

    /// Marks the data set as complete. Returns the numbers of files found and made.
    pub(super) fn finish(&self) -> Result<(usize, usize), DatasetError> {
        // The document itself counts as found if an earlier run completed the data set.
        let of_document = if self.folder.document().is_some() { &self.found } else { &self.made };
        self.folder.finish(Map::new())?;
        of_document.fetch_add(1, Ordering::Relaxed);
        let found = self.found.load(Ordering::Relaxed);
        (self.progress)(ProgressStep {
            done: self.files,
            resumed: found,
            total: self.files,
            last_name: "",
        });
        Ok((found, self.made.load(Ordering::Relaxed)))
    }
}
