//! The crate's tests: one program, which is linked once.

mod circuit;
mod retention;
mod rules;
