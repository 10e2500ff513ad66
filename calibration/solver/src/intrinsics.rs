//! Intrinsic calibration: a camera's parameters from images of a board.
//!
//! It starts from the nominal lens of the sensor's design. Poses follow from rays (`planar`, `start`). Camera and poses
//! are then refined together (`bundle`) under each lens model (`models`), and the Bayesian information criterion
//! chooses a model. The covariance is that of the residuals actually found, and what the images do not determine is
//! reported in words (`advice`).
//!
//! The board's scale is not among the unknowns: a board printed at 101 % scales all poses by 1 % and leaves the camera
//! unchanged.

mod advice;
mod bundle;
mod models;
mod planar;
mod rays;
mod start;

pub use fabkit_camera::LensModel;
use fabkit_camera::{Camera, CameraEstimate, InvalidCovariance, Point2, Point3, Vector2};
use fabkit_geometry::Pose;
use nalgebra::DMatrix;

use crate::information::ScaledCholesky;
pub use advice::{COVERAGE, CalibrationAdvice, ImageCoverage, ViewInfluence};
use bundle::{BundleSolution, State};
pub use rays::{GRID, RaySigma, RaySigmas, RayUncertainty};

/// Smallest number of views: fewer cannot separate the camera from the poses.
pub const MIN_VIEWS: usize = 3;
/// Largest number of views that are solved together.
pub const MAX_VIEWS: usize = 1000;
/// Smallest number of corners in a view.
pub const MIN_CORNERS: usize = planar::MIN_CORNERS;
/// Decrease of the information criterion for which a model replaces one that is as simple or simpler: "very strong"
/// evidence (R. Kass and A. Raftery, "Bayes Factors", JASA 1995).
pub const STRONG_EVIDENCE: f64 = 10.0;

/// Corner of the board observed in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerObservation {
    /// Number of the corner.
    pub id: u32,
    /// Position on the board, x and y, mm.
    pub in_board_mm: Point2<f64>,
    /// Position in the image: column and row, px.
    pub pixel: Point2<f64>,
    /// Standard deviation in each direction, px. Only ratios matter, because the scale follows from the residuals.
    pub sigma_px: f64,
}

/// Image of the board.
///
/// ```
/// use fabkit_calibration::board::{Board, read_corners};
/// use fabkit_calibration::intrinsics::{BoardView, CornerObservation};
/// let board = Board::checkerboard("test", [5, 4], 3.0)?;
/// let list = read_corners("view,corner,x_px,y_px\nleft,0,100.5,80.25\nleft,5,121,99\n", &board)?;
/// // What a detector found, with the places on the board.
/// let views = list.into_iter().map(|(name, corners)| {
///     let corners = corners.iter().map(|corner| {
///         let in_board_mm = board.corners[corner.id as usize].in_board_mm.into();
///         let (id, pixel, sigma_px) = (corner.id, corner.pixel, corner.sigma_px);
///         CornerObservation { id, in_board_mm, pixel, sigma_px }
///     });
///     BoardView { name, corners: corners.collect() }
/// });
/// let views: Vec<BoardView> = views.collect();
/// // Four corners in a row: corner 5 is the second of the second row.
/// assert_eq!(views[0].corners[1].in_board_mm, fabkit_camera::Point2::new(6.0, 6.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BoardView {
    /// Name in messages, for example its file.
    pub name: String,
    /// Corners of the board that were detected.
    pub corners: Vec<CornerObservation>,
}

/// View after calibration.
#[derive(Clone, Debug)]
pub struct SolvedView {
    /// Name as in [`BoardView`].
    pub name: String,
    /// Pose: board frame to camera frame, mm.
    pub camera_from_board: Pose,
    /// Corners that were used.
    pub corners: Vec<CornerObservation>,
    /// Observed minus projected, px, for each corner.
    pub residuals_px: Vec<Vector2<f64>>,
    /// Root mean square length of the residuals, px.
    pub rms_px: f64,
}

/// Lens model with its fit to the images.
#[derive(Clone, Debug)]
pub struct LensCandidate {
    /// Lens model.
    pub model: LensModel,
    /// Number of its parameters.
    pub parameters: usize,
    /// Quality of its fit; `None` if the model cannot map what the images show.
    pub fit: Option<CandidateFit>,
}

/// Quality of a [`LensCandidate`]'s fit.
#[derive(Clone, Copy, Debug)]
pub struct CandidateFit {
    /// Root mean square length of the residuals, px.
    pub rms_px: f64,
    /// Root mean square length of the residuals, px, for each view as if it had been held out, to first order; infinite
    /// if the others do not determine the camera.
    pub held_out_rms_px: f64,
    /// Bayesian information criterion `n ln(cost / n) + p ln n` for `n` coordinates and `p` parameters of the lens.
    /// Only differences are meaningful.
    pub criterion: f64,
}

