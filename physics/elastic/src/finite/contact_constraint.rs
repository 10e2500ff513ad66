//! Contact constraints of the deformed surface: the indenter above each node, and the rings in contact.

use fabkit_geometry::{Point3, Vector3};

use crate::indenter::Indenter;
use crate::rings::{Ring, Rings};

/// Step of the finite difference for the indenter's slope, mm.
const SLOPE_STEP_MM: f64 = 1e-4;
/// Step of the finite difference for the curvature, mm. It speeds up the iteration without changing its result.
const CURVATURE_STEP_MM: f64 = 1e-3;
/// Distance above and below a displaced node within which the indenter counts, mm.
const REACH_MM: f64 = 1e3;

/// Nodes that one pressure acts on: those of a ring. The first ring includes the pole.
///
/// The pole's own pressure acts on nearly no area, and its displacement follows from that of its neighbours.
pub(super) struct ContactConstraint {
    weight: f64,
    pub shares: Vec<(usize, f64)>,
}

/// Creates the constraints of all rings; the pole's ring is merged with the next one.
pub(super) fn contact_constraints(rings: &Rings) -> Vec<ContactConstraint> {
    let grip = |ring: &Ring| ContactConstraint {
        weight: ring.weight,
        shares: ring.column_weights.clone(),
    };
    let mut grips: Vec<ContactConstraint> = rings.rings[1..].iter().map(grip).collect();
    if let Some(first) = grips.first_mut() {
        first.weight += rings.rings[0].weight;
        first.shares.extend(&rings.rings[0].column_weights);
    }
    grips
}

/// Gap along the axis between a displaced point and the indenter, with its derivatives by the radius.
pub(super) struct IndenterGap {
    pub gap_mm: f64,
    pub slope: f64,
    pub curvature: f64,
}

impl IndenterGap {
    /// Measures the indenter above a point given by radius and height, mm.
    pub fn new(presser: &dyn Indenter, [r_mm, z_mm]: [f64; 2], shift_mm: &Vector3<f64>) -> Self {
        let gap = |by_mm: f64| {
            let place = Point3::new(r_mm + by_mm, 0.0, z_mm) - shift_mm;
            presser.gap_mm(&place, &Vector3::z(), REACH_MM)
        };
        // Gaps to both sides; infinite values at the indenter's edge make slope or curvature not finite.
        let here = gap(0.0);
        let (inner, outer) = (gap(-SLOPE_STEP_MM), gap(SLOPE_STEP_MM));
        let (far_in, far_out) = (gap(-CURVATURE_STEP_MM), gap(CURVATURE_STEP_MM));
        let curvature = (far_in - 2.0 * here + far_out) / CURVATURE_STEP_MM.powi(2);
        Self {
            gap_mm: here,
            slope: (outer - inner) / (2.0 * SLOPE_STEP_MM),
            curvature: if curvature.is_finite() { curvature } else { 0.0 },
        }
    }
}

impl ContactConstraint {
    /// Mean gap of the ring, mm; infinite at the indenter's edge and beside it.
    pub fn gap_mm(&self, above: &[IndenterGap]) -> f64 {
        let sum: f64 =
            self.shares.iter().map(|&(column, share)| share * above[column].gap_mm).sum();
        let is_whole = self.shares.iter().all(|&(column, _)| above[column].slope.is_finite());
        if is_whole && sum.is_finite() { sum / self.weight } else { f64::INFINITY }
    }
}
