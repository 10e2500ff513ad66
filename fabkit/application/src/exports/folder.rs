//! Export folders: comparison with an earlier export, and transactional writing.
//!
//! The manifest always describes its folder correctly. Files that an earlier export of the same design with the same
//! options wrote, and that nobody has changed, stay listed. All other files are listed separately with the reason. A
//! file that fabkit did not write is never overwritten unless forced.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

use fabkit_export::{FileEntry, Manifest, PartEntry, ProfileEntry, UnlistedFile, UnlistedReason};
use fabkit_files::directory_listing::list_visible_files;
use fabkit_files::reading::{self, ExpectedFile, ReadError};
use fabkit_files::resumable::{MAX_DOCUMENT_BYTES, SealError, unseal};
use fabkit_files::staging::hash_file;
use fabkit_files::staging::{OutputFile, StagingError, Transaction};
use fabkit_files::{ErrorKind, ErrorSubject, Explained, join_messages};

use super::{Exported, MANIFEST_NAME, manifest_file};
use crate::exports::ExportRunError;

/// Limits for reading a manifest.
const MANIFEST: ExpectedFile = ExpectedFile {
    what: "a manifest",
    max_bytes: MAX_DOCUMENT_BYTES,
    hint: "fabkit did not write it",
};

/// Permissions for existing files.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overwriting {
    /// Remove files that the old manifest lists and this export does not write.
    pub clean: bool,
    /// Overwrite changed files and files that fabkit did not write.
    pub force: bool,
}

/// Result of writing one export folder.
#[derive(Clone, Debug)]
pub struct WrittenExport {
    /// Manifest as written, including files that an earlier export left there.
    pub manifest: Manifest,
    /// Files of an earlier export that were removed.
    pub removed: Vec<String>,
}

/// Error that prevents an export from being written.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// Existing files or folders that may not be replaced.
    #[error("{}", join_messages(.0))]
    Refused(Vec<FolderRefusal>),
    /// A manifest that cannot be encoded.
    #[error(transparent)]
    Export(#[from] ExportRunError),
    /// File system errors.
    #[error(transparent)]
    Staging(#[from] StagingError),
}

/// Existing file or folder that blocks the export.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FolderRefusal {
    /// The folder holds another design's export.
    #[error("{} holds the export of {found}, not of {wanted}", .folder.display())]
    OtherDesign {
        /// Folder.
        folder: PathBuf,
        /// Design whose export it holds.
        found: String,
        /// Design to be exported.
        wanted: String,
    },
    /// The file was changed since fabkit wrote it.
    #[error("{} was changed since fabkit wrote it", .0.display())]
    Changed(PathBuf),
    /// The file was not written by fabkit.
    #[error("{} is there, and no manifest says that fabkit wrote it", .0.display())]
    Foreign(PathBuf),
}

impl FolderError {
    /// Returns whether a folder holds another design's export; `force` does not replace that, only `clean` does.
    pub fn holds_other_design(&self) -> bool {
        let Self::Refused(refusals) = self else { return false };
        refusals.iter().any(|refusal| matches!(refusal, FolderRefusal::OtherDesign { .. }))
    }
}

impl Explained for FolderError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Refused(_) => ErrorKind::BadInput,
            Self::Export(error) => error.kind(),
            Self::Staging(error) => error.kind(),
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Refused(_) if self.holds_other_design() => {
                Some("choose another folder, or have what that export wrote cleaned away".into())
            }
            Self::Refused(_) => Some("choose another folder, or have it replaced by force".into()),
            Self::Export(error) => error.hint(),
            Self::Staging(error) => error.hint(),
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Refused(_) if self.holds_other_design() => ErrorSubject::new("other_design"),
            Self::Refused(_) => ErrorSubject::new("edited_by_hand"),
            Self::Export(error) => error.subject(),
            Self::Staging(error) => error.subject(),
        }
    }
}

