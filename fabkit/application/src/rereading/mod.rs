//! Folders that fabkit wrote, read again: is everything still what was written?
//!
//! Exports, data sets and sweeps list their files with size and hash in a document that carries its own
//! hash. Each file is compared with that, each chunk of a data set with its own checksum, and whatever
//! differs is named. Nothing is written, no link is followed, and what a list names outside of its
//! folder is not looked at.

mod listed;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use fabkit_dataset::{self, DatasetReader};
use fabkit_files::listing::{self, Entry};
use fabkit_files::resumable::{Files, FolderError, State};
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained};
use rayon::prelude::*;

use self::listed::Listed;
use crate::exporting::MANIFEST_NAME;
use crate::sweeping;

/// Files that no list names, beyond which they are only counted.
const MOST_NAMED: usize = 1000;
/// What begins the names of files that are nobody's business.
const HIDDEN: char = '.';

/// What became of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// It is not what was written, or cannot be read.
    Damaged,
    /// It is gone.
    Missing,
    /// The list does not name it.
    Foreign,
}

impl What {
    /// For people and scripts.
    pub fn word(self) -> &'static str {
        match self {
            Self::Damaged => "damaged",
            Self::Missing => "missing",
            Self::Foreign => "foreign",
        }
    }
}

/// A file that is not as it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FolderFinding {
    /// Its path below the folder.
    pub file: String,
    /// What became of it.
    pub what: What,
    /// How that shows.
    pub why: String,
}

/// A folder that was read again.
#[derive(Clone, Debug)]
pub struct Reread {
    /// Where.
    pub folder: PathBuf,
    /// `export`, `data set`, `sweep`.
    pub what: &'static str,
    /// Files that the list names.
    pub files: usize,
    /// Their size, as listed.
    pub bytes: u64,
    /// What is wrong, by path.
    pub findings: Vec<FolderFinding>,
    /// Foreign files besides those that are named.
    pub more_foreign: usize,
    /// What cannot be known.
    pub note: Option<&'static str>,
}

impl Reread {
    /// Whether all is as it was written.
    pub fn passed(&self) -> bool {
        self.findings.is_empty()
    }
}

/// Why a folder cannot be read again.
#[derive(Debug, thiserror::Error)]
pub enum RereadError {
    /// Nothing there says what it holds.
    #[error("{} holds no {}, {} or {}", .folder.display(), .documents[0], .documents[1], .documents[2])]
    NoList {
        /// Where.
        folder: PathBuf,
        /// Names of the lists that there could be.
        documents: [String; 3],
        /// Whether something was begun there.
        is_begun: bool,
    },
    /// A list of another version of its format.
    #[error(transparent)]
    OtherVersion(FolderError),
    /// A list that cannot be read.
    #[error(transparent)]
    List(#[from] FolderError),
    /// The operating system said no.
    #[error("cannot read the folder {}: {source}", .folder.display())]
    Io {
        /// Which.
        folder: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

impl Explained for RereadError {
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
            Self::NoList { folder, .. } => ErrorSubject::at("not_fabkits_folder", folder),
            Self::Io { folder, source } => ErrorSubject::of_io(folder, source, "file_unreadable"),
        }
    }
}

/// What a folder is filled with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Export,
    Dataset,
    Sweep,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Export, Self::Dataset, Self::Sweep];

    fn document(self) -> String {
        match self {
            Self::Export => MANIFEST_NAME.to_owned(),
            Self::Dataset => fabkit_dataset::KIND.document(),
            Self::Sweep => sweeping::KIND.document(),
        }
    }

    fn what(self) -> &'static str {
        match self {
            Self::Export => "export",
            Self::Dataset => fabkit_dataset::KIND.what,
            Self::Sweep => sweeping::KIND.what,
        }
    }

    /// Whatever is there has that name, also what is no file: then it is damaged.
    fn of(folder: &Path) -> Option<Self> {
        let is_there = |kind: &Self| listing::is_there(&folder.join(kind.document()));
        Self::ALL.into_iter().find(is_there)
    }
}

/// Reads a folder again, and the exports in folders below an export, where fixtures and guides lie.
///
/// # Errors
/// A folder that holds no list of contents, or one of another version; damage is none.
pub fn reread(folder: &Path) -> Result<Vec<Reread>, Error> {
    let Some(kind) = Kind::of(folder) else {
        listing::look_at(folder).map_err(|error| cannot_list(folder, error))?;
        return Err(no_list(folder).into());
    };
    let mut all = vec![one(folder, kind)?];
    if kind == Kind::Export {
        for fixture in exports_below(folder)? {
            all.push(one(&fixture, Kind::Export)?);
            for guide in exports_below(&fixture)? {
                all.push(one(&guide, Kind::Export)?);
            }
        }
    }
    Ok(all)
}

