//! Reading and checking boards and lists of their corners.

use crate::common::scene::charuco;
use fabkit_calibration::board::{Board, BoardKind, dictionary, read_corners};
use proptest::prelude::*;

#[test]
fn corners_and_markers_stand_where_opencv_has_them() {
    let board = charuco([8, 6], 3.0, 2.1);
    assert_eq!(board.kind, BoardKind::Charuco);
    assert_eq!(board.inner_corners(), [7, 5]);
    assert_eq!(board.corners[0].in_board_mm, [3.0, 3.0]);
    assert_eq!(board.corners[7].in_board_mm, [3.0, 6.0]);
    // Light squares hold markers row by row; the first square is dark.
    let squares: Vec<[u32; 2]> = board.markers.iter().map(|marker| marker.square).collect();
    assert_eq!(squares[..5], [[1, 0], [3, 0], [5, 0], [7, 0], [0, 1]]);
    assert_eq!(board.markers.len(), 24);
    assert_eq!(Board::from_json(&board.to_json()).unwrap(), board);
}

/// Reads a ChArUco board of which a file says little.
fn from_few_keys(squares: [u32; 2], more: &str) -> Result<Board, String> {
    let text = format!(
        r#"{{"format": "fabkit-board", "version": 1, "name": "few", "kind": "charuco", "squares": {squares:?},
        "square_mm": 3, "marker_mm": 2.1{more}}}"#
    );
    Board::from_json(&text).map_err(|error| error.to_string())
}