/// Writes all exports into their folders in one transaction: all files of all of them, or none.
///
/// # Errors
/// [`FolderError`]; the folders are then unchanged.
///
/// ```
/// use fabkit_application::exports::{ExportOptions, Format, Overwriting, export, write};
/// use fabkit_application::{source::Target, verify_folder::verify_folder};
///
/// let options = ExportOptions { parts: vec!["base".into()], formats: vec![Format::Stl], ..ExportOptions::default() };
/// let exported = export(&Target::new("rtac0").design(&[])?, &options, &|_| ())?;
/// let folder = std::env::temp_dir().join(format!("fabkit-export-{}", std::process::id()));
/// write(&[(folder.clone(), &exported)], Overwriting::default(), &|| false)?;
/// assert!(verify_folder(&folder)?[0].passed());
/// // A file that somebody changed is not overwritten, unless forced.
/// std::fs::write(folder.join("base.stl"), "mine")?;
/// assert!(!verify_folder(&folder)?[0].passed());
/// assert!(write(&[(folder.clone(), &exported)], Overwriting::default(), &|| false).is_err());
/// std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(
    exports: &[(PathBuf, &Exported)],
    how: Overwriting,
    cancelled: &dyn Fn() -> bool,
) -> Result<Vec<WrittenExport>, FolderError> {
    let stop = || if cancelled() { Err(StagingError::Cancelled) } else { Ok(()) };
    let manifests: Vec<PathBuf> =
        exports.iter().map(|(folder, _)| folder.join(MANIFEST_NAME)).collect();
    // The transaction locks its folders: nobody else writes there from here on. Subfolders (of boards) need locks too.
    let below: Vec<PathBuf> = exports
        .iter()
        .flat_map(|(folder, exported)| files(exported).map(|file| folder.join(&file.name)))
        .filter(|place| !manifests.iter().any(|manifest| manifest.parent() == place.parent()))
        .collect();
    let places = manifests.iter().chain(&below).map(PathBuf::as_path);
    let mut set = Transaction::open(places, cancelled)?;
    let mut refusals = Vec::new();
    let mut merged = Vec::new();
    for (folder, exported) in exports {
        merged.push(MergedExport::new(folder, exported, how, &mut refusals)?);
    }
    if !refusals.is_empty() {
        return Err(FolderError::Refused(refusals));
    }
    for ((folder, exported), merged) in exports.iter().zip(&merged) {
        let manifest = manifest_file(&merged.manifest)?;
        for OutputFile { name, bytes } in files(exported).chain([&manifest]) {
            stop()?;
            set.write(&folder.join(name), bytes)?;
        }
        for name in &merged.removed {
            set.remove(&folder.join(name))?;
        }
    }
    stop()?;
    set.commit()?;
    let written = |MergedExport { manifest, removed }| WrittenExport { manifest, removed };
    Ok(merged.into_iter().map(written).collect())
}

/// Lists all files but the manifest, which is written anew from the merged one.
fn files(exported: &Exported) -> impl Iterator<Item = &OutputFile> {
    exported.files.iter().filter(|file| file.name != MANIFEST_NAME)
}

struct MergedExport {
    manifest: Manifest,
    removed: Vec<String>,
}

/// Entry of a file in an earlier manifest.
enum EarlierEntry {
    /// Listed by an export of the same design and options, which still describes the file correctly.
    Same(FileEntry),
    /// Listed by an export of another design or options; holds the BLAKE3 hash.
    Stale(String),
}

impl EarlierEntry {
    fn blake3(&self) -> &str {
        match self {
            Self::Same(entry) => &entry.blake3,
            Self::Stale(blake3) => blake3,
        }
    }
}

