//! Board views, detected in images or read from a list of corners.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit_calibration::board::{self, Board, BoardKind, DetectedCorner, find_corners};
use fabkit_calibration::image::GreyImage;
use fabkit_calibration::intrinsics::{BoardView, CornerObservation, MIN_CORNERS};
use fabkit_calibration::pin_captures::images;
use fabkit_calibration::report::ImageRecord;
use fabkit_files::Error;
use fabkit_files::reading::{self, ExpectedFile};
use fabkit_geometry::NominalCamera;
use rayon::prelude::*;

use super::CalibrationRunError;
use super::error::{BOARD_HINT, CORNERS_HINT};

/// Memory for board detection, the image itself included, bytes per pixel.
const BOARD_BYTES: u64 = 40;

/// Detector of a board's corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detector {
    /// Fabkit's own detector: any board, any lens.
    Fabkit,
    /// OpenCV's detector, if fabkit was built with it: checkerboards only.
    Opencv,
}

/// Board views with the record of every image examined.
#[derive(Clone, Debug, Default)]
pub struct Views {
    /// Record of every image or listed view, used or not.
    pub records: Vec<ImageRecord>,
    /// Views with at least [`MIN_CORNERS`] corners.
    pub usable: Vec<BoardView>,
}

/// Reads a board file.
///
/// # Errors
/// The file cannot be read or holds no valid board.
pub fn read_board(path: &Path) -> Result<Board, Error> {
    let hint = BOARD_HINT;
    let max_bytes = board::MAX_BYTES as u64;
    let text = reading::read_text(path, ExpectedFile { what: "a board's file", max_bytes, hint })?;
    parse_board(&text, Some(path))
}

/// Parses the text of a board file. `file` is named in errors.
///
/// # Errors
/// All problems of the text.
pub fn parse_board(text: &str, file: Option<&Path>) -> Result<Board, Error> {
    Board::from_json(text)
        .map_err(|invalid| CalibrationRunError::board(file, &invalid.problems).into())
}

/// Detects the board in every image file. Images without the board are recorded as unused; unusable files are refused,
/// all at once.
///
/// # Errors
/// Images that cannot be read, that differ in size from the camera's, or that were given twice.
pub fn from_files(
    paths: &[PathBuf],
    board: &Board,
    camera: &NominalCamera,
    detector: Detector,
) -> Result<Views, Error> {
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let picture = |i: usize| {
        let fits = |size_px| Ok(check_size(&names[i], size_px, camera)?);
        Ok(Cow::Owned(images::read_grey_if(&paths[i], fits)?))
    };
    let size_px = [camera.width_px, camera.height_px];
    images::run_on_workers("looking for the board in", size_px, [0, BOARD_BYTES], || {
        from_images(&names, &picture, board, camera, detector)
    })
}

/// Detects the board in named images; `read(i)` returns the i-th image.
///
/// # Errors
/// See [`from_files`].
pub fn from_images<'a>(
    names: &[String],
    read: &(dyn Fn(usize) -> Result<Cow<'a, GreyImage>, Error> + Sync),
    board: &Board,
    camera: &NominalCamera,
    detector: Detector,
) -> Result<Views, Error> {
    let find = corner_finder(detector, board)?;
    let one = |(i, name): (usize, &String)| -> Result<_, Error> {
        let image = read(i)?;
        let size_px = [image.width_px(), image.height_px()].map(|px| px as u32);
        check_size(name, size_px, camera)?;
        let digest = hash_pixels(&image);
        Ok((digest, find(&image, board)))
    };
    // Collected before they are joined, so that the later of two equal images is reported, on any number of threads.
    let results: Vec<Result<_, Error>> = names.par_iter().enumerate().map(one).collect();
    let mut wrong = Vec::new();
    // Identical images would count as independent evidence, so their pixels are compared by hash.
    let mut seen: BTreeMap<[u8; 32], &str> = BTreeMap::new();
    let mut views = Views::default();
    for (here, result) in names.iter().zip(results) {
        match result {
            Err(failure) => wrong.push(failure),
            Ok((digest, found)) => {
                if let Some(there) = seen.insert(digest, here) {
                    let (here, there) = (here.clone(), there.to_owned());
                    wrong.push(CalibrationRunError::SameImage { here, there }.into());
                }
                views.add(here.clone(), found, board);
            }
        }
    }
    Error::join(wrong).map_or(Ok(views), Err)
}

/// Function that finds a board's corners, or returns the reason why it cannot.
type Finder = fn(&GreyImage, &Board) -> Result<Vec<DetectedCorner>, String>;

