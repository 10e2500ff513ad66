//! The crate's tests: one program, which is linked once.

mod booleans;
mod oracle;
mod scenes;
mod seams;
mod surfaces;
mod trees;
