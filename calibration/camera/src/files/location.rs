//! Names of cameras behind the path of a file.

use std::path::{Path, PathBuf};

/// Splits `FILE#NAME` into a path and the name of one camera in that file. `exists` tells whether a path is a file: one
/// whose own name contains `#` is taken as it is.
///
/// ```
/// use std::path::Path;
/// use fabkit_camera::files::split_camera_name;
///
/// let split = |path: &str, exists: bool| split_camera_name(Path::new(path), |_| exists);
/// assert_eq!(split("chain.yaml#cam1", false), ("chain.yaml".into(), Some("cam1".into())));
/// assert_eq!(split("lens#2.yaml", true), ("lens#2.yaml".into(), None));
/// assert_eq!(split("chain.yaml", false), ("chain.yaml".into(), None));
/// ```
pub fn split_camera_name(path: &Path, exists: impl Fn(&Path) -> bool) -> (PathBuf, Option<String>) {
    let split = path.to_str().and_then(|text| text.rsplit_once('#'));
    match split {
        // A `#` in a folder is no separator.
        Some((file, name)) if !file.is_empty() && !name.contains('/') && !exists(path) => {
            (file.into(), Some(name.to_owned()))
        }
        _ => (path.to_owned(), None),
    }
}