fn corner_finder(detector: Detector, board: &Board) -> Result<Finder, CalibrationRunError> {
    match detector {
        Detector::Fabkit => {
            Ok(|image, board| find_corners(image, board).map_err(|why| why.to_string()))
        }
        Detector::Opencv if board.kind == BoardKind::Charuco => Err(CalibrationRunError::Charuco),
        Detector::Opencv => opencv_finder(),
    }
}

#[cfg(feature = "opencv")]
fn opencv_finder() -> Result<Finder, CalibrationRunError> {
    Ok(|image, board| board::find_corners_opencv(image, parse_board).map_err(|why| why.to_string()))
}

#[cfg(not(feature = "opencv"))]
fn opencv_finder() -> Result<Finder, CalibrationRunError> {
    Err(CalibrationRunError::NoOpencv)
}

/// Reads views from a list of corners.
///
/// # Errors
/// The file cannot be read, or rows of it are invalid.
pub fn from_list(path: &Path, board: &Board) -> Result<Views, Error> {
    let hint = CORNERS_HINT;
    let max_bytes = board::MAX_LIST_BYTES as u64;
    let text =
        reading::read_text(path, ExpectedFile { what: "a list of corners", max_bytes, hint })?;
    let list = board::read_corners(&text, board)
        .map_err(|invalid| CalibrationRunError::corners(path, &invalid.problems))?;
    let mut views = Views::default();
    for (name, corners) in list {
        views.add(name, Ok(corners), board);
    }
    Ok(views)
}

/// Makes views from corners that were detected elsewhere, each view with its name.
///
/// # Errors
/// Corners that the board does not have or that occur twice, for all views at once.
pub fn from_corners(
    given: Vec<(String, Vec<DetectedCorner>)>,
    board: &Board,
) -> Result<Views, Error> {
    let mut views = Views::default();
    let mut wrong: Vec<Error> = Vec::new();
    for (view, mut corners) in given {
        // Sorted, so that repeated ids are neighbours.
        corners.sort_by_key(|corner| corner.id);
        let count = board.corners.len();
        let unknown = corners.iter().find(|corner| corner.id as usize >= count);
        let twice = corners.windows(2).find(|pair| pair[0].id == pair[1].id);
        match (unknown, twice) {
            (Some(DetectedCorner { id, .. }), _) => {
                let (corner, last) = (*id, count - 1);
                wrong.push(CalibrationRunError::NoCorner { view, corner, last }.into());
            }
            (None, Some(pair)) => {
                let corner = pair[0].id;
                wrong.push(CalibrationRunError::CornerTwice { view, corner }.into());
            }
            (None, None) => views.add(view, Ok(corners), board),
        }
    }
    Error::join(wrong).map_or(Ok(views), Err)
}

impl Views {
    /// Adds a view with its corners, sorted by id, or with the reason why it has none. A view with fewer than
    /// [`MIN_CORNERS`] corners is recorded as unused.
    fn add(&mut self, file: String, found: Result<Vec<DetectedCorner>, String>, board: &Board) {
        let corners_found = found.as_ref().map_or(0, Vec::len);
        let enough = found.and_then(|corners| match corners.len() {
            n if n < MIN_CORNERS => Err(format!("{n} corners; at least {MIN_CORNERS} are needed")),
            _ => Ok(corners),
        });
        let unused = enough.as_ref().err().cloned();
        self.records.push(ImageRecord { file: file.clone(), corners_found, unused_reason: unused });
        if let Ok(corners) = enough {
            let observation = |found: DetectedCorner| CornerObservation {
                id: found.id,
                in_board_mm: board.corners[found.id as usize].in_board_mm.into(),
                pixel: found.pixel,
                sigma_px: found.sigma_px,
            };
            let corners = corners.into_iter().map(observation).collect();
            self.usable.push(BoardView { name: file, corners });
        }
    }
}

fn check_size(
    name: &str,
    size_px: [u32; 2],
    camera: &NominalCamera,
) -> Result<(), CalibrationRunError> {
    let NominalCamera { width_px: width, height_px: height, .. } = *camera;
    if size_px == [width, height] {
        return Ok(());
    }
    let file = name.into();
    Err(CalibrationRunError::OtherSize { file, size_px, expected_px: [width, height] })
}

/// Hashes the pixel values of an image, independent of its file format and metadata.
fn hash_pixels(image: &GreyImage) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    for value in image.values() {
        hasher.update(&value.to_le_bytes());
    }
    hasher.finalize().into()
}
