//! Calibration from images, corners and pins.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

use fabkit_application::calibration::assignment::{Discrepancy, Mark};
use fabkit_application::calibration::board::{self as on_board, DetectedCorner};
use fabkit_application::calibration::image::GreyImage;
use fabkit_application::calibration::intrinsics::LensModel;
use fabkit_application::calibration::landmarks::PinLandmarks;
use fabkit_application::calibration::pin_detection::{DetectionOptions, Polarity};
use fabkit_application::calibration::report::{
    CaptureRecord, ExtrinsicsReport, ImageRecord, IntrinsicsReport,
};
use fabkit_application::calibration::{extrinsics as pose, intrinsics as lens};
use fabkit_application::calibration_runs::boards::{self, Detector};
use fabkit_application::calibration_runs::captures::{self, MeasuredCapture};
use fabkit_application::calibration_runs::extrinsics::{self as from_pins, PoseCalibrationInputs};
use fabkit_application::calibration_runs::planning::{self, PlanRequest};
use fabkit_application::calibration_runs::{
    PinCaptureError, images, intrinsics as from_views, pose_file,
};
use fabkit_application::camera::Point2;
use fabkit_application::staging::write_each;
use fabkit_application::{Error, UnknownName};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::camera::Camera;
use crate::design::Project;
use crate::errors::{Failure, OrRaise};
use crate::running::{InterruptPolicy, run_guarded, run_on_thread, run_short};

/// Intensities row by row, 0 to 1.
type Picture<'py> = PyReadonlyArray2<'py, f32>;
/// View: name, then ids, pixels and standard deviations of its corners.
type Corners = (String, Vec<u32>, Vec<[f64; 2]>, Vec<f64>);
/// Capture: name, holes with pins if known, then pixels and standard deviations of its marks.
type Pins = (String, Option<Vec<u32>>, Vec<[f64; 2]>, Vec<f64>);
/// Detected points: (n, 2) pixels and (n,) standard deviations.
type DetectedPoints<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

fn grey_image(name: &str, picture: &Picture<'_>) -> Result<GreyImage, PinCaptureError> {
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    let [height, width] = [picture.shape()[0], picture.shape()[1]].map(side);
    let values = picture.as_array().iter().copied().collect();
    GreyImage::new(width, height, values)
        .map_err(|source| PinCaptureError::Image { file: name.into(), source })
}

/// Checks a board file. Returns it as JSON with everything that it leaves to be computed.
#[pyfunction]
pub fn board(py: Python<'_>, text: &str) -> PyResult<String> {
    run_short(py, || Ok::<_, Error>(boards::parse_board(text, None)?.to_json()))?.or_raise(py)
}

/// Detects a board's corners: ids, pixels and standard deviations.
#[pyfunction]
pub fn find_corners<'py>(
    py: Python<'py>,
    picture: Picture<'py>,
    board: &str,
) -> PyResult<(Bound<'py, PyArray1<u32>>, DetectedPoints<'py>)> {
    let picture = grey_image("the image", &picture).or_raise(py)?;
    let board = run_short(py, || boards::parse_board(board, None))?.or_raise(py)?;
    let corners = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
        on_board::find_corners(&picture, &board).map_err(Failure::call)
    })?;
    let ids = PyArray1::from_iter(py, corners.iter().map(|corner| corner.id));
    let pixels = corners.iter().map(|corner| (corner.pixel, corner.sigma_px));
    Ok((ids, into_arrays(py, pixels)?))
}

