//! The crate's tests: one program, which is linked once.

mod distortion;
mod pictures;
mod scene;
mod truth;
