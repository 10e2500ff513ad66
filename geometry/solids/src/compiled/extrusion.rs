//! Extrusion of a profile along z: line crossings, containment and normals.

use nalgebra::Vector3;

use super::region::Region;
use super::shape::{Candidate, CastBuffers, LocalRay, Shape};
use crate::{Extrusion, roots::quadratic};

const BOTTOM: u32 = 0;
const TOP: u32 = 1;
/// Face number of the first segment's wall.
const FIRST_WALL: u32 = 2;

/// [`Extrusion`] prepared for queries.
#[derive(Clone, Debug)]
pub(crate) struct Prism {
    region: Region,
    height_mm: f64,
}

impl Prism {
    pub(crate) fn new(solid: &Extrusion) -> Self {
        Self { region: Region::new(&solid.profile), height_mm: solid.height_mm }
    }

    /// Returns the profile and the height, mm.
    pub(crate) fn parts(&self) -> (&Region, f64) {
        (&self.region, self.height_mm)
    }

    /// Adds candidates where the line may cross a wall, for parameters within `limits`.
    fn walls(&self, ray: &LocalRay, limits: [f64; 2], work: &mut CastBuffers) {
        let (o, d) = (ray.origin.xy(), ray.direction.xy());
        let mut offer = |k: usize, t_mm: f64| {
            let within = limits[0] < t_mm && t_mm < limits[1];
            if within && self.region.edges[k].accepts(o + t_mm * d) {
                work.candidates.push(Candidate { t_mm, face: FIRST_WALL + k as u32 });
            }
        };
        for (k, edge) in self.region.edges.iter().enumerate() {
            match &edge.ellipse {
                None if edge.is_missed_by_line(o, d) => {}
                None => {
                    let along = edge.to - edge.from;
                    let approach = d.perp(&along);
                    if approach != 0.0 {
                        offer(k, (edge.from - o).perp(&along) / approach);
                    }
                }
                Some(ellipse) => {
                    // In coordinates scaled by the half axes the ellipse is the unit circle.
                    let from_centre = (o - ellipse.centre).component_div(&ellipse.half_axes);
                    let step = d.component_div(&ellipse.half_axes);
                    let c = from_centre.norm_squared() - 1.0;
                    let roots = quadratic(step.norm_squared(), from_centre.dot(&step), c);
                    roots.as_slice().iter().for_each(|&t_mm| offer(k, t_mm));
                }
            }
        }
    }
}

impl Shape for Prism {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        self.region.support(u.xy()) + (self.height_mm * u.z).max(0.0)
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        0.0 < p.z && p.z < self.height_mm && self.region.contains(p.xy())
    }

    fn normal(&self, face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        match face {
            BOTTOM => -Vector3::z(),
            TOP => Vector3::z(),
            wall => {
                let edge = &self.region.edges[(wall - FIRST_WALL) as usize];
                edge.outward(p.xy()).push(0.0)
            }
        }
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        let (z, dz) = (ray.origin.z, ray.direction.z);
        let mut limits = [-ray.reach_mm, ray.reach_mm];
        // A horizontal line crosses no cap: it is within the slab along its whole length, or never.
        if dz == 0.0 {
            if z <= 0.0 || z >= self.height_mm {
                return;
            }
        } else {
            let (bottom, top) = (-z / dz, (self.height_mm - z) / dz);
            limits = [bottom.min(top), bottom.max(top)];
            for (t_mm, face) in [(bottom, BOTTOM), (top, TOP)] {
                work.candidates.push(Candidate { t_mm, face });
            }
        }
        self.walls(ray, limits, work);
        work.candidates_to_chords(|t_mm| self.region.contains(ray.at(t_mm).xy()));
    }
}
