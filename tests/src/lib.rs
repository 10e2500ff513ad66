//! What the end-to-end tests share: the real binary, and the built-in designs and their fixtures.

mod command;
mod designs;

pub use command::{Run, binary, command, contents, fabkit, other_profile_binary};
pub use designs::{builtin_designs, builtin_fixtures};
