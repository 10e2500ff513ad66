//! Views of a board: from pictures, or from a list of corners.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit_calibration::board::{self, Board, BoardKind, FoundCorner, find_corners};
use fabkit_calibration::image::GreyImage;
use fabkit_calibration::intrinsics::{BoardView, CornerObservation, MIN_CORNERS};
use fabkit_calibration::pin_captures::pictures;
use fabkit_calibration::report::PictureRecord;
use fabkit_files::Error;
use fabkit_files::reading::{self, Expected};
use fabkit_geometry::NominalCamera;
use rayon::prelude::*;

use super::CalibratingError;
use super::error::{BOARD_HINT, CORNERS_HINT};

/// What looking for the board takes for each pixel, the picture itself included, bytes.
const BOARD_BYTES: u64 = 40;

/// Who finds a board's corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detector {
    /// Our own: any board, any lens.
    Fabkit,
    /// OpenCV, where fabkit was built with it: checkerboards.
    Opencv,
}

/// What was looked at, and what can be used of it.
#[derive(Clone, Debug, Default)]
pub struct Views {
    /// Everything that was given.
    pub records: Vec<PictureRecord>,
    /// With at least [`MIN_CORNERS`] corners.
    pub usable: Vec<BoardView>,
}

/// Reads a board's file.
///
/// # Errors
/// A file that cannot be read or holds no board.
pub fn read_board(path: &Path) -> Result<Board, Error> {
    let hint = BOARD_HINT;
    let max_bytes = board::MAX_BYTES as u64;
    let text = reading::read_text(path, Expected { what: "a board's file", max_bytes, hint })?;
    board(&text, Some(path))
}

/// A board's file from its text, which came from `file`.
///
/// # Errors
/// Everything that is wrong with it.
pub fn board(text: &str, file: Option<&Path>) -> Result<Board, Error> {
    Board::from_json(text)
        .map_err(|invalid| CalibratingError::board(file, &invalid.problems).into())
}

/// Finds the board in every picture. Pictures without it are recorded; those that cannot be
/// pictures of this camera are refused, all at once.
///
/// # Errors
/// Pictures that cannot be read, have another size, or were given twice.
pub fn from_pictures(
    paths: &[PathBuf],
    board: &Board,
    camera: &NominalCamera,
    detector: Detector,
) -> Result<Views, Error> {
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let picture = |i: usize| {
        let fits = |size_px| Ok(check_size(&names[i], size_px, camera)?);
        Ok(Cow::Owned(pictures::read(&paths[i], fits)?))
    };
    let size_px = [camera.width_px, camera.height_px];
    pictures::on_workers("looking for the board in", size_px, [0, BOARD_BYTES], || {
        from_images(&names, &picture, board, camera, detector)
    })
}

/// The same with pictures by their names, from wherever `read` has the i-th.
///
/// # Errors
/// As [`from_pictures`].
pub fn from_images<'a>(
    names: &[String],
    read: &(dyn Fn(usize) -> Result<Cow<'a, GreyImage>, Error> + Sync),
    board: &Board,
    camera: &NominalCamera,
    detector: Detector,
) -> Result<Views, Error> {
    let find = finder(detector, board)?;
    let one = |(i, name): (usize, &String)| -> Result<_, Error> {
        let image = read(i)?;
        let size_px = [image.width_px(), image.height_px()].map(|px| px as u32);
        check_size(name, size_px, camera)?;
        let digest = digest(&image);
        Ok((digest, find(&image, board)))
    };
    let results: Vec<Result<_, Error>> = names.par_iter().enumerate().map(one).collect();
    let mut wrong = Vec::new();
    let mut seen: BTreeMap<[u8; 32], &str> = BTreeMap::new();
    let mut views = Views::default();
    for (here, result) in names.iter().zip(results) {
        match result {
            Err(failure) => wrong.push(failure),
            Ok((digest, found)) => {
                if let Some(there) = seen.insert(digest, here) {
                    let (here, there) = (here.clone(), there.to_owned());
                    wrong.push(CalibratingError::SamePicture { here, there }.into());
                }
                views.add(here.clone(), found, board);
            }
        }
    }
    Error::all(wrong).map_or(Ok(views), Err)
}

