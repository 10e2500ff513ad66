//! Board files, which link the printed sheet to the detector.

use std::collections::BTreeMap;

use fabkit_text::{InvalidDocument, JsonFormat};
use serde::{Deserialize, Serialize};

use super::dictionary;

/// Value of `format` in a board file.
pub const FORMAT: &str = "fabkit-board";
/// Version that this crate reads and writes.
pub const VERSION: u32 = 1;
/// Largest file, bytes.
pub const MAX_BYTES: usize = 4 << 20;
/// Smallest number of squares along a side: below, a grid of corners cannot be distinguished from clutter.
pub const MIN_SQUARES: u32 = 4;
/// Largest number of squares along a side.
pub const MAX_SQUARES: u32 = 100;

/// Smallest and largest side of a square, mm.
const SQUARE_LIMITS_MM: [f64; 2] = [0.1, 500.0];
/// Smallest and largest number of bits along the side of a marker.
const MARKER_BITS: [usize; 2] = [3, 8];
/// Largest distance of a corner from its nominal place, in squares. A measured board differs from the drawing by its
/// printer's scale; a larger difference means another board.
const CORNER_TOLERANCE_SQUARES: f64 = 0.25;

/// Kind of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoardKind {
    /// Dark and light squares only. All of it must be in the image.
    Checkerboard,
    /// Checkerboard with a marker in each light square. Any part of it may be in the image.
    Charuco,
}

/// Inner corner of a board, where four squares meet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoardCorner {
    /// Number, row by row from the upper left: `row * (columns - 1) + column`, both from 0, as in OpenCV.
    pub id: u32,
    /// Coordinates x and y in the board frame, mm; z is 0.
    pub in_board_mm: [f64; 2],
}

/// Marker in a light square.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoardMarker {
    /// Number of the marker in its dictionary.
    pub id: u32,
    /// Column and row of its square, from 0. Their sum is odd, or even for all markers of an older board.
    pub square: [u32; 2],
    /// Rows of bits from the top as printed, without the dark border: `1` is light, `0` dark.
    pub bits: Vec<String>,
}

/// Printed board. The square in column `c` and row `r` is dark if `c + r` is even, and light on a [`Board::legacy`] board
/// with an even number of rows.
///
/// A file may leave out what follows from the rest: `corners` lie at their nominal places, and `markers` are those of
/// the `dictionary` if its bits are known ([`KNOWN`](super::dictionary::KNOWN)).
///
/// A checkerboard whose two numbers of squares are both even or both odd looks the same upside down. Then an image does
/// not determine which corner is which, and calibration does not need it.
///
/// ```
/// use fabkit_calibration::board::Board;
/// let board = Board::checkerboard("a5", [9, 6], 2.5).unwrap();
/// assert_eq!(board.corners.len(), 8 * 5);
/// assert_eq!(board.corners[9].in_board_mm, [5.0, 5.0]);
/// assert_eq!(Board::from_json(&board.to_json()).unwrap(), board);
///
/// // A board that OpenCV before 4.6, or calib.io, made: its first square is light and has a marker.
/// let older = r#"{"format": "fabkit-board", "version": 1, "name": "older", "kind": "charuco", "squares": [8, 6],
///     "square_mm": 3, "marker_mm": 2.1, "dictionary": "DICT_4X4_50", "legacy": true}"#;
/// assert_eq!(Board::from_json(older).unwrap().markers[0].square, [0, 0]);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// Always [`FORMAT`].
    pub format: String,
    /// Always [`VERSION`].
    pub version: u32,
    /// Name of the board.
    pub name: String,
    /// Kind of board.
    pub kind: BoardKind,
    /// Columns and rows of squares.
    pub squares: [u32; 2],
    /// Side of a square, mm.
    pub square_mm: f64,
    /// Side of a marker with its dark border, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marker_mm: Option<f64>,
    /// Name of the dictionary of the markers' bits, for example `DICT_4X4_50`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dictionary: Option<String>,
    /// Whether the markers are placed as by OpenCV before 4.6 (`setLegacyPattern`): with an even number of rows the
    /// first square is light. Matters only without `markers`, whose squares say the same.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub legacy: bool,
    /// Inner corners, sorted by id. A file without them has them at their nominal places.
    #[serde(default)]
    pub corners: Vec<BoardCorner>,
    /// Markers, sorted by id; none on a checkerboard. A file without them has those of the dictionary.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub markers: Vec<BoardMarker>,
}

