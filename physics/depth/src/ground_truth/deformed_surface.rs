//! Deformed surfaces: pressed in where something touches, and bulging beside it.
//!
//! Elastic contact supplies the displacement of each point of the surface along its undeformed normal. A camera ray
//! ends where its depth below the undeformed surface equals the indentation at the foot point, `depth(t) +
//! outwards(foot(t)) = 0`. Where an indenter pushes, the ray ends exactly on it, and also wherever it is nearer: gel
//! cannot reach into an indenter, but interpolation between a solution's nodes might by some micrometres.

use fabkit_geometry::{Point3, Ray, TouchSurface, Vector3};
use rayon::prelude::*;

use super::indenter::PlacedIndenter;
use super::map::{DepthMap, SURFACE_LABEL};
use super::reference::ReferenceSurface;

/// Tolerance of a ray's end, mm.
const NEAR_MM: f64 = 1e-7;
/// The same tolerance as a fraction of the displacement that is ignored.
const NEAR_OF_STILL: f64 = 0.05;
/// Maximum number of secant steps.
const SECANT_STEPS: usize = 12;
/// Steps along a grazing ray in the search for its first crossing, and number of bisections afterwards.
const MARCH_STEPS: u32 = 64;
const HALVINGS: u32 = 40;
/// Displacement below which a point keeps its undeformed normal, mm.
const STILL_MM: f64 = 1e-6;
/// Step of the differences for normals, mm: truncation and rounding errors are both some 1e-6 of it.
const NORMAL_STEP_MM: f64 = 1e-5;
/// Cosine of incidence below which a ray is marched.
const GRAZING: f64 = 0.05;

/// Displacement field of a surface under elastic contact.
///
/// ```
/// # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path};
/// # let grip = FixtureGrip {
/// #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// # let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
/// # let touch = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 2.0, grip }.into();
/// use fabkit_camera::Camera;
/// use fabkit_depth::ground_truth::{PixelRays, ReferenceSurface, SurfaceDisplacement};
/// use fabkit_geometry::{Point3, Pose, Vector3};
///
/// // A dome of radius 10 mm that is blown up by 0.2 mm everywhere, as by air within.
/// struct Inflated;
/// impl SurfaceDisplacement for Inflated {
///     fn outwards_mm(&self, _: &Point3<f64>, _: &Vector3<f64>) -> f64 {
///         0.2
///     }
///     fn is_touched(&self, _: &Point3<f64>, _: &Vector3<f64>) -> bool {
///         false
///     }
///     fn limits_mm(&self) -> [f64; 2] {
///         [0.0, 0.2]
///     }
/// }
/// let rays = PixelRays::new(&Camera::equidistant(9, 9, 2.0)?, &Pose::identity());
/// let surface = ReferenceSurface::cast(&touch, &rays)?;
/// let map = surface.map_deformed(&[], &Inflated, false);
/// assert!(map.range_mm().iter().all(|range_mm| (range_mm - 10.2).abs() < 1e-6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait SurfaceDisplacement: Sync {
    /// Returns the outward displacement, mm, along the outward unit normal of a point of the undeformed surface, sensor
    /// frame; negative where it is pressed in.
    fn outwards_mm(&self, point_in_sensor: &Point3<f64>, outward: &Vector3<f64>) -> f64;

    /// Returns whether an indenter pushes the surface there.
    fn is_touched(&self, point_in_sensor: &Point3<f64>, outward: &Vector3<f64>) -> bool;

    /// Returns the largest inward and outward displacement of any point, mm, both positive.
    fn limits_mm(&self) -> [f64; 2];
}

/// The deformed surface along one ray.
struct DeformedRay<'a> {
    touch: &'a TouchSurface,
    moved: &'a dyn SurfaceDisplacement,
    ray: &'a Ray,
    near_mm: f64,
}