#[test]
fn corners_and_markers_follow_from_the_dictionary() {
    let [even, odd] = [[8, 6], [8, 5]];
    let names = dictionary::KNOWN;
    for (squares, legacy, first) in [
        (even, false, [1, 0]),
        (even, true, [0, 0]),
        (odd, false, [1, 0]),
        // With an odd number of rows both patterns are the same.
        (odd, true, [1, 0]),
    ] {
        for name in names {
            let more = format!(r#", "dictionary": "{name}", "legacy": {legacy}"#);
            // The first markers of the original dictionary look alike when turned.
            let board = match from_few_keys(squares, &more) {
                Ok(board) => board,
                Err(error) if name == "DICT_ARUCO_ORIGINAL" => {
                    assert!(error.contains("rotation"), "{error}");
                    continue;
                }
                Err(error) => panic!("{error}"),
            };
            assert_eq!(board.markers[0].square, first, "{more}");
            let bits: Vec<_> = board.markers.iter().map(|marker| marker.bits.clone()).collect();
            assert_eq!(bits, dictionary::rows_of(name).unwrap()[..bits.len()], "{more}");
            assert_eq!(board.corners, charuco(squares, 3.0, 2.1).corners);
            assert_eq!(Board::from_json(&board.to_json()).unwrap(), board);
        }
    }
    for (squares, more, expected) in [
        (even, "", "needs `dictionary`, one of DICT_4X4_50"),
        (even, r#", "dictionary": "DICT_6X6_250""#, "list `markers`"),
        ([20, 20], r#", "dictionary": "DICT_4X4_100""#, "100 markers for 200 light squares"),
    ] {
        let error = from_few_keys(squares, more).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_measured_board_may_differ_from_its_drawing() {
    let mut board = Board::checkerboard("measured", [9, 6], 3.0).unwrap();
    for corner in &mut board.corners {
        corner.in_board_mm[0] *= 1.004;
    }
    assert_eq!(Board::from_json(&board.to_json()).unwrap(), board);
}

/// Reads a board whose JSON was changed, and returns the error.
fn refused(board: &Board, from: &str, to: &str) -> String {
    let text = board.to_json();
    assert!(text.contains(from), "{from}");
    Board::from_json(&text.replacen(from, to, 1)).unwrap_err().to_string()
}

#[test]
fn wrong_boards_are_refused_with_the_field_and_the_limit() {
    let plain = Board::checkerboard("test", [9, 6], 3.0).unwrap();
    let charuco = charuco([5, 4], 3.0, 2.1);
    let bits = charuco.markers[0].bits.join("\",\n        \"");
    let others = charuco.markers[1].bits.join("\",\n        \"");
    for (board, from, to, expected) in [
        (&plain, "\"version\": 1", "\"version\": 3", "version 3; this fabkit reads"),
        (&plain, "fabkit-board", "other", "format \"other\""),
        (&plain, "\"square_mm\": 3.0", "\"square_mm\": -3.0", "square_mm is -3"),
        (&plain, "\"square_mm\": 3.0", "\"square_mm\": 1e999", "line 10"),
        (&plain, "\"id\": 4,", "\"id\": 5,", "corners[4] has id 5; corners are listed by id"),
        (&plain, "15.0", "17.0", "corners[4] is at (17, 3) mm"),
        (&plain, "\"corners\"", "\"colours\"", "unknown field `colours`"),
        (&plain, "    9,\n    6\n", "    9,\n    7\n", "40 corners; these squares have 48"),
        (&plain, "    9,\n    6\n", "    9,\n    3\n", "both are 4 to 100"),
        (&plain, "    9,\n    6\n", "    9,\n    4000000000\n", "both are 4 to 100"),
        (&plain, "\"checkerboard\"", "\"charuco\"", "a charuco board needs `dictionary`"),
        (&plain, "\"square_mm\"", "\"marker_mm\": 1, \"square_mm\"", "has no markers"),
        (&charuco, "2.1", "3.5", "marker_mm is 3.5"),
        (&charuco, &bits, &others, "markers 0 and 1 look alike in some rotation"),
        (&charuco, &bits, "0110\", \"0110\", \"0110\", \"0112", "rows of as many 0 and 1"),
        (&charuco, &bits, "0110\", \"0110\", \"0110\", \"ü11", "rows of as many 0 and 1"),
        (&charuco, &bits, "0110\", \"1001\", \"1001\", \"0110", "looks the same in two rotations"),
    ] {
        let message = refused(board, from, to);
        assert!(message.contains(expected), "{from} -> {to}: {message}");
    }
    assert!(Board::from_json("{").unwrap_err().to_string().contains("line 1"));
    assert!(Board::from_json(&" ".repeat(5 << 20)).unwrap_err().to_string().contains("at most"));
}

#[test]
fn lists_are_refused_with_the_line() {
    let board = Board::checkerboard("test", [5, 4], 3.0).unwrap();
    let header = "view,corner,x_px,y_px";
    for (text, expected) in [
        (String::new(), "the list is empty"),
        (format!("{header}\n"), "no rows"),
        ("file,corner,x,y\na,0,1,2".into(), "line 1: the columns are `file,corner,x,y`"),
        (format!("# by hand\n{header}\na,0,1"), "line 3: 3 cells; there are 4 columns"),
        (format!("{header}\na,12,1,2"), "line 2: `12` is no corner of this board"),
        (format!("{header}\na,0,one,2"), "line 2: `one` is not a number"),
        (format!("{header}\na,0,1,inf"), "line 2: inf px; the limits are"),
        (format!("{header},sigma_px\na,0,1,2,0"), "line 2: 0 px; the limits are 0.000001"),
        (format!("{header}\na,0,1,2\na,0,3,4"), "line 3: a has corner 0 twice"),
    ] {
        let message = read_corners(&text, &board).unwrap_err().to_string();
        assert!(message.contains(expected), "{text}: {message}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn boards_survive_a_round_trip(columns in 4u32..20, rows in 4u32..20, square_mm in 0.5f64..50.0) {
        let board = Board::checkerboard("any", [columns, rows], square_mm).unwrap();
        prop_assert_eq!(&Board::from_json(&board.to_json()).unwrap(), &board);
        let last = board.corners.last().unwrap();
        let expected = [f64::from(columns - 1) * square_mm, f64::from(rows - 1) * square_mm];
        prop_assert_eq!(last.in_board_mm, expected);
    }

    /// For any text, reading returns corners of the board or an error.
    #[test]
    fn any_text_is_read_or_refused(text in "(view,corner,x_px,y_px\n)?([ab0-9.,e\\-\n]{0,60})") {
        let board = Board::checkerboard("test", [5, 4], 3.0).unwrap();
        match read_corners(&text, &board) {
            Ok(views) => prop_assert!(views.values().flatten().all(|corner| corner.id < 12)),
            Err(invalid) => prop_assert!(!invalid.problems.is_empty()),
        }
    }
}
