//! The crate's tests: one program, which is linked once.

mod anything;
mod consistency;
mod finite;
mod friction;
mod laws;
mod slab;
mod support;
