//! Registered notations of camera files.

use fabkit_text::{MAX_BYTES, YamlNode, list_names, to_printable};

use super::{
    CameraFile, InvalidCameraFile, YamlFault, camodocal, colmap, fabkit, ini, kalibr, matrices,
    mrcal, orb_slam, python_literal, xml, yaml,
};

/// Maximum length of a camera file, bytes. Only mrcal's may be longer than 1 MiB: they hold all that was calibrated with.
pub const MAX_FILE_BYTES: usize = 16 << 20;

/// Notation of camera files.
#[derive(Clone, Copy)]
pub struct Notation {
    /// Name in messages, for example `Kalibr`.
    pub name: &'static str,
    /// Keys or lines by which the notation is recognised, for messages.
    pub told_by: &'static str,
    /// Returns the names of the cameras in a file of this notation, empty for one without a name; `None` for a file of
    /// another notation.
    cameras: fn(&YamlNode) -> Option<Vec<String>>,
    /// Reads the camera with a name.
    read: fn(&YamlNode, &str) -> Result<CameraFile, InvalidCameraFile>,
}

impl std::fmt::Debug for Notation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// All notations that are read, those with the most specific keys first: others may use common names.
pub const NOTATIONS: [Notation; 7] = [
    Notation {
        name: "fabkit",
        told_by: fabkit::VERSION_KEY,
        cameras: |root| root.get(fabkit::VERSION_KEY).map(|_| Vec::new()),
        read: |root, _| fabkit::read(root),
    },
    Notation { name: "Kalibr", told_by: "cam0", cameras: kalibr::cameras, read: kalibr::read },
    Notation {
        name: "COLMAP",
        told_by: "1 OPENCV 640 480",
        cameras: colmap::cameras,
        read: colmap::read,
    },
    Notation { name: "mrcal", told_by: "lensmodel", cameras: mrcal::cameras, read: mrcal::read },
    Notation {
        name: "camodocal",
        told_by: "model_type",
        cameras: camodocal::cameras,
        read: camodocal::read,
    },
    Notation {
        name: "ORB-SLAM",
        told_by: "Camera.fx",
        cameras: orb_slam::cameras,
        read: orb_slam::read,
    },
    Notation {
        name: "OpenCV, ROS",
        told_by: "camera_matrix",
        cameras: matrices::cameras,
        read: matrices::read,
    },
];

/// Reads the camera with a name, or the only one.
pub(super) fn read(text: &str, name: Option<&str>) -> Result<CameraFile, InvalidCameraFile> {
    let (root, twice) = parse(text)?;
    yaml::with_duplicates(read_tree(&root, name), twice)
}

/// Parses a text of any syntax to the tree of the same content in YAML. The faults are those of keys written twice.
fn parse(text: &str) -> Result<(YamlNode, Vec<YamlFault>), YamlFault> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let first = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    let first = first.unwrap_or_default();
    if first.starts_with('{') && mrcal::is_recognised(text) && text.len() <= MAX_FILE_BYTES {
        python_literal::parse(text)
    } else if text.len() > MAX_BYTES {
        // The YAML parser knows what to say about it.
        yaml::parse_tree(text)
    } else if first.starts_with('<') {
        xml::parse(text)
    } else if ini::is_recognised(text) {
        Ok((ini::parse(text)?, Vec::new()))
    } else if colmap::is_recognised(first) {
        Ok(colmap::parse(text))
    } else {
        yaml::parse_tree(text)
    }
}

fn read_tree(root: &YamlNode, name: Option<&str>) -> Result<CameraFile, InvalidCameraFile> {
    for notation in NOTATIONS {
        let Some(cameras) = (notation.cameras)(root) else { continue };
        return match (name, &cameras[..]) {
            (None, []) => (notation.read)(root, ""),
            (None, [only]) => (notation.read)(root, only),
            (Some(name), all) if all.iter().any(|known| known == name) => {
                (notation.read)(root, name)
            }
            (name, all) => Err(wrong_name(name, all).into()),
        };
    }
    Err(unknown_notation(root).into())
}

/// Creates the fault of a file with several cameras, or without the one that is named.
fn wrong_name(name: Option<&str>, all: &[String]) -> YamlFault {
    let shown: Vec<String> = all.iter().map(|name| to_printable(name)).collect();
    let quoted: Vec<String> = shown.iter().map(|name| format!("`{name}`")).collect();
    let listed = list_names(&quoted.iter().map(String::as_str).collect::<Vec<_>>());
    let example = shown.first().map_or("", String::as_str);
    let hint = format!("write FILE#{example} for the first, as in `--camera FILE#{example}`");
    match name {
        None => {
            let message = format!("the file holds {} cameras: {listed}", all.len());
            YamlFault::new(None, "", message).hint(hint)
        }
        Some(name) if all.is_empty() => {
            let message = format!(
                "the file holds one camera, which has no name; `{}` was asked for",
                to_printable(name)
            );
            YamlFault::new(None, "", message).hint("leave out the # and what follows it")
        }
        Some(name) => {
            let message = format!("the file has no camera `{}`, but {listed}", to_printable(name));
            YamlFault::new(None, "", message).hint(hint)
        }
    }
}

/// Creates the fault of a file that no notation recognises. It says what the file lacks.
fn unknown_notation(root: &YamlNode) -> YamlFault {
    let known = NOTATIONS.map(|Notation { name, told_by, .. }| {
        // The key of fabkit's own files says whose they are.
        let is_told = told_by.starts_with(name);
        if is_told { format!("`{told_by}`") } else { format!("`{told_by}` ({name})") }
    });
    let hint = format!("expected {}", known.join(", "));
    let message = match matrices::missing_part(root) {
        Some(missing) => format!("this camera file lacks {missing}"),
        None => "this is no camera file that fabkit knows".to_owned(),
    };
    YamlFault::new(None, "", message).hint(hint)
}
