//! Light marks on a dark ground: dots on pins, painted ends of markers.

use std::sync::Arc;

use fabkit_depth::truth::PixelRays;
use fabkit_geometry::{
    CompiledSolid, Lighting, Matrix3, Point3, Ray, Rgb, Scratch, Sensor, Shows, Vector3,
};
use fabkit_light::Emitters;
use fabkit_optics::{Sights, Tracer};
use rayon::prelude::*;

use super::scene::in_use;
use super::{CaptureError, LightConstants, Painted, moved, sends_back};
use crate::Error;
use crate::ground_truth::Viewpoint;
use crate::pressing::Moved;
use crate::scene::SceneError;

/// A mark lies within so many of its radii around the middle of what faces the camera.
const AROUND: f64 = 2.5;
/// Where light on the ground is looked at: every so many rays.
const COARSE: usize = 12;
/// How bright what shines itself is: white.
const WHITE_GREY: f64 = 255.0;

/// A sensor in a light that shows its marks.
#[derive(Debug)]
pub(super) struct MarkScene<'a> {
    sensor: &'a Sensor,
    marks: CompiledSolid,
    /// The sensor without its marks.
    ground: Sensor,
    lamps: Vec<String>,
    emitters: Emitters,
    constants: &'a LightConstants,
    pub(super) exposure: f64,
}

/// A mark where it is now.
struct Placed {
    at: Point3<f64>,
    /// The middle of what faces the camera, at rest.
    at_rest: Point3<f64>,
    /// From how it stood at rest.
    turn: Matrix3<f64>,
    /// How light arrives there, by its density.
    arrives: Vector3<f64>,
    reach_mm: f64,
}

impl<'a> MarkScene<'a> {
    pub(super) fn of(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let missing = || CaptureError::OtherLight { sensor: sensor.name.clone() };
        let Shows::Marks { marks } = &lighting.shows else { return Err(missing().into()) };
        let compiled = in_use(sensor.body(marks).ok_or_else(missing)?)?;
        let emitters = Emitters::of(sensor, lighting).map_err(CaptureError::NoLight)?;
        let mut ground = sensor.clone();
        ground.bodies.retain(|body| body.name != *marks);
        let mut own = Self {
            sensor,
            marks: compiled,
            ground,
            lamps: lighting.lamps.iter().map(|group| group.body.clone()).collect(),
            emitters,
            constants,
            exposure: 1.0,
        };
        let at_rest = own.placed(&moved(sensor, None));
        let facing = sensor.marks.iter().zip(&at_rest);
        let lit = facing.map(|(mark, placed)| -placed.arrives.dot(&mark.axis));
        let brightest = constants.marks[0].value * lit.fold(0.0, f64::max);
        if brightest <= 0.0 {
            return Err(CaptureError::Dark { sensor: sensor.name.clone() }.into());
        }
        own.exposure = constants.mark_grey.value / brightest;
        Ok(own)
    }

    pub(super) fn words(&self) -> [String; 2] {
        [format!("places of {} marks", self.sensor.marks.len()), self.emitters.what.clone()]
    }

    fn placed(&self, marks: &[Moved]) -> Vec<Placed> {
        let known = marks.par_iter().filter_map(|moved| Some((moved, moved.displacement_mm?)));
        known
            .map_init(
                || self.emitters.tracer(),
                |tracer, (moved, by_mm)| {
                    let at = moved.mark.point + by_mm;
                    Placed {
                        at,
                        at_rest: moved.mark.point,
                        turn: turn(&moved.mark.axis, &moved.axis),
                        arrives: self.arrives(&(at + 1e-3 * moved.axis), tracer),
                        reach_mm: AROUND * moved.mark.radius_mm,
                    }
                },
            )
            .collect()
    }

    /// The ways in which light arrives at a place, by its density.
    fn arrives(&self, place: &Point3<f64>, tracer: &mut Tracer<'_>) -> Vector3<f64> {
        let pieces = self.emitters.pieces().iter();
        let all = pieces.filter_map(|piece| self.emitters.arrival(piece, place, tracer));
        all.map(|found| found.density * found.arrives).sum()
    }

    pub(super) fn paint(
        &self,
        viewpoint: &Viewpoint,
        samples: u32,
        marks: Vec<Moved>,
    ) -> Result<Painted, Error> {
        let stack = viewpoint.stack(&self.ground).map_err(SceneError::Light)?;
        let sights = Arc::new(Sights::new(stack.clone()));
        let straight = viewpoint.rays(samples);
        let rays = straight.clone().through(&sights);
        let placed = self.placed(&marks);
        let ground = self.ground(&straight, &rays, &stack);
        let (width, [light, _]) = (rays.width_px() as usize, &self.constants.marks);
        let bounced = self.constants.bounce.value;
        let mean =
            placed.iter().map(|mark| mark.arrives.norm()).sum::<f64>() / placed.len().max(1) as f64;
        let ray = |(scratch, tracer): &mut (Scratch, Tracer<'_>), i: usize| -> Rgb {
            let behind = ground.at(i, width, bounced * mean) * self.exposure;
            let Some(ray) = rays.ray(i) else { return [self.constants.beside_grey.value; 3] };
            let Some((at_mm, normal, mark)) = self.first(&placed, &ray, scratch) else {
                return [behind; 3];
            };
            // Before it there may be something else than the ground.
            if rays.seen_by()[i] > 1
                && let Some(first) = straight.ray(i)
            {
                let path = tracer.follow(&first);
                if path.end_mm < at_mm && path.last.origin == ray.origin {
                    return [behind; 3];
                }
            }
            let lit = (-mark.arrives.dot(&normal)).max(0.0) + bounced * mean;
            [self.exposure * light.value * lit; 3]
        };
        let memory = || (Scratch::default(), Tracer::new(&stack));
        let light = (0..rays.len()).into_par_iter().map_init(memory, ray).collect();
        Ok(Painted { light, thickness_mm: Vec::new(), marks })
    }