impl MergedExport {
    fn new(
        folder: &Path,
        exported: &Exported,
        how: Overwriting,
        refusals: &mut Vec<FolderRefusal>,
    ) -> Result<Self, StagingError> {
        let mut manifest = exported.manifest.clone();
        let old = read_old_manifest(folder)?;
        if !how.force {
            let place = || folder.join(MANIFEST_NAME);
            match old {
                OldManifest::Unrecognised => refusals.push(FolderRefusal::Foreign(place())),
                OldManifest::Changed => refusals.push(FolderRefusal::Changed(place())),
                OldManifest::Nothing | OldManifest::Ours(_) => {}
            }
        }
        let old = if let OldManifest::Ours(old) = old { Some(*old) } else { None };
        if let Some(old) = old.as_ref().filter(|old| old.sensor != manifest.sensor && !how.clean) {
            // Nothing is merged with another design's folder: its refusal ends the export anyway.
            let (found, wanted) = (old.sensor.clone(), manifest.sensor.clone());
            refusals.push(FolderRefusal::OtherDesign { folder: folder.into(), found, wanted });
            return Ok(Self { manifest, removed: Vec::new() });
        }
        let mut earlier = BTreeMap::new();
        let (mut old_parts, mut old_profile) = (Vec::new(), None);
        if let Some(old) = old {
            let key = |m: &Manifest| (m.sensor.clone(), m.design_hash.clone(), m.options.clone());
            // Entries of other options would describe the file wrongly, so only their hashes are kept.
            let is_same = key(&old) == key(&manifest);
            for entry in old.files.into_iter().filter(|entry| is_plain(&entry.name)) {
                let (name, hash) = (entry.name.clone(), entry.blake3.clone());
                let one =
                    if is_same { EarlierEntry::Same(entry) } else { EarlierEntry::Stale(hash) };
                earlier.insert(name, one);
            }
            let stale = old.others.into_iter().filter(|other| is_plain(&other.name));
            earlier.extend(stale.filter_map(|o| Some((o.name, EarlierEntry::Stale(o.blake3?)))));
            old_parts = old.parts;
            old_profile = old.profile;
        }
        for file in files(exported) {
            let place = folder.join(&file.name);
            let listed = earlier.remove(&file.name);
            // A folder or other non-file in its place is refused when it is written.
            let Some(found) = hash_file(&place)? else { continue };
            // A file with the new content needs no permission, whoever wrote it.
            let is_ours = blake3::hash(&file.bytes).to_hex().as_str() == found
                || listed.as_ref().is_some_and(|listed| listed.blake3() == found);
            if !is_ours && !how.force {
                let refusal =
                    if listed.is_some() { FolderRefusal::Changed } else { FolderRefusal::Foreign };
                refusals.push(refusal(place));
            }
        }
        let mut removed = Vec::new();
        for (name, earlier) in &earlier {
            let Some(found) = hash_file(&folder.join(name))? else { continue };
            let other = |why, blake3| UnlistedFile { name: name.clone(), why, blake3 };
            match earlier {
                // This arm comes first: a changed file is kept even with `clean`.
                _ if found != earlier.blake3() => {
                    manifest.others.push(other(UnlistedReason::Changed, None));
                }
                _ if how.clean => removed.push(name.clone()),
                EarlierEntry::Same(entry) => manifest.files.push(entry.clone()),
                EarlierEntry::Stale(_) => {
                    manifest.others.push(other(UnlistedReason::Stale, Some(found)))
                }
            }
        }
        let known: BTreeSet<&str> = files(exported)
            .map(|file| file.name.as_str())
            .chain(earlier.keys().map(String::as_str))
            .chain([MANIFEST_NAME])
            .collect();
        // Boards have subfolders of their own, which are searched as well.
        let own = known.iter().filter_map(|name| Some(name.rsplit_once('/')?.0));
        let mut there = list_visible_files(folder, "")?;
        for below in own.collect::<BTreeSet<&str>>() {
            there.extend(list_visible_files(&folder.join(below), &format!("{below}/"))?);
        }
        let foreign = there.into_iter().filter(|name| !known.contains(name.as_str()));
        manifest.others.extend(foreign.map(|name| UnlistedFile {
            name,
            why: UnlistedReason::Foreign,
            blake3: None,
        }));
        manifest.others.sort_by(|a, b| a.name.cmp(&b.name));
        manifest.files.sort_by(|a, b| a.name.cmp(&b.name));
        add_parts(&mut manifest, old_parts, &exported.bodies);
        add_profiled(&mut manifest, old_profile, &exported.bodies);
        Ok(Self { manifest, removed })
    }
}

