//! Times and filament as PrusaSlicer estimates them, where it is installed: each part of filament as its 3MF file
//! has it, in a folder of our own, with nothing of the user's configuration.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use fabkit_designs::Design;
use fabkit_files::progress::{OnProgress, Step};
use fabkit_files::scratch::Scratch;
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_guide::{Guide, Sliced};
use rayon::prelude::*;

use crate::exporting::{self, ExportFailure, ExportOptions, Format};

/// Names the slicer by an absolute path, in place of the one on the search path.
pub const SLICER_VARIABLE: &str = "FABKIT_SLICER";

/// As Debian and the slicer's own builds for Linux call it.
const PROGRAM: &str = "prusa-slicer";

/// Most that one part may take.
const LIMIT: Duration = Duration::from_secs(300);

/// Between looks at a slicer that works.
const LOOK: Duration = Duration::from_millis(20);

const MM3_PER_CM3: f64 = 1e3;

/// Why nothing was sliced.
#[derive(Debug, thiserror::Error)]
pub enum SlicingError {
    /// Nothing on the search path, and none is named.
    #[error("{PROGRAM} is not installed")]
    NotFound,
    /// A path that is none.
    #[error("{SLICER_VARIABLE} is {}, which is no absolute path of a file", .0.display())]
    NoSuchSlicer(PathBuf),
    /// No 3MF files to slice.
    #[error(transparent)]
    Export(#[from] ExportFailure),
    /// The system's reasons.
    #[error("cannot slice {part}: {source}")]
    Io {
        /// Which part.
        part: String,
        /// Why.
        source: std::io::Error,
    },
    /// The slicer does not come to an end.
    #[error("slicing {part} took more than {} s", LIMIT.as_secs())]
    TooSlow {
        /// Which part.
        part: String,
    },
    /// The slicer refuses a part, or says nothing of it.
    #[error("the slicer makes nothing of {part}: {said}")]
    Refused {
        /// Which part.
        part: String,
        /// Its last line.
        said: String,
    },
    /// Somebody wants to stop.
    #[error("interrupted")]
    Cancelled,
}

impl Explained for SlicingError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NotFound | Self::NoSuchSlicer(_) => ErrorKind::BadInput,
            Self::Export(error) => error.kind(),
            Self::Io { .. } => ErrorKind::Io,
            Self::Cancelled => ErrorKind::Interrupted,
            Self::TooSlow { .. } | Self::Refused { .. } => ErrorKind::Limit,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::NotFound => Some(format!(
                "install PrusaSlicer, name it by {SLICER_VARIABLE}, or leave the slicer out: the guide then has \
                 fabkit's own estimates"
            )),
            Self::NoSuchSlicer(_) => Some("write its whole path, or unset the variable".into()),
            Self::Export(error) => error.hint(),
            Self::TooSlow { .. } | Self::Refused { .. } => {
                Some("leave the slicer out: the guide then has fabkit's own estimates".into())
            }
            Self::Io { .. } | Self::Cancelled => None,
        }
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::NotFound | Self::NoSuchSlicer(_) => "no_slicer",
            _ => "slicing",
        })
    }
}

/// Where the slicer is.
///
/// # Errors
/// [`SlicingError::NotFound`] and [`SlicingError::NoSuchSlicer`].
pub fn find() -> Result<PathBuf, SlicingError> {
    if let Some(named) = env::var_os(SLICER_VARIABLE).filter(|name| !name.is_empty()) {
        let path = PathBuf::from(named);
        let is_there = path.is_absolute() && path.is_file();
        return if is_there { Ok(path) } else { Err(SlicingError::NoSuchSlicer(path)) };
    }
    let path = env::var_os("PATH").unwrap_or_default();
    // What lies in the working folder is not looked at.
    let folders = env::split_paths(&path).filter(|folder| folder.is_absolute());
    let mut places = folders.map(|folder| folder.join(PROGRAM));
    places.find(|place| place.is_file()).ok_or(SlicingError::NotFound)
}

/// Puts the slicer's times and filament into a guide, in place of the model's. Parts that are printed as one
/// piece with others keep the model's.
///
/// # Errors
/// [`SlicingError`], of the first part in the order of the guide.
pub fn slice(
    design: &Design,
    guide: &mut Guide,
    slicer: &Path,
    cancelled: &(dyn Fn() -> bool + Sync),
    progress: OnProgress,
) -> Result<(), SlicingError> {
    let printed: Vec<String> = guide
        .made
        .iter()
        .filter(|made| made.print.is_some())
        .map(|made| made.name.clone())
        .collect();
    let options = ExportOptions {
        parts: printed.clone(),
        formats: vec![Format::ThreeMf],
        ..ExportOptions::default()
    };
    let exported = match printed.is_empty() {
        true => return Ok(()),
        false => exporting::export(design, &options, &|_| {})?,
    };
    let stem = |name: &str| name.strip_suffix(".3mf").map(str::to_owned);
    let named = exported.files.iter().filter_map(|file| Some((stem(&file.name)?, &file.bytes[..])));
    let files: Vec<(String, &[u8])> = named.filter(|(part, _)| printed.contains(part)).collect();
    let sliced: Vec<Result<Sliced, SlicingError>> =
        files.par_iter().map(|(part, bytes)| one(slicer, part, bytes, cancelled)).collect();
    let all = files.len();
    for (done, ((part, _), sliced)) in files.into_iter().zip(sliced).enumerate() {
        guide.take_sliced(&part, sliced?);
        progress(Step { done: done + 1, all, ..Step::default() });
    }
    Ok(())
}

