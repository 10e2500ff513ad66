//! Verification of folders that fabkit wrote: every file is compared with what was written.
//!
//! Exports, data sets and sweeps list their files with size and hash in a document that carries its own hash. Each file
//! is compared with that list, each chunk of a data set with its own checksum, and every difference is reported.
//! Nothing is written, no link is followed, and listed names outside the folder are ignored.

mod contents_list;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use fabkit_dataset::{self, DatasetReader};
use fabkit_files::directory_listing::{self, DirectoryEntry};
use fabkit_files::resumable::{FilesByPath, PieceState, ResumableFolderError};
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained};
use rayon::prelude::*;

use self::contents_list::ContentsList;
use crate::exports::MANIFEST_NAME;
use crate::sweep_runs;

/// Largest number of foreign files that are named; further ones are only counted.
const MOST_NAMED: usize = 1000;
/// First character of hidden files, which are ignored.
const HIDDEN: char = '.';

/// Kind of difference of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DifferenceKind {
    /// The file differs from what was written, or cannot be read.
    Damaged,
    /// The file is missing.
    Missing,
    /// The file is not in the list.
    Foreign,
}

impl DifferenceKind {
    /// Returns the word for people and scripts.
    pub fn word(self) -> &'static str {
        match self {
            Self::Damaged => "damaged",
            Self::Missing => "missing",
            Self::Foreign => "foreign",
        }
    }
}

/// Difference of one file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileDifference {
    /// Path relative to the folder.
    pub file: String,
    /// Kind of difference.
    pub what: DifferenceKind,
    /// Evidence for it.
    pub why: String,
}

/// Result of verifying one folder.
#[derive(Clone, Debug)]
pub struct VerifiedFolder {
    /// Verified folder.
    pub folder: PathBuf,
    /// Kind of folder: `export`, `data set` or `sweep`.
    pub what: &'static str,
    /// Number of listed files.
    pub files: usize,
    /// Total listed size, bytes.
    pub bytes: u64,
    /// Differences, sorted by path.
    pub findings: Vec<FileDifference>,
    /// Number of foreign files beyond the named ones.
    pub more_foreign: usize,
    /// Limitation of the verification, if any.
    pub note: Option<&'static str>,
}

impl VerifiedFolder {
    /// Returns whether the folder is as it was written.
    pub fn passed(&self) -> bool {
        self.findings.is_empty()
    }
}

/// Error that prevents a verification.
#[derive(Debug, thiserror::Error)]
pub enum FolderVerificationError {
    /// The folder holds no list of contents.
    #[error("{} holds no {}, {} or {}", .folder.display(), .documents[0], .documents[1], .documents[2])]
    NoList {
        /// Folder.
        folder: PathBuf,
        /// File names of the possible lists.
        documents: [String; 3],
        /// True if an unfinished data set or sweep lies there.
        is_begun: bool,
    },
    /// List of another version of its format.
    #[error(transparent)]
    OtherVersion(ResumableFolderError),
    /// List that cannot be read.
    #[error(transparent)]
    List(#[from] ResumableFolderError),
    /// Operating system error.
    #[error("cannot read the folder {}: {source}", .folder.display())]
    Io {
        /// Folder.
        folder: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
}

impl Explained for FolderVerificationError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoList { .. } => ErrorKind::BadInput,
            Self::OtherVersion(error) | Self::List(error) => error.kind(),
            Self::Io { .. } => ErrorKind::Io,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::NoList { is_begun: true, .. } => "it is not finished: go on with what began it",
            Self::NoList { .. } => "name a folder that `fabkit export`, `dataset` or `sweep` wrote",
            Self::OtherVersion(_) => "read it with the fabkit that wrote it",
            Self::List(error) => return error.hint(),
            Self::Io { .. } => return None,
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::OtherVersion(error) | Self::List(error) => error.subject(),
            Self::NoList { folder, .. } => ErrorSubject::from_path("not_fabkits_folder", folder),
            Self::Io { folder, source } => ErrorSubject::from_io(folder, source, "file_unreadable"),
        }
    }
}

/// Kind of folder content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FolderContent {
    Export,
    Dataset,
    Sweep,
}

