//! A camera's intrinsics from pictures of a board.
//!
//! The start is the nominal lens of the sensor's design; the poses follow from rays (`planar`,
//! `start`); camera and poses are then refined together (`bundle`) under each lens model
//! (`models`), and the pictures choose among them by the Bayesian information criterion. The
//! covariance is that of the residuals actually found, and what the pictures do not tell is said
//! in words (`advice`).
//!
//! The board's scale is not among the unknowns: a board printed at 101 % moves all poses by 1 %
//! and leaves the camera as it is.

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
pub use advice::{Advice, COVERAGE, ImageCoverage, ViewInfluence};
use bundle::{BundleSolution, State};
pub use rays::{GRID, RaySigma, RaySigmas, Rays};

/// Fewer views cannot tell the camera from the poses.
pub const MIN_VIEWS: usize = 3;
/// Most views that are solved together.
pub const MAX_VIEWS: usize = 1000;
/// Fewest corners that make a view.
pub const MIN_CORNERS: usize = planar::MIN_CORNERS;
/// A model is taken instead of one that is as simple or simpler if the information criterion is
/// lower by more than this: "very strong" evidence (R. Kass and A. Raftery, "Bayes Factors", JASA
/// 1995).
pub const STRONG_EVIDENCE: f64 = 10.0;

/// A corner of the board seen in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerObservation {
    /// Which corner.
    pub id: u32,
    /// Where it is on the board: x and y, mm.
    pub in_board_mm: Point2<f64>,
    /// Where it is seen: column and row.
    pub pixel: Point2<f64>,
    /// Standard deviation in each direction, px. Only ratios matter: the scale follows from the
    /// residuals.
    pub sigma_px: f64,
}

/// One picture of the board.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardView {
    /// What messages call it, for example its file.
    pub name: String,
    /// What is seen of the board.
    pub corners: Vec<CornerObservation>,
}

/// A view after calibration.
#[derive(Clone, Debug)]
pub struct SolvedView {
    /// As in [`BoardView`].
    pub name: String,
    /// Board frame to camera frame.
    pub camera_from_board: Pose,
    /// What was used.
    pub corners: Vec<CornerObservation>,
    /// Observed minus projected, px, for each corner.
    pub residuals_px: Vec<Vector2<f64>>,
    /// Root mean square length of the residuals, px.
    pub rms_px: f64,
}

/// How well a lens model explains the pictures.
#[derive(Clone, Debug)]
pub struct LensCandidate {
    /// Which.
    pub model: LensModel,
    /// Its parameters.
    pub parameters: usize,
    /// Root mean square length of the residuals, px, and the Bayesian information criterion;
    /// nothing if the model cannot see what the pictures show.
    pub fit: Option<CandidateFit>,
}

/// See [`LensCandidate`].
#[derive(Clone, Copy, Debug)]
pub struct CandidateFit {
    /// Root mean square length of the residuals, px.
    pub rms_px: f64,
    /// The same for each view as if it had taken no part, to first order; infinite where the others
    /// do not determine the camera.
    pub held_out_rms_px: f64,
    /// `n ln(cost / n) + p ln n` for `n` coordinates and `p` parameters of the lens; only
    /// differences mean something.
    pub criterion: f64,
}

/// A calibrated camera and what is to be said about it.
#[derive(Clone, Debug)]
pub struct LensCalibration {
    /// The camera with the covariance of its parameters.
    pub estimate: CameraEstimate,
    /// The model chosen.
    pub model: LensModel,
    /// All models tried, in the order of preference.
    pub candidates: Vec<LensCandidate>,
    /// The views used.
    pub views: Vec<SolvedView>,
    /// Root mean square length of all residuals, px.
    pub rms_px: f64,
    /// Standard deviation of the residuals in those that the views state: 1 if corners are as good
    /// as the detector says and lens and board are as modelled.
    pub residual_scale: f64,
    /// Scale of the image on the axis, px per radian, with its standard deviation: what models
    /// with different parameters have in common. From columns.
    pub focal_px: [f64; 2],
    /// How well rays are known, whatever parameters are.
    pub rays: Rays,
    /// What the pictures do not tell.
    pub advice: Advice,
}

/// Why there is no calibration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// Too few pictures show the board.
    #[error(
        "views with at least {MIN_CORNERS} corners of the board: {usable}; {MIN_VIEWS} are needed"
    )]
    TooFewViews {
        /// How many do.
        usable: usize,
    },
    /// Too many.
    #[error("{views} views; at most {MAX_VIEWS} are solved together")]
    TooManyViews {
        /// How many.
        views: usize,
    },
    /// A coordinate is not a number, or a standard deviation is not above 0.
    #[error("{view}: corner {id} has impossible coordinates or an impossible sigma")]
    Impossible {
        /// Which view.
        view: String,
        /// Which corner.
        id: u32,
    },
    /// In no way does the board look flat.
    #[error(
        "no pose of the board explains what is seen, with the nominal focal length of {focal_px:.0} px \
         per radian or half or twice that"
    )]
    NoStart {
        /// Of the nominal camera.
        focal_px: f64,
    },
    /// No lens model fits.
    #[error("none of the lens models ({}) fits these views", .tried.join(", "))]
    NoModel {
        /// What was tried.
        tried: Vec<&'static str>,
    },
    /// Some combination of the camera's parameters can change without a trace in these views.
    #[error("these views do not determine the camera: {reason}")]
    NotObservable {
        /// Why, as far as it can be told.
        reason: String,
    },
    /// Numbers beyond what can be computed with.
    #[error("the covariance cannot be computed: {0}")]
    Covariance(#[from] InvalidCovariance),
}

