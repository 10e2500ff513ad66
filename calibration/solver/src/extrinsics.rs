//! Where the camera is, from pins at known places.
//!
//! [`calibrate`] does all of it: it estimates how well pins repeat, fits every explanation of the
//! pixels that the landmarks allow, judges each on captures it has not seen, and says what it chose
//! and what the pins cannot tell. [`solve_pose`] is the bare solver.

mod candidates;
mod crosschecks;
mod groups;
mod joint;
mod linear;
mod refine;
mod scatter;
mod selection;
mod tolerances;

use fabkit_camera::{Camera, CameraEstimate, InvalidCovariance, JointEstimate, POSE_COUNT};
use fabkit_geometry::{Point3, Pose, Vector3};
use nalgebra::{DMatrix, Rotation3};

pub use candidates::{Drawing, Medium, Optics, ParameterSet};
pub use crosschecks::{CrossChecks, FAR_SIGMAS};
pub use groups::Scatter;
pub use joint::{JointCovariance, joint_estimate};
pub use refine::{Loss, PoseSolution, SolveError, refine};
pub use scatter::{PinScatter, pin_scatter};
pub use selection::{Selection, Trial};
pub use tolerances::{Difference, TOLERANCE_SIGMAS};

use self::tolerances::Expected;
use crate::model::{FitParameter, MarkOffsets, Model, Observation};

/// Residuals beyond this many standard deviations count by their length: one in ninety if all are
/// normal.
const HUBER: f64 = 3.0;
/// Refractive index of silicone gels.
pub const SILICONE_INDEX: f64 = 1.41;
/// The scatter is believed from this many degrees of freedom on.
const MIN_SCATTER_FREEDOM: usize = 5;
/// Contacts within this part of their extent from a common plane lie in it.
const PLANE: f64 = 0.02;

/// How to calibrate.
#[derive(Clone, Copy, Debug)]
pub struct CalibrationOptions<'a> {
    /// Refractive index of the gel behind an interface that is tried.
    pub gel_index: f64,
    /// What the design draws between lens and pins, if that is known.
    pub drawn: Option<Drawing<'a>>,
    /// How residuals count.
    pub loss: Loss,
    /// Where marks are found beside their tips, if that is known.
    pub mark_offsets: Option<&'a MarkOffsets>,
    /// How the surface lies at a contact; without, pins are taken to be pushed straight in.
    pub outward: Option<Outward<'a>>,
}

/// The outward unit normal of a surface at a place, sensor frame.
#[derive(Clone, Copy)]
pub struct Outward<'a>(pub &'a dyn Fn(&Point3<f64>) -> Vector3<f64>);

impl std::fmt::Debug for Outward<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Outward")
    }
}

impl Default for CalibrationOptions<'_> {
    fn default() -> Self {
        Self {
            gel_index: SILICONE_INDEX,
            drawn: None,
            loss: Loss::Huber(HUBER),
            mark_offsets: None,
            outward: None,
        }
    }
}

/// The result, with all that is needed to judge it.
#[derive(Clone, Debug)]
pub struct PoseCalibration {
    /// The camera as it was given.
    pub given: CameraEstimate,
    /// The observations, with standard deviations that include the play of the pins.
    pub observations: Vec<Observation>,
    /// How well pins repeat, if any hole has pins in several captures.
    pub scatter: Option<PinScatter>,
    /// What was tried and chosen.
    pub selection: Selection,
    /// Covariance of the chosen fit's parameters: enlarged where residuals are larger than the
    /// observations' standard deviations explain, and with the part of the given camera's errors
    /// that the fit takes up.
    pub covariance: DMatrix<f64>,
    /// The chosen camera, and how sure it and its pose are together.
    pub joint: JointEstimate,
    /// How large the errors of pins and of captures are, and what the fit has of them alone.
    pub errors: Scatter,
    /// What other captures would make of it.
    pub checks: CrossChecks,
    /// Residuals over what they should be; 1 if the model and the standard deviations are right.
    pub misfit: f64,
}

impl PoseCalibration {
    /// What was chosen.
    pub fn chosen(&self) -> &Trial {
        &self.selection.trials[self.selection.chosen]
    }

    /// The pose alone, with the camera as given; `None` if that could not be fitted.
    pub fn plain(&self) -> Option<&Trial> {
        self.selection.trials.iter().find(|trial| trial.candidate == ParameterSet::PLAIN)
    }

    /// Standard deviations of the pose's six parameters from leaving out each capture in turn, over those that are claimed
    /// for the same errors: 1 where the claim is right. `None` for fewer than three captures.
    pub fn jackknife_ratio(&self) -> Option<[f64; POSE_COUNT]> {
        let chosen = self.chosen();
        let count = chosen.left_out.len() as f64;
        if count < 3.0 {
            return None;
        }
        let pose = &chosen.fit.model.camera_from_sensor;
        let off = |other: &Pose| -> [f64; POSE_COUNT] {
            let turned =
                Rotation3::from_matrix_unchecked(other.rotation() * pose.rotation().transpose());
            let (turn, shift) =
                (turned.scaled_axis(), other.translation_mm() - pose.translation_mm());
            std::array::from_fn(|i| if i < 3 { turn[i] } else { shift[i - 3] })
        };
        let all: Vec<[f64; POSE_COUNT]> = chosen.left_out.iter().map(off).collect();
        Some(std::array::from_fn(|i| {
            let mean = all.iter().map(|off| off[i]).sum::<f64>() / count;
            let squares = all.iter().map(|off| (off[i] - mean).powi(2)).sum::<f64>();
            let claimed = self.errors.of_pixels[(i, i)].max(f64::MIN_POSITIVE).sqrt();
            // Quenouille and Tukey: (n - 1) / n of the squares' sum.
            ((count - 1.0) / count * squares).sqrt() / claimed
        }))
    }

