//! Ground truth for one camera: where it looks from, what it sees of a sensor's surface, what
//! presses there, and all of it as bytes.

mod coverage;
mod files;
mod penetration;
mod presses;
pub mod probes;
mod viewpoint;

pub use coverage::{Coverage, coverage};
pub use files::{GREY_STEP_MM, Shown, arrays, cloud, grey, picture, tiff};
pub use penetration::{Penetration, approach, penetration};
pub use presses::{Deepest, deepest, pressers};
pub use viewpoint::{InvalidViewpoint, Viewpoint};
