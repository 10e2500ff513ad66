//! Calibration boards: their printed pattern, and the detection of their corners in images.
//!
//! # Board frame
//!
//! As printed and seen from the front: origin at the upper left corner of the first square, +x to the right, +y down,
//! +z into the board; the corners lie at z = 0. This is OpenCV's convention.
//!
//! # Detection
//!
//! Saddle points of the intensity are candidates (`saddle`). Candidates joined by edges form grids (`grid`), whatever
//! the lens does to straight lines. A grid is located on the board by its outline or by its markers (`location`,
//! `marker`), and corners that do not fit their row and column are dropped.

mod corner_list;
pub mod dictionary;
mod document;
mod grid;
mod location;
mod marker;
#[cfg(feature = "opencv")]
mod opencv;
mod saddle;

use fabkit_camera::Point2;

pub use corner_list::{MAX_LIST_BYTES, read_corners};
pub use document::{
    Board, BoardCorner, BoardKind, BoardMarker, FORMAT, MAX_BYTES, MAX_SQUARES, MIN_SQUARES,
    VERSION,
};
#[cfg(feature = "opencv")]
pub use opencv::{OpenCvError, find_corners_opencv};

use crate::image::GreyImage;

/// Standard deviations of the smoothing with which candidates are searched, px: first for sharp images, then for
/// blurred or very large ones, then for very small squares.
const SCALES_PX: [f64; 4] = [1.5, 3.0, 1.0, 6.0];
/// Error that remains without noise, px, because pixels are squares and distortion is not locally affine. Measured on
/// rendered boards.
const SYSTEMATIC_PX: f64 = 0.02;

/// Smallest intensity of a saturated pixel, where white is 1.
const SATURATED: f32 = 0.995;
/// Percentage of saturated pixels that explains why no board is found.
const SATURATED_PERCENT: u32 = 30;
/// Smallest range of intensities, between the darkest and the brightest hundredth of the pixels, of an image with
/// contrast.
const MIN_INTENSITY_RANGE: f32 = 0.04;

/// Corner of the board, found in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectedCorner {
    /// Number of the corner on the board.
    pub id: u32,
    /// Column and row, px; the centre of the first pixel is (0, 0).
    pub pixel: Point2<f64>,
    /// Standard deviation in each direction, px, predicted from the image's noise and the corner's contrast.
    pub sigma_px: f64,
}

/// Reason why no board was found.
///
/// ```
/// use fabkit_calibration::board::{Board, BoardNotFound, find_corners};
/// use fabkit_calibration::image::GreyImage;
/// let board = Board::checkerboard("test", [9, 6], 2.5)?;
/// let find = |value: f32| {
///     let image = GreyImage::new(128, 96, vec![value; 128 * 96]).unwrap();
///     find_corners(&image, &board).unwrap_err()
/// };
/// // The exposure explains more than that there is no grid.
/// assert_eq!(find(1.0), BoardNotFound::Saturated { percent: 100 });
/// assert_eq!(find(0.5), BoardNotFound::NoContrast);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BoardNotFound {
    /// Too many pixels are white.
    #[error("{percent} % of the image is saturated: lower the exposure")]
    Saturated {
        /// Percentage of saturated pixels.
        percent: u32,
    },
    /// All pixels have nearly the same intensity.
    #[error("the image has no contrast: is there light, is the lens uncovered?")]
    NoContrast,
    /// The image shows no grid of corners.
    #[error("no grid of dark and light squares is to be seen")]
    NoGrid,
    /// The largest grid does not have the size of the checkerboard.
    #[error(
        "a checkerboard must be in sight as a whole: a grid of {found} corners was found, and the \
         board has {expected}"
    )]
    Incomplete {
        /// Number of corners of the largest grid.
        found: usize,
        /// Number of corners of the board.
        expected: usize,
    },
    /// There are squares, but too few markers of this board.
    #[error("{read} markers of this board could be read, and {needed} must agree")]
    NoMarkers {
        /// Number of markers that agree.
        read: usize,
        /// Number of markers that must agree.
        needed: usize,
    },
}

