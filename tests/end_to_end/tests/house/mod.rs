//! The house as code has it: what crates and modules know of each other.

pub mod modules;
pub mod paths;
pub mod tokens;