/// Calibrated camera, with its quality.
#[derive(Clone, Debug)]
pub struct LensCalibration {
    /// Camera with the covariance of its parameters.
    pub estimate: CameraEstimate,
    /// Chosen lens model.
    pub model: LensModel,
    /// All models tried, in the order of preference.
    pub candidates: Vec<LensCandidate>,
    /// Views that were used.
    pub views: Vec<SolvedView>,
    /// Root mean square length of all residuals, px.
    pub rms_px: f64,
    /// Ratio of the residuals' standard deviation to that stated by the views: 1 if corners are as good as the detector
    /// states and lens and board are as modelled.
    pub residual_scale: f64,
    /// Scale of the image on the axis, px per radian, along columns, and its standard deviation. It is comparable
    /// between models with different parameters.
    pub focal_px: [f64; 2],
    /// Uncertainty of the rays, which is comparable between models.
    pub rays: RayUncertainty,
    /// Report of what the images do not determine.
    pub advice: CalibrationAdvice,
}

/// Reason why an intrinsic calibration failed.
///
/// ```
/// use fabkit_calibration::intrinsics::{BoardView, LensCalibrationError, LensModel, calibrate};
/// use fabkit_camera::Camera;
/// let nominal = Camera::equidistant(640, 480, 2.5)?;
/// let empty = BoardView { name: "01.png".into(), corners: Vec::new() };
/// let refused = calibrate(&vec![empty; 12], &nominal, &[LensModel::KannalaBrandt]).unwrap_err();
/// // Twelve images, and the board in none of them.
/// assert_eq!(refused, LensCalibrationError::TooFewViews { usable: 0 });
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LensCalibrationError {
    /// Too few images show the board.
    #[error(
        "views with at least {MIN_CORNERS} corners of the board: {usable}; {MIN_VIEWS} are needed"
    )]
    TooFewViews {
        /// Number of usable views.
        usable: usize,
    },
    /// There are too many views.
    #[error("{views} views; at most {MAX_VIEWS} are solved together")]
    TooManyViews {
        /// Number of views.
        views: usize,
    },
    /// A coordinate is not a number or too large, or a standard deviation is not above 0.
    #[error("{view}: corner {id} has impossible coordinates or an impossible sigma")]
    ImpossibleCorner {
        /// Name of the view.
        view: String,
        /// Number of the corner.
        id: u32,
    },
    /// No pose of the board explains its corners under the focal lengths tried.
    #[error(
        "no pose of the board explains what is seen, with the nominal focal length of {focal_px:.0} px \
         per radian or half or twice that"
    )]
    NoInitialPose {
        /// Focal length of the nominal camera, px per radian.
        focal_px: f64,
    },
    /// No lens model fits.
    #[error("none of the lens models ({}) fits these views", .tried.join(", "))]
    NoModel {
        /// Names of the models tried.
        tried: Vec<&'static str>,
    },
    /// Some combination of the camera's parameters can change almost without effect in these views.
    #[error("these views do not determine the camera: {reason}")]
    NotObservable {
        /// Probable cause, for messages.
        reason: String,
    },
    /// The covariance contains numbers that are too large or not finite.
    #[error("the covariance cannot be computed: {0}")]
    Covariance(#[from] InvalidCovariance),
}

