//! Input and output files of a command.
//!
//! A command declares them before it begins. Files are compared by identity, not by spelling: `./x`, symbolic links,
//! hard links, and another case where the file system ignores case, are recognised. An output that would replace an
//! input or another output is refused.

use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

use fabkit_application::scene::split_camera_path;
use fabkit_application::{Error, ErrorSubject, reading};

use crate::failure::{ErrorKind, Failure};

/// Input and output files of one run of a command.
#[derive(Debug, Default)]
pub(crate) struct FileRoles {
    inputs: Vec<FileRole>,
    outputs: Vec<FileRole>,
}

#[derive(Debug)]
struct FileRole {
    /// Option, for example `--camera` or `SENSOR`.
    option: String,
    path: PathBuf,
    identity: FileIdentity,
    /// True if the command cannot begin without it.
    is_needed: bool,
}

impl FileRole {
    fn new(option: &str, path: &Path, is_needed: bool) -> Self {
        Self {
            option: option.into(),
            path: path.into(),
            identity: FileIdentity::from_path(path),
            is_needed,
        }
    }

    fn is_missing(&self) -> bool {
        matches!(self.identity, FileIdentity::Missing(..))
    }
}

impl FileRoles {
    /// Adds input files; an option that was not given adds none.
    pub(crate) fn reads<P: AsRef<Path>>(
        self,
        option: &str,
        path: impl IntoIterator<Item = P>,
    ) -> Self {
        self.inputs(option, path, true)
    }

    /// Adds a camera file, of which `FILE#NAME` names one camera.
    pub(crate) fn reads_camera<P: AsRef<Path>>(self, path: impl IntoIterator<Item = P>) -> Self {
        let files = path.into_iter().map(|path| split_camera_path(path.as_ref()).0);
        self.reads("--camera", files)
    }

    /// Adds input files that may be missing, because they are optional or because their reader reports all faults at once.
    pub(crate) fn may_read<P: AsRef<Path>>(
        self,
        option: &str,
        path: impl IntoIterator<Item = P>,
    ) -> Self {
        self.inputs(option, path, false)
    }

    fn inputs<P: AsRef<Path>>(
        mut self,
        option: &str,
        path: impl IntoIterator<Item = P>,
        is_needed: bool,
    ) -> Self {
        let path = path.into_iter();
        self.inputs.extend(path.map(|path| FileRole::new(option, path.as_ref(), is_needed)));
        self
    }

    /// Adds all input files of a place: the files in a folder, or a file and, if it is a list, the files named in it.
    /// `is_read` selects the files that the command reads.
    pub(crate) fn reads_all(
        self,
        option: &str,
        place: Option<&Path>,
        is_read: impl Fn(&str) -> bool,
    ) -> Self {
        let Some(place) = place else { return self };
        let mut files = vec![place.to_owned()];
        if let Ok(entries) = place.read_dir() {
            let paths = entries.flatten().map(|entry| entry.path());
            files = paths.filter(|path| is_read(&path.to_string_lossy())).collect();
        // Larger files are not lists; they are not searched for names.
        } else if fs::metadata(place).is_ok_and(|found| found.is_file() && found.len() < 1 << 24) {
            let text = fs::read_to_string(place).unwrap_or_default();
            let folder = place.parent().unwrap_or(Path::new(""));
            let named = text.lines().flat_map(|line| line.split(','));
            let named = named.map(|field| field.trim()).filter(|field| is_read(field));
            files.extend(named.map(|field| folder.join(field)));
        }
        // The reader of the list reports missing files, with the line that names them.
        self.inputs(option, files, false)
    }

    /// Adds output files; an option that was not given adds none.
    pub(crate) fn writes<P: AsRef<Path>>(
        mut self,
        option: &str,
        path: impl IntoIterator<Item = P>,
    ) -> Self {
        self.outputs
            .extend(path.into_iter().map(|path| FileRole::new(option, path.as_ref(), false)));
        self
    }