    /// The first mark on a ray: how far along it, mm, its normal there, and which.
    fn first<'p>(
        &self,
        placed: &'p [Placed],
        ray: &Ray,
        scratch: &mut Scratch,
    ) -> Option<(f64, Vector3<f64>, &'p Placed)> {
        let mut nearest: Option<(f64, Vector3<f64>, &Placed)> = None;
        for mark in placed {
            let from = mark.at - ray.origin;
            let along = from.dot(&ray.direction);
            if from.norm_squared() - along * along > mark.reach_mm * mark.reach_mm {
                continue;
            }
            // Back to where the mark is drawn.
            let back = mark.turn.transpose();
            let origin = mark.at_rest + back * (ray.origin - mark.at);
            let drawn = Ray { origin, direction: back * ray.direction };
            let mut crossings = Vec::new();
            self.marks.crossings_into(&drawn, scratch, &mut crossings);
            let is_it = |t: f64| (drawn.at(t) - mark.at_rest).norm() < mark.reach_mm;
            let first = crossings
                .iter()
                .find(|crossing| crossing.entering && crossing.t > 0.0 && is_it(crossing.t));
            if let Some(first) = first
                && nearest.as_ref().is_none_or(|(t, ..)| first.t < *t)
            {
                nearest = Some((first.t, mark.turn * first.normal, mark));
            }
        }
        nearest
    }

    /// What is behind the marks.
    fn ground(
        &self,
        straight: &PixelRays,
        rays: &PixelRays,
        stack: &fabkit_optics::Stack,
    ) -> Ground {
        let [light, dark] = &self.constants.marks;
        let sends = |name: &String| match self.lamps.contains(name) {
            true => f64::INFINITY,
            // The surface is seen through what lies on it: what marks stand on.
            false => sends_back(self.ground.body(name), [light.value, dark.value]),
        };
        let sends: Vec<f64> = rays.seen_by_names().iter().map(sends).collect();
        let (width, height) = (rays.width_px() as usize, rays.height_px() as usize);
        let columns = width.div_ceil(COARSE) + 1;
        let rows = height.div_ceil(COARSE) + 1;
        let node = |(of_light, of_camera): &mut (Tracer<'_>, Tracer<'_>), i: usize| {
            let pixel = |k: usize, most: usize| (k * COARSE).min(most - 1);
            let at = pixel(i / columns, height) * width + pixel(i % columns, width);
            let Some(ray) = straight.ray(at) else { return 0.0 };
            let path = of_camera.follow(&ray);
            if !path.end_mm.is_finite() {
                return 0.0;
            }
            // What is looked at looks back.
            let place = path.last.at(path.end_mm - 1e-2);
            self.arrives(&place, of_light).dot(&path.last.direction).max(0.0)
        };
        let memory = || (self.emitters.tracer(), Tracer::new(stack));
        let lit = (0..rows * columns).into_par_iter().map_init(memory, node).collect();
        let sends = rays.seen_by().iter().map(|by| sends[usize::from(*by)]).collect();
        Ground { columns, lit, sends }
    }
}

/// Light on what is behind marks, and what of it comes back.
struct Ground {
    columns: usize,
    /// Every [`COARSE`] rays.
    lit: Vec<f64>,
    /// Of each ray.
    sends: Vec<f64>,
}

impl Ground {
    fn at(&self, ray: usize, width: usize, bounced: f64) -> f64 {
        let sends = self.sends[ray];
        if sends.is_infinite() {
            return WHITE_GREY;
        }
        let [row, column] = [ray / width, ray % width].map(|k| k as f64 / COARSE as f64);
        let (i, j) = (row as usize, column as usize);
        let (by_row, by_column) = (row - i as f64, column - j as f64);
        let lit = |i: usize, j: usize| self.lit[i * self.columns + j];
        let between = (1.0 - by_row) * ((1.0 - by_column) * lit(i, j) + by_column * lit(i, j + 1))
            + by_row * ((1.0 - by_column) * lit(i + 1, j) + by_column * lit(i + 1, j + 1));
        sends * (between + bounced)
    }
}

/// The least turn that takes one unit vector to another (Rodrigues 1840).
fn turn(from: &Vector3<f64>, to: &Vector3<f64>) -> Matrix3<f64> {
    let (axis, cosine) = (from.cross(to), from.dot(to));
    let across = axis.cross_matrix();
    // A mark does not turn over.
    Matrix3::identity() + across + across * across / (1.0 + cosine).max(1e-6)
}
