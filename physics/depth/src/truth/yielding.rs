//! Surfaces that give way: pressed in where something touches, and bulging beside it.
//!
//! Elastic contact says how far each place of the surface has moved along its normal at rest. A camera ray ends
//! where its depth below the surface at rest is what the surface has been pressed in at its foot:
//! `depth(t) + outwards(foot(t)) = 0`. Where a presser pushes, the ray ends on it, exactly; and wherever it is
//! nearer: the gel does not reach into it, and between the nodes of a solution it might by some micrometres.

use fabkit_geometry::{Point3, Ray, TouchSurface, Vector3};
use rayon::prelude::*;

use super::map::{DepthMap, SURFACE_LABEL};
use super::presser::Presser;
use super::reference::ReferenceSurface;

/// How near to the surface a ray ends, mm.
const NEAR_MM: f64 = 1e-7;
/// The same as a part of what is not worth looking at.
const NEAR_OF_STILL: f64 = 0.05;
/// Steps of the secant until it is given up.
const SECANT_STEPS: usize = 12;
/// Steps along a ray that only grazes, in which its first crossing is looked for, and halvings then.
const MARCH_STEPS: u32 = 64;
const HALVINGS: u32 = 40;
/// Places that move by less keep their normal, mm.
const STILL_MM: f64 = 1e-6;
/// Steps of the differences that give normals, mm: what they leave out and what is rounded are both some 1e-6 of it.
const NORMAL_STEP_MM: f64 = 1e-5;
/// A ray that meets the surface flatter than this is marched along, cosine.
const GRAZING: f64 = 0.05;

/// What elastic contact says of a surface.
pub trait Yielding: Sync {
    /// How far it has moved outwards, mm, along the outward unit normal of a point of the surface at rest, sensor
    /// frame; negative where it is pressed in.
    fn outwards_mm(&self, point_in_sensor: &Point3<f64>, outward: &Vector3<f64>) -> f64;

    /// Whether something pushes it there.
    fn is_touched(&self, point_in_sensor: &Point3<f64>, outward: &Vector3<f64>) -> bool;

    /// How far any place has moved in and out at most, mm, both positive.
    fn limits_mm(&self) -> [f64; 2];
}

/// The moved surface along one ray.
struct Along<'a> {
    touch: &'a TouchSurface,
    moved: &'a dyn Yielding,
    ray: &'a Ray,
    near_mm: f64,
}

impl Along<'_> {
    /// How deep below the moved surface the ray is at a range, mm.
    #[inline]
    fn depth_mm(&self, range_mm: f64) -> f64 {
        below_mm(self.touch, self.moved, &self.ray.at(range_mm))
    }

    /// Where the ray leaves the gel, from where it would at rest: its range, and how deep it is there.
    fn exit_mm(&self, rest: [f64; 2], cosine: f64) -> [f64; 2] {
        let marched = || {
            let range_mm = self.march_mm(rest[0]);
            [range_mm, self.depth_mm(range_mm)]
        };
        let mut at = rest;
        if at[1].abs() <= self.near_mm {
            return rest;
        }
        if cosine < GRAZING {
            return marched();
        }
        let mut next_mm = at[0] + at[1] / cosine;
        for _ in 0..SECANT_STEPS {
            let next = [next_mm, self.depth_mm(next_mm)];
            if next[1].abs() <= self.near_mm {
                return next;
            }
            let slope = (next[1] - at[1]) / (next[0] - at[0]);
            // Further along a ray that leaves the gel it is less deep.
            if slope.is_nan() || slope >= -0.2 * cosine {
                break;
            }
            next_mm = next[0] - next[1] / slope;
            at = next;
        }
        marched()
    }

    /// The first crossing in steps: where a ray only grazes, or flanks are steep.
    fn march_mm(&self, rest_mm: f64) -> f64 {
        let [inwards_mm, outwards_mm] = self.moved.limits_mm();
        // What a ray meets flat it meets far off: a circle's chord of that height.
        let radius_mm = self.touch.least_curvature_radius_mm().min(50.0);
        let reach = |mm: f64| (2.0 * radius_mm * mm).sqrt() + mm;
        let (from, to) = ((rest_mm - reach(inwards_mm)).max(0.0), rest_mm + reach(outwards_mm));
        let place = |i: u32| from + (to - from) * f64::from(i) / f64::from(MARCH_STEPS);
        let first = (1..=MARCH_STEPS).find(|i| self.depth_mm(place(*i)) <= 0.0);
        let Some(first) = first else { return rest_mm };
        let (mut inside, mut outside) = (place(first - 1), place(first));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            *(if self.depth_mm(middle) > 0.0 { &mut inside } else { &mut outside }) = middle;
        }
        0.5 * (inside + outside)
    }
}

