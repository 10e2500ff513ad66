//! Surfaces that rays see.

use fabkit_geometry::{Point3, Vector3};

/// Stands for the leaf number of a face that the cut has made.
pub(super) const CUT_LEAF: u32 = u32::MAX;

/// A surface that a ray sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenSurface {
    pub t: f64,
    /// Scene frame, mm.
    pub point: Point3<f64>,
    /// Scene frame, unit length, towards the viewer.
    pub normal: Vector3<f64>,
    pub actor: u32,
    pub leaf: u32,
    pub face: u32,
    /// How strongly lines on it show, 0 to 1: less on and behind what lets light through.
    pub line_weight: f64,
}
