//! Extrinsic calibration: the camera's pose from pins at known places.
//!
//! [`calibrate`] is the complete procedure. It estimates how well pins repeat, fits every explanation of the pixels
//! that the landmarks allow, judges each on held-out captures, and reports its choice and what the pins cannot
//! determine. [`solve_pose`] is the bare solver.

mod candidates;
mod capture_errors;
mod crosschecks;
mod joint;
mod linear;
mod refine;
mod scatter;
mod selection;
mod tolerances;

use fabkit_camera::{
    Camera, CameraEstimate, InvalidCovariance, JointEstimate, POSE_PARAMETER_COUNT,
};
use fabkit_geometry::{Point3, Pose, Vector3};
use nalgebra::{DMatrix, Rotation3};

pub use candidates::{Drawing, Medium, Optics, ParameterSet};
pub use capture_errors::ErrorEstimate;
pub use crosschecks::{CrossChecks, OUTLIER_SIGMAS};
pub use joint::{JointCovariance, joint_estimate};
pub use refine::{Loss, PoseSolution, SolveError, refine};
pub use scatter::{PinScatter, pin_scatter};
pub use selection::{Selection, Trial};
pub use tolerances::{TOLERANCE_SIGMAS, UnitDifference};

use self::tolerances::ExpectedValues;
use crate::model::{FitParameter, MarkOffsets, Model, Observation};

/// Threshold of the Huber loss, in standard deviations: one normally distributed residual in ninety is longer.
const HUBER: f64 = 3.0;
/// Refractive index of silicone gels.
pub const SILICONE_INDEX: f64 = 1.41;
/// Smallest number of degrees of freedom from which the scatter is used.
const MIN_SCATTER_FREEDOM: usize = 5;
/// Largest extent of the contacts across a plane, as a fraction of their largest extent, for which they count as
/// coplanar.
const MAX_PLANE_EXTENT: f64 = 0.02;

/// Options of an extrinsic calibration.
///
/// ```
/// use fabkit_calibration::extrinsics::{CalibrationOptions, Loss, SILICONE_INDEX};
/// let options = CalibrationOptions { loss: Loss::Squares, ..CalibrationOptions::default() };
/// assert_eq!((options.gel_index, SILICONE_INDEX), (1.41, 1.41));
/// assert!(options.drawing.is_none() && options.mark_offsets.is_none());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CalibrationOptions<'a> {
    /// Refractive index of the gel behind an interface that is tried.
    pub gel_index: f64,
    /// Bodies that the design draws between lens and pins, if known.
    pub drawing: Option<Drawing<'a>>,
    /// Loss of the residuals.
    pub loss: Loss,
    /// Offsets of marks from their tips, if known.
    pub mark_offsets: Option<&'a MarkOffsets>,
    /// Normals of the surface at contacts; without them pins are taken to be pushed along the normal.
    pub outward: Option<SurfaceNormal<'a>>,
}

/// Function that returns a surface's outward unit normal at a place, sensor frame.
#[derive(Clone, Copy)]
pub struct SurfaceNormal<'a>(pub &'a dyn Fn(&Point3<f64>) -> Vector3<f64>);

impl std::fmt::Debug for SurfaceNormal<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Outward")
    }
}

impl Default for CalibrationOptions<'_> {
    fn default() -> Self {
        Self {
            gel_index: SILICONE_INDEX,
            drawing: None,
            loss: Loss::Huber(HUBER),
            mark_offsets: None,
            outward: None,
        }
    }
}

/// Result of an extrinsic calibration, with everything needed to judge it.
#[derive(Clone, Debug)]
pub struct PoseCalibration {
    /// Camera as given.
    pub given: CameraEstimate,
    /// Observations, with standard deviations that include the play of the pins.
    pub observations: Vec<Observation>,
    /// Repeatability of the pins, if any hole has pins in several captures.
    pub scatter: Option<PinScatter>,
    /// Explanations that were tried, and the choice.
    pub selection: Selection,
    /// Covariance of the chosen fit's parameters. It is enlarged if the residuals are larger than the observations'
    /// standard deviations explain, and includes the part of the given camera's errors that the fit takes up.
    pub covariance: DMatrix<f64>,
    /// Chosen camera, with the joint covariance of it and its pose.
    pub joint: JointEstimate,
    /// Estimated errors of pins and of captures, and the covariance that they cause.
    pub errors: ErrorEstimate,
    /// Comparison with fits to other captures.
    pub checks: CrossChecks,
    /// Ratio of the residuals to their expected size; 1 if the model and the standard deviations are right.
    pub misfit: f64,
}

