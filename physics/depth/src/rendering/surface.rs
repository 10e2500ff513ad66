//! Surfaces that rays see.

use fabkit_geometry::{Point3, Vector3};

/// Leaf number that stands for the face of a section cut.
pub(super) const CUT_LEAF: u32 = u32::MAX;

/// A surface that a ray sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct VisibleSurface {
    pub t: f64,
    /// Point on the surface, scene frame, mm.
    pub point: Point3<f64>,
    /// Normal towards the viewer, scene frame, unit length.
    pub normal: Vector3<f64>,
    pub actor: u32,
    pub leaf: u32,
    pub face: u32,
    /// Strength of lines on the surface, 0 to 1: less on and behind translucent bodies.
    pub line_weight: f64,
}
