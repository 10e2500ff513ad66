//! Hints of failures in Python, which name arguments instead of options. Errors without an entry here use their own
//! hint.

use fabkit_application::calibration_runs::PinCaptureError;
use fabkit_application::dataset::{DatasetError, DatasetRequestError, SampleError};
use fabkit_application::export::ExportError;
use fabkit_application::exports::{self, ExportRunError};
use fabkit_application::mesh::MeshError;
use fabkit_application::resumable::ResumableFolderError;
use fabkit_application::scene::SceneError;
use fabkit_application::sweep_runs::SweepError;
use fabkit_application::verifier::VerifierError;
use fabkit_application::{Error, ErrorKind, Explained};

/// Returns the hint of an error, if there is one.
pub fn hint(error: &Error) -> Option<String> {
    if error.kind() == ErrorKind::Bug {
        return Some(REPORT.into());
    }
    if let Some(first) = error.parts().first() {
        return hint(first);
    }
    // The type to which `error` is downcast follows from the function that is called with it.
    if let Some(error) = error.downcast_ref() {
        return folder(error);
    }
    if let Some(error) = error.downcast_ref() {
        return export(error);
    }
    if let Some(VerifierError::Export(error)) = error.downcast_ref() {
        return export(error);
    }
    if let Some(refused @ exports::FolderError::Refused(_)) = error.downcast_ref() {
        let hint = if refused.holds_other_design() {
            "choose another folder; clean=True removes what that export wrote"
        } else {
            "choose another folder; force=True replaces it"
        };
        return Some(hint.into());
    }
    if let Some(SceneError::NoContact { .. } | SceneError::PressNotVisible(_)) =
        error.downcast_ref()
    {
        return Some(format!("{} with allow_no_contact=True", error.hint()?));
    }
    if let Some(DatasetRequestError::NoPatterns(_)) = error.downcast_ref() {
        return Some("list presses in a text file and pass it as `presses`".into());
    }
    if let Some(error) = error.downcast_ref() {
        return match error {
            DatasetError::Folder(error) => folder(error),
            DatasetError::Read(error) => sample(error),
            DatasetError::Cancelled => Some(RESUME_HINT.into()),
            other => other.hint(),
        };
    }
    if let Some(error) = error.downcast_ref() {
        return sample(error);
    }
    if let Some(error) = error.downcast_ref() {
        return match error {
            SweepError::Folder(error) => folder(error),
            SweepError::Cancelled => Some(RESUME_HINT.into()),
            other => other.hint(),
        };
    }
    if let Some(error) = error.downcast_ref() {
        return pin_captures(error);
    }
    error.hint()
}

const REPORT: &str = "this is a bug in fabkit; please report it with the call and, if there is one, the \
                      sensor's file";
const RESUME_HINT: &str = "resume=True goes on from here";

fn sample(error: &SampleError) -> Option<String> {
    let hint = match error {
        SampleError::Folder(error) => return folder(error),
        SampleError::NoDataset { is_begun: true, .. } => {
            "it is not finished: call `fabkit.dataset.write` again with resume=True"
        }
        SampleError::NoDataset { .. } => "`fabkit.dataset.write` writes one",
        SampleError::Damaged { .. } => {
            "delete that file, and `fabkit.dataset.write` with resume=True makes it again"
        }
        other => return other.hint(),
    };
    Some(hint.into())
}

fn pin_captures(error: &PinCaptureError) -> Option<String> {
    let hint = match error {
        PinCaptureError::NoReference { .. } => {
            "save one there as ref.png, or pass it as `reference`"
        }
        PinCaptureError::SeveralKinds { .. } => {
            "say which was used with `pin`, or in the column `kind` of captures.csv"
        }
        other => return other.hint(),
    };
    Some(hint.into())
}

fn folder(error: &ResumableFolderError) -> Option<String> {
    let hint = match error {
        ResumableFolderError::NotEmpty { .. } => {
            "choose another folder; resume=True goes on with what the same call began"
        }
        ResumableFolderError::OtherPlan { .. } => {
            "resume with the arguments it was begun with, or choose another folder"
        }
        ResumableFolderError::Damaged { .. } => "delete that file, and resume=True makes it again",
        ResumableFolderError::Changed { .. } => {
            "delete them, and resume=True makes them again; if nobody edited them, check the disk"
        }
        other => return other.hint(),
    };
    Some(hint.into())
}

fn export(error: &ExportRunError) -> Option<String> {
    let hint = match error {
        ExportRunError::TooManyTriangles { .. }
        | ExportRunError::Mesh { source: MeshError::TooFine { .. }, .. } => {
            "allow a larger tolerance_mm, or export fewer parts"
        }
        ExportRunError::Plate(_) => {
            "pass your printer's bed as bed_mm, or leave plates out with formats=[\"stl\"]"
        }
        ExportRunError::Stock(_) => {
            "pass your stock as stock_mm, or leave drawings out with formats=[\"stl\", \"3mf\"]"
        }
        ExportRunError::Outline { source: ExportError::KerfTooWide { .. }, .. } => {
            "pass your laser's width as kerf_mm, or leave it out with nominal=True"
        }
        ExportRunError::HolesBreakOut { .. } => {
            "export this part without `process`, and let the slicer make up for the printer"
        }
        ExportRunError::ProfileWithoutFiles { .. } => {
            "ask for \"stl\" or \"3mf\" in `formats` too, or leave `process` out"
        }
        ExportRunError::ProfileUnused { has_process: true, .. } => {
            "measure a coupon of that material (`fixtures.coupon.material`), or apply this profile all \
             the same with process_for_any_material=True"
        }
        ExportRunError::ProfileUnused { .. } => {
            "leave `process` out, or pass the profile of the printer that makes these parts"
        }
        other => return other.hint(),
    };
    Some(hint.into())
}
