//! The crate's tests: one program, which is linked once.

mod inverse;
mod paths;
mod tiles;