fn one(
    slicer: &Path,
    part: &str,
    bytes: &[u8],
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<Sliced, SlicingError> {
    let failed = |source| SlicingError::Io { part: part.to_owned(), source };
    // Before there is anything to clean up: from here on somebody looks.
    if cancelled() {
        return Err(SlicingError::Cancelled);
    }
    let folder = Scratch::new().map_err(failed)?;
    folder.write("part.3mf", bytes).map_err(failed)?;
    folder.make_folder("settings").map_err(failed)?;
    let log = folder.create("log").map_err(failed)?;
    let arguments: [OsString; 6] = [
        "--datadir".into(),
        folder.place("settings").into(),
        "--export-gcode".into(),
        "--output".into(),
        folder.place("part.gcode").into(),
        folder.place("part.3mf").into(),
    ];
    let child = Command::new(slicer)
        .args(arguments)
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(log.try_clone().map_err(failed)?)
        .stderr(log)
        .spawn()
        .map_err(failed)?;
    wait(child, part, cancelled)?;
    let text = folder.read("part.gcode");
    read(&String::from_utf8_lossy(&text)).ok_or_else(|| {
        let log = folder.read("log");
        let log = String::from_utf8_lossy(&log);
        let said = log.lines().last().unwrap_or("it ended without a word").trim().to_owned();
        SlicingError::Refused { part: part.to_owned(), said }
    })
}

fn wait(
    mut child: Child,
    part: &str,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<(), SlicingError> {
    let begun = Instant::now();
    loop {
        let failed = |source| SlicingError::Io { part: part.to_owned(), source };
        if let Some(status) = child.try_wait().map_err(failed)? {
            if !status.success() {
                // Ctrl-C in a terminal reaches the slicer as well, perhaps a little earlier.
                std::thread::sleep(LOOK);
            }
            return if cancelled() { Err(SlicingError::Cancelled) } else { Ok(()) };
        }
        let is_cancelled = cancelled();
        if is_cancelled || begun.elapsed() > LIMIT {
            // Whatever it says, it is to end.
            let _ = child.kill();
            let _ = child.wait();
            return Err(match is_cancelled {
                true => SlicingError::Cancelled,
                false => SlicingError::TooSlow { part: part.to_owned() },
            });
        }
        std::thread::sleep(LOOK);
    }
}

/// What the comments of a G-code file say.
fn read(gcode: &str) -> Option<Sliced> {
    let said = |key: &str| {
        let line = gcode.lines().find(|line| line.starts_with(key))?;
        line.split_once(" = ").map(|(_, value)| value.trim())
    };
    let cm3: f64 = said("; filament used [cm3]")?.parse().ok()?;
    let minutes = minutes(said("; estimated printing time (normal mode)")?)?;
    let maker = gcode.lines().next()?.strip_prefix("; generated by ")?;
    let maker = maker.split(" on ").next().unwrap_or(maker);
    // Builds of distributions add to the version.
    let slicer = maker.split('+').next().unwrap_or(maker).trim().to_owned();
    Some(Sliced { minutes, filament_mm3: cm3 * MM3_PER_CM3, slicer })
}

/// Minutes of `1d 2h 3m 4s`.
fn minutes(text: &str) -> Option<f64> {
    let piece = |piece: &str| {
        let (number, unit) = piece.split_at(piece.len().checked_sub(1)?);
        let each = match unit {
            "d" => 1440.0,
            "h" => 60.0,
            "m" => 1.0,
            "s" => 1.0 / 60.0,
            _ => return None,
        };
        Some(number.parse::<f64>().ok()? * each)
    };
    text.split_whitespace().map(piece).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_read() {
        let text = "; generated by PrusaSlicer 2.5.0+UNKNOWN on 2026-01-01\nG28\n; filament used [mm] = 100\n\
                    ; filament used [cm3] = 3.11\n; estimated printing time (normal mode) = 1h 33m 30s\n";
        let sliced = read(text).unwrap();
        assert_eq!(sliced.slicer, "PrusaSlicer 2.5.0");
        assert_eq!((sliced.filament_mm3, sliced.minutes), (3110.0, 93.5));
        assert_eq!(minutes("1d 1s"), Some(1440.0 + 1.0 / 60.0));
        assert_eq!(minutes("soon"), None);
        assert_eq!(read("G28\n"), None);
    }
}
