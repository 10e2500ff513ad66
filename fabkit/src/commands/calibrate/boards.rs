//! Views of a board: from pictures, or from a list of corners.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit::calibration::board::{self, Board, BoardKind, FoundCorner, find_corners};
use fabkit::calibration::image::GreyImage;
use fabkit::calibration::intrinsics::{MIN_CORNERS, Observation, View};
use fabkit::calibration::report::PictureRecord;
use fabkit::geometry::NominalCamera;
use rayon::prelude::*;

use super::pictures;
pub use crate::cli::Detector;
use crate::failure::{Exit, Failure};
use crate::reading::{self, Expected};

/// What looking for the board takes for each pixel, the picture itself included, bytes.
const BOARD_BYTES: u64 = 40;

/// What was looked at, and what can be used of it.
#[derive(Clone, Debug, Default)]
pub struct Views {
    /// Everything that was given.
    pub records: Vec<PictureRecord>,
    /// With at least [`MIN_CORNERS`] corners.
    pub usable: Vec<View>,
}

/// Reads a board's file.
///
/// # Errors
/// A file that cannot be read or holds no board.
pub fn read_board(path: &Path) -> Result<Board, Failure> {
    let hint = "`fabkit export SENSOR/boards` writes one beside each board";
    let max_bytes = board::MAX_BYTES as u64;
    let text = reading::text(path, Expected { what: "a board's file", max_bytes, hint })?;
    Board::from_json(&text).map_err(|invalid| {
        let problems: Vec<String> =
            invalid.problems.iter().map(|p| format!("{}: {p}", path.display())).collect();
        Failure::new(Exit::BadInput, problems.join("\nerror: "), hint)
    })
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
) -> Result<Views, Failure> {
    let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let picture = |i: usize| {
        let fits = |size_px| check_size(&names[i], size_px, camera);
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
    read: &(dyn Fn(usize) -> Result<Cow<'a, GreyImage>, Failure> + Sync),
    board: &Board,
    camera: &NominalCamera,
    detector: Detector,
) -> Result<Views, Failure> {
    let find = finder(detector, board)?;
    let one = |(i, name): (usize, &String)| -> Result<_, Failure> {
        let image = read(i)?;
        let size_px = [image.width_px(), image.height_px()].map(|px| px as u32);
        check_size(name, size_px, camera)?;
        let digest = digest(&image);
        Ok((digest, find(&image, board)))
    };
    let results: Vec<Result<_, Failure>> = names.par_iter().enumerate().map(one).collect();
    let mut wrong = Vec::new();
    let mut seen: BTreeMap<[u8; 32], &str> = BTreeMap::new();
    let mut views = Views::default();
    for (here, result) in names.iter().zip(results) {
        match result {
            Err(failure) => wrong.push(failure),
            Ok((digest, found)) => {
                if let Some(there) = seen.insert(digest, here) {
                    let message = format!("{here} and {there} are the same picture");
                    let hint = "give each picture once; the same one again is no new evidence";
                    wrong.push(Failure::new(Exit::BadInput, message, hint));
                }
                views.add(here.clone(), found, board);
            }
        }
    }
    Failure::all(wrong).map_or(Ok(views), Err)
}

/// Finds a board's corners, or says why not.
type Finder = fn(&GreyImage, &Board) -> Result<Vec<FoundCorner>, String>;

fn finder(detector: Detector, board: &Board) -> Result<Finder, Failure> {
    match detector {
        Detector::Fabkit => {
            Ok(|image, board| find_corners(image, board).map_err(|why| why.to_string()))
        }
        Detector::Opencv if board.kind == BoardKind::Charuco => Err(Failure::new(
            Exit::BadInput,
            "--detector opencv finds checkerboards, and this is a ChArUco board",
            "leave --detector out, or give what OpenCV found by --corners",
        )),
        Detector::Opencv => opencv_finder(),
    }
}

#[cfg(feature = "opencv")]
fn opencv_finder() -> Result<Finder, Failure> {
    Ok(|image, board| board::find_corners_opencv(image, board).map_err(|why| why.to_string()))
}

#[cfg(not(feature = "opencv"))]
fn opencv_finder() -> Result<Finder, Failure> {
    Err(Failure::new(
        Exit::BadInput,
        "this fabkit was built without OpenCV",
        "build it with `cargo build --release --features opencv`, or give what OpenCV found by \
         --corners",
    ))
}

/// Reads a list of corners.
///
/// # Errors
/// A file that cannot be read, and rows that are wrong.
pub fn from_list(path: &Path, board: &Board) -> Result<Views, Failure> {
    let hint = "the columns are view,corner,x_px,y_px and, if known, sigma_px";
    let max_bytes = board::MAX_LIST_BYTES as u64;
    let text = reading::text(path, Expected { what: "a list of corners", max_bytes, hint })?;
    let list = board::read_corners(&text, board).map_err(|invalid| {
        let problems: Vec<String> =
            invalid.problems.iter().map(|p| format!("{}: {p}", path.display())).collect();
        Failure::new(Exit::BadInput, problems.join("\nerror: "), hint)
    })?;
    let mut views = Views::default();
    for (name, corners) in list {
        views.add(name, Ok(corners), board);
    }
    Ok(views)
}

impl Views {
    /// Adds a view by its corners, sorted by id, or why there are none.
    pub fn add(&mut self, file: String, found: Result<Vec<FoundCorner>, String>, board: &Board) {
        let corners_found = found.as_ref().map_or(0, Vec::len);
        let enough = found.and_then(|corners| match corners.len() {
            n if n < MIN_CORNERS => Err(format!("{n} corners; at least {MIN_CORNERS} are needed")),
            _ => Ok(corners),
        });
        let unused = enough.as_ref().err().cloned();
        self.records.push(PictureRecord { file: file.clone(), corners_found, unused });
        if let Ok(corners) = enough {
            let observation = |found: FoundCorner| Observation {
                id: found.id,
                in_board_mm: board.corners[found.id as usize].in_board_mm.into(),
                pixel: found.pixel,
                sigma_px: found.sigma_px,
            };
            let corners = corners.into_iter().map(observation).collect();
            self.usable.push(View { name: file, corners });
        }
    }
}

fn check_size(name: &str, size_px: [u32; 2], camera: &NominalCamera) -> Result<(), Failure> {
    let NominalCamera { width_px: width, height_px: height, .. } = *camera;
    if size_px == [width, height] {
        return Ok(());
    }
    let [found_width, found_height] = size_px;
    let message = format!(
        "{name}: {found_width} x {found_height} px; the sensor's camera has {width} x {height} px"
    );
    let hint = "take all pictures with the sensor's camera at its own size, or change the sensor's \
                with --set camera.width_px=... --set camera.height_px=...";
    Err(Failure::new(Exit::BadInput, message, hint))
}

/// Of what is seen, whatever the file says besides.
fn digest(image: &GreyImage) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    for value in image.values() {
        hasher.update(&value.to_le_bytes());
    }
    hasher.finalize().into()
}
