//! Errors of resumable folders.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use crate::staging::{StagingError, io_hint};
use crate::{ErrorKind, ErrorSubject, Explained};

/// Reason why a folder cannot be filled or read.
///
/// ```
/// use fabkit_files::resumable::{FolderKind, ResumableFolder, ResumableFolderError};
/// use fabkit_files::scratch_folder::ScratchFolder;
/// use serde_json::json;
///
/// let kind = FolderKind { what: "data set", name: "dataset", version: 1 };
/// let root = ScratchFolder::new()?;
/// let open = |seed: u32, resume| {
///     ResumableFolder::open(kind, root.path(), json!({ "version": 1, "seed": seed }), resume)
/// };
/// open(7, false)?.put("0.png", b"zero")?;
/// assert!(matches!(open(7, false), Err(ResumableFolderError::NotEmpty { .. })));
/// let error = open(8, true).unwrap_err();
/// assert!(error.to_string().ends_with("holds another data set\n  seed: 7 there, 8 asked for"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, thiserror::Error)]
pub enum ResumableFolderError {
    /// Folder that is not empty.
    #[error("{} is not empty", .folder.display())]
    NotEmpty {
        /// Path of the folder.
        folder: PathBuf,
    },
    /// Folder that was begun with a different plan.
    #[error(
        "{} holds another {what}{}",
        .folder.display(),
        differences.iter().map(|line| format!("\n  {line}")).collect::<String>()
    )]
    OtherPlan {
        /// Kind of folder, for example `data set`.
        what: &'static str,
        /// Path of the folder.
        folder: PathBuf,
        /// First few values that differ: path, value in the folder, requested value.
        differences: Vec<String>,
    },
    /// Document of a different version of the format.
    #[error("{} is version {found} of a {what}; this fabkit knows version {known}", .path.display())]
    OtherVersion {
        /// Kind of folder, for example `data set`.
        what: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Version in the file.
        found: u64,
        /// Version that this program writes.
        known: u64,
    },
    /// File that was damaged after it was written.
    #[error("{} is damaged: {what}", .path.display())]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// Description of the damage.
        what: String,
    },
    /// Plan or list of contents that was damaged after it was written.
    #[error("{} is damaged: {what}", .path.display())]
    DamagedDocument {
        /// Path of the file.
        path: PathBuf,
        /// Description of the damage.
        what: String,
    },
    /// Files of a complete folder whose content has changed.
    #[error("{}", describe_changed_files(what, paths))]
    Changed {
        /// Kind of folder, for example `data set`.
        what: &'static str,
        /// Paths of the files.
        paths: Vec<PathBuf>,
    },
    /// Symbolic link in place of a folder.
    #[error("{} is a symbolic link: what is written there lands elsewhere", .path.display())]
    Link {
        /// Path of the link.
        path: PathBuf,
    },
    /// Name that leads out of the folder.
    #[error("`{name}` does not name a file below {}", .folder.display())]
    Outside {
        /// Name as given.
        name: String,
        /// Path of the folder.
        folder: PathBuf,
    },
    /// Lock held by another process, or file that cannot be written.
    #[error(transparent)]
    Staging(#[from] StagingError),
    /// Error of the operating system.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// Action that failed, for example `read`.
        action: &'static str,
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

impl ResumableFolderError {
    /// Creates an error of the operating system.
    pub(super) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.into(), source }
    }
}

