//! The crate's tests: one program, which is linked once.

mod common;
mod domain;
mod files;
mod jacobians;
mod making;
mod notations;
mod opencv;
mod plausibility;
mod refraction;
mod round_trips;
