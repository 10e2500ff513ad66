//! Revolution of a profile around z: line crossings, containment and normals.

use nalgebra::{Vector2, Vector3};

use super::region::{Edge, Region};
use super::ring::{meridian, refine_root, rotate_to_azimuth, swept_ellipse};
use super::shape::{Candidate, CastBuffers, LocalRay, Shape};
use crate::{Revolution, roots::quadratic};

/// [`Revolution`] prepared for queries.
#[derive(Clone, Debug)]
pub(crate) struct RevolutionShape {
    region: Region,
}

impl RevolutionShape {
    pub(crate) fn new(solid: &Revolution) -> Self {
        Self { region: Region::new(&solid.profile) }
    }

    /// Returns the profile, in coordinates (distance from z, z).
    pub(crate) fn region(&self) -> &Region {
        &self.region
    }
}

/// Line in coordinates (distance from z, z), for rejecting edges far from it cheaply.
struct MeridianLine<'a> {
    ray: &'a LocalRay,
    /// Squared distance from z along the line: `s[2] t^2 + 2 s[1] t + s[0]`.
    s: [f64; 3],
    /// Parameter at which the line is nearest to z, mm.
    nearest_mm: f64,
    per_height: f64,
}

impl<'a> MeridianLine<'a> {
    fn new(ray: &'a LocalRay) -> Self {
        let (o, d) = (ray.origin.xy(), ray.direction.xy());
        let s = [o.norm_squared(), o.dot(&d), d.norm_squared()];
        let nearest_mm = if s[2] > 0.0 { -s[1] / s[2] } else { 0.0 };
        Self { ray, s, nearest_mm, per_height: 1.0 / ray.direction.z }
    }

    fn squared(&self, t_mm: f64) -> f64 {
        (self.s[2] * t_mm + 2.0 * self.s[1]) * t_mm + self.s[0]
    }

    /// Returns the parameters between which the line has the heights of the edge, mm; `None` if it is nowhere near the
    /// edge there.
    fn parameter_range(&self, edge: &Edge) -> Option<[f64; 2]> {
        let (z, reach_mm) = (self.ray.origin.z, 2.0 * self.ray.reach_mm);
        let mut between = [-reach_mm, reach_mm];
        if self.ray.direction.z == 0.0 {
            if z < edge.low.y || z > edge.high.y {
                return None;
            }
        } else {
            let ends = [edge.low.y, edge.high.y].map(|height| (height - z) * self.per_height);
            between = [ends[0].min(ends[1]).max(-reach_mm), ends[0].max(ends[1]).min(reach_mm)];
            if between[0] > between[1] {
                return None;
            }
        }
        let ends = between.map(|t_mm| self.squared(t_mm));
        let is_passed = between[0] < self.nearest_mm && self.nearest_mm < between[1];
        let nearest = if is_passed { self.squared(self.nearest_mm) } else { ends[0].min(ends[1]) };
        // Compared with the range of distances from z that the line has beside the edge.
        let (inner, outer) = (edge.low.x.max(0.0), edge.high.x);
        // Rounding errors of squares scale with the line's reach, not with the edge's size.
        let rounding = 1e-12 * reach_mm * reach_mm;
        let meets =
            nearest <= outer * outer + rounding && ends[0].max(ends[1]) >= inner * inner - rounding;
        meets.then_some(between)
    }
}

/// Offers the parameters where the line may cross the plane, cylinder or cone that a straight edge sweeps around z.
fn swept_line(edge: &Edge, ray: &LocalRay, mut offer: impl FnMut(f64)) {
    let (o, d) = (&ray.origin, &ray.direction);
    let along = (edge.to - edge.from).normalize();
    if along.y == 0.0 {
        if d.z != 0.0 {
            offer((edge.from.y - o.z) / d.z);
        }
        return;
    }
    // The edge's line is along.y r = w(z), linear in z; squared it is a quadric. Dividing by neither component treats
    // flat and steep edges alike.
    let w = along.y * edge.from.x + along.x * (o.z - edge.from.y);
    let dw = along.x * d.z;
    let squared = along.y * along.y;
    let a = squared * d.xy().norm_squared() - dw * dw;
    let half_b = squared * o.xy().dot(&d.xy()) - w * dw;
    let c = squared * o.xy().norm_squared() - w * w;
    for &root in quadratic(a, half_b, c).as_slice() {
        // One Newton step on the unsquared equation restores the digits that squaring cost on edges that are nearly
        // flat.
        let p = ray.at(root);
        let r = meridian(&p).x;
        let value = along.y * r - (w + root * dw);
        let slope = along.y * p.xy().dot(&d.xy()) / r - dw;
        let step = value / slope;
        // A large step means a root of the mirrored cone or a tangent; the root is kept as it is.
        let is_small = step.is_finite() && step.abs() < 1e-6 * ray.reach_mm;
        offer(if is_small { root - step } else { root });
    }
}

impl Shape for RevolutionShape {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        self.region.support(meridian(u))
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        self.region.contains(meridian(p))
    }

    fn normal(&self, face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        rotate_to_azimuth(self.region.edges[face as usize].outward(meridian(p)), p)
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        let passing = MeridianLine::new(ray);
        for (k, edge) in self.region.edges.iter().enumerate() {
            let Some(between_mm) = passing.parameter_range(edge) else { continue };
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
                    for &root in swept_ellipse(ellipse, ray, between_mm).as_slice() {
                        offer(refine_root(ellipse, ray, root));
                    }
                }
            }
        }
        work.candidates_to_chords(|t_mm| self.contains(&ray.at(t_mm)));
    }
}
