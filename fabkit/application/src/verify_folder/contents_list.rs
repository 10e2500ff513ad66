//! Lists of contents, read for the verification of a folder.

use std::collections::BTreeSet;
use std::path::Path;

use fabkit_export::{Manifest, UnlistedFile};
use fabkit_files::directory_listing;
use fabkit_files::resumable::{
    self, FilesByPath, MAX_DOCUMENT_BYTES, Piece, ResumableFolderError, SealError, is_safe_name,
    listed_files, read_regular, unseal,
};
use serde_json::Value;

use super::{FolderContent, FolderVerificationError};
use crate::exports::MANIFEST_NAME;
use crate::sweep_runs;

/// Note on manifests without a checksum.
const UNSEALED_NOTE: &str = "manifest.json has no checksum, because an older fabkit wrote it: whether it \
                        was damaged itself cannot be known; export again to have one";

/// List of contents that is itself undamaged.
pub(super) struct ContentsList {
    /// Files that must be there.
    pub files: FilesByPath,
    /// Other files known to lie there; they may be gone.
    pub others: BTreeSet<String>,
    /// Invalid entries: the name and what is wrong with it.
    pub impossible: Vec<(String, String)>,
    pub note: Option<&'static str>,
}

impl ContentsList {
    /// Reads the list, or returns the damage that makes it unusable.
    ///
    /// # Errors
    /// A list of another format version, and errors of the file system.
    pub(super) fn read(
        folder: &Path,
        kind: FolderContent,
    ) -> Result<Result<Self, String>, FolderVerificationError> {
        let path = folder.join(kind.document());
        if directory_listing::is_not_a_file(&path) {
            return Ok(Err("it is not a file".into()));
        }
        let read = match kind {
            FolderContent::Export => manifest(&path),
            FolderContent::Dataset => document(&path, fabkit_dataset::KIND),
            FolderContent::Sweep => document(&path, sweep_runs::KIND),
        };
        match read {
            Ok(listed) => Ok(Ok(listed)),
            Err(
                ResumableFolderError::DamagedDocument { what, .. }
                | ResumableFolderError::Damaged { what, .. },
            ) => Ok(Err(what)),
            Err(error @ ResumableFolderError::OtherVersion { .. }) => {
                Err(FolderVerificationError::OtherVersion(error))
            }
            Err(error) => Err(error.into()),
        }
    }
}

fn gone(path: &Path) -> ResumableFolderError {
    ResumableFolderError::Damaged { path: path.into(), what: "it is missing".into() }
}

fn document(
    path: &Path,
    kind: resumable::FolderKind,
) -> Result<ContentsList, ResumableFolderError> {
    let document = kind.read(path)?.ok_or_else(|| gone(path))?;
    let files = listed_files(&document);
    let names = document["files"].as_object().into_iter().flatten().map(|(name, _)| name);
    let impossible = names.filter(|name| !files.contains_key(*name)).map(|name| not_a_name(name));
    let impossible = impossible.collect();
    Ok(ContentsList { files, others: BTreeSet::new(), impossible, note: None })
}

fn manifest(path: &Path) -> Result<ContentsList, ResumableFolderError> {
    let bytes = read_regular(path, MAX_DOCUMENT_BYTES)?.ok_or_else(|| gone(path))?;
    let damaged =
        |what: String| Err(ResumableFolderError::DamagedDocument { path: path.into(), what });
    let (document, note) = match unseal(&bytes) {
        Ok(document) => (document, None),
        Err(error @ SealError::Mismatch) => return damaged(error.to_string()),
        Err(SealError::Missing) => match serde_json::from_slice::<Value>(&bytes) {
            // A seal that is not at the end was not written by fabkit.
            Ok(document) if document["blake3"].is_null() => (document, Some(UNSEALED_NOTE)),
            _ => return damaged(SealError::Missing.to_string()),
        },
    };
    let found = document["version"].as_u64();
    let known = u64::from(Manifest::VERSION);
    let Some(manifest) = Manifest::from_json(&bytes) else {
        return match found {
            Some(found) if found != known => {
                let (what, path) = ("manifest", path.into());
                Err(ResumableFolderError::OtherVersion { what, path, found, known })
            }
            _ => damaged("it is not a list of an export's files".into()),
        };
    };
    let mut listed = ContentsList {
        files: FilesByPath::new(),
        others: manifest.others.iter().map(|other| other.name.clone()).collect(),
        impossible: Vec::new(),
        note,
    };
    for entry in &manifest.files {
        match Piece::from_listing(entry.bytes, &entry.blake3) {
            Some(piece) if is_safe_name(&entry.name) && entry.name != MANIFEST_NAME => {
                listed.files.insert(entry.name.clone(), piece);
            }
            _ => listed.impossible.push(not_a_name(&entry.name)),
        }
    }
    listed.add_stale(path.parent().unwrap_or(Path::new("")), &manifest.others);
    Ok(listed)
}

impl ContentsList {
    /// Adds leftovers of an earlier export, so that they are compared as well where they still exist.
    fn add_stale(&mut self, folder: &Path, others: &[UnlistedFile]) {
        for UnlistedFile { name, blake3, .. } in
            others.iter().filter(|other| is_safe_name(&other.name))
        {
            let Some(blake3) = blake3 else { continue };
            // Their sizes are not listed, and they may have been removed.
            let Some(bytes) = directory_listing::size_bytes(&folder.join(name)) else { continue };
            if let Some(piece) = Piece::from_listing(bytes, blake3) {
                self.files.insert(name.clone(), piece);
            }
        }
    }
}

fn not_a_name(name: &str) -> (String, String) {
    let why = "it is listed, and is no name of a file in the folder with a size and a hash";
    (name.to_owned(), why.to_owned())
}