/// Exports in folders directly below another one, sorted.
fn exports_below(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut below: Vec<PathBuf> = listing::entries(folder)
        .map_err(|e| cannot_list(folder, e))?
        .flatten()
        .filter(|entry| entry.is_folder)
        .map(|entry| entry.path)
        .filter(|path| Kind::of(path) == Some(Kind::Export))
        .collect();
    below.sort();
    Ok(below)
}

fn no_list(folder: &Path) -> RereadError {
    let is_begun = [fabkit_dataset::KIND, sweeping::KIND]
        .iter()
        .any(|kind| folder.join(kind.partial("")).is_dir());
    let documents = Kind::ALL.map(Kind::document);
    RereadError::NoList { folder: folder.into(), documents, is_begun }
}

fn cannot_list(folder: &Path, source: io::Error) -> RereadError {
    RereadError::Io { folder: folder.into(), source }
}

fn one(folder: &Path, kind: Kind) -> Result<Reread, Error> {
    let document = kind.document();
    let listed = match Listed::read(folder, kind)? {
        Ok(listed) => listed,
        Err(why) => {
            // Whatever it lists cannot be relied on.
            let findings = vec![FolderFinding { file: document, what: What::Damaged, why }];
            let folder = folder.into();
            let what = kind.what();
            return Ok(Reread {
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
    let mut findings = compare(folder, &listed.files);
    for (file, why) in &listed.impossible {
        let what = What::Damaged;
        findings.insert(file.clone(), FolderFinding { file: file.clone(), what, why: why.clone() });
    }
    if kind == Kind::Dataset {
        add_chunks(folder, &mut findings)?;
    }
    let is_known = |name: &str| {
        name == document || listed.files.contains_key(name) || listed.others.contains(name)
    };
    // Boards of an export have folders of their own; other folders below it are exports or somebody else's.
    let is_ours = |below: &str| {
        let mut names = listed.files.keys();
        kind != Kind::Export
            || names.any(|name| name.strip_prefix(below).is_some_and(|rest| rest.starts_with('/')))
    };
    let (foreign, more_foreign) = foreign(folder, kind, &is_known, &is_ours)?;
    for file in foreign {
        let why = format!("{document} does not name it");
        findings.insert(file.clone(), FolderFinding { file, what: What::Foreign, why });
    }
    Ok(Reread {
        folder: folder.into(),
        what: kind.what(),
        files: listed.files.len(),
        bytes: listed.files.values().map(|piece| piece.bytes()).sum(),
        findings: findings.into_values().collect(),
        more_foreign,
        note: listed.note,
    })
}

type Findings = BTreeMap<String, FolderFinding>;

/// Every file with its size and hash.
fn compare(folder: &Path, files: &Files) -> Findings {
    let look = |name: &String| {
        let (what, why) = match files[name].state(folder, name) {
            Ok(State::Right) => return None,
            Ok(State::Missing) => (What::Missing, "it is not there".to_owned()),
            Ok(State::Other(why)) => (What::Damaged, why),
            Err(error) => (What::Damaged, error.to_string()),
        };
        Some((name.clone(), FolderFinding { file: name.clone(), what, why }))
    };
    let names: Vec<&String> = files.keys().collect();
    names.into_par_iter().filter_map(look).collect()
}

/// Says which chunk is damaged, and finds chunks that were so before they were hashed.
fn add_chunks(folder: &Path, findings: &mut Findings) -> Result<(), Error> {
    // Its document was just read.
    let Ok(reader) = DatasetReader::open(folder) else { return Ok(()) };
    for (file, why) in reader.damaged_chunks()? {
        match findings.get_mut(&file) {
            None => {
                let what = What::Damaged;
                findings.insert(file.clone(), FolderFinding { file, what, why });
            }
            Some(found) if found.what == What::Damaged && why.starts_with("chunk ") => {
                found.why = why;
            }
            Some(_) => {}
        }
    }
    Ok(())
}

/// Names of files that nobody lists, and how many there are besides, in the folder and in those below it that
/// are its own.
fn foreign(
    folder: &Path,
    kind: Kind,
    is_known: &dyn Fn(&str) -> bool,
    is_ours: &dyn Fn(&str) -> bool,
) -> Result<(Vec<String>, usize), RereadError> {
    let (mut named, mut more) = (Vec::new(), 0);
    let mut open = vec![String::new()];
    while let Some(below) = open.pop() {
        let place = folder.join(&below);
        let entries = listing::entries(&place).map_err(|e| cannot_list(&place, e))?;
        for entry in entries {
            let Entry { name, is_folder, .. } = entry.map_err(|e| cannot_list(&place, e))?;
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

/// What a run leaves that was killed in its last moment; going on removes it.
fn is_partial(kind: Kind, name: &str) -> bool {
    let kind = match kind {
        Kind::Export => return false,
        Kind::Dataset => fabkit_dataset::KIND,
        Kind::Sweep => sweeping::KIND,
    };
    kind.partial("").trim_end_matches('/') == name
}
