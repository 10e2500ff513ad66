//! End-to-end tests.

mod designs;

pub use designs::builtin_designs;
