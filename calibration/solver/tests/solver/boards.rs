//! Detection of boards in rendered images whose corners are known exactly.

use crate::common::scene::{Spoil, Studio, USUAL, charuco, fisheye, save, somewhere, word};
use fabkit_calibration::board::{Board, DetectedCorner, find_corners};
use fabkit_calibration::image::GreyImage;
use fabkit_geometry::sequences::SplitMix64;

/// Number of views of each board, with some forty corners each: a root mean square is known to 2 %.
const VIEWS: usize = 24;

#[derive(Default, Debug)]
struct Tally {
    views: usize,
    found: usize,
    corners: usize,
    expected: usize,
    square_sum: f64,
    worst: f64,
    /// Sum of squared errors, in units of the detector's standard deviations, per coordinate.
    nees: f64,
}

impl Tally {
    fn rms(&self) -> f64 {
        (self.square_sum / self.corners as f64).sqrt()
    }
}

/// Function that detects a board, or returns the reason for its failure.
type Detector = fn(&GreyImage, &Board) -> Result<Vec<DetectedCorner>, String>;

fn ours(image: &GreyImage, board: &Board) -> Result<Vec<DetectedCorner>, String> {
    find_corners(image, board).map_err(|why| why.to_string())
}

/// Detects a board in random views that contain it entirely.
fn tally(detector: Detector, board: &Board, views: usize, seed: u64, spoil: Spoil) -> Tally {
    let studio = Studio::new(fisheye());
    let mut random = SplitMix64::new(seed);
    let mut tally = Tally::default();
    let size = f64::from(board.squares[0]) * board.square_mm;
    while tally.views < views {
        let pose = somewhere(board, &mut random, [0.45 * size, 1.6 * size], 60.0, 50.0);
        if !studio.shows(board, &pose, 8.0) {
            continue;
        }
        let truth = studio.truth(board, &pose).unwrap();
        let image = studio.picture(board, &pose, spoil, &mut random);
        tally.views += 1;
        let found = match detector(&image, board) {
            Ok(found) => found,
            Err(why) => {
                println!("view {}: {why}", tally.views);
                if let Ok(folder) = std::env::var("FABKIT_TEST_PICTURES") {
                    save(&image, format!("{folder}/{}-{}.png", word(board), tally.views));
                }
                continue;
            }
        };
        tally.found += 1;
        tally.expected += board.corners.len();
        for corner in found {
            let error = (corner.pixel - truth[corner.id as usize]).norm();
            tally.corners += 1;
            tally.square_sum += error * error;
            tally.worst = tally.worst.max(error);
            tally.nees += 0.5 * (error / corner.sigma_px).powi(2);
            if error > 0.3 {
                println!(
                    "view {}: corner {} off by {error:.2} at {}",
                    tally.views, corner.id, corner.pixel
                );
                if let Ok(folder) = std::env::var("FABKIT_TEST_PICTURES") {
                    save(&image, format!("{folder}/{}-{}.png", word(board), tally.views));
                }
            }
        }
    }
    println!(
        "{}: {}/{} views, {}/{} corners, rms {:.4} px, worst {:.3} px, nees {:.2}",
        word(board),
        tally.found,
        tally.views,
        tally.corners,
        tally.expected,
        tally.rms(),
        tally.worst,
        tally.nees / tally.corners as f64
    );
    tally
}

#[test]
fn checkerboards_in_a_fisheye() {
    // Odd by even squares: only one way to number the corners.
    let board = Board::checkerboard("test", [9, 6], 3.0).unwrap();
    let tally = tally(ours, &board, VIEWS, 1, USUAL);
    assert!(tally.found as f64 >= 0.9 * tally.views as f64);
    assert!(tally.rms() <= 0.1);
    assert!(tally.worst <= 1.0);
}