/// Calibrates a camera, starting from the nominal one of the sensor's design.
///
/// The model with the fewest parameters among `models` is chosen; of equally simple ones the first. Another model needs
/// strong evidence ([`STRONG_EVIDENCE`]), and if it has more parameters, also an error on held-out views that is lower
/// by more than its standard error. Views with fewer than [`MIN_CORNERS`] corners are left out.
///
/// # Errors
/// Returns [`LensCalibrationError`] for too few or too many views, impossible values, or views that no model fits or that do
/// not determine the camera.
///
/// # Example
/// ```
/// use fabkit_calibration::intrinsics::{BoardView, CornerObservation, LensModel, calibrate};
/// use fabkit_camera::{Camera, Point2, Point3};
/// use fabkit_geometry::{Angle, Pose};
///
/// // The data sheet says 150 degrees; the lens has 160.
/// let camera = Camera::equidistant(640, 480, 160f64.to_radians())?;
/// let nominal = Camera::equidistant(640, 480, 150f64.to_radians())?;
/// let views: Vec<BoardView> = [[30.0, 0.0], [-30.0, 10.0], [5.0, 40.0], [-10.0, -35.0]]
///     .into_iter()
///     .map(|[a, b]| {
///         let turn = |deg: f64| Angle::from_deg(deg).unwrap();
///         let pose = Pose::translation(-12.0, -10.0, 20.0)
///             .then_in(Pose::rotation_x(turn(a)))
///             .then_in(Pose::rotation_y(turn(b)));
///         let corners = (0..48).map(|id| {
///             let (x, y) = (f64::from(id % 8) * 3.0, f64::from(id / 8) * 3.0);
///             let pixel = camera.project(&pose.point(Point3::new(x, y, 0.0))).unwrap();
///             CornerObservation { id, in_board_mm: Point2::new(x, y), pixel, sigma_px: 0.1 }
///         });
///         BoardView { name: format!("tilted by {a} and {b}"), corners: corners.collect() }
///     })
///     .collect();
/// let found = calibrate(&views, &nominal, &LensModel::ALL)?;
/// let focal_px = found.estimate.camera().lens().intrinsics().fx_px;
/// assert!((focal_px / camera.lens().intrinsics().fx_px - 1.0).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn calibrate(
    views: &[BoardView],
    nominal: &Camera,
    models: &[LensModel],
) -> Result<LensCalibration, LensCalibrationError> {
    if views.len() > MAX_VIEWS {
        return Err(LensCalibrationError::TooManyViews { views: views.len() });
    }
    check(views)?;
    let views: Vec<BoardView> =
        views.iter().filter(|view| view.corners.len() >= MIN_CORNERS).cloned().collect();
    if views.len() < MIN_VIEWS {
        return Err(LensCalibrationError::TooFewViews { usable: views.len() });
    }
    let no_start =
        || LensCalibrationError::NoInitialPose { focal_px: nominal.lens().intrinsics().fx_px };
    // Each lens model starts from this camera, as far out as corners were seen.
    let rough = start::initial_state(&views, nominal).ok_or_else(no_start)?;
    let angle_rad = largest_angle(&views, &rough);
    let mut fits = Vec::new();
    for &model in models {
        let fit = models::fit_model_to_camera(model, &rough.camera, angle_rad).and_then(|camera| {
            let free = vec![true; camera.parameter_count()];
            bundle::fit(&views, State { camera, ..rough.clone() }, &free)
        });
        fits.push((model, fit));
    }
    let candidates: Vec<LensCandidate> =
        fits.iter().map(|(model, fit)| candidate(&views, *model, fit.as_ref())).collect();
    let chosen = choose(&candidates, &fits).ok_or_else(|| LensCalibrationError::NoModel {
        tried: models.iter().map(|model| model.name()).collect(),
    })?;
    let (model, fit) = fits.swap_remove(chosen);
    let fit = fit.expect("a chosen model has a fit");
    finish(&views, model, candidates, fit)
}

/// Checks that all values are finite and possible.
fn check(views: &[BoardView]) -> Result<(), LensCalibrationError> {
    for view in views {
        for corner in &view.corners {
            let finite =
                [corner.in_board_mm, corner.pixel].iter().all(|p| p.iter().all(|v| v.abs() < 1e6));
            if !finite || !(1e-6..1e6).contains(&corner.sigma_px) {
                return Err(LensCalibrationError::ImpossibleCorner {
                    view: view.name.clone(),
                    id: corner.id,
                });
            }
        }
    }
    Ok(())
}

/// Lists the corners of all views with their points in the camera frame, mm.
fn points<'a>(
    views: &'a [BoardView],
    state: &'a State,
) -> impl Iterator<Item = (&'a CornerObservation, Point3<f64>)> {
    views.iter().zip(&state.cameras_from_board).flat_map(|(view, pose)| {
        view.corners.iter().map(move |corner| {
            (corner, pose.point(Point3::new(corner.in_board_mm.x, corner.in_board_mm.y, 0.0)))
        })
    })
}

/// Returns the largest angle between the optical axis and any corner, rad.
fn largest_angle(views: &[BoardView], state: &State) -> f64 {
    let angle = |point: Point3<f64>| point.x.hypot(point.y).atan2(point.z);
    points(views, state).map(|(_, point)| angle(point)).fold(0.0, f64::max)
}