impl DeformedRay<'_> {
    /// Depth of the ray below the deformed surface at a range, mm.
    #[inline]
    fn depth_mm(&self, range_mm: f64) -> f64 {
        depth_below_mm(self.touch, self.moved, &self.ray.at(range_mm))
    }

    /// Finds where the ray leaves the gel, starting from its undeformed exit. Arguments and results are pairs of range
    /// and depth.
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
        // First step: as if the surface were parallel to the undeformed one.
        let mut next_mm = at[0] + at[1] / cosine;
        for _ in 0..SECANT_STEPS {
            let next = [next_mm, self.depth_mm(next_mm)];
            if next[1].abs() <= self.near_mm {
                return next;
            }
            let slope = (next[1] - at[1]) / (next[0] - at[0]);
            // Along a ray that leaves the gel the depth decreases; otherwise the secant is unreliable.
            if slope.is_nan() || slope >= -0.2 * cosine {
                break;
            }
            next_mm = next[0] - next[1] / slope;
            at = next;
        }
        marched()
    }

    /// Finds the first crossing by marching, for grazing rays and steep flanks.
    fn march_mm(&self, rest_mm: f64) -> f64 {
        let [inwards_mm, outwards_mm] = self.moved.limits_mm();
        // A displacement shifts a grazing ray's end by up to the chord of a circle of that height.
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

/// Computes the depth of a point below the deformed surface, mm.
#[inline]
fn depth_below_mm(
    touch: &TouchSurface,
    moved: &dyn SurfaceDisplacement,
    point: &Point3<f64>,
) -> f64 {
    let (depth_mm, outward) = touch.depth_mm(point);
    depth_mm + moved.outwards_mm(&(point + depth_mm * outward), &outward)
}

impl DeformedRay<'_> {
    /// Computes the normal out of the deformed surface at a range with a known depth. Along the undeformed normal,
    /// depth changes as range does and the foot point stays, so that two differences across it suffice.
    fn normal(&self, [range_mm, depth_mm]: [f64; 2]) -> Vector3<f64> {
        let point = self.ray.at(range_mm);
        let (_, outward) = self.touch.depth_mm(&point);
        // Any vector that is not nearly parallel to the normal.
        let aside = if outward.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() };
        let first = outward.cross(&aside).normalize();
        let across = [first, outward.cross(&first)].map(|way| {
            let there_mm = depth_below_mm(self.touch, self.moved, &(point + NORMAL_STEP_MM * way));
            (there_mm - depth_mm) / NORMAL_STEP_MM * way
        });
        (outward - across[0] - across[1]).normalize()
    }
}

impl ReferenceSurface<'_> {
    /// Computes the map of a surface deformed by indenters, whose labels follow [`SURFACE_LABEL`] in list order. A
    /// pixel gets an indenter's label where that is in its place and pushes. Normals are computed if `has_normals`.
    pub fn map_deformed(
        &self,
        indenters: &[PlacedIndenter],
        moved: &dyn SurfaceDisplacement,
        has_normals: bool,
    ) -> DepthMap<'_> {
        self.map_deformed_beyond(0.0, indenters, moved, has_normals)
    }

    /// Computes the same map, but rays end at the undeformed surface where there is no indenter and the surface moves
    /// by no more than `still_mm`. Most pixels then need a single evaluation.
    pub fn map_deformed_beyond(
        &self,
        still_mm: f64,
        indenters: &[PlacedIndenter],
        moved: &dyn SurfaceDisplacement,
        has_normals: bool,
    ) -> DepthMap<'_> {
        let mut map = self.map_with_indenters(indenters);
        let touch = &self.touch;
        let near_mm = (NEAR_OF_STILL * still_mm).max(NEAR_MM);
        let pixels = (0..map.range_mm.len()).into_par_iter();
        let seen = |pixel: usize| -> Option<(usize, f64, bool, Option<Vector3<f64>>)> {
            let rest_mm = self.range_mm()[pixel];
            let ray = self.rays().ray(pixel).filter(|_| rest_mm.is_finite())?;
            let is_rigid = map.label[pixel] > SURFACE_LABEL;
            let along = DeformedRay { touch, moved, ray: &ray, near_mm };
            let rest = [rest_mm, along.depth_mm(rest_mm)];
            if !is_rigid && rest[1].abs() <= still_mm {
                return None;
            }
            let (_, outward) = touch.depth_mm(&ray.at(rest_mm));
            let gel = along.exit_mm(rest, outward.dot(&ray.direction));
            let gel_mm = gel[0];
            let rigid_mm = map.range_mm[pixel];
            // The rigid ray may end on the indenter where the gel has already lost contact.
            let is_touched = is_rigid && {
                let point = ray.at(rigid_mm);
                let (depth_mm, outward) = touch.depth_mm(&point);
                moved.is_touched(&(point + depth_mm * outward), &outward)
            };
            let is_indenter = is_touched || is_rigid && rigid_mm <= gel_mm;
            let range_mm = if is_indenter { rigid_mm } else { gel_mm };
            let is_moved = has_normals && !is_indenter && (range_mm - rest_mm).abs() > STILL_MM;
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
            map.changed_normals.extend(normal.map(|normal| (pixel as u32, normal)));
        }
        map
    }
}