impl PoseCalibration {
    /// Returns the chosen trial.
    pub fn chosen_trial(&self) -> &Trial {
        &self.selection.trials[self.selection.chosen]
    }

    /// Returns the fit of the pose alone, with the camera as given; `None` if it failed.
    pub fn plain_trial(&self) -> Option<&Trial> {
        self.selection.trials.iter().find(|trial| trial.candidate == ParameterSet::PLAIN)
    }

    /// Computes the jackknife standard deviations of the pose's six parameters, from leaving out each capture in turn,
    /// relative to those claimed for the same errors; 1 if the claim is right. `None` for fewer than three captures.
    pub fn jackknife_ratio(&self) -> Option<[f64; POSE_PARAMETER_COUNT]> {
        let chosen = self.chosen_trial();
        let count = chosen.left_out.len() as f64;
        if count < 3.0 {
            return None;
        }
        let pose = &chosen.fit.model.camera_from_sensor;
        let off = |other: &Pose| -> [f64; POSE_PARAMETER_COUNT] {
            let turned =
                Rotation3::from_matrix_unchecked(other.rotation() * pose.rotation().transpose());
            let (turn, shift) =
                (turned.scaled_axis(), other.translation_mm() - pose.translation_mm());
            std::array::from_fn(|i| if i < 3 { turn[i] } else { shift[i - 3] })
        };
        let all: Vec<[f64; POSE_PARAMETER_COUNT]> = chosen.left_out.iter().map(off).collect();
        Some(std::array::from_fn(|i| {
            let mean = all.iter().map(|off| off[i]).sum::<f64>() / count;
            let squares = all.iter().map(|off| (off[i] - mean).powi(2)).sum::<f64>();
            let claimed = self.errors.pixel_covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt();
            // Jackknife variance (Quenouille and Tukey): (n - 1) / n of the sum of squares.
            ((count - 1.0) / count * squares).sqrt() / claimed
        }))
    }

    /// Returns the chosen model.
    pub fn model(&self) -> &Model {
        &self.chosen_trial().fit.model
    }
}

/// Reason why a calibration failed.
///
/// ```
/// use fabkit_calibration::extrinsics::{CalibrationError, CalibrationOptions, calibrate};
/// use fabkit_calibration::model::{Contact, Observation};
/// use fabkit_camera::Camera;
/// use fabkit_geometry::{Point3, Pose};
/// let (camera, pose) = (Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// // Eight holes of one ring: a camera farther away would see a ring as well.
/// let observe = |hole: u32| {
///     let (sin, cos) = (f64::from(hole) * 45f64.to_radians()).sin_cos();
///     let contact_in_sensor_mm = Point3::new(9.0 * cos, 9.0 * sin, 12.0);
///     let contact = Contact { capture: 0, hole, contact_in_sensor_mm, axis_in_sensor: None };
///     let pixel = camera.project(&pose.point(contact_in_sensor_mm)).unwrap();
///     Observation { contact, pixel, sigma_px: 0.3 }
/// };
/// let ring: Vec<Observation> = (1..=8).map(observe).collect();
/// let refused = calibrate(&camera.into(), &ring, &pose, None, &CalibrationOptions::default());
/// assert_eq!(refused.unwrap_err(), CalibrationError::OnePlane { pins: 8 });
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// All contacts lie in a plane, as those of one ring do.
    #[error(
        "all {pins} pins touch in one plane, as the holes of one ring do: distance and tilt would be guesses"
    )]
    OnePlane {
        /// Number of pins.
        pins: usize,
    },
    /// No explanation of the pixels can be fitted.
    #[error("no explanation of the pixels can be fitted{}", reasons(.failed))]
    NoExplanation {
        /// Explanations with their errors, in the order in which they were tried.
        failed: Vec<(ParameterSet, SolveError)>,
    },
    /// The covariance contains numbers that are too large or not finite.
    #[error("the covariance cannot be computed: {0}")]
    Covariance(#[from] InvalidCovariance),
}

/// Lists every error once, a line each, with the explanations that failed by it.
fn reasons(failed: &[(ParameterSet, SolveError)]) -> String {
    let mut by_reason: Vec<(&SolveError, Vec<String>)> = Vec::new();
    for (candidate, error) in failed {
        match by_reason.iter_mut().find(|(known, _)| *known == error) {
            Some((_, names)) => names.push(candidate.to_string()),
            None => by_reason.push((error, vec![candidate.to_string()])),
        }
    }
    let line =
        |(error, names): (&SolveError, Vec<String>)| format!("\n  {error} ({})", names.join(", "));
    by_reason.into_iter().map(line).collect()
}

