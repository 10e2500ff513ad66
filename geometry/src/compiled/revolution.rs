//! Revolution of a profile around z.

use nalgebra::{Vector2, Vector3};

use super::region::{Edge, Region};
use super::ring::{meridian, polished, swept_ellipse, turned};
use super::shape::{Candidate, LocalRay, Shape, Work};
use crate::{Revolution, roots::quadratic};

/// A [`Revolution`] ready for questions.
#[derive(Clone, Debug)]
pub(crate) struct Spun {
    region: Region,
}

impl Spun {
    pub(crate) fn new(solid: &Revolution) -> Self {
        Self { region: Region::new(&solid.profile) }
    }

    /// The profile, in distance from z and z.
    pub(crate) fn region(&self) -> &Region {
        &self.region
    }
}

/// Where the line may pass the plane, cylinder or cone that a straight edge sweeps around z.
fn swept_line(edge: &Edge, ray: &LocalRay, mut offer: impl FnMut(f64)) {
    let (o, d) = (&ray.origin, &ray.direction);
    let along = (edge.to - edge.from).normalize();
    if along.y == 0.0 {
        if d.z != 0.0 {
            offer((edge.from.y - o.z) / d.z);
        }
        return;
    }
    // The edge's line is along.y r = w(z), linear in z; squared, a quadric. Dividing by neither
    // component keeps flat and steep edges alike.
    let w = along.y * edge.from.x + along.x * (o.z - edge.from.y);
    let dw = along.x * d.z;
    let squared = along.y * along.y;
    let a = squared * d.xy().norm_squared() - dw * dw;
    let half_b = squared * o.xy().dot(&d.xy()) - w * dw;
    let c = squared * o.xy().norm_squared() - w * w;
    for &root in quadratic(a, half_b, c).as_slice() {
        // One Newton step on the unsquared equation restores the digits that squaring cost on
        // edges that are nearly flat.
        let p = ray.at(root);
        let r = p.x.hypot(p.y);
        let value = along.y * r - (w + root * dw);
        let slope = along.y * p.xy().dot(&d.xy()) / r - dw;
        let step = value / slope;
        let is_small = step.is_finite() && step.abs() < 1e-6 * ray.reach_mm;
        offer(if is_small { root - step } else { root });
    }
}

impl Shape for Spun {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        self.region.support(meridian(u))
    }

    fn holds(&self, p: &Vector3<f64>) -> bool {
        self.region.holds(meridian(p))
    }

    fn normal(&self, face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        turned(self.region.edges[face as usize].outward(meridian(p)), p)
    }

    fn cast(&self, ray: &LocalRay, work: &mut Work) {
        for (k, edge) in self.region.edges.iter().enumerate() {
            let mut offer = |t_mm: f64| {
                let p: Vector2<f64> = meridian(&ray.at(t_mm));
                if edge.accepts(p) {
                    work.candidates.push(Candidate { t_mm, face: k as u32 });
                }
            };
            match &edge.ellipse {
                // An edge on the axis sweeps no surface.
                None if edge.from.x == 0.0 && edge.to.x == 0.0 => {}
                None => swept_line(edge, ray, offer),
                Some(ellipse) => {
                    for &root in swept_ellipse(ellipse, ray).as_slice() {
                        offer(polished(ellipse, ray, root));
                    }
                }
            }
        }
        work.keep_changes(|t_mm| self.holds(&ray.at(t_mm)));
    }
}
