//! Intersections of rays with the bodies of a sensor.

use fabkit_geometry::{
    Assembly, CompiledSolid, Elasticity, Point3, Ray, Scratch, Sensor, TouchSurface, Vector3,
};

use super::error::SoftError;

/// Gap below which an interval continues the one before, mm.
const JOINT_MM: f64 = 1e-3;
/// Depth up to which layers count as soft, as a part of a dome's smallest radius of curvature.
const DEEPEST: f64 = 0.75;

/// A body placed in the sensor.
pub(super) struct PlacedBody {
    pub(super) name: String,
    pub(super) material: String,
    pub(super) elasticity: Option<Elasticity>,
    pub(super) solid: CompiledSolid,
}

/// Interval of a ray inside one body, mm.
#[derive(Clone, Copy)]
pub(super) struct RayInterval {
    pub(super) body: usize,
    pub(super) begin_mm: f64,
    pub(super) end_mm: f64,
}

/// Soft bodies below a point of the surface.
pub(super) struct SoftColumn {
    /// Intervals from outside inwards, each beginning where the one before ends.
    pub(super) soft: Vec<RayInterval>,
    /// True if something rigid follows.
    pub(super) is_held: bool,
    /// Body that follows; `None` if there is none, or the depth limit is reached.
    pub(super) next: Option<usize>,
}

/// All bodies of a sensor, and the depth up to which they count as soft, mm.
pub(super) struct Bodies {
    pub(super) placed: Vec<PlacedBody>,
    pub(super) deepest_mm: f64,
}

impl Bodies {
    /// Compiles the bodies of the finished sensor.
    pub(super) fn from_sensor(sensor: &Sensor) -> Result<Self, SoftError> {
        let (mut placed, mut unknown) = (Vec::new(), Vec::new());
        for body in &sensor.bodies {
            let is_soft = body.gives_way();
            let is_in_sensor = body.placements.iter().any(|p| p.assembly == Assembly::sensor());
            if is_soft && is_in_sensor && body.substance.elasticity.is_none() {
                unknown.push(format!("{} of {}", body.name, body.material));
            }
            for place in body.placements.iter().filter(|p| p.assembly == Assembly::sensor()) {
                let solid = body.solid.clone().placed(place.assembly_from_body);
                let solid = CompiledSolid::new(&solid)?;
                let elasticity = body.substance.elasticity.clone();
                placed.push(PlacedBody {
                    name: body.name.clone(),
                    material: body.material.clone(),
                    elasticity: elasticity.filter(|_| is_soft),
                    solid,
                });
            }
        }
        if !unknown.is_empty() {
            return Err(SoftError::UnknownElasticity { layers: unknown.join(", ") });
        }
        // Normals of a dome meet in its centre: far below a press, soft material is treated as rigid.
        let curvature = |touch: &TouchSurface| DEEPEST * touch.least_curvature_radius_mm();
        let deepest_mm = sensor.touch.as_ref().map_or(f64::INFINITY, curvature);
        Ok(Self { placed, deepest_mm })
    }

    /// Returns the intervals of all bodies on a ray, in the order in which they begin.
    pub(super) fn intersect(&self, ray: &Ray) -> Vec<RayInterval> {
        let (mut scratch, mut found, mut met) = (Scratch::default(), Vec::new(), Vec::new());
        for (body, placed) in self.placed.iter().enumerate() {
            placed.solid.stretches_into(ray, &mut scratch, &mut found);
            met.extend(found.iter().map(|&[begin_mm, end_mm]| RayInterval {
                body,
                begin_mm,
                end_mm,
            }));
        }
        met.sort_by(|a, b| a.begin_mm.total_cmp(&b.begin_mm));
        met
    }

    /// Returns the soft bodies below a point of the surface, along its inward normal.
    pub(super) fn find_soft_below(&self, place: Point3<f64>, outward: Vector3<f64>) -> SoftColumn {
        // From 1 mm outside, so that the ray crosses the surface itself.
        let ray = Ray { origin: place + outward, direction: -outward };
        self.follow(&self.intersect(&ray), 1.0, self.deepest_mm)
    }

    /// Returns the soft bodies on a ray from the first one on, at any depth. Intervals are measured from the ray's
    /// origin.
    pub(super) fn first_soft(&self, ray: &Ray) -> SoftColumn {
        let met = self.intersect(ray);
        let first = met.iter().find(|stretch| self.placed[stretch.body].elasticity.is_some());
        let begin_mm = first.map_or(0.0, |first| first.begin_mm);
        let mut column = self.follow(&met, begin_mm, f64::INFINITY);
        for stretch in &mut column.soft {
            stretch.begin_mm += begin_mm;
            stretch.end_mm += begin_mm;
        }
        column
    }

    /// Follows adjoining soft bodies from a point of the ray; depths are measured from there.
    fn follow(&self, met: &[RayInterval], from_mm: f64, deepest_mm: f64) -> SoftColumn {
        let (mut soft, mut at_mm) = (Vec::<RayInterval>::new(), from_mm);
        loop {
            let next =
                met.iter().find(|s| (s.begin_mm - at_mm).abs() < JOINT_MM && s.end_mm > at_mm);
            match next {
                Some(next) if self.placed[next.body].elasticity.is_some() => {
                    at_mm = next.end_mm.min(from_mm + deepest_mm);
                    soft.push(RayInterval {
                        begin_mm: next.begin_mm - from_mm,
                        end_mm: at_mm - from_mm,
                        ..*next
                    });
                    // Cut off at the depth limit: treated as held.
                    if next.end_mm > at_mm {
                        return SoftColumn { soft, is_held: true, next: None };
                    }
                }
                other => {
                    let next = other.map(|stretch| stretch.body);
                    return SoftColumn { soft, is_held: next.is_some(), next };
                }
            }
        }
    }
}
