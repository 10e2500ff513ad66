//! Alternative corner detector from OpenCV, for a comparison.
//!
//! OpenCV only locates the corners. The numbers of the corners and their standard deviations come from the same code as
//! for fabkit's own detector, so that results can be compared.

use fabkit_camera::{Point2, Vector2};
use opencv::calib3d::{self, find_chessboard_corners_sb};
use opencv::core::{
    Mat, MatTraitConst, Point2f, Size, TermCriteria, TermCriteria_COUNT, TermCriteria_EPS, Vector,
};
use opencv::imgproc::corner_sub_pix;

use super::grid::Grid;
use super::saddle::{self, Saddle};
use super::{Board, BoardKind, FoundCorner, NotFound, exposure, numbered, place};
use crate::image::GreyImage;

/// Standard deviation of the smoothing with which a corner's contrast is measured, px.
const SMOOTHING_PX: f64 = 1.5;
/// Half width of the window in which OpenCV refines a corner, px. Small, because a fisheye bends lines.
const REFINING_HALF_PX: i32 = 4;
/// Error that remains without noise, px, as measured on rendered boards (`tests/solver/boards.rs`).
const SYSTEMATIC_PX: f64 = 0.04;
/// Largest number of OpenCV's refinement steps.
const REFINING_STEPS: i32 = 30;
/// Length of a step, px, at which OpenCV's refinement ends.
const REFINING_STEP_PX: f64 = 1e-3;

/// Reason why OpenCV found no corners.
#[derive(Debug, thiserror::Error)]
pub enum OpenCvError {
    /// The board is a ChArUco board: OpenCV's module for them depends on its version. Checkerboards are the same in all
    /// versions.
    #[error("OpenCV's detector is offered for checkerboards, and this is a ChArUco board")]
    Charuco,
    /// The detector found no board.
    #[error(transparent)]
    NotFound(#[from] NotFound),
    /// OpenCV reported an error.
    #[error("OpenCV: {0}")]
    Failed(#[from] opencv::Error),
}

/// Finds a checkerboard's corners with OpenCV's `findChessboardCornersSB` (A. Duda and U. Frese, "Accurate Detection
/// and Localization of Checkerboard Corners for Calibration", BMVC 2018), sorted by id. `sigma_px` is predicted from
/// the image's noise and the corner's contrast, as in [`find_corners`](super::find_corners).
///
/// # Errors
/// Returns [`OpenCvError`] for a ChArUco board, a board that is not entirely in the image, or an error of OpenCV.
pub fn find_corners_opencv(
    image: &GreyImage,
    board: &Board,
) -> Result<Vec<FoundCorner>, OpenCvError> {
    if board.kind != BoardKind::Checkerboard {
        return Err(OpenCvError::Charuco);
    }
    let bytes: Vec<u8> = image
        .values()
        .iter()
        .map(|value| (255.0 * value).round().clamp(0.0, 255.0) as u8)
        .collect();
    let flat = Mat::from_slice(&bytes)?;
    let picture = flat.reshape(1, image.height_px() as i32)?;
    let [columns, rows] = board.inner_corners();
    let flags = calib3d::CALIB_CB_NORMALIZE_IMAGE
        | calib3d::CALIB_CB_EXHAUSTIVE
        | calib3d::CALIB_CB_ACCURACY;
    let mut corners = Vector::<Point2f>::new();
    let size = Size::new(columns as i32, rows as i32);
    if !find_chessboard_corners_sb(&picture, size, &mut corners, flags)? {
        return Err(exposure(image).unwrap_or(NotFound::NoGrid).into());
    }
    corner_sub_pix(
        &picture,
        &mut corners,
        Size::new(REFINING_HALF_PX, REFINING_HALF_PX),
        Size::new(-1, -1),
        TermCriteria::new(TermCriteria_COUNT + TermCriteria_EPS, REFINING_STEPS, REFINING_STEP_PX)?,
    )?;
    let points: Vec<Point2<f64>> =
        corners.iter().map(|p| Point2::new(f64::from(p.x), f64::from(p.y))).collect();
    let grid = grid(image, &points, columns);
    let placed = place::place(image, board, &[grid])?;
    Ok(numbered(placed, board, SYSTEMATIC_PX))
}

/// Arranges corners, given row by row, as a [`Grid`]: right-handed, and with light squares where its definition
/// requires them.
fn grid(image: &GreyImage, points: &[Point2<f64>], columns: usize) -> Grid {
    let mut rows: Vec<Vec<Point2<f64>>> = points.chunks_exact(columns).map(<[_]>::to_vec).collect();
    let turns: f64 = squares(&rows).map(|(_, [a, b, _, d])| (b - a).perp(&(d - a))).sum();
    // OpenCV may number the corners of a mirrored board: rows are then reversed.
    if turns < 0.0 {
        rows.iter_mut().for_each(|row| row.reverse());
    }
    let light_on_even: f64 = squares(&rows)
        .map(|((i, j), corners)| {
            let sum: Vector2<f64> = corners.iter().map(|corner| corner.coords).sum();
            let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
            let [x, y] = [0.25 * sum.x, 0.25 * sum.y].map(|v| v.round() as usize);
            sign * f64::from(image.at(x, y))
        })
        .sum();
    // If the squares with an even sum are dark, a shift by one column exchanges the colours.
    let shift = if light_on_even < 0.0 { 1 } else { 0 };
    let noise = saddle::noise(image);
    let mut grid = Grid::new();
    for (j, row) in rows.iter().enumerate() {
        for (i, at) in row.iter().enumerate() {
            // Without a saddle point there is no corner, whatever OpenCV says.
            if let Some(fine) = saddle::refine(image, *at, SMOOTHING_PX, noise) {
                grid.insert((i as i32 + shift, j as i32), Saddle { at: *at, ..fine });
            }
        }
    }
    grid
}

/// Lists each square's column and row, and its corners in the order of the image's axes.
fn squares(rows: &[Vec<Point2<f64>>]) -> impl Iterator<Item = ((usize, usize), [Point2<f64>; 4])> {
    rows.windows(2).enumerate().flat_map(|(j, pair)| {
        let [above, below] = [&pair[0], &pair[1]];
        let corners = |i| [above[i], above[i + 1], below[i + 1], below[i]];
        (0..above.len() - 1).map(move |i| ((i, j), corners(i)))
    })
}
