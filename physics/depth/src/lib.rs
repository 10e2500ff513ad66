//! Exact ray casting of solids: shaded images of parts and assemblies, and ground-truth depth maps.
//!
//! # Conventions
//!
//! - Millimetres and radians, `f64` throughout. There are no triangles anywhere: every sample is a ray through the
//!   exact surfaces, so an image shows the part and not its tessellation.
//! - The *scene* frame is right-handed with z up. Bodies are placed in it by `scene_from_body`.
//! - Rays have unit directions, so a crossing's `t` is the range along the ray in mm.
//! - Image coordinates are in pixels, x to the right, y downwards, the first pixel's *centre* at (0.5, 0.5).
//! - Results are deterministic to the byte: every sample is a pure function of its position, and threads only decide
//!   who computes it.
//!
//! [`Scene`] intersects rays with bodies and knows nothing of pixels. [`render`] casts one or more rays per pixel,
//! shades by the true normals and draws lines at discontinuities of the surface.
//!
//! ```
//! use fabkit_depth::{Actor, View, render};
//! use fabkit_geometry::{CompiledSolid, Solid};
//!
//! let ball = Actor::new(CompiledSolid::new(&Solid::sphere(5.0))?, [200, 120, 60]);
//! let image = render(&[ball], &View::isometric(64, 48))?;
//! let centre = image.pixel(32, 24);
//! assert!(centre[0] > centre[2], "the ball is orange");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cast;
pub mod ground_truth;
mod rendering;

pub use cast::{Hit, Scene, SceneScratch};
pub use rendering::{
    Actor, Framing, MAX_PIXELS, PixelContent, RenderError, RenderedImage, SectionCut, View,
    ViewProjection, contact_sheet, render, render_camera_view, render_with_framing,
    render_with_progress,
};
