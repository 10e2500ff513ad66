//! Ground truth for one camera: its viewpoint, the coverage of a sensor's surface, presses, and output files.

mod collected;
mod coverage;
mod coverage_map;
mod files;
mod looking;
mod penetration;
mod presses;
pub mod probes;
mod viewpoint;

pub use collected::median;
pub use collected::{Collected, Wanted};
pub use coverage::{BESIDE_PICTURE, REFRACTION, SurfaceCoverage, coverage};
pub use coverage_map::coverage_map;
pub use files::{GREY_STEP_MM, Shown, arrays, picture};
pub use looking::{are_seen, pixels_of};
pub use penetration::{Penetration, approach, penetration};
pub use presses::{Deepest, deepest, pressers};
pub use viewpoint::{InvalidViewpoint, Viewpoint};
