//! What programs are told of a failure: a short name that stays, and what it is about.

use std::io;
use std::path::Path;

use fabkit_elastic::BallTestError;
use fabkit_export::ExportError;
use fabkit_fixtures::FixtureError;
use fabkit_mesh::MeshError;
use fabkit_tetra::TetraError;
use fabkit_text::{Problem, number_and_unit};
use serde_json::{Value, json};

use crate::benching::BenchError;
use crate::bodies::UnknownName;
use crate::calibrating::CalibratingError;
use crate::dataset::{DatasetError, DatasetRequestError, SampleError};
use crate::exporting::{self, ExportFailure};
use crate::pictures::PictureError;
use crate::pressing::PressingError;
use crate::reading::ReadError;
use crate::reconstructing::ReconstructError;
use crate::rereading::RereadError;
use crate::resumable::FolderError;
use crate::scene::SceneError;
use crate::slicing::SlicingError;
use crate::source::SourceError;
use crate::staging::StagingError;
use crate::sweeping::SweepError;
use crate::verifier::VerifierError;
use crate::{Error, ErrorKind, Explained};

/// What a failure is about that is none of a text's problems.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct About {
    /// A short name of the kind of failure; it stays.
    pub code: String,
    /// The file or folder that it is about.
    pub file: Option<String>,
    /// What was given and is wrong, as written.
    pub written: Option<String>,
    /// The words that could have been given.
    pub choices: Vec<String>,
    /// The parameter or option that it is about.
    pub path: Option<String>,
    /// What to give instead.
    pub suggestion: Option<String>,
}

impl About {
    /// Of a kind, and no more.
    pub fn of(code: &str) -> Self {
        Self { code: code.into(), ..Self::default() }
    }

    fn at(code: &str, file: &Path) -> Self {
        Self { file: Some(file.display().to_string()), ..Self::of(code) }
    }

    /// One of the problems of `fabkit-error`.
    pub fn to_json(&self, message: &str, hint: Option<&str>) -> Value {
        let written = self.written.as_deref();
        let (value, unit) = written.map_or((Value::Null, None), amount);
        let suggestion = self.suggestion.as_ref();
        json!({
            "code": self.code,
            "message": message,
            "hint": hint,
            "file": self.file,
            "line": null,
            "column": null,
            "path": self.path,
            "value": value,
            "unit": unit,
            "written": written,
            "limit": limit([None, None], &self.choices),
            "suggestion": suggestion.map(|value| json!({ "path": self.path, "value": value })),
        })
    }
}

/// The same of a problem of a text.
pub fn problem_json(problem: &Problem) -> Value {
    let some = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
    let (value, unit) = some(&problem.value).map_or((Value::Null, None), |text| amount(&text));
    let facts = &problem.facts;
    let suggestion = facts.suggestion.as_ref();
    json!({
        "code": facts.code,
        "message": problem.message,
        "hint": problem.hint,
        "file": some(&problem.file),
        "line": problem.line,
        "column": problem.column,
        "path": some(&problem.path),
        "value": value,
        "unit": unit,
        "written": some(&problem.value),
        "limit": limit([facts.at_least.as_deref(), facts.at_most.as_deref()], &facts.choices),
        "suggestion": suggestion.map(|s| json!({ "path": s.path, "value": s.value })),
    })
}

/// A number with its unit beside it, or the text as it is.
pub(crate) fn amount(text: &str) -> (Value, Option<String>) {
    match number_and_unit(text) {
        Some((number, unit)) => {
            (json!(number), Some(unit.to_owned()).filter(|unit| !unit.is_empty()))
        }
        None => (json!(text), None),
    }
}

/// What is allowed: the ends in one unit, or words; nothing where nobody says.
pub(crate) fn limit(ends: [Option<&str>; 2], choices: &[String]) -> Value {
    let [min, max] = ends.map(|end| end.and_then(number_and_unit));
    if min.is_none() && max.is_none() && choices.is_empty() {
        return Value::Null;
    }
    let unit = min.or(max).map(|(_, unit)| unit).filter(|unit| !unit.is_empty());
    let number = |end: Option<(f64, &str)>| end.map(|(number, _)| number);
    json!({ "min": number(min), "max": number(max), "unit": unit, "choices": choices })
}

