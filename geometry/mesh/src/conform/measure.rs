//! Deviation of new triangles from the exact face.

use fabkit_geometry::{PlacedPrimitive, Vector3};

use crate::surface::LeafSurface;

/// Barycentric coordinates at which a triangle is compared with the face: its centroid and the midpoints of its edges.
const SAMPLES: [[f64; 3]; 4] =
    [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];

/// Fraction of the tolerance that the samples may reach: where the curvature of the face varies along an edge, the
/// largest deviation is not at its midpoint.
const SAMPLED_SHARE: f64 = 0.95;

pub(super) struct DeviationCheck {
    surface: LeafSurface,
    most_mm: f64,
}

impl DeviationCheck {
    /// Prepares the comparison with one face of a leaf; `None` if there is no such face.
    pub fn new(leaf: &PlacedPrimitive, face: u32, tolerance_mm: f64) -> Option<Self> {
        let surface = LeafSurface::new(&leaf.primitive, face, leaf.body_from_leaf)?;
        Some(Self { surface, most_mm: SAMPLED_SHARE * tolerance_mm })
    }

    /// Returns whether the triangle deviates from the face by less than the tolerance.
    pub fn is_within_tolerance(&self, corners: [[f64; 3]; 3]) -> bool {
        SAMPLES.iter().all(|weights| {
            let [a, b, c] = [0, 1, 2].map(|i| weights[i] * Vector3::from(corners[i]));
            self.surface.offset((a + b + c).into()).distance_mm.abs() <= self.most_mm
        })
    }
}
