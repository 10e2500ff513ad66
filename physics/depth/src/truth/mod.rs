//! Exact ground truth: what a camera inside a sensor sees of its surface, pressed or not.
//!
//! # Model
//!
//! The camera looks at the sensing surface from within. Without contact it sees the *reference*
//! surface. A rigid body that is pressed in takes the place of gel, which follows it
//! (`rigid` contact): along each camera ray the first thing met is either the reference surface,
//! from inside, or a presser, from outside. Both are exact crossings of exact solids; there is no
//! mesh, no z-buffer and no resampling. Rays that go [through](PixelRays::through) a sensor's bodies are
//! bent by what is clear and end at what is not.
//!
//! # Conventions
//!
//! - Points, normals and poses are in the sensor frame unless a name says otherwise; lengths in mm.
//! - Normals point out of the gel: at the reference surface outwards, on a presser into it.
//! - *Range* is the distance along the ray from where it enters the gel: where it was bent last on its way
//!   through the drawn bodies, or on the camera's own interface; the lens's centre where nothing bends it.
//!   *z* is the third coordinate in the camera frame. They are never mixed.
//! - *Indentation* is the range without contact minus the range with it, along the same ray.
//! - Pixels are stored row by row, the first one at the upper left; `NaN` marks pixels that see no
//!   sensing surface.
//! - Same input, same bits, on any number of threads.

mod ball;
mod cast;
mod map;
mod membrane;
mod picture;
mod presser;
mod rays;
mod reference;
mod sigma;
mod stitch;
mod tiles;
mod transfer;
mod yielding;

pub use map::{DepthMap, NO_LABEL, SURFACE_LABEL};
pub use picture::{false_color, scale_color};
pub use presser::Presser;
pub use rays::PixelRays;
pub use reference::ReferenceSurface;
pub use sigma::{Sigmas, Uncertainty};
pub use stitch::{Seam, Side};
pub use yielding::Yielding;