/// What is known of a failure; of several, of the first.
pub fn about(error: &Error) -> About {
    match error {
        Error::Several(errors) => errors.first().map_or_else(|| of_kind(error.kind()), about),
        Error::Invalid(_) => About::of("invalid"),
        Error::Unknown(error) => unknown(error),
        Error::Read(error) => read(error),
        Error::Memory(_) => About::of("memory_limit"),
        Error::Staging(error) => staging(error),
        Error::Folder(error) => folder(error),
        Error::Authored(_) => About::of("edited_by_hand"),
        Error::Source(error) => source(error),
        Error::Export(error) => export(error),
        Error::ExportFolder(error) => export_folder(error),
        Error::Slicing(error) => About::of(slicing(error)),
        Error::Picture(error) => picture(error),
        Error::Verifier(error) => verifier(error),
        Error::Bench(BenchError::NoPackage { python, .. })
        | Error::Sweep(SweepError::Bench(BenchError::NoPackage { python, .. })) => {
            About::at("no_bench", python)
        }
        Error::Bench(other) => of_kind(other.kind()),
        Error::Scene(error) => About::of(scene(error)),
        Error::Pressing(error) => About::of(pressing(error)),
        Error::Capture(_) | Error::FitLight(_) => About::of("no_light"),
        Error::Reconstruct(error) => match error {
            ReconstructError::OtherLight { .. } | ReconstructError::NoMarks { .. } => {
                About::of("no_light")
            }
            ReconstructError::OtherSize { file, .. } => About::at("other_size", file),
            ReconstructError::Dark { file, .. }
            | ReconstructError::NoColors { file }
            | ReconstructError::FewMarks { file, .. } => About::at("bad_picture", file),
            ReconstructError::Network { file, .. } | ReconstructError::Card { file, .. } => {
                About::at("bad_network", file)
            }
            ReconstructError::SameName { first, .. } => About::at("same_name", first),
        },
        Error::Gel(BallTestError::Elastic(_)) => About::of("no_contact_solution"),
        Error::Gel(_) => About::of("no_modulus"),
        Error::DatasetRequest(DatasetRequestError::NoPatterns(_)) => About::of("no_presses"),
        Error::DatasetRequest(DatasetRequestError::Presses { .. }) => {
            About::of("no_contact_solution")
        }
        Error::DatasetRequest(DatasetRequestError::HalfCaptures(_)) => About::of("half_captures"),
        Error::Dataset(DatasetError::Folder(error)) | Error::Sweep(SweepError::Folder(error)) => {
            folder(error)
        }
        Error::Dataset(DatasetError::Read(error)) | Error::Sample(error) => sample(error),
        Error::Sweep(SweepError::Staging(error)) => staging(error),
        Error::Sweep(SweepError::Memory(_)) => About::of("memory_limit"),
        Error::Calibrating(error) => calibrating(error),
        Error::Reread(error) => reread(error),
        Error::Dataset(_) | Error::Sweep(_) | Error::Bug(_) => of_kind(error.kind()),
    }
}

/// Where nothing more is known.
pub fn of_kind(kind: ErrorKind) -> About {
    About::of(match kind {
        ErrorKind::BadInput => "bad_input",
        ErrorKind::Limit => "limit_exceeded",
        ErrorKind::Io => "io",
        ErrorKind::Bug => "bug",
        ErrorKind::Interrupted => "interrupted",
    })
}

/// A name that is not there: `unknown_sensor`, `unknown_part`.
pub fn unknown(error: &UnknownName) -> About {
    About {
        written: Some(error.name.clone()),
        choices: error.known.clone(),
        suggestion: error.closest.clone(),
        ..About::of(&format!(
            "unknown_{}",
            error.what.trim_start_matches("built-in ").replace(' ', "_")
        ))
    }
}

