//! The house as its READMEs tell it and as code has it: what rooms, crates and modules know of each other.

mod circles;
pub mod crates;
pub mod modules;
pub mod paths;
pub mod plan;
pub mod rules;
pub mod tokens;
