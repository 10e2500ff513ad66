//! The crate's tests: one program, which is linked once.

mod drawings;
mod figures;
mod formats;
mod samples;