fn read(error: &ReadError) -> About {
    match error {
        ReadError::Io { path, source } => system(path, source, "file_unreadable"),
        ReadError::NotAFile { path, .. } => About::at("not_a_file", path),
        ReadError::TooLarge { path, .. } => About::at("file_too_large", path),
        ReadError::NotText { path, .. } => About::at("not_utf8", path),
    }
}

/// What the system said of a file.
fn system(path: &Path, error: &io::Error, otherwise: &str) -> About {
    let code = match error.kind() {
        io::ErrorKind::NotFound => "file_missing",
        io::ErrorKind::PermissionDenied => "permission_denied",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "disk_full",
        _ => otherwise,
    };
    About::at(code, path)
}

fn staging(error: &StagingError) -> About {
    match error {
        StagingError::Io { path, source, .. } => system(path, source, "cannot_write"),
        StagingError::Occupied { path, .. } => About::at("not_a_file", path),
        StagingError::Locked { folder, .. } => About::at("folder_locked", folder),
        StagingError::Kept { place, .. } => About::at("not_put_back", place),
        StagingError::Cancelled => About::of("interrupted"),
    }
}

fn folder(error: &FolderError) -> About {
    match error {
        FolderError::NotEmpty { folder } => About::at("folder_not_empty", folder),
        FolderError::OtherPlan { folder, .. } => About::at("other_plan", folder),
        FolderError::OtherVersion { path, .. } => About::at("other_version", path),
        FolderError::Damaged { path, .. } | FolderError::DamagedDocument { path, .. } => {
            About::at("damaged", path)
        }
        FolderError::Changed { paths, .. } => match paths.first() {
            Some(path) => About::at("damaged", path),
            None => About::of("damaged"),
        },
        FolderError::Link { path } => About::at("symbolic_link", path),
        FolderError::Outside { folder, .. } => About::at("outside_folder", folder),
        FolderError::Staging(error) => staging(error),
        FolderError::Io { path, source, .. } => system(path, source, "cannot_write"),
    }
}

fn source(error: &SourceError) -> About {
    match error {
        SourceError::Sensor(error) | SourceError::Preset { unknown: error, .. } => unknown(error),
        SourceError::Fixture(FixtureError::Unknown { name }) => {
            unknown(&UnknownName::new("fixture", name, fabkit_fixtures::fixture_names()))
        }
        SourceError::Fixture(_) => About::of("unsuitable_fixture"),
        SourceError::Extended { why, .. } => read(why),
    }
}

fn export(error: &ExportFailure) -> About {
    About::of(match error {
        ExportFailure::Unknown(error) => return unknown(error),
        ExportFailure::Picture { source, .. } => return picture(source),
        ExportFailure::TooManyTriangles { .. }
        | ExportFailure::Mesh { source: MeshError::TooFine { .. }, .. } => "too_many_triangles",
        ExportFailure::Mesh { source: MeshError::Tolerance { .. }, .. } => "out_of_range",
        ExportFailure::Plate(_) => "larger_than_bed",
        ExportFailure::Stock(_) => "larger_than_stock",
        ExportFailure::Outline { source: ExportError::KerfTooWide { .. }, .. } => "kerf_too_wide",
        ExportFailure::CannotBeMade { .. } => "cannot_be_made",
        ExportFailure::HolesBreakOut { .. } => "holes_break_out",
        ExportFailure::ProfileWithoutFiles { .. } | ExportFailure::ProfileUnused { .. } => {
            "profile_unused"
        }
        ExportFailure::NoOutlines { .. } => "no_outlines",
        ExportFailure::Soft(_) => "nothing_soft",
        ExportFailure::Tetra(TetraError::TooMany { .. }) => "too_many_tetrahedra",
        ExportFailure::Tetra(TetraError::Edge { .. }) => "out_of_range",
        other => return of_kind(other.kind()),
    })
}

