//! Advice on a calibration: what the images do not determine, in numbers and in words.

use fabkit_camera::{Camera, Point2, Vector3};
use nalgebra::DMatrix;

use super::bundle::{BundleSolution, State};
use super::{BoardView, RaySigma, RayUncertainty, largest_angle};
use crate::information::ScaledCholesky;

/// Numbers of columns and rows of the coverage map.
pub const COVERAGE: [usize; 2] = [8, 6];
/// Largest uncertainty of rays at observed corners without a warning, px: several times the uncertainty of a corner.
const RAY_LIMIT_PX: f64 = 0.5;
/// Largest uncertainty of rays in the rest of the image without a warning, px.
const EXTRAPOLATED_LIMIT_PX: f64 = 2.0;
/// Largest tilt against the image plane, degrees, of boards that count as frontal.
const FRONTAL_DEG: f64 = 15.0;
/// Largest decrease of a parameter's standard deviation, as a fraction of an equal share, of a view that adds nothing.
const MIN_FAIR_FRACTION: f64 = 0.2;
/// Ratio of a view's residuals to the typical ones from which the view is reported.
const BAD_VIEW: f64 = 3.0;
/// Ratio of all residuals to those that the detector states from which they are reported.
const BAD_SCALE: f64 = 3.0;
/// Smallest fraction of the image's cells with corners that needs no warning.
const MIN_COVERAGE: f64 = 0.6;

/// Distribution of the corners over the image.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageCoverage {
    /// Number of corners in each cell of the image, [`COVERAGE`] columns and rows, row by row.
    pub corners: Vec<usize>,
    /// Fraction of cells with at least one corner, 0 to 1.
    pub covered_fraction: f64,
    /// Largest angle between a corner and the optical axis, degrees.
    pub observed_max_angle_deg: f64,
    /// Angle between the image's farthest corner and the optical axis, limited to the lens's domain, degrees.
    pub image_max_angle_deg: f64,
}

/// Contribution of one view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewInfluence {
    /// Largest growth of a parameter's standard deviation without this view: 0.05 for 5 %; infinite if the others do
    /// not determine the camera.
    pub growth: f64,
    /// Angle between the board and the image plane, degrees.
    pub tilt_deg: f64,
    /// True if the view could be left out without loss.
    pub adds_nothing: bool,
}

/// Advice on a calibration: gaps in the data, and how to close them.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationAdvice {
    /// Distribution of the corners over the image.
    pub coverage: ImageCoverage,
    /// Contribution of each view.
    pub influence: Vec<ViewInfluence>,
    /// Warnings in words, the most important first; empty if all is well.
    pub warnings: Vec<String>,
}

/// Examines a calibration and formulates warnings.
pub(super) fn advise(
    views: &[BoardView],
    fit: &BundleSolution,
    rays: &RayUncertainty,
) -> CalibrationAdvice {
    let coverage = coverage(views, &fit.state);
    let influence = influence(fit);
    let mut warnings = Vec::new();
    if rays.observed.worst.px > RAY_LIMIT_PX {
        let known = format!(
            "rays are known only to {} where corners were seen",
            format_sigma(&rays.observed.worst)
        );
        warnings.push(if are_frontal(&fit.state) {
            format!("{known}: {FRONTAL}")
        } else {
            format!(
                "{known}: add views with the board tilted by 30 to 45 degrees, to all sides, near \
                 and far"
            )
        });
    }
    warnings.extend(misfits(views, fit));
    if coverage.covered_fraction < MIN_COVERAGE {
        warnings.push(format!(
            "corners cover {:.0} % of the image; none {}",
            100.0 * coverage.covered_fraction,
            empty_parts(&coverage.corners)
        ));
    }
    let beyond = rays.extrapolated.map(|beyond| beyond.worst);
    let is_wide = coverage.observed_max_angle_deg < 0.8 * coverage.image_max_angle_deg;
    if let Some(worst) = beyond.filter(|worst| is_wide || worst.px > EXTRAPOLATED_LIMIT_PX) {
        warnings.push(format!(
            "corners reach {:.0} degrees off the axis, the image {:.0}: beyond the corners the lens model extrapolates, rays to {} at worst; add views with the board at the image's border",
            coverage.observed_max_angle_deg,
            coverage.image_max_angle_deg,
            format_sigma(&worst)
        ));
    }
    let idle: Vec<&str> = (views.iter().zip(&influence))
        .filter(|(_, influence)| influence.adds_nothing)
        .map(|(view, _)| view.name.as_str())
        .collect();
    if !idle.is_empty() {
        warnings.push(format!("nothing would be lost without {}", idle.join(", ")));
    }
    CalibrationAdvice { coverage, influence, warnings }
}

/// Formats an uncertainty like `0.21 mrad (0.06 px)`.
fn format_sigma(sigma: &RaySigma) -> String {
    format!("{:.2} mrad ({:.2} px)", 1e3 * sigma.angle_rad, sigma.px)
}

const FRONTAL: &str = "the board is nearly parallel to the image in all views, so that a longer \
                       focal length looks like a shorter distance; tilt the board by 30 to 45 \
                       degrees, to all sides";

/// Returns the probable cause of a singular information matrix, judged by the poses.
pub(super) fn why_not_observable(state: &State) -> String {
    if are_frontal(state) {
        FRONTAL.into()
    } else {
        "show the board tilted to all sides, near and far, in the middle and at the borders".into()
    }
}

fn tilt_deg(normal_in_camera: Vector3<f64>) -> f64 {
    normal_in_camera.z.abs().min(1.0).acos().to_degrees()
}