/// Uses the same views as the test above, so that the printed lines can be compared.
#[cfg(feature = "opencv")]
#[test]
fn checkerboards_in_a_fisheye_by_opencv() {
    use fabkit_calibration::board::{OpenCvError, find_corners_opencv};
    fn theirs(image: &GreyImage, board: &Board) -> Result<Vec<DetectedCorner>, String> {
        find_corners_opencv(image, board).map_err(|why| why.to_string())
    }
    let board = Board::checkerboard("test", [9, 6], 3.0).unwrap();
    let tally = tally(theirs, &board, VIEWS, 1, USUAL);
    assert!(tally.found as f64 >= 0.9 * tally.views as f64);
    assert!(tally.rms() <= 0.1);
    assert!(tally.worst <= 1.0);

    let flat = GreyImage::new(640, 480, vec![0.5; 640 * 480]).unwrap();
    assert!(matches!(find_corners_opencv(&flat, &board), Err(OpenCvError::NotFound(_))));
    let charuco = charuco([8, 6], 3.0, 2.1);
    assert!(matches!(find_corners_opencv(&flat, &charuco), Err(OpenCvError::Charuco)));
}

/// The sheet is larger than the lens's field of view: part of it is always outside, and squares are small and distorted
/// at the edge of the image.
#[test]
fn large_charuco_boards_in_part() {
    let board = charuco([26, 17], 10.0, 7.5);
    let studio = Studio::new(fisheye());
    let mut random = SplitMix64::new(3);
    let (mut seen, mut found, mut square_sum, mut worst) = (0, 0, 0.0, 0.0f64);
    for view in 0..VIEWS / 4 {
        let pose = somewhere(&board, &mut random, [60.0, 130.0], 25.0, 35.0);
        let image = studio.picture(&board, &pose, USUAL, &mut random);
        let pixels = studio.in_sight(&board, &pose, 12.0);
        let corners = find_corners(&image, &board).unwrap();
        println!("view {view}: {} of {} corners", corners.len(), pixels.iter().flatten().count());
        if let Ok(folder) = std::env::var("FABKIT_TEST_PICTURES") {
            save(&image, format!("{folder}/large-{view}.png"));
        }
        seen += pixels.iter().flatten().count();
        for corner in corners {
            let truth = studio.see(board.corners[corner.id as usize].in_board_mm, &pose).unwrap();
            let error = (corner.pixel - truth).norm();
            found += 1;
            square_sum += error * error;
            worst = worst.max(error);
            if error > 0.5 {
                println!("view {view}: corner {} off by {error:.2} at {}", corner.id, corner.pixel);
            }
        }
    }
    let rms = (square_sum / f64::from(found)).sqrt();
    println!("large: {found}/{seen} corners, rms {rms:.4} px, worst {worst:.3} px");
    assert!(f64::from(found) > 0.8 * seen as f64);
    assert!(rms <= 0.1);
    assert!(worst <= 1.0);
}

#[test]
fn charuco_boards_in_a_fisheye() {
    let board = charuco([8, 6], 3.0, 2.1);
    let tally = tally(ours, &board, VIEWS, 2, USUAL);
    assert!(tally.found as f64 >= 0.9 * tally.views as f64);
    assert!(tally.rms() <= 0.1);
    assert!(tally.worst <= 1.0);
}

/// Boards of OpenCV before 4.6 begin with a light square if the number of rows is even.
#[test]
fn older_charuco_boards_are_found() {
    let text = r#"{"format": "fabkit-board", "version": 1, "name": "older", "kind": "charuco",
        "squares": [8, 6], "square_mm": 3, "marker_mm": 2.1, "dictionary": "DICT_4X4_50", "legacy": true}"#;
    let board = Board::from_json(text).unwrap();
    let tally = tally(ours, &board, VIEWS / 2, 4, USUAL);
    assert!(tally.found as f64 >= 0.9 * tally.views as f64);
    assert!(tally.rms() <= 0.1);
    assert!(tally.worst <= 1.0);
}
