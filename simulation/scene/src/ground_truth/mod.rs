//! Ground truth for one camera: its viewpoint, the coverage of a sensor's surface, presses, and output files.

mod map_collector;
mod coverage;
mod coverage_map;
mod files;
mod projector;
mod penetration;
mod presses;
pub mod probes;
mod viewpoint;

pub use map_collector::median;
pub use map_collector::{MapCollector, FileSelection};
pub use coverage::{OUTSIDE_IMAGE, REFRACTION, SurfaceCoverage, compute_coverage};
pub use coverage_map::draw_coverage_map;
pub use files::{GREY_STEP_MM, MapQuantity, arrays, false_color_image};
pub use projector::{are_visible, project_points};
pub use penetration::{Penetration, find_deepest_point, find_penetration};
pub use presses::{DeepestContact, find_deepest_contact, compile_indenters};
pub use viewpoint::{InvalidViewpoint, Viewpoint};
