//! Exact ground truth of what a camera inside a sensor sees of its surface, with or without a press.
//!
//! # Model
//!
//! The camera looks at the sensing surface from within. Without contact it sees the *reference* surface. A rigid
//! indenter displaces the gel, which follows it (`rigid` contact): each camera ray ends at whichever comes first, the
//! reference surface from inside or an indenter from outside. Both are exact crossings of exact solids; there is no
//! mesh, no z-buffer and no resampling. Rays traced [through](PixelRays::traced_through) a sensor's bodies are refracted by
//! clear ones and end at opaque ones.
//!
//! # Conventions
//!
//! - Points, normals and poses are in the sensor frame unless a name says otherwise; lengths are in mm.
//! - Normals point out of the gel: outwards on the reference surface, into the indenter on an indenter.
//! - *Range* is the distance along the ray from where it enters the gel: from its last refraction in the drawn bodies,
//!   or at the camera's own interface; from the lens's centre where nothing refracts it. *z* is the third coordinate in
//!   the camera frame. They are never mixed.
//! - *Indentation* is the range without contact minus the range with it, along the same ray.
//! - Pixels are stored row by row, the first one at the upper left; `NaN` marks pixels that see no sensing surface.
//! - The same input yields the same bits on any number of threads.

mod ball;
mod cast;
mod deformed_surface;
mod false_color;
mod indenter;
mod map;
mod membrane;
mod rays;
mod reference;
mod stitch;
mod tiles;
mod transfer;
mod uncertainty;

pub use deformed_surface::SurfaceDisplacement;
pub use false_color::{false_color, scale_color};
pub use indenter::PlacedIndenter;
pub use map::{DepthMap, NO_LABEL, SURFACE_LABEL};
pub use rays::PixelRays;
pub use reference::ReferenceSurface;
pub use stitch::{Seam, Side};
pub use uncertainty::{StandardDeviations, Uncertainty};