    /// The chosen model.
    pub fn model(&self) -> &Model {
        &self.chosen().fit.model
    }
}

/// Why nothing was calibrated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// All contacts lie in a plane, as those of one ring do.
    #[error(
        "all {pins} pins touch in one plane, as the holes of one ring do: distance and tilt would be guesses"
    )]
    OnePlane {
        /// How many there are.
        pins: usize,
    },
    /// No explanation of the pixels can be fitted.
    #[error("no explanation of the pixels can be fitted{}", reasons(.failed))]
    NoExplanation {
        /// Each with why, in the order in which they were tried.
        failed: Vec<(ParameterSet, SolveError)>,
    },
    /// Numbers beyond what can be computed with.
    #[error("the covariance cannot be computed: {0}")]
    Covariance(#[from] InvalidCovariance),
}

/// Every reason once, a line each, with the explanations that it stopped.
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

/// Calibrates from assigned pins.
///
/// The camera's own covariance is handed on to the pose. `start` is a pose near enough to see all pins, for example [`crate::assignment::Assignment`]'s.
/// Where `nominal` is given, the distance from it takes part as what is known beforehand.
///
/// # Errors
/// [`CalibrationError`]: pins in one plane; too few pins, or pins that cannot be seen, under every
/// explanation.
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
    // The pictures' noise is within the scatter; a pin seen worse than it repeats keeps its own.
    let floor_px = believed.map_or(0.0, |scatter| scatter.rms_px / std::f64::consts::SQRT_2);
    let of_mark = |o: &Observation| {
        let found = options.mark_offsets?.of(&o.contact.contact_in_sensor_mm);
        found.map(|offset| offset.sigma_px)
    };
    let observations: Vec<Observation> = observations
        .iter()
        .map(|o| {
            let sigma_px = o.sigma_px.hypot(of_mark(o).unwrap_or(0.0)).max(floor_px);
            Observation { sigma_px, ..o.clone() }
        })
        .collect();
    // What is before the lens is for the pixels to say.
    let camera = &camera.clone().undrawn();
    let mut model = Model::new(*camera.camera(), *start);
    model.expected_translation_mm = nominal.map(|pose| *pose.translation_mm());
    model.mark_offsets = options.mark_offsets.cloned().unwrap_or_default();
    let expected = Expected { given: camera, nominal, drawn: options.drawn };
    let selection = selection::select(&model, &observations, captures, options, &expected)
        .map_err(|failed| CalibrationError::NoExplanation { failed })?;
    let fit = &selection.trials[selection.chosen].fit;
    let coordinates = 2 * observations.len();
    let freedom = coordinates.saturating_sub(fit.parameters.len()).max(1);
    let misfit = (fit.cost / freedom as f64).sqrt();
    let errors = groups::scatter(fit, &observations, options.loss);
    let joint = joint_estimate(camera, fit, &observations, options.loss, &errors.covariance)?;
    let checks = crosschecks::cross_checks(fit, &observations, options, &errors.of_pixels);
    Ok(PoseCalibration {
        given: camera.clone(),
        observations,
        scatter,
        selection,
        covariance: joint.of_fit,
        joint: joint.estimate,
        errors,
        checks,
        misfit,
    })
}

/// The pose that rays through the observed pixels give without a starting value; `None` for fewer
/// than six pins, or pins whose contacts lie in a plane.
pub fn pose_without_start(camera: &Camera, observations: &[Observation]) -> Option<Pose> {
    let mut rays = Vec::with_capacity(observations.len());
    let mut points = Vec::with_capacity(observations.len());
    for observation in observations {
        // A pixel outside the lens's image has no ray; refinement will deal with its pin.
        if let Ok(ray) = camera.unproject(&observation.pixel) {
            rays.push(ray);
            points.push(observation.contact.contact_in_sensor_mm);
        }
    }
    linear::pose_from_rays(&rays, &points)
}

/// Solves for the pose through the bodies that a design draws, from a model near enough to see all pins; with
/// it for what molds, prints and data sheets leave open of them.
///
/// # Errors
/// As [`refine`]; an interface that is not before the camera.
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

/// Solves for the pose alone, from a linear solution if there is one and else from `nominal`.
///
/// # Errors
/// As [`refine`], also where there is neither a linear solution nor a nominal pose.
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
    Err(first_error.unwrap_or(SolveError::TooFew { unknowns: 6, coordinates }))
}

fn in_one_plane(observations: &[Observation]) -> bool {
    let points = observations.iter().map(|o| o.contact.contact_in_sensor_mm.coords);
    let count = observations.len().max(1) as f64;
    let mean = points.clone().sum::<nalgebra::Vector3<f64>>() / count;
    let spread: nalgebra::Matrix3<f64> =
        points.map(|p| (p - mean) * (p - mean).transpose()).sum::<nalgebra::Matrix3<f64>>() / count;
    let eigenvalues = spread.symmetric_eigenvalues();
    eigenvalues.min().max(0.0).sqrt() <= PLANE * eigenvalues.max().sqrt()
}
