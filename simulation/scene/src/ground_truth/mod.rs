//! Ground truth for one camera: its viewpoint, the coverage of a sensor's surface, presses, and output files.

mod coverage;
mod coverage_map;
mod files;
mod map_collector;
mod penetration;
mod presses;
pub mod probes;
mod projector;
mod viewpoint;

pub use coverage::{OUTSIDE_IMAGE, REFRACTION, SurfaceCoverage, compute_coverage};
pub use coverage_map::draw_coverage_map;
pub use files::{GREY_STEP_MM, MapQuantity, arrays, false_color_image};
pub use map_collector::median;
pub use map_collector::{FileSelection, MapCollector};
pub use penetration::{Penetration, find_deepest_point, find_penetration};
pub use presses::{DeepestContact, compile_indenters, find_deepest_contact};
pub use projector::{are_visible, project_points};
pub use viewpoint::{InvalidViewpoint, Viewpoint};
