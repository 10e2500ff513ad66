//! Hints of failures at the command line, which name options. Errors without an entry here use their own hint.

use std::io;

use fabkit_application::calibration::intrinsics::LensCalibrationError;
use fabkit_application::calibration_runs::{CalibrationRunError, PinCaptureError};
use fabkit_application::dataset::{DatasetError, DatasetRequestError, SampleError};
use fabkit_application::edited_files::NotReplaced;
use fabkit_application::export::ExportError;
use fabkit_application::exports::{self, ExportRunError};
use fabkit_application::memory::{MemoryError, MemoryHint};
use fabkit_application::mesh::MeshError;
use fabkit_application::reading::ReadError;
use fabkit_application::resumable::ResumableFolderError;
use fabkit_application::scene::SceneError;
use fabkit_application::staging::StagingError;
use fabkit_application::sweep_runs::SweepError;
use fabkit_application::verifier::VerifierError;
use fabkit_application::verify_folder::FolderVerificationError;
use fabkit_application::{Error, ErrorKind, Explained};

/// Hint of a violated invariant.
pub(crate) const REPORT: &str = "this is a bug in fabkit; please report it with the command line and, if \
                                 there is one, the sensor's file";
const RESUME_HINT: &str = "--resume goes on from here";

/// Returns the hint of an error, if there is one.
pub(crate) fn hint(error: &Error) -> Option<String> {
    if error.kind() == ErrorKind::Bug {
        return Some(REPORT.into());
    }
    if let Some(first) = error.parts().first() {
        return hint(first);
    }
    // The type to which `error` is downcast follows from the function that is called with it.
    if let Some(error) = error.downcast_ref() {
        return memory(error);
    }
    if let Some(error) = error.downcast_ref() {
        return staging(error);
    }
    if let Some(error) = error.downcast_ref() {
        return folder(error);
    }
    if error.downcast_ref::<NotReplaced>().is_some() {
        return Some("choose another file with -o, or let --force replace it".into());
    }
    if let Some(error) = error.downcast_ref() {
        return export(error);
    }
    if let Some(error) = error.downcast_ref() {
        return export_folder(error);
    }
    if let Some(error) = error.downcast_ref() {
        return verifier(error);
    }
    if let Some(error) = error.downcast_ref() {
        return scene(error);
    }
    if let Some(DatasetRequestError::NoPatterns(_)) = error.downcast_ref() {
        return Some("list presses in a text file and name it with --presses".into());
    }
    if let Some(error) = error.downcast_ref() {
        return dataset(error);
    }
    if let Some(error) = error.downcast_ref() {
        return sample(error);
    }
    if let Some(error) = error.downcast_ref() {
        return sweep(error);
    }
    if let Some(error) = error.downcast_ref() {
        return calibrating(error);
    }
    if let Some(error) = error.downcast_ref() {
        return pin_captures(error);
    }
    if let Some(error) = error.downcast_ref() {
        return reread(error);
    }
    error.hint()
}

fn dataset(error: &DatasetError) -> Option<String> {
    match error {
        DatasetError::Read(error) => sample(error),
        DatasetError::Folder(error) => folder(error),
        DatasetError::Cancelled => Some(RESUME_HINT.into()),
        other => other.hint(),
    }
}

fn sweep(error: &SweepError) -> Option<String> {
    match error {
        SweepError::Folder(error) => folder(error),
        SweepError::Memory(error) => memory(error),
        SweepError::Staging(error) => staging(error),
        SweepError::Cancelled => Some(RESUME_HINT.into()),
        other => other.hint(),
    }
}

fn reread(error: &FolderVerificationError) -> Option<String> {
    match error {
        FolderVerificationError::NoList { is_begun: true, .. } => {
            Some("it is not finished: run the command that began it with --resume".into())
        }
        FolderVerificationError::List(error) => folder(error),
        other => other.hint(),
    }
}

fn memory(error: &MemoryError) -> Option<String> {
    let less = match error {
        MemoryError::TooMuch { less: MemoryHint::Rays, .. } => {
            "ask for fewer --samples or files".into()
        }
        MemoryError::TooMuch { less: MemoryHint::Pixels, .. } => "ask for a smaller --size".into(),
        other => other.hint()?,
    };
    Some(format!("{less}, or allow it with --memory {}", error.sufficient_limit()?))
}

fn staging(error: &StagingError) -> Option<String> {
    let hint = error.hint()?;
    Some(match error {
        StagingError::Io { source, .. } => add_output_option(hint, source),
        StagingError::Occupied { .. }
        | StagingError::Foreign { .. }
        | StagingError::Locked { .. } => format!("{hint} with -o"),
        _ => hint,
    })
}

/// Adds `-o` to the hint: most refusals of the system concern the place of the output. A file that is too large would
/// be so anywhere.
fn add_output_option(hint: String, error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::FileTooLarge => hint,
        _ => format!("{hint} with -o"),
    }
}