/// Detects pin marks: pixels and standard deviations, strongest first. Also says which fainter spots were left out.
#[pyfunction]
pub fn find_pins<'py>(
    py: Python<'py>,
    reference: Picture<'py>,
    picture: Picture<'py>,
    brighter: bool,
) -> PyResult<(DetectedPoints<'py>, Option<String>)> {
    let reference = grey_image("the reference", &reference).or_raise(py)?;
    let picture = grey_image("the image", &picture).or_raise(py)?;
    let polarity = if brighter { Polarity::Brighter } else { Polarity::Darker };
    let options = DetectionOptions { polarity, ..DetectionOptions::default() };
    let detections = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
        let read = |_| Ok(Cow::Borrowed(&picture));
        Ok(images::detect_in_images(&reference, &["the image".into()], &read, &options)?)
    })?;
    let left_out = detections.iter().map(|detection| detection.marks.summary());
    let left_out = left_out.filter(|left_out| left_out.count > 0).map(|one| one.to_string()).next();
    let marks = detections.iter().flat_map(|detection| detection.marks.kept());
    Ok((into_arrays(py, marks.map(|mark| (mark.pixel, mark.sigma_px)))?, left_out))
}

fn into_arrays<'py>(
    py: Python<'py>,
    marks: impl Iterator<Item = (Point2<f64>, f64)>,
) -> PyResult<DetectedPoints<'py>> {
    let (pixels, sigmas): (Vec<[f64; 2]>, Vec<f64>) =
        marks.map(|(pixel, sigma)| (<[f64; 2]>::from(pixel), sigma)).unzip();
    let count = pixels.len();
    let pixels = PyArray1::from_vec(py, pixels.into_flattened()).reshape([count, 2])?;
    Ok((pixels, PyArray1::from_vec(py, sigmas)))
}

/// Calibrated lens with its report.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Intrinsics {
    sensor: String,
    board: String,
    pictures: Vec<ImageRecord>,
    calibration: lens::LensCalibration,
}

impl Intrinsics {
    fn of(&self) -> IntrinsicsReport<'_> {
        IntrinsicsReport {
            sensor: &self.sensor,
            board: &self.board,
            images: &self.pictures,
            calibration: &self.calibration,
        }
    }
}

#[pymethods]
impl Intrinsics {
    fn camera(&self) -> Camera {
        Camera { estimate: self.calibration.estimate.clone() }
    }

    fn document(&self, py: Python<'_>) -> PyResult<String> {
        run_guarded(py, || Ok(self.of().to_json().to_string()))
    }

    fn html(&self, py: Python<'_>) -> PyResult<String> {
        run_guarded(py, || Ok(self.of().to_html()))
    }
}

/// Board views in one of three forms.
enum BoardViews {
    Files(Vec<PathBuf>),
    Pictures(Vec<String>, Vec<GreyImage>),
    Corners(Vec<Corners>),
}

/// Calibrates the lens from files, else from images, else from corners.
#[pyfunction]
#[pyo3(signature = (project, board, files, pictures, corners, models))]
pub fn intrinsics(
    py: Python<'_>,
    project: &Project,
    board: &str,
    files: Vec<PathBuf>,
    pictures: Vec<(String, Picture<'_>)>,
    corners: Vec<Corners>,
    models: Vec<String>,
) -> PyResult<Intrinsics> {
    let board = run_short(py, || boards::parse_board(board, None))?.or_raise(py)?;
    let models = models.iter().map(|name| {
        let known = || LensModel::ALL.iter().map(|model| model.name());
        LensModel::from_name(name).ok_or_else(|| UnknownName::new("lens model", name, known()))
    });
    let models = models.collect::<Result<Vec<_>, _>>().or_raise(py)?;
    let views = if !files.is_empty() {
        BoardViews::Files(files)
    } else if !pictures.is_empty() {
        let images = pictures.iter().map(|(name, picture)| grey_image(name, picture));
        let images = images.collect::<Result<Vec<_>, _>>().or_raise(py)?;
        BoardViews::Pictures(pictures.into_iter().map(|(name, _)| name).collect(), images)
    } else {
        BoardViews::Corners(corners)
    };
    let project = Arc::clone(&project.project);
    run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
        let sensor = &project.design.sensor;
        // In Python, OpenCV's detector is available from its own package.
        let detector = Detector::Fabkit;
        let views = match views {
            BoardViews::Files(files) => {
                boards::from_files(&files, &board, &sensor.camera, detector)?
            }
            BoardViews::Pictures(names, images) => {
                let read = |i: usize| Ok(Cow::Borrowed(&images[i]));
                boards::from_images(&names, &read, &board, &sensor.camera, detector)?
            }
            BoardViews::Corners(views) => {
                boards::from_corners(views.into_iter().map(found_corners).collect(), &board)?
            }
        };
        let calibration = from_views::solve(&views, &sensor.camera, &models)?;
        let (sensor, board) = (sensor.name.clone(), board.name.clone());
        Ok(Intrinsics { sensor, board, pictures: views.records, calibration })
    })
}

