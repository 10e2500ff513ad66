//! Reports as single HTML files, with drawings as inline SVG.
//!
//! Pages need neither network nor scripts, and print well. Drawings have pixel coordinates of their own, y down.
//!
//! ```
//! use fabkit_report::{Plot, page};
//! let mut plot = Plot::between([[10.0, 20.0], [0.0, 1.0]], ["radius, mm", "seen"]);
//! plot.dot([15.0, 0.4], "#1f4e79", "variant 3");
//! let html = page("A sweep", &format!("<figure>{}</figure>\n", plot.finish("seen against radius")));
//! assert!(html.contains("<svg") && !html.contains("http"));
//! ```

#![forbid(unsafe_code)]

mod page;
mod plot;
mod svg;

pub use page::{page, page_with_style};
pub use plot::{Plot, round_tick_step};
pub use svg::{
    BORDER_STYLE, LOWER_BOUND_STYLE, NO_DATA_STYLE, RESIDUAL_STYLE, Svg, escape, heat_color,
};