fn export_folder(error: &exporting::FolderError) -> About {
    match error {
        exporting::FolderError::Refused(_) if error.is_of_another_design() => {
            About::of("other_design")
        }
        exporting::FolderError::Refused(_) => About::of("edited_by_hand"),
        exporting::FolderError::Export(error) => export(error),
        exporting::FolderError::Staging(error) => staging(error),
    }
}

fn picture(error: &PictureError) -> About {
    match error {
        PictureError::Unknown(error) => unknown(error),
        other => of_kind(other.kind()),
    }
}

fn verifier(error: &VerifierError) -> About {
    match error {
        VerifierError::NoEnvironment => About::of("no_verifier"),
        VerifierError::NoPackage(path) | VerifierError::RelativePython(path) => {
            About::at("no_verifier", path)
        }
        VerifierError::Export(error) => export(error),
        VerifierError::Folder(error) => export_folder(error),
        VerifierError::Read(error) => read(error),
        other => of_kind(other.kind()),
    }
}

fn scene(error: &SceneError) -> &'static str {
    match error {
        SceneError::TooManyRays { .. } => "too_many_rays",
        SceneError::Press(_) => "unknown_press",
        SceneError::TooDeep(_) => "too_deep",
        SceneError::NoContact { .. } => "no_contact",
        SceneError::NothingSeen(_) => "nothing_seen",
        SceneError::Length { .. } | SceneError::Samples { .. } => "out_of_range",
        _ => "bad_viewpoint",
    }
}

fn pressing(error: &PressingError) -> &'static str {
    match error {
        PressingError::Press(_) => "unknown_press",
        PressingError::Range { .. }
        | PressingError::NoFriction { .. }
        | PressingError::Contact { .. }
        | PressingError::Finite { .. }
        | PressingError::RigidShear { .. } => "out_of_range",
        PressingError::Elastic(_) => "no_contact_solution",
        PressingError::Soft(_) => "nothing_soft",
    }
}

fn sample(error: &SampleError) -> About {
    match error {
        SampleError::Folder(error) => folder(error),
        SampleError::Absent { .. } => About::of("no_dataset"),
        SampleError::Damaged { .. } => About::of("damaged"),
        SampleError::OutOfRange { .. } => About::of("out_of_range"),
        other => of_kind(other.kind()),
    }
}

fn calibrating(error: &CalibratingError) -> About {
    match error {
        CalibratingError::Folder { folder, source } => system(folder, source, "file_unreadable"),
        CalibratingError::NoCaptures { folder } => About::at("no_captures", folder),
        CalibratingError::Unlabelled { file } => About::at("unlabelled", Path::new(file)),
        CalibratingError::NoReference { folder } => About::at("no_reference", folder),
        CalibratingError::TooManyPictures { folder } => About::at("too_many_pictures", folder),
        CalibratingError::Camera { file, .. } => About::at("bad_camera_file", file),
        CalibratingError::List { file, .. } => About::at("bad_list", file),
        CalibratingError::OtherSize { file, .. } => About::at("other_size", Path::new(file)),
        CalibratingError::Picture { file, .. } => About::at("bad_picture", Path::new(file)),
        CalibratingError::Board(_) => About::of("bad_board"),
        CalibratingError::Corners(_) => About::of("bad_corners"),
        CalibratingError::Landmarks { .. } => About::of("bad_landmarks"),
        CalibratingError::NotAssigned | CalibratingError::Pose(_) => About::of("no_pose"),
        CalibratingError::Lens { .. } => About::of("no_lens"),
        other => of_kind(other.kind()),
    }
}

fn reread(error: &RereadError) -> About {
    match error {
        RereadError::OtherVersion(error) | RereadError::List(error) => folder(error),
        RereadError::NoList { folder, .. } => About::at("not_fabkits_folder", folder),
        RereadError::Io { folder, source } => system(folder, source, "file_unreadable"),
    }
}

fn slicing(error: &SlicingError) -> &'static str {
    match error {
        SlicingError::NotFound | SlicingError::NoSuchSlicer(_) => "no_slicer",
        _ => "slicing",
    }
}