fn found_corners((name, ids, pixels, sigmas): Corners) -> (String, Vec<DetectedCorner>) {
    let corners = ids.into_iter().zip(pixels).zip(sigmas);
    let corner = |((id, [x, y]), sigma_px): ((u32, [f64; 2]), f64)| {
        let pixel = Point2::new(x, y);
        DetectedCorner { id, pixel, sigma_px }
    };
    (name, corners.map(corner).collect())
}

/// Calibrated pose with its report.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Extrinsics {
    sensor: String,
    camera_file: String,
    landmarks: PinLandmarks,
    captures: Vec<CaptureRecord>,
    discrepancies: Vec<Discrepancy>,
    calibration: pose::PoseCalibration,
    not_drawn: Option<String>,
    not_marked: Option<String>,
    saturated: f64,
}

impl Extrinsics {
    fn of(&self) -> ExtrinsicsReport<'_> {
        ExtrinsicsReport {
            sensor: &self.sensor,
            camera_file: &self.camera_file,
            landmarks: &self.landmarks,
            captures: &self.captures,
            discrepancies: &self.discrepancies,
            calibration: &self.calibration,
            drawing_unused_reason: self.not_drawn.as_deref(),
            mark_offsets_unknown_reason: self.not_marked.as_deref(),
            saturated_fraction: self.saturated,
            crops: &[],
        }
    }
}

#[pymethods]
impl Extrinsics {
    /// The camera with which the pose was solved, with its marginal covariance.
    fn camera(&self) -> Camera {
        Camera { estimate: self.calibration.joint.camera_estimate() }
    }

    fn document(&self, py: Python<'_>) -> PyResult<String> {
        run_guarded(py, || Ok(self.of().to_json().to_string()))
    }

    fn html(&self, py: Python<'_>) -> PyResult<String> {
        run_guarded(py, || Ok(self.of().to_html()))
    }

    /// The content of a pose file, with an empty camera name: the caller stores the camera.
    fn pose_text(&self, py: Python<'_>) -> PyResult<String> {
        run_guarded(py, || Ok(pose_file::format_pose(&self.of(), "")))
    }

    /// Writes the pose file and the camera file that belongs to it.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let files = run_guarded(py, || pose_file::pose_files(&path, &self.of()).or_raise(py))?;
        run_on_thread(py, InterruptPolicy::Wait, None, move |link| {
            let files = files.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
            Ok(write_each(files, &|| link.is_cancelled())?)
        })
    }
}

