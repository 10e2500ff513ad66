//! Layers that give.
#![forbid(unsafe_code)]

mod division;
mod element;
mod error;
mod harmonic;
mod material;
mod meridian;
mod mesh;

pub use division::Division;
pub use error::ElasticError;
pub use material::{MAX_POISSON_RATIO, Material};
pub use meridian::{Body, Curve, Hold, Layer};
