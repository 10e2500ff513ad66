//! The crate's tests: one program, which is linked once.

mod distortion;
mod images;
mod scene;
mod truth;