/// Calibrates a camera, beginning at the nominal one of the sensor's design.
///
/// Of `models` the simplest is taken, with the fewest parameters; of those as simple the first.
/// Another needs strong evidence on its side ([`STRONG_EVIDENCE`]), and if it has more parameters,
/// an error on views that are held out that is lower by more than its standard error. Views with fewer than [`MIN_CORNERS`] corners are left out.
///
/// # Errors
/// [`CalibrateError`].
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
) -> Result<LensCalibration, CalibrateError> {
    if views.len() > MAX_VIEWS {
        return Err(CalibrateError::TooManyViews { views: views.len() });
    }
    check(views)?;
    let views: Vec<BoardView> =
        views.iter().filter(|view| view.corners.len() >= MIN_CORNERS).cloned().collect();
    if views.len() < MIN_VIEWS {
        return Err(CalibrateError::TooFewViews { usable: views.len() });
    }
    let no_start = || CalibrateError::NoStart { focal_px: nominal.lens().intrinsics().fx_px };
    let rough = start::state(&views, nominal).ok_or_else(no_start)?;
    let angle_rad = largest_angle(&views, &rough);
    let mut fits = Vec::new();
    for &model in models {
        let fit = models::like(model, &rough.camera, angle_rad).and_then(|camera| {
            let free = vec![true; camera.parameter_count()];
            bundle::fit(&views, State { camera, ..rough.clone() }, &free)
        });
        fits.push((model, fit));
    }
    let candidates: Vec<LensCandidate> =
        fits.iter().map(|(model, fit)| candidate(&views, *model, fit.as_ref())).collect();
    let chosen = choose(&candidates, &fits).ok_or_else(|| CalibrateError::NoModel {
        tried: models.iter().map(|model| model.name()).collect(),
    })?;
    let (model, fit) = fits.swap_remove(chosen);
    let fit = fit.expect("a chosen model has a fit");
    finish(&views, model, candidates, fit)
}

fn check(views: &[BoardView]) -> Result<(), CalibrateError> {
    for view in views {
        for corner in &view.corners {
            let finite =
                [corner.in_board_mm, corner.pixel].iter().all(|p| p.iter().all(|v| v.abs() < 1e6));
            if !finite || !(1e-6..1e6).contains(&corner.sigma_px) {
                return Err(CalibrateError::Impossible { view: view.name.clone(), id: corner.id });
            }
        }
    }
    Ok(())
}

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

/// Between the optical axis and any corner.
fn largest_angle(views: &[BoardView], state: &State) -> f64 {
    let angle = |point: Point3<f64>| point.x.hypot(point.y).atan2(point.z);
    points(views, state).map(|(_, point)| angle(point)).fold(0.0, f64::max)
}

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

fn candidate(views: &[BoardView], model: LensModel, fit: Option<&BundleSolution>) -> LensCandidate {
    let coordinates: usize = views.iter().map(|view| 2 * view.corners.len()).sum();
    let n = coordinates as f64;
    let parameters = model.parameter_count();
    let fit = fit.map(|fit| CandidateFit {
        rms_px: rms_px(views, &fit.state),
        // Perfect data cost nothing.
        held_out_rms_px: rms_px(views, &fit.state)
            * (fit.held_out.iter().sum::<f64>() / fit.cost.max(f64::MIN_POSITIVE)).sqrt(),
        // Perfect data have a cost of rounding alone, whose logarithm says nothing.
        criterion: n * (fit.cost / n).max(1e-12).ln() + parameters as f64 * n.ln(),
    });
    LensCandidate { model, parameters, fit }
}

/// Candidates from the simplest on; each has to show that it is worth more than the one before. Those
/// whose parameters the views do not determine stand back.
fn choose(
    candidates: &[LensCandidate],
    fits: &[(LensModel, Option<BundleSolution>)],
) -> Option<usize> {
    let fits = candidates.iter().zip(fits).enumerate();
    let fitted = fits.filter_map(|(i, (c, (_, fit)))| Some((i, c, c.fit?, fit.as_ref()?)));
    let (determined, others): (Vec<_>, Vec<_>) =
        fitted.partition(|(.., fit)| ScaledCholesky::new(&fit.informations.iter().sum()).is_some());
    let mut fitted = if determined.is_empty() { others } else { determined };
    // Stable: of those as simple, the first is asked first.
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

/// Whether costs of views that were held out are lower by more than one standard error of their
/// difference (L. Breiman and others, "Classification and Regression Trees", 1984).
fn predicts_better(new: &[f64], old: &[f64]) -> bool {
    let [new_sum, old_sum] = [new, old].map(|costs| costs.iter().sum::<f64>());
    if !old_sum.is_finite() {
        // Too few views to hold one out: the criterion alone.
        return true;
    }
    let count = new.len() as f64;
    let mean = (old_sum - new_sum) / count;
    let squares = new.iter().zip(old).map(|(new, old)| (old - new - mean).powi(2));
    let error = (squares.sum::<f64>() / (count - 1.0) / count).sqrt();
    mean > error
}

fn finish(
    views: &[BoardView],
    model: LensModel,
    candidates: Vec<LensCandidate>,
    fit: BundleSolution,
) -> Result<LensCalibration, CalibrateError> {
    let total: DMatrix<f64> = fit.informations.iter().sum();
    let not_observable =
        || CalibrateError::NotObservable { reason: advice::why_not_observable(&fit.state) };
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
        // Boards are looked at in air: this is the lens by itself.
        estimate: CameraEstimate::new(fit.state.camera, Some(covariance))?.behind_drawing(),
        model,
        candidates,
        rms_px,
        residual_scale: fit.scale,
        focal_px,
        rays,
        advice,
    })
}