const DOCUMENT: JsonFormat = JsonFormat {
    what: "calibration board",
    format: FORMAT,
    version: VERSION,
    max_bytes: MAX_BYTES,
};

impl Board {
    /// Creates a checkerboard of columns x rows squares with sides of `square_mm`.
    ///
    /// # Errors
    /// Fails for too few or too many squares, or a side outside 0.1 mm to 500 mm.
    ///
    /// ```
    /// use fabkit_calibration::board::Board;
    /// let few = Board::checkerboard("a5", [9, 3], 2.5).unwrap_err();
    /// assert_eq!(few.problems, ["squares are [9, 3]; both are 4 to 100"]);
    /// // Sides are in millimetres, not in metres.
    /// assert!(Board::checkerboard("a5", [9, 6], 0.0025).is_err());
    /// ```
    pub fn checkerboard(
        name: &str,
        squares: [u32; 2],
        square_mm: f64,
    ) -> Result<Self, InvalidDocument> {
        let board = Self {
            format: FORMAT.into(),
            version: VERSION,
            name: name.into(),
            kind: BoardKind::Checkerboard,
            squares,
            square_mm,
            marker_mm: None,
            dictionary: None,
            legacy: false,
            corners: Self::regular_corners(squares, square_mm)?,
            markers: Vec::new(),
        };
        board.check()?;
        Ok(board)
    }

