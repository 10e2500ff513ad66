//! Layers that give.
#![forbid(unsafe_code)]

mod compliance;
mod contact;
mod division;
mod element;
mod error;
mod harmonic;
mod material;
mod meridian;
mod mesh;
mod outcome;
mod patch;
mod presser;
mod rings;
mod stack;

pub use division::Division;
pub use error::ElasticError;
pub use material::{MAX_POISSON_RATIO, Material};
pub use meridian::{Body, Curve, Hold, Layer};
pub use outcome::{Level, Outcome, SurfaceNode};
pub use presser::{Ball, Press, Presser, SolidPresser};
pub use stack::Stack;