/// How deep a point lies below the moved surface, mm.
#[inline]
fn below_mm(touch: &TouchSurface, moved: &dyn Yielding, point: &Point3<f64>) -> f64 {
    let (depth_mm, outward) = touch.depth_mm(point);
    depth_mm + moved.outwards_mm(&(point + depth_mm * outward), &outward)
}

impl Along<'_> {
    /// Out of the moved surface at a range where it is so deep: along the normal at rest depth changes as range does, as
    /// the foot stays, so that two differences across it are enough.
    fn normal(&self, [range_mm, depth_mm]: [f64; 2]) -> Vector3<f64> {
        let point = self.ray.at(range_mm);
        let (_, outward) = self.touch.depth_mm(&point);
        let aside = if outward.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() };
        let first = outward.cross(&aside).normalize();
        let across = [first, outward.cross(&first)].map(|way| {
            let there_mm = below_mm(self.touch, self.moved, &(point + NORMAL_STEP_MM * way));
            (there_mm - depth_mm) / NORMAL_STEP_MM * way
        });
        (outward - across[0] - across[1]).normalize()
    }
}

impl ReferenceSurface<'_> {
    /// The map of a surface that has given way to pressers, whose labels follow [`SURFACE_LABEL`] in their order: a
    /// pixel has one where the presser is in its place and pushes. Normals are found if they are wanted.
    pub fn yielded(
        &self,
        pressers: &[Presser],
        moved: &dyn Yielding,
        has_normals: bool,
    ) -> DepthMap<'_> {
        self.yielded_beyond(0.0, pressers, moved, has_normals)
    }

    /// The same, but where no presser is and the surface moves by no more than that, mm, rays end where they do at rest: most
    /// of a picture is then found at a single look.
    pub fn yielded_beyond(
        &self,
        still_mm: f64,
        pressers: &[Presser],
        moved: &dyn Yielding,
        has_normals: bool,
    ) -> DepthMap<'_> {
        let mut map = self.pressed(pressers);
        let touch = &self.touch;
        let near_mm = (NEAR_OF_STILL * still_mm).max(NEAR_MM);
        let pixels = (0..map.range_mm.len()).into_par_iter();
        let seen = |pixel: usize| -> Option<(usize, f64, bool, Option<Vector3<f64>>)> {
            let rest_mm = self.range_mm()[pixel];
            let ray = self.rays().ray(pixel).filter(|_| rest_mm.is_finite())?;
            let is_rigid = map.label[pixel] > SURFACE_LABEL;
            let along = Along { touch, moved, ray: &ray, near_mm };
            let rest = [rest_mm, along.depth_mm(rest_mm)];
            if !is_rigid && rest[1].abs() <= still_mm {
                return None;
            }
            let (_, outward) = touch.depth_mm(&ray.at(rest_mm));
            let gel = along.exit_mm(rest, outward.dot(&ray.direction));
            let gel_mm = gel[0];
            let rigid_mm = map.range_mm[pixel];
            let is_touched = is_rigid && {
                let point = ray.at(rigid_mm);
                let (depth_mm, outward) = touch.depth_mm(&point);
                moved.is_touched(&(point + depth_mm * outward), &outward)
            };
            let is_presser = is_touched || is_rigid && rigid_mm <= gel_mm;
            let range_mm = if is_presser { rigid_mm } else { gel_mm };
            let is_moved = has_normals && !is_presser && (range_mm - rest_mm).abs() > STILL_MM;
            let normal = is_moved.then(|| along.normal(gel));
            let is_new = is_rigid || range_mm != rest_mm;
            is_new.then_some((pixel, range_mm, is_touched, normal))
        };
        let found: Vec<_> = pixels.filter_map(seen).collect();
        for (pixel, range_mm, is_touched, normal) in found {
            map.range_mm[pixel] = range_mm;
            if !is_touched && map.label[pixel] > SURFACE_LABEL {
                map.label[pixel] = SURFACE_LABEL;
            }
            map.moved.extend(normal.map(|normal| (pixel as u32, normal)));
        }
        map
    }
}