impl FolderContent {
    const ALL: [Self; 3] = [Self::Export, Self::Dataset, Self::Sweep];

    fn document(self) -> String {
        match self {
            Self::Export => MANIFEST_NAME.to_owned(),
            Self::Dataset => fabkit_dataset::KIND.document(),
            Self::Sweep => sweep_runs::KIND.document(),
        }
    }

    fn what(self) -> &'static str {
        match self {
            Self::Export => "export",
            Self::Dataset => fabkit_dataset::KIND.what,
            Self::Sweep => sweep_runs::KIND.what,
        }
    }

    /// Determines the kind by the name of the list. Anything with that name counts, even if it is not a file: it is
    /// then reported as damaged.
    fn detect(folder: &Path) -> Option<Self> {
        let is_there =
            |kind: &Self| directory_listing::exists_or_dangles(&folder.join(kind.document()));
        Self::ALL.into_iter().find(is_there)
    }
}

/// Verifies a folder and, for an export, the exports of fixtures and guides in its subfolders.
///
/// # Errors
/// A folder without a list of contents, or with one of another version. Damage is not an error.
///
/// ```
/// use fabkit_application::verify_folder::verify_folder;
///
/// let folder = std::env::temp_dir().join(format!("fabkit-empty-{}", std::process::id()));
/// std::fs::create_dir(&folder)?;
/// // Nothing says what should be here: an error, and no damage.
/// let error = verify_folder(&folder).unwrap_err();
/// assert!(error.to_string().contains("manifest.json"));
/// std::fs::remove_dir(&folder)?;
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn verify_folder(folder: &Path) -> Result<Vec<VerifiedFolder>, Error> {
    let Some(kind) = FolderContent::detect(folder) else {
        directory_listing::check_exists(folder).map_err(|error| cannot_list(folder, error))?;
        return Err(no_list(folder).into());
    };
    let mut all = vec![verify_one(folder, kind)?];
    if kind == FolderContent::Export {
        for fixture in exports_below(folder)? {
            all.push(verify_one(&fixture, FolderContent::Export)?);
            for guide in exports_below(&fixture)? {
                all.push(verify_one(&guide, FolderContent::Export)?);
            }
        }
    }
    Ok(all)
}

/// Finds exports in the direct subfolders of a folder, sorted.
fn exports_below(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut below: Vec<PathBuf> = directory_listing::list_entries(folder)
        .map_err(|e| cannot_list(folder, e))?
        .flatten()
        .filter(|entry| entry.is_folder)
        .map(|entry| entry.path)
        .filter(|path| FolderContent::detect(path) == Some(FolderContent::Export))
        .collect();
    below.sort();
    Ok(below)
}

fn no_list(folder: &Path) -> FolderVerificationError {
    let is_begun = [fabkit_dataset::KIND, sweep_runs::KIND]
        .iter()
        .any(|kind| folder.join(kind.partial("")).is_dir());
    let documents = FolderContent::ALL.map(FolderContent::document);
    FolderVerificationError::NoList { folder: folder.into(), documents, is_begun }
}

fn cannot_list(folder: &Path, source: io::Error) -> FolderVerificationError {
    FolderVerificationError::Io { folder: folder.into(), source }
}

fn verify_one(folder: &Path, kind: FolderContent) -> Result<VerifiedFolder, Error> {
    let document = kind.document();
    let listed = match ContentsList::read(folder, kind)? {
        Ok(listed) => listed,
        Err(why) => {
            // A damaged list cannot be relied on, so nothing else is compared.
            let findings =
                vec![FileDifference { file: document, what: DifferenceKind::Damaged, why }];
            let folder = folder.into();
            let what = kind.what();
            return Ok(VerifiedFolder {
                folder,
                what,
                files: 0,
                bytes: 0,
                findings,
                more_foreign: 0,
                note: None,
            });
        }
    };
    let mut findings = compare_files(folder, &listed.files);
    for (file, why) in &listed.impossible {
        let what = DifferenceKind::Damaged;
        findings
            .insert(file.clone(), FileDifference { file: file.clone(), what, why: why.clone() });
    }
    if kind == FolderContent::Dataset {
        add_chunks(folder, &mut findings)?;
    }
    let is_known = |name: &str| {
        name == document || listed.files.contains_key(name) || listed.others.contains(name)
    };
    // Boards of an export lie in its own subfolders. Other subfolders hold other exports or foreign files.
    let is_ours = |below: &str| {
        let mut names = listed.files.keys();
        kind != FolderContent::Export
            || names.any(|name| name.strip_prefix(below).is_some_and(|rest| rest.starts_with('/')))
    };
    let (foreign, more_foreign) = find_foreign_files(folder, kind, &is_known, &is_ours)?;
    for file in foreign {
        let why = format!("{document} does not name it");
        findings.insert(file.clone(), FileDifference { file, what: DifferenceKind::Foreign, why });
    }
    Ok(VerifiedFolder {
        folder: folder.into(),
        what: kind.what(),
        files: listed.files.len(),
        bytes: listed.files.values().map(|piece| piece.bytes()).sum(),
        findings: findings.into_values().collect(),
        more_foreign,
        note: listed.note,
    })
}

