//! Calibration boards: what is printed on them, and finding their corners in pictures.
//!
//! # Board frame
//!
//! As printed and seen from the front: origin at the upper left corner of the first square, +x to
//! the right, +y down, +z into the board; the corners lie at z = 0. The same convention as
//! OpenCV's.

mod document;

pub use document::{
    Board, BoardCorner, BoardKind, BoardMarker, FORMAT, InvalidBoard, MAX_BYTES, MAX_SQUARES,
    MIN_SQUARES, VERSION,
};