/// Calibrates pose and, if the pixels require it, camera from assigned pins.
///
/// The camera's own covariance is propagated to the pose. `start` is a pose from which all pins are visible, for
/// example that of [`crate::assignment::Assignment`]. If `nominal` is given, it acts as a prior of the translation.
///
/// # Errors
/// Fails for pins in one plane, or if every explanation fails because there are too few pins or pins are not visible.
///
/// ```
/// use fabkit_calibration::extrinsics::{CalibrationOptions, calibrate};
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::Model;
/// use fabkit_calibration::synthetic::SyntheticSensor;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
///
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9], "6": [12, 0, 9], "7": [-12, 0, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let (camera, designed) = (Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// let truth = Model::new(camera, Pose::translation(0.4, -0.3, 7.6));
/// let captures = vec![landmarks.pins.iter().collect(); 5];
/// let seen = SyntheticSensor::new(truth, 1).observe(&captures, 0.3)?;
/// let options = CalibrationOptions::default();
/// let found = calibrate(&camera.into(), &seen, &designed, Some(&designed), &options)?;
/// // Nothing but the pose differs from the design, and pins repeat to 0.3 px in both directions.
/// assert_eq!(found.chosen_trial().candidate.to_string(), "plain");
/// assert!((found.scatter.unwrap().rms_px / 0.3f64.hypot(0.3) - 1.0).abs() < 0.3);
/// let z_mm = found.model().camera_from_sensor.translation_mm().z;
/// assert!((z_mm - 7.6).abs() < 4.0 * found.covariance[(5, 5)].sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn calibrate(
    camera: &CameraEstimate,
    observations: &[Observation],
    start: &Pose,
    nominal: Option<&Pose>,
    options: &CalibrationOptions<'_>,
) -> Result<PoseCalibration, CalibrationError> {
    if in_one_plane(observations) {
        return Err(CalibrationError::OnePlane { pins: observations.len() });
    }
    let captures = observations.iter().map(|o| o.contact.capture + 1).max().unwrap_or(0);
    let scatter = pin_scatter(observations);
    let believed = scatter.filter(|s| s.degrees_of_freedom >= MIN_SCATTER_FREEDOM);
    // The scatter includes the images' noise. A pin that is detected worse than pins repeat keeps its own standard
    // deviation.
    // The scatter counts both coordinates together, a standard deviation each by itself.
    let floor_px = believed.map_or(0.0, |scatter| scatter.rms_px / std::f64::consts::SQRT_2);
    let of_mark = |o: &Observation| {
        let found = options.mark_offsets?.offset_at(&o.contact.contact_in_sensor_mm);
        found.map(|offset| offset.sigma_px)
    };
    let observations: Vec<Observation> = observations
        .iter()
        .map(|o| {
            let sigma_px = o.sigma_px.hypot(of_mark(o).unwrap_or(0.0)).max(floor_px);
            Observation { sigma_px, ..o.clone() }
        })
        .collect();
    // The fits decide which medium is in front of the lens.
    let camera = &camera.clone().without_drawn_interface();
    let mut model = Model::new(*camera.camera(), *start);
    model.expected_translation_mm = nominal.map(|pose| *pose.translation_mm());
    model.mark_offsets = options.mark_offsets.cloned().unwrap_or_default();
    let expected = ExpectedValues { given: camera, nominal, drawn: options.drawing };
    let selection = selection::select(&model, &observations, captures, options, &expected)
        .map_err(|failed| CalibrationError::NoExplanation { failed })?;
    let fit = &selection.trials[selection.chosen].fit;
    let coordinates = 2 * observations.len();
    // At least 1, so that a fit without redundancy has a finite misfit.
    let freedom = coordinates.saturating_sub(fit.parameters.len()).max(1);
    let misfit = (fit.cost / freedom as f64).sqrt();
    let errors = capture_errors::estimate_errors(fit, &observations, options.loss);
    let joint = joint_estimate(camera, fit, &observations, options.loss, &errors.covariance)?;
    let checks = crosschecks::cross_checks(fit, &observations, options, &errors.pixel_covariance);
    Ok(PoseCalibration {
        given: camera.clone(),
        observations,
        scatter,
        selection,
        covariance: joint.fit_covariance,
        joint: joint.estimate,
        errors,
        checks,
        misfit,
    })
}

/// Computes the pose from rays through the observed pixels, without a starting value; `None` for fewer than six pins,
/// or contacts in a plane.
///
/// ```
/// use fabkit_calibration::extrinsics::pose_without_start;
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::Model;
/// use fabkit_calibration::synthetic::SyntheticSensor;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9], "6": [12, 0, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let truth = Model::new(Camera::equidistant(640, 480, 2.8)?, Pose::translation(3.0, -2.0, 9.0));
/// let captures = [landmarks.pins.iter().collect()];
/// let exact = SyntheticSensor::new(truth.clone(), 1).observe(&captures, 0.0)?;
/// let found = pose_without_start(&truth.camera, &exact).unwrap();
/// let off_mm = found.translation_mm() - truth.camera_from_sensor.translation_mm();
/// assert!(off_mm.norm() < 1e-6);
/// assert!(pose_without_start(&truth.camera, &exact[..5]).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn pose_without_start(camera: &Camera, observations: &[Observation]) -> Option<Pose> {
    let mut rays = Vec::with_capacity(observations.len());
    let mut points = Vec::with_capacity(observations.len());
    for observation in observations {
        // A pixel outside the lens's image has no ray; the refinement will handle its pin.
        if let Ok(ray) = camera.unproject(&observation.pixel) {
            rays.push(ray);
            points.push(observation.contact.contact_in_sensor_mm);
        }
    }
    linear::pose_from_rays(&rays, &points)
}

