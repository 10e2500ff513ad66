//! Derivatives of a ray's last segment by the ray that leaves the camera.
//!
//! Any error of a camera and its pose shifts the ray that leaves the camera in two directions across itself, and turns
//! it in two. The media's effect on these four changes is the same for all errors and every press, and is traced once.

use fabkit_geometry::{Point3, Ray, Vector3};
use fabkit_optics::{SightLine, Tracer, ViewStacks};
use rayon::prelude::*;

use super::PixelRays;
use super::rays::{SEES_NOTHING, SEES_SURFACE, trace_all};

/// Steps of one-sided differences, rad and mm. Rays are accurate to 1e-14 and nearly linear over a step, so that
/// derivatives are accurate to 1e-6.
const STEP: f64 = 1e-6;

/// Shift of a last segment's start, mm, above which a step has led through another face. Without one it is far smaller.
const NEIGHBOUR_MM: f64 = 1e-3;

/// Ray of a pixel outside the lens.
const NOWHERE: Ray = Ray {
    origin: Point3::new(0.0, 0.0, 0.0),
    direction: Vector3::new(f64::NAN, f64::NAN, f64::NAN),
};

/// Number of changes of a ray: two turns and two shifts.
const CHANGES: usize = 4;

/// Change of a ray, or of its last segment, by a parameter, sensor frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub(super) origin: Vector3<f64>,
    pub(super) direction: Vector3<f64>,
}

impl Change {
    /// Change that is not known.
    pub(super) const UNKNOWN: Self = Self {
        origin: Vector3::new(f64::NAN, f64::NAN, f64::NAN),
        direction: Vector3::new(f64::NAN, f64::NAN, f64::NAN),
    };
}

/// Derivatives of all rays, pixel by pixel.
#[derive(Clone, Debug)]
pub(super) struct Transfer {
    /// Changes of origin and direction by each of the turns and shifts; `NaN` where both steps of one lead through
    /// other faces, as at an edge. Single precision saves memory and suffices for uncertainties.
    by: Vec<[[f32; 6]; CHANGES]>,
}

impl Transfer {
    /// Traces all rays again with each of the four changes.
    pub(super) fn compute(rays: &PixelRays, media: &ViewStacks) -> Self {
        let leaving: Vec<Option<Ray>> =
            (0..rays.len()).into_par_iter().map(|pixel| rays.camera_ray(pixel)).collect();
        let mut by = vec![[[f32::NAN; 6]; CHANGES]; rays.len()];
        for way in 0..CHANGES {
            let start = |leaving: &Option<Ray>| {
                let ray = leaving.as_ref().map_or(NOWHERE, |ray| stepped(ray, way, STEP));
                (ray.origin, ray.direction)
            };
            let (mut origins, mut directions): (Vec<_>, Vec<_>) =
                leaving.par_iter().map(start).unzip();
            // Rays that do not see the surface are not traced.
            let unasked = |seen: &u8| if *seen == SEES_SURFACE { SEES_NOTHING } else { *seen };
            let mut seen_by: Vec<u8> = rays.seen_by().iter().map(unasked).collect();
            let width = rays.width_px() as usize;
            trace_all(media.stack(), width, &mut origins, &mut directions, &mut seen_by, None);
            let before = |tracer: &mut Tracer<'_>, pixel: usize| {
                let ray = stepped(leaving[pixel].as_ref()?, way, -STEP);
                Some(tracer.follow(&media.stack().enter(&ray)).last)
            };
            by.par_iter_mut().enumerate().for_each_init(
                || media.media_tracer(),
                |tracer, (pixel, by)| {
                    // Where a forward step leads through another face, the backward step serves.
                    let is_asked = rays.seen_by().get(pixel) == Some(&SEES_SURFACE);
                    let Some(here) = rays.ray(pixel).filter(|_| is_asked) else { return };
                    let after = Ray { origin: origins[pixel], direction: directions[pixel] };
                    let change = slope(&here, &after, STEP)
                        .or_else(|| slope(&here, &before(tracer, pixel)?, -STEP));
                    if let Some(change) = change {
                        by[way] = change;
                    }
                },
            );
        }
        Self { by }
    }

    /// Computes the change of a pixel's last segment by a change of the ray that leaves the camera and is traced from
    /// `entered`.
    pub(super) fn apply(
        &self,
        pixel: usize,
        [leaving, entered, last]: [&Ray; 3],
        change: &Change,
    ) -> Change {
        if entered.origin == last.origin {
            // Not refracted: the ray is the same, but begins farther along.
            let ahead_mm = (entered.origin - leaving.origin).dot(&leaving.direction);
            return Change { origin: change.origin + ahead_mm * change.direction, ..*change };
        }
        let across = SightLine::transverse_axes(&leaving.direction);
        let (turns, shifts) = (across.tr_mul(&change.direction), across.tr_mul(&change.origin));
        let parts = [turns.x, turns.y, shifts.x, shifts.y];
        let mut sum = [0.0; 6];
        for (part, by) in parts.into_iter().zip(&self.by[pixel]) {
            sum.iter_mut().zip(by).for_each(|(sum, by)| *sum += part * f64::from(*by));
        }
        let [x, y, z, turned_x, turned_y, turned_z] = sum;
        Change {
            origin: Vector3::new(x, y, z),
            direction: Vector3::new(turned_x, turned_y, turned_z),
        }
    }
}

/// Shifts or turns a ray that leaves the camera.
fn stepped(ray: &Ray, way: usize, step: f64) -> Ray {
    let across = SightLine::transverse_axes(&ray.direction);
    let by = step * across.column(way % 2);
    if way < 2 {
        Ray { direction: (ray.direction + by).normalize(), ..*ray }
    } else {
        Ray { origin: ray.origin + by, ..*ray }
    }
}

/// Difference quotient of two last segments; `None` where they begin at different faces.
fn slope(here: &Ray, there: &Ray, step: f64) -> Option<[f32; 6]> {
    let (origin, direction) = (there.origin - here.origin, there.direction - here.direction);
    // False for NaN too.
    let is_near = origin.norm() < NEIGHBOUR_MM;
    let by = [origin.x, origin.y, origin.z, direction.x, direction.y, direction.z];
    is_near.then(|| by.map(|by| (by / step) as f32))
}