/// Solves for the pose from a folder of captures, else from pins.
#[pyfunction]
#[pyo3(signature = (project, camera, camera_file, landmarks, folder, reference, pins, kind, gel_index))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments in Python")]
pub fn extrinsics(
    py: Python<'_>,
    project: &Project,
    camera: &Camera,
    camera_file: String,
    landmarks: &str,
    folder: Option<PathBuf>,
    reference: Option<PathBuf>,
    pins: Vec<Pins>,
    kind: Option<String>,
    gel_index: f64,
) -> PyResult<Extrinsics> {
    let landmarks = run_short(py, || from_pins::parse_landmarks(landmarks, None))?.or_raise(py)?;
    let (project, camera) = (Arc::clone(&project.project), camera.estimate.clone());
    run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
        let kind = kind.as_deref();
        let captures = match &folder {
            Some(folder) => captures::read(folder, reference.as_deref(), &landmarks, kind)?,
            None => captures::from_marks(
                pins.into_iter().map(measured_capture).collect(),
                &landmarks,
                kind,
            )?,
        };
        let inputs = PoseCalibrationInputs {
            project: &project,
            camera: &camera,
            camera_file: &camera_file,
            landmarks: &landmarks,
            captures: &captures,
            tip_radius_mm: landmarks.tip_radius_mm,
            gel_index,
        };
        from_pins::solve(&inputs, |report| {
            Ok(Extrinsics {
                sensor: report.sensor.into(),
                camera_file: report.camera_file.into(),
                landmarks: report.landmarks.clone(),
                captures: report.captures.to_vec(),
                discrepancies: report.discrepancies.to_vec(),
                calibration: report.calibration.clone(),
                not_drawn: report.drawing_unused_reason.map(str::to_owned),
                not_marked: report.mark_offsets_unknown_reason.map(str::to_owned),
                saturated: report.saturated_fraction,
            })
        })
    })
}

fn measured_capture((name, holes, pixels, sigmas): Pins) -> MeasuredCapture {
    let mark = |([x, y], sigma_px): ([f64; 2], f64)| Mark { pixel: Point2::new(x, y), sigma_px };
    MeasuredCapture { name, holes, marks: pixels.into_iter().zip(sigmas).map(mark).collect() }
}

/// Forecasts the accuracy of pin captures, as JSON: see [`planning::plan`]. Existing captures are given as a folder, or
/// as the holes of each.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keyword arguments in Python")]
pub fn plan(
    py: Python<'_>,
    project: &Project,
    camera: Option<(PyRef<'_, Camera>, String)>,
    folder: Option<PathBuf>,
    holes: Vec<Vec<u32>>,
    kind: Option<String>,
    captures: Option<usize>,
    pins: Option<usize>,
) -> PyResult<String> {
    let (source, project) = (Arc::clone(&project.source), Arc::clone(&project.project));
    let camera = camera.map(|(camera, file)| (camera.estimate.clone(), file));
    run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
        let forecast = planning::build_forecast(&source, &project)?;
        let (landmarks, kind) = (&forecast.landmarks, kind.as_deref());
        let done = match &folder {
            Some(folder) => captures::pressed_pins(folder, landmarks, kind)?,
            None => holes
                .iter()
                .map(|holes| {
                    holes.iter().map(|hole| find_landmark(*hole, landmarks, kind)).collect()
                })
                .collect::<Result<_, _>>()?,
        };
        let lens = camera.as_ref().map(|(estimate, _)| estimate);
        let wanted = PlanRequest { lens, done: &done, captures, pins };
        let plan = planning::plan_captures(&project, &forecast, &wanted)?;
        let file = camera.as_ref().map(|(_, file)| file.as_str());
        Ok::<_, Failure>(plan.to_json(&project.design.sensor.name, file).to_string())
    })
}

/// Finds the landmark of a hole's pin.
fn find_landmark(
    hole: u32,
    landmarks: &PinLandmarks,
    kind: Option<&str>,
) -> Result<usize, Failure> {
    let kinds = landmarks.kinds();
    let known = kinds.join(", ");
    let kind = match (kind, &kinds[..]) {
        (Some(kind), _) => kind,
        (None, [only]) => only,
        (None, several) => {
            let problem = format!("pins are of {} kinds, {known}: say `pin`", several.len());
            return Err(Failure::call(problem));
        }
    };
    let found = landmarks.pins.iter().position(|pin| pin.hole == hole && pin.kind == kind);
    found.ok_or_else(|| {
        Failure::call(format!("there is no pin `{kind}` in hole {hole}; kinds: {known}"))
    })
}