/// Solves for the pose through the bodies that a design draws, and for the parameters of these that molds, prints and
/// data sheets leave uncertain. All pins must be visible from `start`.
///
/// # Errors
/// Fails as [`refine`], or if the drawn interface is not in front of the camera.
pub fn solve_drawn(
    observations: &[Observation],
    start: &Model,
    drawing: &Drawing<'_>,
    loss: Loss,
) -> Result<PoseSolution, SolveError> {
    let set = ParameterSet {
        optics: Optics { medium: Medium::Drawn, radial_terms: 0 },
        ..ParameterSet::PLAIN
    };
    let mut parameters = set.parameters(&start.camera, 0);
    if !start.mark_offsets.is_empty() {
        parameters.extend(FitParameter::LIGHT);
    }
    candidates::fit_drawn(drawing, start, &parameters, observations, loss)
}

/// Solves for the pose alone, starting from a linear solution if there is one and else from `nominal`.
///
/// # Errors
/// Fails as [`refine`], also if there is neither a linear solution nor a nominal pose.
///
/// ```
/// use fabkit_calibration::extrinsics::{Loss, SolveError, solve_pose};
/// use fabkit_calibration::model::{Contact, Observation};
/// use fabkit_camera::{Camera, Point2};
/// use fabkit_geometry::{Point3, Pose};
/// let camera = Camera::equidistant(640, 480, 2.8)?;
/// let contact_in_sensor_mm = Point3::new(0.0, 0.0, 15.0);
/// let contact = Contact { capture: 0, hole: 1, contact_in_sensor_mm, axis_in_sensor: None };
/// let one = Observation { contact, pixel: Point2::new(319.5, 239.5), sigma_px: 0.3 };
/// // A pose has six unknowns, and a pin has two coordinates: three pins are the least.
/// let designed = Pose::translation(0.0, 0.0, 7.0);
/// let refused = solve_pose(&camera, &[one], Some(&designed), Loss::Squares).unwrap_err();
/// assert_eq!(refused, SolveError::TooFewObservations { unknowns: 6, coordinates: 2 });
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
pub fn solve_pose(
    camera: &Camera,
    observations: &[Observation],
    nominal: Option<&Pose>,
    loss: Loss,
) -> Result<PoseSolution, SolveError> {
    let linear = pose_without_start(camera, observations);
    let mut first_error = None;
    for start in [linear, nominal.copied()].into_iter().flatten() {
        match refine(&Model::new(*camera, start), &FitParameter::POSE, observations, loss) {
            Ok(fit) => return Ok(fit),
            Err(error) => {
                first_error.get_or_insert(error);
            }
        }
    }
    let coordinates = 2 * observations.len();
    Err(first_error.unwrap_or(SolveError::TooFewObservations { unknowns: 6, coordinates }))
}

/// Returns whether all contacts lie close to one plane.
fn in_one_plane(observations: &[Observation]) -> bool {
    let points = observations.iter().map(|o| o.contact.contact_in_sensor_mm.coords);
    let count = observations.len().max(1) as f64;
    let mean = points.clone().sum::<nalgebra::Vector3<f64>>() / count;
    let spread: nalgebra::Matrix3<f64> =
        points.map(|p| (p - mean) * (p - mean).transpose()).sum::<nalgebra::Matrix3<f64>>() / count;
    let eigenvalues = spread.symmetric_eigenvalues();
    // The smallest extent against the largest one; rounding can make an eigenvalue negative.
    eigenvalues.min().max(0.0).sqrt() <= MAX_PLANE_EXTENT * eigenvalues.max().sqrt()
}
