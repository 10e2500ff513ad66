//! The crate's tests: one program, which is linked once.

mod edges;
mod edits;
mod fits;
mod fixing;
mod flat_gel;
mod fluidic;
mod freedom;
mod hardware;
mod marks;
mod parameters;
mod profile;
mod rtac0;
mod shadowtac;
mod slivers;
mod tactip;
mod uvdtact;
