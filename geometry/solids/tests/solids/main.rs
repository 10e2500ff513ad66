//! The crate's tests: one program, which is linked once.

mod bodies;
mod json;
mod offset;
mod patterns;
mod profiles;
mod proofs;
mod volumes;
