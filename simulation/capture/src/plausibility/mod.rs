//! Comparison of captures with what their sensor can show, before and after anything is computed from them.
//!
//! An image of another sensor, with red and blue exchanged, turned, or with 12 bits in 16, has as many pixels as the
//! right one. What is computed from it looks like a result. Therefore functions that compute from images demand a
//! [`CheckedImage`], which only an [`ImageGate`] makes, and return their results [`Judged`]: the result comes out by
//! [`Judged::accept`], which fails with the findings, or by [`Judged::accept_anyway`], which hands them out beside it.
//!
//! ```
//! use std::path::Path;
//!
//! use fabkit_capture::CapturedImage;
//! use fabkit_capture::plausibility::{ExpectedLight, ImageGate};
//!
//! let grey = |level: f32| CapturedImage { size_px: [8, 6], channels: 1, values: vec![level; 48] };
//! // Nothing is drawn here: only what images say about each other is compared.
//! let expected = ExpectedLight::unknown([8, 6], "no light is drawn");
//! let gate = ImageGate::new(expected, Path::new("rest.png"), grey(0.5))?.accept()?;
//! assert!(gate.check(Path::new("right.png"), grey(0.49))?.accept().is_ok());
//! // A 12-bit camera's values in 16 bits.
//! let narrow = gate.check(Path::new("narrow.png"), grey(0.5 / 16.0))?;
//! let codes: Vec<_> = narrow.judgement().findings.iter().map(|one| one.fault.code()).collect();
//! assert_eq!(codes, ["narrow_range", "other_exposure"]);
//! assert!(narrow.accept().is_err());
//! # Ok::<(), fabkit_files::Error>(())
//! ```

mod cells;
mod expected;
mod fault;
mod gate;
mod result;

use std::path::{Path, PathBuf};

use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained};
use serde_json::{Value, json};

pub use expected::ExpectedLight;
pub use fault::ImageFault;
pub use gate::{CheckedImage, ImageGate};
pub use result::DepthFigures;

/// An image that cannot be what it is taken for, or a result that cannot be right.
///
/// ```
/// use fabkit_capture::plausibility::{ImageFault, ImplausibleImage};
/// let fault = ImageFault::NotFinite { count: 3, of: 48 };
/// let finding = ImplausibleImage { file: "a.png".into(), fault };
/// assert_eq!(finding.to_string(), "a.png: 3 of 48 values are no finite numbers");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {fault}", .file.display())]
pub struct ImplausibleImage {
    /// Path of the image.
    pub file: PathBuf,
    /// What is wrong, with figures.
    pub fault: ImageFault,
}

impl Explained for ImplausibleImage {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        Some(self.fault.advice())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::from_path("implausible_picture", &self.file)
    }
}

/// A comparison that could not be made: neither passed nor failed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NotKnown {
    /// Name of the comparison.
    pub what: &'static str,
    /// Reason.
    pub why: String,
}

/// Findings about images or results, and comparisons that could not be made.
///
/// ```
/// use fabkit_capture::plausibility::Judgement;
/// let mut all = Judgement::default();
/// all.merge(&Judgement::default());
/// assert!(all.is_plausible() && all.error().is_none());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[must_use]
pub struct Judgement {
    /// Everything that is wrong.
    pub findings: Vec<ImplausibleImage>,
    /// Everything that could not be compared, without duplicates.
    pub not_known: Vec<NotKnown>,
}

impl Judgement {
    /// Returns whether nothing is wrong.
    pub fn is_plausible(&self) -> bool {
        self.findings.is_empty()
    }

    /// Adds what another judgement says.
    pub fn merge(&mut self, other: &Self) {
        self.findings.extend(other.findings.iter().cloned());
        self.not_known.extend(other.not_known.iter().cloned());
        self.not_known.sort();
        self.not_known.dedup();
    }

    /// Returns all findings as one error; `None` without findings.
    pub fn error(&self) -> Option<Error> {
        Error::join(self.findings.iter().cloned().map(Error::from).collect())
    }

    /// Returns the judgement for documents.
    pub fn document(&self) -> Value {
        let findings = self.findings.iter().map(|one| {
            json!({
                "picture": one.file.display().to_string(),
                "code": one.fault.code(),
                "message": one.fault.to_string(),
                "advice": one.fault.advice(),
                "figures": one.fault.figures(),
            })
        });
        let not_known =
            self.not_known.iter().map(|one| json!({ "what": one.what, "why": one.why }));
        json!({
            "findings": findings.collect::<Vec<_>>(),
            "not_known": not_known.collect::<Vec<_>>(),
        })
    }

    pub(crate) fn find(&mut self, file: &Path, fault: ImageFault) {
        self.findings.push(ImplausibleImage { file: file.to_owned(), fault });
    }

    fn leave_open(&mut self, what: &'static str, why: impl Into<String>) {
        self.not_known.push(NotKnown { what, why: why.into() });
        self.not_known.sort();
        self.not_known.dedup();
    }
}

/// A value that comes out only with a decision about its findings.
///
/// ```
/// use fabkit_capture::plausibility::{Judged, Judgement};
/// let judged = Judged::new(7, Judgement::default()).map(|seven| seven + 1);
/// assert_eq!(judged.accept()?, 8);
/// # Ok::<(), fabkit_files::Error>(())
/// ```
#[derive(Clone, Debug)]
#[must_use]
pub struct Judged<T> {
    value: T,
    judgement: Judgement,
}

impl<T> Judged<T> {
    /// Joins a value with what is said about it.
    pub fn new(value: T, judgement: Judgement) -> Self {
        Self { value, judgement }
    }

    /// Returns what is said about the value.
    pub fn judgement(&self) -> &Judgement {
        &self.judgement
    }

    /// Returns the value if nothing is wrong.
    ///
    /// # Errors
    /// Returns all findings as one error.
    pub fn accept(self) -> Result<T, Error> {
        match self.judgement.error() {
            Some(error) => Err(error),
            None => Ok(self.value),
        }
    }

    /// Returns the value with its findings, for callers who report these.
    pub fn accept_anyway(self) -> (T, Judgement) {
        (self.value, self.judgement)
    }

    /// Applies `of` to the value.
    pub fn map<U>(self, of: impl FnOnce(T) -> U) -> Judged<U> {
        Judged { value: of(self.value), judgement: self.judgement }
    }
}