/// Adds the parts of files that stay listed, in the order of the design.
fn add_parts(manifest: &mut Manifest, old: Vec<PartEntry>, order: &[String]) {
    let mut is_complete = true;
    for part in old {
        let is_listed = |file: &FileEntry| file.parts.contains(&part.name);
        if !manifest.files.iter().any(is_listed) {
            continue;
        }
        match manifest.parts.iter_mut().find(|there| there.name == part.name) {
            None => {
                manifest.parts.push(part);
                is_complete = false;
            }
            // The earlier export included this part's outlines, which are still there.
            Some(there) if there.sheet.is_none() && part.sheet.is_some() => *there = part,
            Some(_) => {}
        }
    }
    if !is_complete {
        let place = |name: &str| order.iter().position(|there| there == name);
        manifest.parts.sort_by_key(|part| place(&part.name));
    }
}

/// Adds the earlier profile entries of parts that stay listed. The options are the same, so it is the same profile.
fn add_profiled(manifest: &mut Manifest, old: Option<ProfileEntry>, order: &[String]) {
    let (Some(profile), Some(old)) = (&mut manifest.profile, old) else { return };
    let is_known = |name: &String| {
        profile.applied.contains(name) || profile.not_applied.iter().any(|no| no.part == *name)
    };
    let stays =
        |name: &String| manifest.parts.iter().any(|part| part.name == *name) && !is_known(name);
    let applied = old.applied.into_iter().filter(stays).collect::<Vec<_>>();
    let to_other = old.applied_to_other_material.into_iter().filter(stays).collect::<Vec<_>>();
    let not_applied = old.not_applied.into_iter().filter(|no| stays(&no.part)).collect::<Vec<_>>();
    profile.applied.extend(applied);
    profile.applied_to_other_material.extend(to_other);
    profile.not_applied.extend(not_applied);
    let place = |name: &str| order.iter().position(|there| there == name);
    profile.applied.sort_by_key(|name| place(name));
    profile.applied_to_other_material.sort_by_key(|name| place(name));
    profile.not_applied.sort_by_key(|no| place(&no.part));
}

enum OldManifest {
    Nothing,
    Ours(Box<Manifest>),
    /// Manifest of fabkit whose seal does not match its content.
    Changed,
    Unrecognised,
}

fn read_old_manifest(folder: &Path) -> Result<OldManifest, StagingError> {
    let path = folder.join(MANIFEST_NAME);
    let bytes = match reading::read(&path, MANIFEST) {
        Ok(bytes) => bytes,
        Err(ReadError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
            return Ok(OldManifest::Nothing);
        }
        Err(ReadError::Io { path, source }) => {
            return Err(StagingError::Io { action: "read", path, source });
        }
        Err(_) => return Ok(OldManifest::Unrecognised),
    };
    Ok(match unseal(&bytes) {
        Err(SealError::Mismatch) => OldManifest::Changed,
        // Manifests of old versions have no seal.
        Ok(_) | Err(SealError::Missing) => Manifest::from_json(&bytes)
            .map_or(OldManifest::Unrecognised, |manifest| OldManifest::Ours(manifest.into())),
    })
}

/// Returns whether a listed name is a plain file below the folder. A manifest edited by hand could otherwise lead to
/// removals elsewhere.
fn is_plain(name: &str) -> bool {
    fabkit_files::resumable::is_safe_name(name) && name != MANIFEST_NAME
}