/// Finds a board's corners, or says why not.
type Finder = fn(&GreyImage, &Board) -> Result<Vec<FoundCorner>, String>;

fn finder(detector: Detector, board: &Board) -> Result<Finder, CalibratingError> {
    match detector {
        Detector::Fabkit => {
            Ok(|image, board| find_corners(image, board).map_err(|why| why.to_string()))
        }
        Detector::Opencv if board.kind == BoardKind::Charuco => Err(CalibratingError::Charuco),
        Detector::Opencv => opencv_finder(),
    }
}

#[cfg(feature = "opencv")]
fn opencv_finder() -> Result<Finder, CalibratingError> {
    Ok(|image, board| board::find_corners_opencv(image, board).map_err(|why| why.to_string()))
}

#[cfg(not(feature = "opencv"))]
fn opencv_finder() -> Result<Finder, CalibratingError> {
    Err(CalibratingError::NoOpencv)
}

/// Reads a list of corners.
///
/// # Errors
/// A file that cannot be read, and rows that are wrong.
pub fn from_list(path: &Path, board: &Board) -> Result<Views, Error> {
    let hint = CORNERS_HINT;
    let max_bytes = board::MAX_LIST_BYTES as u64;
    let text = reading::read_text(path, Expected { what: "a list of corners", max_bytes, hint })?;
    let list = board::read_corners(&text, board)
        .map_err(|invalid| CalibratingError::corners(path, &invalid.problems))?;
    let mut views = Views::default();
    for (name, corners) in list {
        views.add(name, Ok(corners), board);
    }
    Ok(views)
}

/// Views from corners that were found elsewhere, each by its name.
///
/// # Errors
/// Corners that the board does not have, or twice, of all views.
pub fn from_corners(given: Vec<(String, Vec<FoundCorner>)>, board: &Board) -> Result<Views, Error> {
    let mut views = Views::default();
    let mut wrong: Vec<Error> = Vec::new();
    for (view, mut corners) in given {
        corners.sort_by_key(|corner| corner.id);
        let count = board.corners.len();
        let unknown = corners.iter().find(|corner| corner.id as usize >= count);
        let twice = corners.windows(2).find(|pair| pair[0].id == pair[1].id);
        match (unknown, twice) {
            (Some(FoundCorner { id, .. }), _) => {
                let (corner, last) = (*id, count - 1);
                wrong.push(CalibratingError::NoCorner { view, corner, last }.into());
            }
            (None, Some(pair)) => {
                let corner = pair[0].id;
                wrong.push(CalibratingError::CornerTwice { view, corner }.into());
            }
            (None, None) => views.add(view, Ok(corners), board),
        }
    }
    Error::all(wrong).map_or(Ok(views), Err)
}

impl Views {
    /// Adds a view by its corners, sorted by id, or why there are none.
    fn add(&mut self, file: String, found: Result<Vec<FoundCorner>, String>, board: &Board) {
        let corners_found = found.as_ref().map_or(0, Vec::len);
        let enough = found.and_then(|corners| match corners.len() {
            n if n < MIN_CORNERS => Err(format!("{n} corners; at least {MIN_CORNERS} are needed")),
            _ => Ok(corners),
        });
        let unused = enough.as_ref().err().cloned();
        self.records.push(PictureRecord { file: file.clone(), corners_found, unused });
        if let Ok(corners) = enough {
            let observation = |found: FoundCorner| CornerObservation {
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
) -> Result<(), CalibratingError> {
    let NominalCamera { width_px: width, height_px: height, .. } = *camera;
    if size_px == [width, height] {
        return Ok(());
    }
    let file = name.into();
    Err(CalibratingError::OtherSize { file, size_px, expected_px: [width, height] })
}

/// Of what is seen, whatever the file says besides.
fn digest(image: &GreyImage) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    for value in image.values() {
        hasher.update(&value.to_le_bytes());
    }
    hasher.finalize().into()
}
