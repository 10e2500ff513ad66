//! The crate's tests: one program, which is linked once.

mod inverse;
mod markers;
mod paths;
mod tiles;
