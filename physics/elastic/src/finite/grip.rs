//! What holds a moved surface: the presser above each of its nodes, and rings that it pushes.

use fabkit_geometry::{Point3, Vector3};

use crate::presser::Presser;
use crate::rings::{Ring, Rings};

/// Over what a presser's slope is measured, mm.
const SLOPE_STEP_MM: f64 = 1e-4;
/// Over what its curvature is, mm; it speeds the iteration up and does not change where it ends.
const CURVATURE_STEP_MM: f64 = 1e-3;
/// How far above and below a moved place its presser is looked for, mm.
const REACH_MM: f64 = 1e3;

/// What one pressure pushes: a ring, and the first one together with the pole.
///
/// The pole's own pressure acts on next to no area, and its place follows from that of its neighbours.
pub(super) struct Grip {
    weight: f64,
    pub shares: Vec<(usize, f64)>,
}

pub(super) fn grips(rings: &Rings) -> Vec<Grip> {
    let grip = |ring: &Ring| Grip { weight: ring.weight, shares: ring.shares.clone() };
    let mut grips: Vec<Grip> = rings.rings[1..].iter().map(grip).collect();
    if let Some(first) = grips.first_mut() {
        first.weight += rings.rings[0].weight;
        first.shares.extend(&rings.rings[0].shares);
    }
    grips
}

/// A presser above a moved place: along the axis, and how that changes with the radius.
pub(super) struct Above {
    pub gap_mm: f64,
    pub slope: f64,
    pub curvature: f64,
}

impl Above {
    /// Of a place by its radius and height, mm.
    pub fn new(presser: &dyn Presser, [r_mm, z_mm]: [f64; 2], shift_mm: &Vector3<f64>) -> Self {
        let gap = |by_mm: f64| {
            let place = Point3::new(r_mm + by_mm, 0.0, z_mm) - shift_mm;
            presser.gap_mm(&place, &Vector3::z(), REACH_MM)
        };
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

impl Grip {
    /// The mean gap around it, mm; infinite at the presser's edge and beside it.
    pub fn gap_mm(&self, above: &[Above]) -> f64 {
        let sum: f64 =
            self.shares.iter().map(|&(column, share)| share * above[column].gap_mm).sum();
        let is_whole = self.shares.iter().all(|&(column, _)| above[column].slope.is_finite());
        if is_whole && sum.is_finite() { sum / self.weight } else { f64::INFINITY }
    }
}