/// Computes the root mean square length of all residuals, px.
fn rms_px(views: &[BoardView], state: &State) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (corner, point) in points(views, state) {
        if let Ok(pixel) = state.camera.project(&point) {
            sum += (corner.pixel - pixel).norm_squared();
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Computes the quality of a model's fit.
fn candidate(views: &[BoardView], model: LensModel, fit: Option<&BundleSolution>) -> LensCandidate {
    let coordinates: usize = views.iter().map(|view| 2 * view.corners.len()).sum();
    let n = coordinates as f64;
    let parameters = model.parameter_count();
    let fit = fit.map(|fit| CandidateFit {
        rms_px: rms_px(views, &fit.state),
        // Perfect data have no cost; nothing is divided by 0.
        held_out_rms_px: rms_px(views, &fit.state)
            * (fit.held_out.iter().sum::<f64>() / fit.cost.max(f64::MIN_POSITIVE)).sqrt(),
        // Perfect data have a cost of rounding errors only, whose logarithm is meaningless.
        criterion: n * (fit.cost / n).max(1e-12).ln() + parameters as f64 * n.ln(),
    });
    LensCandidate { model, parameters, fit }
}

/// Chooses among candidates from the simplest on: each must be better than the one before. Candidates whose parameters
/// the views do not determine are considered only if there are no others.
fn choose(
    candidates: &[LensCandidate],
    fits: &[(LensModel, Option<BundleSolution>)],
) -> Option<usize> {
    let fits = candidates.iter().zip(fits).enumerate();
    let fitted = fits.filter_map(|(i, (c, (_, fit)))| Some((i, c, c.fit?, fit.as_ref()?)));
    let (determined, others): (Vec<_>, Vec<_>) =
        fitted.partition(|(.., fit)| ScaledCholesky::new(&fit.informations.iter().sum()).is_some());
    let mut fitted = if determined.is_empty() { others } else { determined };
    // The sort is stable: of equally simple candidates the first comes first.
    fitted.sort_by_key(|(_, candidate, ..)| candidate.parameters);
    let mut fitted = fitted.into_iter();
    let mut chosen = fitted.next()?;
    for next in fitted {
        let strong = next.2.criterion < chosen.2.criterion - STRONG_EVIDENCE;
        let as_simple = next.1.parameters == chosen.1.parameters;
        if strong && (as_simple || predicts_better(&next.3.held_out, &chosen.3.held_out)) {
            chosen = next;
        }
    }
    Some(chosen.0)
}

/// Returns whether the costs of held-out views are lower by more than one standard error of their difference (L.
/// Breiman and others, "Classification and Regression Trees", 1984).
fn predicts_better(new: &[f64], old: &[f64]) -> bool {
    let [new_sum, old_sum] = [new, old].map(|costs| costs.iter().sum::<f64>());
    if !old_sum.is_finite() {
        // There are too few views to hold one out: the criterion alone decides.
        return true;
    }
    let count = new.len() as f64;
    let mean = (old_sum - new_sum) / count;
    let squares = new.iter().zip(old).map(|(new, old)| (old - new - mean).powi(2));
    let error = (squares.sum::<f64>() / (count - 1.0) / count).sqrt();
    mean > error
}

/// Derives the result from the chosen fit.
fn finish(
    views: &[BoardView],
    model: LensModel,
    candidates: Vec<LensCandidate>,
    fit: BundleSolution,
) -> Result<LensCalibration, LensCalibrationError> {
    let total: DMatrix<f64> = fit.informations.iter().sum();
    let not_observable =
        || LensCalibrationError::NotObservable { reason: advice::why_not_observable(&fit.state) };
    let factor = ScaledCholesky::new(&total).ok_or_else(not_observable)?;
    let covariance = factor.inverse() * fit.scale.powi(2);
    let focal_px = rays::focal(&fit.state.camera, &factor, fit.scale);
    let rays = rays::rays(views, &fit.state, &factor, fit.scale).ok_or_else(not_observable)?;
    let advice = advice::advise(views, &fit, &rays);
    let rms_px = rms_px(views, &fit.state);
    let solved = views.iter().zip(&fit.state.cameras_from_board).map(|(view, pose)| {
        let residuals_px: Vec<Vector2<f64>> = view
            .corners
            .iter()
            .filter_map(|c| bundle::residual(&fit.state.camera, pose, &c.in_board_mm, &c.pixel))
            .collect();
        let sum: f64 = residuals_px.iter().map(|r| r.norm_squared()).sum();
        SolvedView {
            name: view.name.clone(),
            camera_from_board: *pose,
            corners: view.corners.clone(),
            rms_px: (sum / residuals_px.len() as f64).sqrt(),
            residuals_px,
        }
    });
    Ok(LensCalibration {
        views: solved.collect(),
        // Boards are seen in air, so that this is the lens without the media of the sensor.
        estimate: CameraEstimate::new(fit.state.camera, Some(covariance))?.with_drawn_interface(),
        model,
        candidates,
        rms_px,
        residual_scale: fit.scale,
        focal_px,
        rays,
        advice,
    })
}