    /// Creates a ChArUco board with OpenCV's layout (since 4.6): markers 0, 1, 2, ... of the dictionary in the light
    /// squares, row by row.
    ///
    /// `bits` holds the rows of each marker, `1` for light. Markers beyond the last light square are left out.
    ///
    /// # Errors
    /// Fails as [`Board::checkerboard`], for too few markers, markers that look alike in some rotation, or a marker
    /// that does not fit its square.
    ///
    /// ```
    /// use fabkit_calibration::board::{Board, BoardKind};
    /// // Eight markers of 3 x 3 bits that differ in all rotations, for the eight light squares of 4 x 4.
    /// let marker = |top: &str, middle: &str| [top, middle, "000"].map(str::to_owned).to_vec();
    /// let tops = ["100", "010", "110", "011"];
    /// let bits = tops.map(|top| [marker(top, "000"), marker(top, "010")]).concat();
    /// let board = Board::charuco("test", [4, 4], 6.0, 4.0, "TEST_3X3", &bits)?;
    /// assert_eq!((board.kind, board.markers.len()), (BoardKind::Charuco, 8));
    /// assert_eq!(board.markers[0].square, [1, 0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn charuco(
        name: &str,
        squares: [u32; 2],
        square_mm: f64,
        marker_mm: f64,
        dictionary: &str,
        bits: &[Vec<String>],
    ) -> Result<Self, InvalidDocument> {
        let corners = Self::regular_corners(squares, square_mm)?;
        let light = Self::light_squares(squares);
        if bits.len() < light.len() {
            return Err(DOCUMENT.refuse(format!(
                "{} markers for {} light squares",
                bits.len(),
                light.len()
            )));
        }
        let markers = (0..).zip(light).zip(bits);
        let board = Self {
            format: FORMAT.into(),
            version: VERSION,
            name: name.into(),
            kind: BoardKind::Charuco,
            squares,
            square_mm,
            marker_mm: Some(marker_mm),
            dictionary: Some(dictionary.into()),
            legacy: false,
            corners,
            markers: markers
                .map(|((id, square), bits)| BoardMarker { id, square, bits: bits.clone() })
                .collect(),
        };
        board.check()?;
        Ok(board)
    }

    /// Reads a board file.
    ///
    /// # Errors
    /// Reports text that is no such document, with line and column; other formats and versions; all contradictions in
    /// the content.
    ///
    /// ```
    /// use fabkit_calibration::board::Board;
    /// let text = Board::checkerboard("a5", [9, 6], 2.5)?.to_json();
    /// // A measured board may be a percent larger; corners that lie elsewhere contradict the squares.
    /// assert!(Board::from_json(&text.replace("\"square_mm\": 2.5", "\"square_mm\": 2.52")).is_ok());
    /// let wrong = Board::from_json(&text.replace("\"square_mm\": 2.5", "\"square_mm\": 5.0"));
    /// let expected = "corners[0] is at (2.5, 2.5) mm; squares and square_mm put it at (5, 5) mm";
    /// assert_eq!(wrong.unwrap_err().problems[0], expected);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_json(text: &str) -> Result<Self, InvalidDocument> {
        let mut board: Self = DOCUMENT.read(text, &DOCUMENT.parse(text)?)?;
        board.complete()?;
        board.check()?;
        Ok(board)
    }

    /// Adds corners and markers that the file leaves out.
    fn complete(&mut self) -> Result<(), InvalidDocument> {
        if self.corners.is_empty() {
            self.corners = Self::regular_corners(self.squares, self.square_mm)?;
        }
        if self.kind == BoardKind::Checkerboard || !self.markers.is_empty() {
            return Ok(());
        }
        let known = dictionary::KNOWN.join(", ");
        let Some(name) = &self.dictionary else {
            return Err(DOCUMENT.refuse(format!(
                "a charuco board needs `dictionary`, one of {known}, or else `markers` with their bits"
            )));
        };
        let Some(bits) = dictionary::rows_of(name) else {
            return Err(DOCUMENT.refuse(format!(
                "the bits of dictionary {name} are not known here, only those of {known}; list `markers`: each has id, \
                 square and bits, which OpenCV's `generateImageMarker` draws (docs/reference/files.md shows how)"
            )));
        };
        let squares = Self::squares_of_parity(self.squares, self.marker_parity());
        if bits.len() < squares.len() {
            let (most, needed) = (bits.len(), squares.len());
            return Err(DOCUMENT.refuse(format!("{most} markers for {needed} light squares")));
        }
        let markers = (0..).zip(squares).zip(bits);
        self.markers =
            markers.map(|((id, square), bits)| BoardMarker { id, square, bits }).collect();
        Ok(())
    }

    /// Sum of column and row, modulo 2, of the squares with markers of a dictionary.
    fn marker_parity(&self) -> u32 {
        u32::from(!(self.legacy && self.squares[1].is_multiple_of(2)))
    }

    /// Writes indented JSON with a final newline.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("strings and finite numbers can be written") + "\n"
    }

    /// Numbers of columns and rows of inner corners.
    pub fn inner_corners(&self) -> [usize; 2] {
        self.squares.map(|n| n as usize - 1)
    }

    /// Lists column and row of every light square, row by row.
    ///
    /// ```
    /// use fabkit_calibration::board::Board;
    /// // The first square, at the upper left, is dark.
    /// assert_eq!(Board::light_squares([4, 4])[..3], [[1, 0], [3, 0], [0, 1]]);
    /// ```
    pub fn light_squares(squares: [u32; 2]) -> Vec<[u32; 2]> {
        Self::squares_of_parity(squares, 1)
    }

    /// Lists the squares whose column and row add up to an even (0) or odd (1) number, row by row.
    fn squares_of_parity([columns, rows]: [u32; 2], parity: u32) -> Vec<[u32; 2]> {
        let all = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
        all.filter(|[column, row]| (column + row) % 2 == parity).collect()
    }

    /// Lists the corners at their nominal places.
    fn regular_corners(
        squares: [u32; 2],
        square_mm: f64,
    ) -> Result<Vec<BoardCorner>, InvalidDocument> {
        check_squares(squares)?;
        let [columns, rows] = squares.map(|n| n - 1);
        let corner = |id: u32| {
            let place = [id % columns, id / columns];
            BoardCorner { id, in_board_mm: place.map(|i| f64::from(i + 1) * square_mm) }
        };
        Ok((0..columns * rows).map(corner).collect())
    }

    /// Reports everything that is wrong.
    fn check(&self) -> Result<(), InvalidDocument> {
        let nominal = Self::regular_corners(self.squares, self.square_mm)?;
        let mut problems = Vec::new();
        let [min, max] = SQUARE_LIMITS_MM;
        if !(min..=max).contains(&self.square_mm) {
            let side = self.square_mm;
            problems.push(format!("square_mm is {side}; the limits are {min} and {max}"));
        }
        if self.corners.len() != nominal.len() {
            let (found, expected) = (self.corners.len(), nominal.len());
            problems.push(format!("{found} corners; these squares have {expected}"));
        }
        let tolerance = CORNER_TOLERANCE_SQUARES * self.square_mm;
        for (index, (corner, expected)) in self.corners.iter().zip(&nominal).enumerate() {
            if corner.id != expected.id {
                let id = corner.id;
                problems.push(format!("corners[{index}] has id {id}; corners are listed by id"));
            }
            let ([x, y], [u, v]) = (corner.in_board_mm, expected.in_board_mm);
            let near = (x - u).abs() <= tolerance && (y - v).abs() <= tolerance;
            if !near {
                problems.push(format!(
                    "corners[{index}] is at ({x}, {y}) mm; squares and square_mm put it at ({u}, {v}) mm"
                ));
            }
        }
        match self.kind {
            BoardKind::Checkerboard => {
                if !self.markers.is_empty() || self.marker_mm.is_some() {
                    problems.push("a checkerboard has no markers".into());
                }
            }
            BoardKind::Charuco => self.check_markers(&mut problems),
        }
        DOCUMENT.accept(problems)
    }

    /// Reports everything that is wrong with the markers.
    fn check_markers(&self, problems: &mut Vec<String>) {
        match self.marker_mm {
            Some(side) if side > 0.3 * self.square_mm && side < self.square_mm => {}
            Some(side) => problems.push(format!(
                "marker_mm is {side}; it must be between 0.3 and 1 times square_mm, {}",
                self.square_mm
            )),
            None => problems.push("a charuco board needs marker_mm".into()),
        }
        let mut squares: Vec<[u32; 2]> =
            // Row first, so that sorting goes row by row like `light_squares`.
            self.markers.iter().map(|m| [m.square[1], m.square[0]]).collect();
        squares.sort_unstable();
        let has_all = |parity| {
            let light = Self::squares_of_parity(self.squares, parity);
            squares.iter().copied().eq(light.iter().map(|[c, r]| [*r, *c]))
        };
        // On older boards the first square is light.
        if !has_all(1) && !has_all(0) {
            problems.push(
                "markers: each light square needs one (column + row odd; on older boards, even)"
                    .into(),
            );
        }
        let side = self.markers.first().map_or(0, |m| m.bits.len());
        let [min, max] = MARKER_BITS;
        for marker in &self.markers {
            let square = marker.bits.len() == side
                && (min..=max).contains(&side)
                && marker
                    .bits
                    .iter()
                    .all(|r| r.len() == side && r.bytes().all(|b| b == b'0' || b == b'1'));
            if !square {
                let id = marker.id;
                problems.push(format!(
                    "marker {id}: bits must be {min} to {max} rows of as many 0 and 1, the same for all"
                ));
                return;
            }
        }
        let mut seen = BTreeMap::new();
        for marker in &self.markers {
            // The detector tries all rotations, so that markers must differ in all of them.
            let words = [0, 1, 2, 3].map(|turns| marker.packed_bits(turns));
            let id = marker.id;
            if words[1..].contains(&words[0]) {
                problems.push(format!("marker {id} looks the same in two rotations"));
            }
            // The smallest of the four rotations is the same for markers that look alike in any of them.
            let canonical = words.into_iter().min();
            if let Some(other) = seen.insert(canonical, id) {
                problems.push(format!("markers {other} and {id} look alike in some rotation"));
            }
        }
    }
}

impl BoardMarker {
    /// Packs the bits into a word, row by row from the most significant, after `turns` clockwise quarter turns of the
    /// printed marker.
    pub(super) fn packed_bits(&self, turns: usize) -> u64 {
        let side = self.bits.len();
        let mut word = 0;
        for row in 0..side {
            for column in 0..side {
                let (mut r, mut c) = (row, column);
                for _ in 0..turns {
                    // The field at (row, column) of the turned marker was here one turn before.
                    (r, c) = (side - 1 - c, r);
                }
                word = word << 1 | u64::from(self.bits[r].as_bytes()[c] == b'1');
            }
        }
        word
    }
}

/// Checks the limits of the numbers of squares.
fn check_squares(squares: [u32; 2]) -> Result<(), InvalidDocument> {
    if squares.iter().all(|n| (MIN_SQUARES..=MAX_SQUARES).contains(n)) {
        return Ok(());
    }
    let [columns, rows] = squares;
    Err(DOCUMENT.refuse(format!(
        "squares are [{columns}, {rows}]; both are {MIN_SQUARES} to {MAX_SQUARES}"
    )))
}
