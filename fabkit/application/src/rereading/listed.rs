//! Lists of contents, read for the verification of a folder.

use std::collections::BTreeSet;
use std::path::Path;

use fabkit_export::{Manifest, OtherFile};
use fabkit_files::listing;
use fabkit_files::resumable::{
    self, Files, FolderError, MAX_DOCUMENT_BYTES, Piece, SealError, files_of, is_plain,
    read_regular, unseal,
};
use serde_json::Value;

use super::{Kind, RereadError};
use crate::exporting::MANIFEST_NAME;
use crate::sweeping;

/// Note on manifests without a checksum.
const UNSEALED: &str = "manifest.json has no checksum, because an older fabkit wrote it: whether it \
                        was damaged itself cannot be known; export again to have one";

/// List of contents that is itself undamaged.
pub(super) struct Listed {
    /// Files that must be there.
    pub files: Files,
    /// Other files known to lie there; they may be gone.
    pub others: BTreeSet<String>,
    /// Invalid entries: the name and what is wrong with it.
    pub impossible: Vec<(String, String)>,
    pub note: Option<&'static str>,
}

impl Listed {
    /// Reads the list, or returns the damage that makes it unusable.
    ///
    /// # Errors
    /// A list of another format version, and errors of the file system.
    pub(super) fn read(folder: &Path, kind: Kind) -> Result<Result<Self, String>, RereadError> {
        let path = folder.join(kind.document());
        if listing::is_no_file(&path) {
            return Ok(Err("it is not a file".into()));
        }
        let read = match kind {
            Kind::Export => manifest(&path),
            Kind::Dataset => document(&path, fabkit_dataset::KIND),
            Kind::Sweep => document(&path, sweeping::KIND),
        };
        match read {
            Ok(listed) => Ok(Ok(listed)),
            Err(FolderError::DamagedDocument { what, .. } | FolderError::Damaged { what, .. }) => {
                Ok(Err(what))
            }
            Err(error @ FolderError::OtherVersion { .. }) => Err(RereadError::OtherVersion(error)),
            Err(error) => Err(error.into()),
        }
    }
}

fn gone(path: &Path) -> FolderError {
    FolderError::Damaged { path: path.into(), what: "it is missing".into() }
}

fn document(path: &Path, kind: resumable::FolderKind) -> Result<Listed, FolderError> {
    let document = kind.read(path)?.ok_or_else(|| gone(path))?;
    let files = files_of(&document);
    let names = document["files"].as_object().into_iter().flatten().map(|(name, _)| name);
    let impossible = names.filter(|name| !files.contains_key(*name)).map(|name| not_a_name(name));
    let impossible = impossible.collect();
    Ok(Listed { files, others: BTreeSet::new(), impossible, note: None })
}

fn manifest(path: &Path) -> Result<Listed, FolderError> {
    let bytes = read_regular(path, MAX_DOCUMENT_BYTES)?.ok_or_else(|| gone(path))?;
    let damaged = |what: String| Err(FolderError::DamagedDocument { path: path.into(), what });
    let (document, note) = match unseal(&bytes) {
        Ok(document) => (document, None),
        Err(error @ SealError::Other) => return damaged(error.to_string()),
        Err(SealError::None) => match serde_json::from_slice::<Value>(&bytes) {
            // A seal that is not at the end was not written by fabkit.
            Ok(document) if document["blake3"].is_null() => (document, Some(UNSEALED)),
            _ => return damaged(SealError::None.to_string()),
        },
    };
    let found = document["version"].as_u64();
    let known = u64::from(Manifest::VERSION);
    let Some(manifest) = Manifest::from_json(&bytes) else {
        return match found {
            Some(found) if found != known => {
                let (what, path) = ("manifest", path.into());
                Err(FolderError::OtherVersion { what, path, found, known })
            }
            _ => damaged("it is not a list of an export's files".into()),
        };
    };
    let mut listed = Listed {
        files: Files::new(),
        others: manifest.others.iter().map(|other| other.name.clone()).collect(),
        impossible: Vec::new(),
        note,
    };
    for entry in &manifest.files {
        match Piece::listed(entry.bytes, &entry.blake3) {
            Some(piece) if is_plain(&entry.name) && entry.name != MANIFEST_NAME => {
                listed.files.insert(entry.name.clone(), piece);
            }
            _ => listed.impossible.push(not_a_name(&entry.name)),
        }
    }
    listed.add_stale(path.parent().unwrap_or(Path::new("")), &manifest.others);
    Ok(listed)
}

impl Listed {
    /// Adds leftovers of an earlier export, so that they are compared as well where they still exist.
    fn add_stale(&mut self, folder: &Path, others: &[OtherFile]) {
        for OtherFile { name, blake3, .. } in others.iter().filter(|other| is_plain(&other.name)) {
            let Some(blake3) = blake3 else { continue };
            // Their sizes are not listed, and they may have been removed.
            let Some(bytes) = listing::size_bytes(&folder.join(name)) else { continue };
            if let Some(piece) = Piece::listed(bytes, blake3) {
                self.files.insert(name.clone(), piece);
            }
        }
    }
}

fn not_a_name(name: &str) -> (String, String) {
    let why = "it is listed, and is no name of a file in the folder with a size and a hash";
    (name.to_owned(), why.to_owned())
}