type Findings = BTreeMap<String, FileDifference>;

/// Compares every file with its listed size and hash.
fn compare_files(folder: &Path, files: &FilesByPath) -> Findings {
    let look = |name: &String| {
        let (what, why) = match files[name].verify(folder, name) {
            Ok(PieceState::Intact) => return None,
            Ok(PieceState::Missing) => (DifferenceKind::Missing, "it is not there".to_owned()),
            Ok(PieceState::Changed(why)) => (DifferenceKind::Damaged, why),
            Err(error) => (DifferenceKind::Damaged, error.to_string()),
        };
        Some((name.clone(), FileDifference { file: name.clone(), what, why }))
    };
    let names: Vec<&String> = files.keys().collect();
    names.into_par_iter().filter_map(look).collect()
}

/// Names damaged chunks, and finds chunks that were damaged before their file was hashed.
fn add_chunks(folder: &Path, findings: &mut Findings) -> Result<(), Error> {
    // The list was just read without error; if it has changed since, there is nothing to add.
    let Ok(reader) = DatasetReader::open(folder) else { return Ok(()) };
    for (file, why) in reader.damaged_chunks()? {
        match findings.get_mut(&file) {
            None => {
                let what = DifferenceKind::Damaged;
                findings.insert(file.clone(), FileDifference { file, what, why });
            }
            // The name of the chunk is more precise than the mismatch of the file's hash.
            Some(found) if found.what == DifferenceKind::Damaged && why.starts_with("chunk ") => {
                found.why = why;
            }
            Some(_) => {}
        }
    }
    Ok(())
}

/// Finds unlisted files in the folder and its own subfolders. Returns their names, and the number of further ones.
fn find_foreign_files(
    folder: &Path,
    kind: FolderContent,
    is_known: &dyn Fn(&str) -> bool,
    is_ours: &dyn Fn(&str) -> bool,
) -> Result<(Vec<String>, usize), FolderVerificationError> {
    let (mut named, mut more) = (Vec::new(), 0);
    let mut open = vec![String::new()];
    while let Some(below) = open.pop() {
        let place = folder.join(&below);
        let entries =
            directory_listing::list_entries(&place).map_err(|e| cannot_list(&place, e))?;
        for entry in entries {
            let DirectoryEntry { name, is_folder, .. } =
                entry.map_err(|e| cannot_list(&place, e))?;
            if name.starts_with(HIDDEN) {
                continue;
            }
            let path = if below.is_empty() { name } else { format!("{below}/{name}") };
            let is_partial = below.is_empty() && is_partial(kind, &path);
            match is_folder {
                true if is_partial || !is_ours(&path) => {}
                true => open.push(path),
                false if is_known(&path) => {}
                false if named.len() < MOST_NAMED => named.push(path),
                false => more += 1,
            }
        }
    }
    Ok((named, more))
}

/// Returns whether a name is the working folder left by a run that was killed at its very end; resuming removes it.
fn is_partial(kind: FolderContent, name: &str) -> bool {
    let kind = match kind {
        FolderContent::Export => return false,
        FolderContent::Dataset => fabkit_dataset::KIND,
        FolderContent::Sweep => sweep_runs::KIND,
    };
    kind.partial("").trim_end_matches('/') == name
}
