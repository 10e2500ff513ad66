//! Calibration boards: what is printed on them, and finding their corners in pictures.
//!
//! # Board frame
//!
//! As printed and seen from the front: origin at the upper left corner of the first square, +x to
//! the right, +y down, +z into the board; the corners lie at z = 0. The same convention as
//! OpenCV's.
//!
//! # How corners are found
//!
//! Saddles of brightness are candidates (`saddle`); candidates joined by edges form grids (`grid`),
//! whatever the lens does to lines; a grid is laid on the board by its outline or by its markers
//! (`place`, `marker`); and what does not fit its row and its column is dropped.

mod document;
mod grid;
mod list;
mod marker;
#[cfg(feature = "opencv")]
mod opencv;
mod place;
mod saddle;

use fabkit_camera::Point2;

pub use document::{
    Board, BoardCorner, BoardKind, BoardMarker, FORMAT, MAX_BYTES, MAX_SQUARES, MIN_SQUARES,
    VERSION,
};
pub use list::{MAX_LIST_BYTES, read_corners};
#[cfg(feature = "opencv")]
pub use opencv::{OpenCvError, find_corners_opencv};

use crate::image::GreyImage;

/// Smoothing with which candidates are sought, px: sharp pictures first, then blurred or very
/// large ones, then very small squares.
const SCALES_PX: [f64; 4] = [1.5, 3.0, 1.0, 6.0];
/// What remains of an error without noise: pixels are squares and distortion is not locally
/// affine. As measured on rendered boards.
const SYSTEMATIC_PX: f64 = 0.02;

/// Brightness from which a pixel counts as saturated.
const SATURATED: f32 = 0.995;
/// The saturated part of a picture, percent, that explains why no board is found.
const SATURATED_PERCENT: u32 = 30;
/// Brightness between the darkest and the brightest hundredth of a picture below which it shows
/// nothing.
const LEAST_RANGE: f32 = 0.04;

/// A corner of the board in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundCorner {
    /// Which corner of the board.
    pub id: u32,
    /// Column and row; the centre of the first pixel is (0, 0).
    pub pixel: Point2<f64>,
    /// Standard deviation in each direction, as the picture's noise and the corner's contrast
    /// predict it, px.
    pub sigma_px: f64,
}

/// Why no board was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotFound {
    /// White where the board should be.
    #[error("{percent} % of the picture is saturated: lower the exposure")]
    Saturated {
        /// Percent of all pixels.
        percent: u32,
    },
    /// One brightness all over.
    #[error("the picture has no contrast: is there light, is the lens uncovered?")]
    Flat,
    /// No grid of corners.
    #[error("no grid of dark and light squares is to be seen")]
    NoGrid,
    /// The largest grid is not the board.
    #[error(
        "a checkerboard must be in sight as a whole: a grid of {found} corners was found, and the \
         board has {expected}"
    )]
    Incomplete {
        /// Corners of the largest grid.
        found: usize,
        /// Corners of the board.
        expected: usize,
    },
    /// Squares but no markers, or not the board's.
    #[error("{read} markers of this board could be read, and {needed} must agree")]
    NoMarkers {
        /// How many agreed.
        read: usize,
        /// How many must.
        needed: usize,
    },
}

/// Finds a board's corners, sorted by id.
///
/// # Errors
/// [`NotFound`]: a picture without contrast, no grid, a checkerboard that is not in sight as a whole, a ChArUco board without
/// legible markers.
pub fn find_corners(image: &GreyImage, board: &Board) -> Result<Vec<FoundCorner>, NotFound> {
    let noise = saddle::noise(image);
    let mut best: Result<Vec<FoundCorner>, NotFound> = Err(NotFound::NoGrid);
    for sigma_px in SCALES_PX {
        let scene = grid::BoardPicture { image, noise, sigma_px };
        let found = find_at_scale(&scene, board);
        let is_complete = matches!(&found, Ok(corners) if corners.len() == board.corners.len());
        let is_better = match (&found, &best) {
            (Ok(new), Ok(old)) => new.len() > old.len(),
            (Ok(_), Err(_)) => true,
            // The reason that got farther says more.
            (Err(new), Err(old)) => *old == NotFound::NoGrid && *new != NotFound::NoGrid,
            (Err(_), Ok(_)) => false,
        };
        if is_better {
            best = found;
        }
        if is_complete {
            break;
        }
    }
    best.map_err(|why| exposure(image).unwrap_or(why))
}

/// Whether the exposure is to blame.
fn exposure(image: &GreyImage) -> Option<NotFound> {
    let mut values = image.values().to_vec();
    let count = values.len();
    let saturated = values.iter().filter(|v| **v >= SATURATED).count();
    let percent = (100 * saturated / count) as u32;
    if percent >= SATURATED_PERCENT {
        return Some(NotFound::Saturated { percent });
    }
    let mut quantile = |index: usize| *values.select_nth_unstable_by(index, f32::total_cmp).1;
    let range = quantile(count - 1 - count / 100) - quantile(count / 100);
    (range < LEAST_RANGE).then_some(NotFound::Flat)
}

fn find_at_scale(scene: &grid::BoardPicture, board: &Board) -> Result<Vec<FoundCorner>, NotFound> {
    let saddles = saddle::find(scene.image, scene.sigma_px, scene.noise);
    let mut grids = grid::grow(scene, &saddles);
    for grid in &mut grids {
        grid::polish(scene, grid);
    }
    let placed = place::place(scene.image, board, &grids)?;
    Ok(numbered(placed, board, SYSTEMATIC_PX))
}

/// A grid that lies on the board, as a list sorted by id; `systematic_px` is the detector's.
fn numbered(placed: grid::Grid, board: &Board, systematic_px: f64) -> Vec<FoundCorner> {
    let [columns, _] = board.inner_corners();
    let mut corners: Vec<FoundCorner> = placed
        .into_iter()
        .map(|((column, row), saddle)| FoundCorner {
            id: row as u32 * columns as u32 + column as u32,
            pixel: saddle.at,
            sigma_px: saddle.noise_px.hypot(systematic_px),
        })
        .collect();
    corners.sort_by_key(|corner| corner.id);
    corners
}