    /// Refuses missing inputs before anything is computed, and outputs that are also inputs or other outputs, all at
    /// once.
    ///
    /// # Errors
    /// Files that cannot be opened; bad input that names both options.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let missing = self.inputs.iter().filter(|input| input.is_needed && input.is_missing());
        let unreadable = missing.filter_map(|input| reading::open(&input.path).err());
        if let Some(error) = Error::join(unreadable.map(Error::from).collect()) {
            return Err(error.into());
        }
        let mut wrong = Vec::new();
        for (i, output) in self.outputs.iter().enumerate() {
            let shown = format!("{} {}", output.option, output.path.display());
            let is_same = |other: &&FileRole| other.identity.may_equal(&output.identity);
            if let Some(input) = self.inputs.iter().find(is_same) {
                let (option, path) = (&input.option, input.path.display());
                wrong.push(format!("{shown} would replace what {option} reads ({path})"));
            }
            if let Some(other) = self.outputs[..i].iter().find(is_same) {
                let (option, path) = (&other.option, other.path.display());
                wrong.push(format!("{shown} and {option} {path} are the same file"));
            }
        }
        let hint = "give each file that is written a name of its own";
        if wrong.is_empty() {
            Ok(())
        } else {
            Err(Failure::new(ErrorKind::BadInput, wrong.join("\nerror: "), hint)
                .with_subject(ErrorSubject::new("replaces_input")))
        }
    }
}

/// Identity of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
enum FileIdentity {
    /// Existing file: device and inode or, on other systems, the canonical path.
    Existing(u64, u64, Option<PathBuf>),
    /// Missing file: canonical folder and name. Names that differ only in case count as the same, because some systems
    /// do not distinguish them.
    Missing(PathBuf, OsString),
}

impl FileIdentity {
    fn from_path(path: &Path) -> Self {
        match fs::metadata(path) {
            Ok(found) => Self::there(path, &found),
            Err(_) => {
                // A missing file has no identity of its own, but its folder has.
                let (folder, name) = split(path);
                Self::Missing(resolve_path(&folder), name)
            }
        }
    }

    #[cfg(unix)]
    fn there(_: &Path, found: &fs::Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self::Existing(found.dev(), found.ino(), None)
    }

    #[cfg(not(unix))]
    fn there(path: &Path, _: &fs::Metadata) -> Self {
        Self::There(0, 0, Some(resolve_path(path)))
    }

    fn may_equal(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Missing(folder, name), Self::Missing(there, other)) => {
                let lower = |name: &OsString| name.to_string_lossy().to_lowercase();
                folder == there && (name == other || lower(name) == lower(other))
            }
            _ => self == other,
        }
    }
}

fn split(path: &Path) -> (PathBuf, OsString) {
    let name = path.file_name().map(OsString::from).unwrap_or_default();
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => (folder.to_owned(), name),
        _ => (PathBuf::from("."), name),
    }
}

/// Resolves links and `..` as far as the path exists; the rest stays as written.
fn resolve_path(path: &Path) -> PathBuf {
    if let Ok(real) = fs::canonicalize(path) {
        return real;
    }
    match path.components().next_back() {
        Some(Component::Normal(name)) => {
            let (folder, _) = split(path);
            resolve_path(&folder).join(name)
        }
        Some(Component::ParentDir) => {
            let above = resolve_path(path.parent().unwrap_or(Path::new(".")));
            above.parent().map_or(above.clone(), Path::to_path_buf)
        }
        _ => path.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clash(input: &Path, output: &Path) -> bool {
        FileRoles::default().reads("IN", [input]).writes("-o", [output]).check().is_err()
    }

    #[test]
    fn a_file_is_the_same_in_any_spelling() {
        let root = tempfile::tempdir().unwrap();
        let path = |name: &str| root.path().join(name);
        fs::create_dir(path("sub")).unwrap();
        fs::write(path("a.yaml"), "a").unwrap();
        fs::write(path("b.yaml"), "b").unwrap();
        fs::hard_link(path("a.yaml"), path("hard.yaml")).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(path("a.yaml"), path("soft.yaml")).unwrap();
        for same in ["a.yaml", "./a.yaml", "sub/../a.yaml", "hard.yaml", "soft.yaml"] {
            assert!(clash(&path("a.yaml"), &path(same)), "{same}");
        }
        for other in ["b.yaml", "c.yaml", "A.yaml"] {
            assert!(!clash(&path("a.yaml"), &path(other)), "{other}");
        }
    }

    #[test]
    fn outputs_that_are_not_there_yet_are_told_apart_too() {
        let root = tempfile::tempdir().unwrap();
        let path = |name: &str| root.path().join(name);
        let both = |a: &str, b: &str| {
            FileRoles::default().writes("--png", [path(a)]).writes("--grey", [path(b)]).check()
        };
        for (a, b) in [("x.png", "./x.png"), ("x.png", "X.png"), ("n/x.png", "n/m/../x.png")] {
            let text = both(a, b).unwrap_err().to_text();
            assert!(text.contains("--png") && text.contains("--grey"), "{text}");
        }
        both("x.png", "y.png").unwrap();
        both("n/x.png", "m/x.png").unwrap();
    }
}
