//! Exact ray casting of solids. For now: shaded pictures of parts and assemblies.

use fabkit_geometry::{Body, Pose, Vector3};

/// One body in a picture.
#[derive(Clone, Debug)]
pub struct Actor {
    /// What is drawn.
    pub body: Body,
    /// Where it stands.
    pub scene_from_body: Pose,
    /// sRGB.
    pub color: [u8; 3],
    /// 0 to 1; below 1, what lies behind shows through.
    pub opacity: f64,
}

/// From where, and how large.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Image width, px.
    pub width_px: u32,
    /// Image height, px.
    pub height_px: u32,
    /// Direction in which the viewer looks, scene frame; the image's up is z's as far as possible.
    pub looking: Vector3<f64>,
}

/// An opaque sRGB image, row by row from the top, three bytes a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// px.
    pub width_px: u32,
    /// px.
    pub height_px: u32,
    /// `3 * width * height` bytes.
    pub rgb: Vec<u8>,
}

/// Draws a scene.
pub fn render(_actors: &[Actor], _view: &View) -> Picture {
    todo!()
}
