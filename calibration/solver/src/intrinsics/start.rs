//! Start of a calibration: from the sensor's nominal lens to a first camera and first poses.

use fabkit_camera::{Camera, Intrinsics, Vector3};
use fabkit_geometry::Pose;

use super::bundle::{self, State};
use super::{BoardView, planar};

/// Multiples of the nominal focal length that are tried: a data sheet's angle of view may be inaccurate, or refer to
/// another side of the image.
const FOCAL_FACTORS: [f64; 9] = [1.0, 0.85, 1.18, 0.72, 1.4, 0.6, 1.65, 0.5, 2.0];

/// Finds the focal length, of those tried, under which the boards look flattest, and refines the nominal camera with it
/// and the poses. `None` if under every focal length some view has no pose.
pub(super) fn initial_state(views: &[BoardView], nominal: &Camera) -> Option<State> {
    let mut best: Option<(f64, State)> = None;
    for factor in FOCAL_FACTORS {
        // Some lenses do not exist at a multiple of their focal length.
        let Some(camera) = with_focal_factor(nominal, factor) else { continue };
        let Some(cameras_from_board) =
            views.iter().map(|view| pose(&camera, view)).collect::<Option<Vec<_>>>()
        else {
            continue;
        };
        let state = State { camera, cameras_from_board };
        // The median tolerates corners that were misread.
        let Some(error) = median_px(views, &state) else { continue };
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, state));
        }
    }
    let (_, state) = best?;
    // Focal length and centre first: coefficients would diverge while the poses are inaccurate.
    let mut free = vec![false; state.camera.parameter_count()];
    free[..4].fill(true);
    bundle::fit(views, state, &free).map(|fit| fit.state)
}

/// Finds the board's pose in one view under an approximate camera.
pub(super) fn pose(camera: &Camera, view: &BoardView) -> Option<Pose> {
    let mut corners_mm = Vec::new();
    let mut rays: Vec<Vector3<f64>> = Vec::new();
    for corner in &view.corners {
        if let Ok(ray) = camera.unproject(&corner.pixel) {
            corners_mm.push(corner.in_board_mm);
            rays.push(ray.direction);
        }
    }
    planar::pose_from_rays(&corners_mm, &rays)
}

fn with_focal_factor(nominal: &Camera, factor: f64) -> Option<Camera> {
    let mut values: Vec<f64> = nominal.parameters().iter().map(|(_, value)| *value).collect();
    let Intrinsics { fx_px, fy_px, .. } = nominal.lens().intrinsics();
    [values[0], values[1]] = [fx_px * factor, fy_px * factor];
    nominal.with_parameters(&values).ok()
}

/// Computes the median length of residuals, px; `None` if it is infinite.
fn median_px(views: &[BoardView], state: &State) -> Option<f64> {
    let pairs = views.iter().zip(&state.cameras_from_board);
    let mut lengths: Vec<f64> = pairs
        .flat_map(|(view, pose)| view.corners.iter().map(move |corner| (corner, pose)))
        .map(|(corner, pose)| {
            bundle::residual(&state.camera, pose, &corner.in_board_mm, &corner.pixel)
                .map_or(f64::INFINITY, |residual| residual.norm())
        })
        .collect();
    let middle = lengths.len() / 2;
    let (_, median, _) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
    median.is_finite().then_some(*median)
}