fn folder(error: &ResumableFolderError) -> Option<String> {
    let hint = match error {
        ResumableFolderError::NotEmpty { .. } => {
            "choose another folder with -o; --resume goes on with what the same command began"
        }
        ResumableFolderError::OtherPlan { .. } => {
            "resume with the arguments it was begun with, or choose another folder with -o"
        }
        ResumableFolderError::OtherVersion { .. } => "make it again in another folder, with -o",
        ResumableFolderError::Damaged { .. } => "delete that file, and --resume makes it again",
        ResumableFolderError::Changed { .. } => {
            "delete them, and --resume makes them again; if nobody edited them, check the disk"
        }
        ResumableFolderError::Staging(StagingError::Io { source, .. })
        | ResumableFolderError::Io { source, .. } => {
            let hint =
                add_output_option(fabkit_application::staging::io_hint(source)?.into(), source);
            return Some(format!("{hint}; then {RESUME_HINT}"));
        }
        ResumableFolderError::Staging(error) => return staging(error),
        other => return other.hint(),
    };
    Some(hint.into())
}

fn export(error: &ExportRunError) -> Option<String> {
    let hint = match error {
        ExportRunError::TooManyTriangles { .. }
        | ExportRunError::Mesh { source: MeshError::TooFine { .. }, .. } => {
            "allow a larger --tolerance, or export fewer parts with --part"
        }
        ExportRunError::Plate(_) => {
            "name your printer's bed with --bed, or leave plates out with --format stl"
        }
        ExportRunError::Stock(_) => {
            "name your stock with --stock, or leave drawings out with --format stl,3mf"
        }
        ExportRunError::Outline { source: ExportError::KerfTooWide { .. }, .. } => {
            "name your laser's width with --kerf, or leave it out with --nominal"
        }
        ExportRunError::HolesBreakOut { .. } => {
            "export this part without --process, and let the slicer make up for the printer"
        }
        ExportRunError::ProfileWithoutFiles { .. } => {
            "ask for --format stl or 3mf too, or leave --process out"
        }
        ExportRunError::ProfileUnused { has_process: true, .. } => {
            "measure a coupon of that material (`--set fixtures.coupon.material=NAME`), or apply this \
             profile all the same with --process-for-any-material"
        }
        ExportRunError::ProfileUnused { .. } => {
            "leave --process out, or name the profile of the printer that makes these parts"
        }
        ExportRunError::NoOutlines { .. } => "printed parts have --format stl,3mf",
        other => return other.hint(),
    };
    Some(hint.into())
}

fn export_folder(error: &exports::FolderError) -> Option<String> {
    let hint = match error {
        exports::FolderError::Refused(_) if error.holds_other_design() => {
            "choose another folder with -o, or let --clean remove what that export wrote"
        }
        exports::FolderError::Refused(_) => {
            "choose another folder with -o, or let --force replace it"
        }
        exports::FolderError::Export(error) => return export(error),
        exports::FolderError::Staging(error) => return staging(error),
    };
    Some(hint.into())
}

fn verifier(error: &VerifierError) -> Option<String> {
    let hint = match error {
        VerifierError::Export(error) => return export(error),
        VerifierError::Folder(exports::FolderError::Refused(_)) => {
            "choose another folder with --keep"
        }
        VerifierError::Folder(error) => return export_folder(error),
        VerifierError::Read(ReadError::TooLarge { .. }) => "export fewer parts at once with --part",
        other => return other.hint(),
    };
    Some(hint.into())
}

fn scene(error: &SceneError) -> Option<String> {
    let hint = match error {
        SceneError::TooManyRays { .. } => "ask for fewer --samples",
        SceneError::NoContact { .. } | SceneError::PressNotVisible(_) => {
            return Some(format!("{} with --allow-no-contact", error.hint()?));
        }
        other => return other.hint(),
    };
    Some(hint.into())
}

fn sample(error: &SampleError) -> Option<String> {
    let hint = match error {
        SampleError::Folder(error) => return folder(error),
        SampleError::NoDataset { is_begun: true, .. } => {
            "it is not finished: run the same `fabkit dataset` with --resume"
        }
        SampleError::NoDataset { .. } => "`fabkit dataset SENSOR -o DIR` writes one",
        SampleError::Damaged { .. } => "delete that file and run `fabkit dataset --resume`",
        other => return other.hint(),
    };
    Some(hint.into())
}

fn calibrating(error: &CalibrationRunError) -> Option<String> {
    let hint = match error {
        CalibrationRunError::OtherSize { .. } => {
            "take all images with the sensor's camera at its own size, or change the sensor's with \
             --set camera.width_px=... --set camera.height_px=..."
        }
        CalibrationRunError::Charuco => {
            "leave --detector out, or give what OpenCV found by --corners"
        }
        CalibrationRunError::NoOpencv => {
            "build it with `cargo build --release --features opencv`, or give what OpenCV found by \
             --corners"
        }
        CalibrationRunError::Lens { source: LensCalibrationError::NoModel { .. }, .. } => {
            "try all lens models, without --model"
        }
        other => return other.hint(),
    };
    Some(hint.into())
}

fn pin_captures(error: &PinCaptureError) -> Option<String> {
    let hint = match error {
        PinCaptureError::NoReference { .. } => {
            "save one there as ref.png, or name it with --reference"
        }
        PinCaptureError::SeveralKinds { .. } => {
            "say which was used with --pin, or in the column `kind` of captures.csv"
        }
        other => return other.hint(),
    };
    Some(hint.into())
}
