//! Print times and filament estimated by PrusaSlicer, if it is installed. Each FDM part is sliced from its 3MF file in
//! a temporary folder, independent of the user's configuration.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use fabkit_designs::Design;
use fabkit_files::progress::{ProgressCallback, ProgressStep};
use fabkit_files::scratch_folder::ScratchFolder;
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_guide::{Guide, SlicerEstimate};
use rayon::prelude::*;

use crate::exports::{self, ExportOptions, ExportRunError, Format};
use crate::programs::{Program, RelativeProgram};

/// Environment variable with the slicer's absolute path, instead of a search in `PATH`.
pub const SLICER_VARIABLE: &str = "FABKIT_SLICER";

/// Name of the program in Debian and in the slicer's own Linux builds.
const SLICER_PROGRAM: &str = "prusa-slicer";

/// Time limit for one part.
const TIME_LIMIT: Duration = Duration::from_secs(300);

/// Polling interval of a running slicer.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

const MM3_PER_CM3: f64 = 1e3;

/// Error of slicing.
#[derive(Debug, thiserror::Error)]
pub enum SlicingError {
    /// The slicer is not in `PATH`, and none was named.
    #[error("{SLICER_PROGRAM} is not installed")]
    NotFound,
    /// The named path is not absolute or not a file.
    #[error("{SLICER_VARIABLE} is {}, which is no absolute path of a file", .0.display())]
    NoSuchSlicer(PathBuf),
    /// The 3MF files could not be made.
    #[error(transparent)]
    Export(#[from] ExportRunError),
    /// Operating system error.
    #[error("cannot slice {part}: {source}")]
    Io {
        /// Name of the part.
        part: String,
        /// Reason.
        source: std::io::Error,
    },
    /// The slicer exceeded its time limit.
    #[error("slicing {part} took more than {} s", TIME_LIMIT.as_secs())]
    TooSlow {
        /// Name of the part.
        part: String,
    },
    /// The slicer rejected a part or gave no estimate.
    #[error("the slicer cannot slice {part}: {said}")]
    Refused {
        /// Name of the part.
        part: String,
        /// Last line of its log.
        said: String,
    },
    /// The caller asked to stop.
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

/// Slicer of the user's system.
#[derive(Clone, Debug)]
pub struct Slicer(Program);

/// Finds the slicer.
///
/// # Errors
/// [`SlicingError::NotFound`] and [`SlicingError::NoSuchSlicer`].
pub fn find_slicer() -> Result<Slicer, SlicingError> {
    let named = Program::from_variable(SLICER_VARIABLE);
    let named = named.map_err(|RelativeProgram(path)| SlicingError::NoSuchSlicer(path))?;
    match named {
        Some(program) if program.path().is_file() => Ok(Slicer(program)),
        Some(program) => Err(SlicingError::NoSuchSlicer(program.path().to_owned())),
        None => Program::find(SLICER_PROGRAM).map(Slicer).ok_or(SlicingError::NotFound),
    }
}

/// Replaces fabkit's estimates of time and filament in a guide by the slicer's. Parts that are printed in one piece
/// with others keep fabkit's.
///
/// # Errors
/// [`SlicingError`] of the first part in the order of the guide.
pub fn slice_parts(
    design: &Design,
    guide: &mut Guide,
    slicer: &Slicer,
    cancelled: &(dyn Fn() -> bool + Sync),
    progress: ProgressCallback,
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
    let exported = if printed.is_empty() {
        return Ok(());
    } else {
        exports::export(design, &options, &|_| {})?
    };
    let stem = |name: &str| name.strip_suffix(".3mf").map(str::to_owned);
    let named = exported.files.iter().filter_map(|file| Some((stem(&file.name)?, &file.bytes[..])));
    let files: Vec<(String, &[u8])> = named.filter(|(part, _)| printed.contains(part)).collect();
    let sliced: Vec<Result<SlicerEstimate, SlicingError>> =
        files.par_iter().map(|(part, bytes)| slice_part(slicer, part, bytes, cancelled)).collect();
    let all = files.len();
    for (done, ((part, _), sliced)) in files.into_iter().zip(sliced).enumerate() {
        guide.set_slicer_estimate(&part, sliced?);
        progress(ProgressStep { done: done + 1, total: all, ..ProgressStep::default() });
    }
    Ok(())
}

fn slice_part(
    slicer: &Slicer,
    part: &str,
    bytes: &[u8],
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<SlicerEstimate, SlicingError> {
    let failed = |source| SlicingError::Io { part: part.to_owned(), source };
    // Checked before the temporary folder exists; afterwards `wait` checks regularly.
    if cancelled() {
        return Err(SlicingError::Cancelled);
    }
    let folder = ScratchFolder::new().map_err(failed)?;
    folder.write("part.3mf", bytes).map_err(failed)?;
    folder.make_folder("settings").map_err(failed)?;
    let log = folder.create("log").map_err(failed)?;
    let arguments: [OsString; 6] = [
        "--datadir".into(),
        folder.path_of_file("settings").into(),
        "--export-gcode".into(),
        "--output".into(),
        folder.path_of_file("part.gcode").into(),
        folder.path_of_file("part.3mf").into(),
    ];
    let child = slicer
        .0
        .command()
        .args(arguments)
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(log.try_clone().map_err(failed)?)
        .stderr(log)
        .spawn()
        .map_err(failed)?;
    wait_for_slicer(child, part, cancelled)?;
    let text = folder.read("part.gcode");
    parse_gcode(&String::from_utf8_lossy(&text)).ok_or_else(|| {
        let log = folder.read("log");
        let log = String::from_utf8_lossy(&log);
        let said = log.lines().last().unwrap_or("it printed no message").trim().to_owned();
        SlicingError::Refused { part: part.to_owned(), said }
    })
}

fn wait_for_slicer(
    mut child: Child,
    part: &str,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<(), SlicingError> {
    let begun = Instant::now();
    loop {
        let failed = |source| SlicingError::Io { part: part.to_owned(), source };
        if let Some(status) = child.try_wait().map_err(failed)? {
            if !status.success() {
                // Ctrl-C in a terminal reaches the slicer as well, perhaps slightly earlier; `cancelled` needs a moment
                // to report it.
                std::thread::sleep(POLL_INTERVAL);
            }
            return if cancelled() { Err(SlicingError::Cancelled) } else { Ok(()) };
        }
        let is_cancelled = cancelled();
        if is_cancelled || begun.elapsed() > TIME_LIMIT {
            // Errors of `kill` are ignored: the process may have ended just now.
            let _ = child.kill();
            let _ = child.wait();
            return Err(if is_cancelled {
                SlicingError::Cancelled
            } else {
                SlicingError::TooSlow { part: part.to_owned() }
            });
        }
        std::thread::sleep(POLL_INTERVAL);
    }
}

/// Reads the estimates from the comments of a G-code file.
fn parse_gcode(gcode: &str) -> Option<SlicerEstimate> {
    let said = |key: &str| {
        let line = gcode.lines().find(|line| line.starts_with(key))?;
        line.split_once(" = ").map(|(_, value)| value.trim())
    };
    let cm3: f64 = said("; filament used [cm3]")?.parse().ok()?;
    let minutes = parse_minutes(said("; estimated printing time (normal mode)")?)?;
    let maker = gcode.lines().next()?.strip_prefix("; generated by ")?;
    let maker = maker.split(" on ").next().unwrap_or(maker);
    // Builds of distributions append to the version after a plus sign.
    let slicer = maker.split('+').next().unwrap_or(maker).trim().to_owned();
    Some(SlicerEstimate { minutes, filament_mm3: cm3 * MM3_PER_CM3, slicer })
}

/// Converts a time such as `1d 2h 3m 4s` to minutes.
fn parse_minutes(text: &str) -> Option<f64> {
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
        let sliced = parse_gcode(text).unwrap();
        assert_eq!(sliced.slicer, "PrusaSlicer 2.5.0");
        assert_eq!((sliced.filament_mm3, sliced.minutes), (3110.0, 93.5));
        assert_eq!(parse_minutes("1d 1s"), Some(1440.0 + 1.0 / 60.0));
        assert_eq!(parse_minutes("soon"), None);
        assert_eq!(parse_gcode("G28\n"), None);
    }
}