fn are_frontal(state: &State) -> bool {
    let normals = state.cameras_from_board.iter().map(|pose| pose.vector(Vector3::z()));
    normals.map(tilt_deg).all(|tilt| tilt < FRONTAL_DEG)
}

/// Computes the influence of each view.
fn influence(fit: &BundleSolution) -> Vec<ViewInfluence> {
    let count = fit.informations.len();
    let total: DMatrix<f64> = fit.informations.iter().sum();
    let with = ScaledCholesky::new(&total).map(|factor| factor.inverse());
    // Growth without one of `count` views with equal information.
    let fair = (count as f64 / (count as f64 - 1.0)).sqrt() - 1.0;
    let one = |(without, pose): (&DMatrix<f64>, &fabkit_geometry::Pose)| {
        let others = ScaledCholesky::new(&(&total - without)).map(|factor| factor.inverse());
        let growth = match (&with, others) {
            (Some(with), Some(others)) => {
                // The parameter that suffers most without the view counts.
                let ratios =
                    (0..with.nrows()).map(|i| (others[(i, i)] / with[(i, i)]).sqrt() - 1.0);
                ratios.fold(0.0, f64::max)
            }
            _ => f64::INFINITY,
        };
        ViewInfluence {
            growth,
            tilt_deg: tilt_deg(pose.vector(Vector3::z())),
            adds_nothing: growth < MIN_FAIR_FRACTION * fair,
        }
    };
    fit.informations.iter().zip(&fit.state.cameras_from_board).map(one).collect()
}

/// Counts the corners in each cell of the image.
fn coverage(views: &[BoardView], state: &State) -> ImageCoverage {
    let camera = &state.camera;
    let [columns, rows] = COVERAGE;
    let mut corners = vec![0; columns * rows];
    let cell = |at: f64, size_px: u32, cells: usize| {
        let part = (at + 0.5) / f64::from(size_px) * cells as f64;
        (0.0..cells as f64).contains(&part).then_some(part as usize)
    };
    for corner in views.iter().flat_map(|view| &view.corners) {
        let column = cell(corner.pixel.x, camera.width_px(), columns);
        let row = cell(corner.pixel.y, camera.height_px(), rows);
        if let Some((column, row)) = column.zip(row) {
            corners[row * columns + column] += 1;
        }
    }
    let covered = corners.iter().filter(|n| **n > 0).count();
    ImageCoverage {
        covered_fraction: covered as f64 / corners.len() as f64,
        corners,
        observed_max_angle_deg: largest_angle(views, state).to_degrees(),
        image_max_angle_deg: image_angle_deg(camera),
    }
}

/// Returns the angle between the optical axis and the farthest pixel that the lens maps, degrees.
fn image_angle_deg(camera: &Camera) -> f64 {
    let [right, bottom] = [camera.width_px(), camera.height_px()].map(|n| f64::from(n) - 1.0);
    let corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)];
    let angles = corners.map(|(x, y)| match camera.unproject(&Point2::new(x, y)) {
        Ok(ray) => ray.direction.z.clamp(-1.0, 1.0).acos(),
        Err(_) => camera.angle_limit_rad(),
    });
    angles.into_iter().fold(0.0, f64::max).to_degrees()
}

/// Reports views with exceptional residuals, and residuals that are large as a whole.
fn misfits(views: &[BoardView], fit: &BundleSolution) -> Vec<String> {
    let scales: Vec<f64> = (views.iter().zip(&fit.state.cameras_from_board))
        .map(|(view, pose)| {
            let sum: f64 = view
                .corners
                .iter()
                .filter_map(|c| {
                    let r =
                        super::bundle::residual(&fit.state.camera, pose, &c.in_board_mm, &c.pixel)?;
                    Some((r.norm() / c.sigma_px).powi(2))
                })
                .sum();
            (0.5 * sum / view.corners.len() as f64).sqrt()
        })
        .collect();
    let mut sorted = scales.clone();
    sorted.sort_by(f64::total_cmp);
    let typical = sorted[sorted.len() / 2];
    let mut warnings = Vec::new();
    for (view, scale) in views.iter().zip(&scales) {
        if *scale > BAD_VIEW * typical {
            warnings.push(format!(
                "{}: residuals are {:.1} times those of the other views; is it blurred, or the board \
                 bent or partly hidden?",
                view.name,
                scale / typical
            ));
        }
    }
    if fit.scale > BAD_SCALE {
        warnings.push(format!(
            "residuals are {:.1} times the detector's noise: is the board flat, is it this board, is the lens behind a window or gel?",
            fit.scale
        ));
    }
    warnings
}

/// Names the empty ninths of the image, for example `upper left, middle right`.
fn empty_parts(corners: &[usize]) -> String {
    let [columns, rows] = COVERAGE;
    let thirds = |i: usize, n: usize| 3 * i / n;
    let mut empty = Vec::new();
    for (v, vertical) in ["upper", "middle", "lower"].into_iter().enumerate() {
        for (h, horizontal) in ["left", "middle", "right"].into_iter().enumerate() {
            let cells = (0..columns * rows)
                .filter(|i| thirds(i / columns, rows) == v && thirds(i % columns, columns) == h);
            if cells.clone().all(|i| corners[i] == 0) {
                empty.push(match (vertical, horizontal) {
                    ("middle", "middle") => "in the middle".to_owned(),
                    (vertical, horizontal) => format!("{vertical} {horizontal}"),
                });
            }
        }
    }
    if empty.is_empty() { "in scattered places".into() } else { empty.join(", ") }
}
