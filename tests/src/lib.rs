//! What the end-to-end tests share: the real binary, and the built-in designs and their fixtures.

mod command;
pub mod contract;
mod designs;

pub use command::{Run, binary, command, contents, fabkit};
pub use designs::{built, builtin_designs, builtin_fixtures, sampled};