impl Explained for ResumableFolderError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NotEmpty { .. } | Self::OtherPlan { .. } | Self::OtherVersion { .. } => {
                ErrorKind::BadInput
            }
            Self::Staging(error) => error.kind(),
            Self::Damaged { .. }
            | Self::DamagedDocument { .. }
            | Self::Changed { .. }
            | Self::Link { .. }
            | Self::Outside { .. }
            | Self::Io { .. } => ErrorKind::Io,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::NotEmpty { .. } => {
                "choose another folder, or go on with what the same order began there"
            }
            Self::OtherPlan { .. } => "go on as it was begun, or choose another folder",
            Self::OtherVersion { .. } => "make it again in another folder",
            Self::Damaged { .. } => "delete that file, and going on makes it again",
            Self::DamagedDocument { .. } => {
                "what the folder holds is unknown without it: begin anew in another one"
            }
            Self::Changed { .. } => {
                "delete them, and going on makes them again; if nobody edited them, check the disk"
            }
            Self::Link { .. } => "replace the link by a folder",
            Self::Outside { .. } => SAME_VERSION_HINT,
            Self::Staging(StagingError::Io { source, .. }) | Self::Io { source, .. } => {
                return Some(format!("{}; then go on from here", io_hint(source)?));
            }
            Self::Staging(error) => return error.hint(),
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::NotEmpty { folder } => ErrorSubject::from_path("folder_not_empty", folder),
            Self::OtherPlan { folder, .. } => ErrorSubject::from_path("other_plan", folder),
            Self::OtherVersion { path, .. } => ErrorSubject::from_path("other_version", path),
            Self::Damaged { path, .. } | Self::DamagedDocument { path, .. } => {
                ErrorSubject::from_path("damaged", path)
            }
            Self::Changed { paths, .. } => match paths.first() {
                Some(path) => ErrorSubject::from_path("damaged", path),
                None => ErrorSubject::new("damaged"),
            },
            Self::Link { path } => ErrorSubject::from_path("symbolic_link", path),
            Self::Outside { folder, .. } => ErrorSubject::from_path("outside_folder", folder),
            Self::Staging(error) => error.subject(),
            Self::Io { path, source, .. } => ErrorSubject::from_io(path, source, "cannot_write"),
        }
    }
}

/// Hint for data from other processes that should be impossible.
pub const SAME_VERSION_HINT: &str = "do all workers have this version of fabkit?";

/// Maximum number of paths listed one by one.
const MAX_LISTED_PATHS: usize = 8;

/// Describes files that have changed.
fn describe_changed_files(what: &str, paths: &[PathBuf]) -> String {
    let shown = paths.iter().take(MAX_LISTED_PATHS).map(|path| path.display().to_string());
    let shown: Vec<String> = shown.collect();
    let more = match paths.len() - shown.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let (are, they) = if paths.len() == 1 { ("is", "it was") } else { ("are", "they were") };
    format!("{}{more} {are} no longer what {they} when the {what} was written", shown.join(", "))
}

/// Lists the first values of `found` that differ from the plan `wanted`. Extra keys of `found` are ignored, because the
/// document of a complete folder contains more than its plan.
///
/// ```
/// use fabkit_files::resumable::find_differences;
/// use serde_json::json;
///
/// let found = json!({ "size_px": [640, 480], "lens": { "k1": 0.1 }, "files": {} });
/// let wanted = json!({ "size_px": [640, 360], "lens": { "k1": 0.2 } });
/// let differences = find_differences(&found, &wanted);
/// assert_eq!(
///     differences,
///     ["lens.k1: 0.1 there, 0.2 asked for", "size_px[1]: 480 there, 360 asked for"]
/// );
/// ```
pub fn find_differences(found: &Value, wanted: &Value) -> Vec<String> {
    /// Maximum number of differences.
    const MOST: usize = 5;
    let none = Map::new();
    let mut lines = Vec::new();
    // Only keys of the plan are compared.
    let found = found.as_object().unwrap_or(&none);
    for (key, wanted) in wanted.as_object().into_iter().flatten() {
        collect_differences(key, found.get(key).unwrap_or(&Value::Null), wanted, &mut lines);
    }
    lines.truncate(MOST);
    lines
}

/// Appends the differences of two JSON values, by path.
fn collect_differences(path: &str, found: &Value, wanted: &Value, lines: &mut Vec<String>) {
    match (found, wanted) {
        (Value::Object(a), Value::Object(b)) => {
            let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            for key in keys {
                let of = |map: &Map<String, Value>| map.get(key).cloned().unwrap_or_default();
                collect_differences(&format!("{path}.{key}"), &of(a), &of(b), lines);
            }
        }
        // Lists of different lengths are not compared item by item.
        (Value::Array(a), Value::Array(b)) if a.len() != b.len() => {
            lines.push(format!("{path}: {} there, {} asked for", a.len(), b.len()));
        }
        (Value::Array(a), Value::Array(b)) => {
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                collect_differences(&format!("{path}[{i}]"), a, b, lines);
            }
        }
        (a, b) if a == b => {}
        (a, b) => lines.push(format!("{path}: {a} there, {b} asked for")),
    }
}
