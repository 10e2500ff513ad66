//! How far new triangles stray from the exact face.

use fabkit_geometry::{PlacedPrimitive, Vector3};

use crate::surface::LeafSurface;

/// Where a triangle is compared with the face: in its middle and halfway along its edges.
const SAMPLES: [[f64; 3]; 4] =
    [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];

/// Share of the tolerance that the samples may reach: where the face bends more at one end of an edge
/// than at the other, the edge is farthest from it beside its middle.
const SAMPLED_SHARE: f64 = 0.95;

pub(super) struct Measure {
    surface: LeafSurface,
    most_mm: f64,
}

impl Measure {
    /// Of one face of a leaf; `None` if there is no such face.
    pub fn new(leaf: &PlacedPrimitive, face: u32, tolerance_mm: f64) -> Option<Self> {
        let surface = LeafSurface::new(&leaf.primitive, face, leaf.body_from_leaf)?;
        Some(Self { surface, most_mm: SAMPLED_SHARE * tolerance_mm })
    }

    /// Whether the triangle keeps to the face.
    pub fn holds(&self, corners: [[f64; 3]; 3]) -> bool {
        SAMPLES.iter().all(|weights| {
            let [a, b, c] = [0, 1, 2].map(|i| weights[i] * Vector3::from(corners[i]));
            self.surface.offset((a + b + c).into()).distance_mm.abs() <= self.most_mm
        })
    }
}
