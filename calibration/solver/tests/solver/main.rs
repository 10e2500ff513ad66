//! The crate's tests: one program, which is linked once.

mod assigning;
mod board_files;
mod boards;
mod calibrating;
mod common;
mod crosschecks;
mod detection;
mod intrinsics;
mod landmarks;
mod observability;
mod planning;
mod pose;
mod reseated;
mod support;
mod uncertainty;