/// Finds a board's corners, sorted by id.
///
/// # Errors
/// Returns [`BoardNotFound`] for an image without contrast, no grid, a checkerboard that is not entirely in the image, or a
/// ChArUco board without legible markers.
///
/// ```
/// use fabkit_calibration::board::{Board, find_corners};
/// use fabkit_calibration::image::GreyImage;
/// let board = Board::checkerboard("test", [7, 6], 2.5)?;
/// // Squares of 20 px on a white sheet; the first pixel of the first square is (30, 20).
/// let value = |i: usize| {
///     let (x, y) = ((i % 200) as i32 - 30, (i / 200) as i32 - 20);
///     let is_on_board = (0..140).contains(&x) && (0..120).contains(&y);
///     if is_on_board && (x / 20 + y / 20) % 2 == 0 { 0.1 } else { 0.9 }
/// };
/// let image = GreyImage::new(200, 160, (0..200 * 160).map(value).collect())?;
/// let corners = find_corners(&image, &board)?;
/// assert_eq!(corners.len(), 6 * 5);
/// // Pixel centres lie at integers: the edge between columns 49 and 50 is at 49.5.
/// let first = corners[0].pixel;
/// assert!((first.x - 49.5).abs() < 0.05 && (first.y - 39.5).abs() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn find_corners(
    image: &GreyImage,
    board: &Board,
) -> Result<Vec<DetectedCorner>, BoardNotFound> {
    let noise = saddle::noise(image);
    let mut best: Result<Vec<DetectedCorner>, BoardNotFound> = Err(BoardNotFound::NoGrid);
    for sigma_px in SCALES_PX {
        let scene = grid::BoardImage { image, noise, sigma_px };
        let found = find_at_scale(&scene, board);
        let is_complete = matches!(&found, Ok(corners) if corners.len() == board.corners.len());
        let is_better = match (&found, &best) {
            (Ok(new), Ok(old)) => new.len() > old.len(),
            (Ok(_), Err(_)) => true,
            // Of two failures the one that got farther says more.
            (Err(new), Err(old)) => *old == BoardNotFound::NoGrid && *new != BoardNotFound::NoGrid,
            (Err(_), Ok(_)) => false,
        };
        if is_better {
            best = found;
        }
        if is_complete {
            break;
        }
    }
    best.map_err(|why| find_exposure_problem(image).unwrap_or(why))
}

/// Returns an exposure problem, if one explains that no board was found.
fn find_exposure_problem(image: &GreyImage) -> Option<BoardNotFound> {
    let mut values = image.values().to_vec();
    let count = values.len();
    let saturated = values.iter().filter(|v| **v >= SATURATED).count();
    let percent = (100 * saturated / count) as u32;
    if percent >= SATURATED_PERCENT {
        return Some(BoardNotFound::Saturated { percent });
    }
    let mut quantile = |index: usize| *values.select_nth_unstable_by(index, f32::total_cmp).1;
    // Hundredths instead of extremes, so that a few hot or dead pixels do not count.
    let range = quantile(count - 1 - count / 100) - quantile(count / 100);
    (range < MIN_INTENSITY_RANGE).then_some(BoardNotFound::NoContrast)
}

/// Finds the corners with one smoothing.
fn find_at_scale(
    scene: &grid::BoardImage,
    board: &Board,
) -> Result<Vec<DetectedCorner>, BoardNotFound> {
    let saddles = saddle::find(scene.image, scene.sigma_px, scene.noise);
    let mut grids = grid::find_grids(scene, &saddles);
    for grid in &mut grids {
        grid::refine_saddles(scene, grid);
    }
    let placed = location::locate(scene.image, board, &grids)?;
    Ok(number_corners(placed, board, SYSTEMATIC_PX))
}

/// Lists a placed grid's corners by id; `systematic_px` is the detector's error without noise.
fn number_corners(placed: grid::Grid, board: &Board, systematic_px: f64) -> Vec<DetectedCorner> {
    let [columns, _] = board.inner_corners();
    let mut corners: Vec<DetectedCorner> = placed
        .into_iter()
        .map(|((column, row), saddle)| DetectedCorner {
            id: row as u32 * columns as u32 + column as u32,
            pixel: saddle.at,
            sigma_px: saddle.noise_px.hypot(systematic_px),
        })
        .collect();
    corners.sort_by_key(|corner| corner.id);
    corners
}
