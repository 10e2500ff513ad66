//! A reflective coat under coloured lamps: which way it looks, and what throws shadows on it.

use fabkit_depth::truth::{DepthMap, NO_LABEL, Sigmas, Yielding as _};
use fabkit_geometry::{
    Lighting, Mark, Point3, Rgb, Scratch, Sensor, Shows, SurfacePoints, TouchSurface, Vector3,
};
use fabkit_light::{Coat, Emitter, Emitters, Peg};
use rayon::prelude::*;

use super::pegs::Pegs;
use super::scene::middle_of;
use super::table::{Place, Plan};
use super::{CaptureError, LightConstants, Painted, moved};
use crate::Error;
use crate::pressing::Answer;
use crate::scene::Seen;

/// Farther from what stands out of a coat it throws no shadow, mm.
const SHADOW_MM: f64 = 2.5;
/// Rays that meet the coat flatter than this are taken to meet it so, cosine.
const LEAST_COSINE: f64 = 0.2;
/// Steps along light in which the moved surface is looked for, and how far, mm.
const SHADOW_STEPS: u32 = 16;
const SHADOW_REACH_MM: f64 = 8.0;
/// The surface stands in the way of light that passes so deep behind it, mm.
const BEHIND_MM: f64 = 0.02;
/// How far light from one place of the table passes beside that from the next, mm.
const BESIDE_MM: f64 = 0.5;
/// Off a place, where its shadows begin, mm.
const OFF_MM: f64 = 1e-3;

/// A sensor in a light that shows which way its coat looks.
#[derive(Debug)]
pub(crate) struct CoatScene<'a> {
    sensor: &'a Sensor,
    touch: &'a TouchSurface,
    /// Thickness of the coat, mm.
    coat_mm: f64,
    /// Whether marks are dark places; else they stand out.
    is_printed: bool,
    plan: Plan,
    /// Pieces of lamps, each with how its light arrives at the table's places: at rest, and as deep as layers give way.
    lamps: Vec<(Emitter, [Vec<Arrives>; 2])>,
    soft_mm: f64,
    mean: Rgb,
    constants: &'a LightConstants,
    coat: Coat,
    pub(super) exposure: f64,
    words: [String; 2],
    /// What each ray sees at rest, where many pictures are taken by the same rays.
    at_rest: Option<Vec<Rgb>>,
}

/// What stands in the way of light: all of the surface that is pressed in, as far as it is seen, lies in a ball.
#[derive(Clone, Copy)]
struct Dent {
    centre: Point3<f64>,
    radius_mm: f64,
}

impl Dent {
    fn of(map: &DepthMap<'_>, touch: &TouchSurface) -> Option<Self> {
        let places = map.point_in_sensor().enumerate();
        let pressed = |(i, place): (usize, Point3<f64>)| {
            let is_in = map.has_moved(i) && touch.depth_mm(&place).0 > BEHIND_MM;
            is_in.then_some(place.coords)
        };
        let places: Vec<Vector3<f64>> = places.filter_map(pressed).collect();
        if places.is_empty() {
            return None;
        }
        let centre = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
        let radius_mm = places.iter().map(|place| (place - centre).norm()).fold(0.0, f64::max);
        Some(Self { centre: Point3::from(centre), radius_mm })
    }

    /// Whether light that goes on from a place may pass so near.
    fn is_near(&self, from: &Point3<f64>, towards: &Vector3<f64>, slack_mm: f64) -> bool {
        let way = self.centre - from;
        let along_mm = way.dot(towards).clamp(0.0, SHADOW_REACH_MM);
        (way - along_mm * towards).norm() < self.radius_mm + slack_mm
    }
}

/// The way in which light arrives, times its density; zero where none does.
type Arrives = Vector3<f64>;

impl<'a> CoatScene<'a> {
    pub(crate) fn of(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let missing = || CaptureError::OtherLight { sensor: sensor.name.clone() };
        let Shows::Slopes { coat, printed } = &lighting.shows else { return Err(missing().into()) };
        let touch = sensor.touch.as_ref();
        let touch = touch.ok_or_else(|| CaptureError::NoSurface { sensor: sensor.name.clone() })?;
        let (middle, outward) = middle_of(touch).ok_or_else(missing)?;
        let body = sensor.body(coat).ok_or_else(missing)?;
        // In the middle it may have a mark: beside it, it is thinner.
        let solid = super::scene::in_use(body)?;
        let coat_mm = thinnest(touch, &solid);
        let emitters = Emitters::of(sensor, lighting).map_err(CaptureError::NoLight)?;
        let points = SurfacePoints::new(touch).map_err(Error::bug)?;
        let plan = Plan::of(&points);
        let soft_mm = touch.soft_mm();
        let places = plan.places(&points);
        let arrives = |below_mm: f64| -> Vec<Vec<Arrives>> {
            let below = |(point, outward): Place| point - below_mm * outward;
            let known: Vec<Option<Point3<f64>>> =
                places.iter().map(|(place, _)| place.map(below)).collect();
            let of_piece = |piece: &Emitter| {
                let mut tracer = emitters.tracer();
                let mut arrives = |place: &Point3<f64>| {
                    let found = emitters.arrival(piece, place, &mut tracer);
                    found.map_or_else(Vector3::zeros, |found| found.density * found.arrives)
                };
                known
                    .iter()
                    .map(|place| place.as_ref().map_or_else(Vector3::zeros, &mut arrives))
                    .collect()
            };
            emitters.pieces().par_iter().map(of_piece).collect()
        };
        let [at_rest, deep] = [coat_mm + OFF_MM, coat_mm + OFF_MM + soft_mm].map(arrives);
        let both = at_rest.into_iter().zip(deep).map(|(rest, deep)| [rest, deep]);
        let lamps: Vec<_> = emitters.pieces().iter().copied().zip(both).collect();
        let [diffuse, shine, exponent] = &constants.coat;
        let coat = Coat { diffuse: diffuse.value, shine: shine.value, exponent: exponent.value };
        let marks = match (printed, sensor.marks.len()) {
            (_, 0) => String::new(),
            (Some(_), count) => format!(" with {count} dark marks"),
            (None, count) => format!(" with {count} dimples"),
        };
        let words = [format!("slopes of {coat}{marks}", coat = body.name), emitters.what];
        let mut own = Self {
            sensor,
            touch,
            coat_mm,
            is_printed: printed.is_some(),
            plan,
            lamps,
            soft_mm,
            mean: [0.0; 3],
            constants,
            coat,
            exposure: 1.0,
            words,
            at_rest: None,
        };
        // What bounces on: a part of what arrives on average over the surface.
        let mut sums = ([0.0; 3], 0.0);
        for (place, share) in &places {
            let Some((point, outward)) = place else { continue };
            let straight = own.straight(point, &-outward);
            sums.0 = [0, 1, 2].map(|part| sums.0[part] + share * straight[part]);
            sums.1 += share;
        }
        own.mean = sums.0.map(|sum| sum / sums.1);
        if own.mean.iter().all(|part| *part <= 0.0) {
            return Err(CaptureError::Dark { sensor: sensor.name.clone() }.into());
        }
        let lit = own.lit(&middle, &-outward, &outward, 0.0, &mut |_, _| false);
        let brightest = lit.into_iter().fold(0.0, f64::max);
        if let Some(grey) = &constants.middle_grey {
            own.exposure = grey.value / brightest;
        }
        Ok(own)
    }

    pub(super) fn words(&self) -> [String; 2] {
        self.words.clone()
    }

    /// What arrives on an area that looks along a unit normal, straight and without shadows of marks.
    fn straight(&self, rest: &Point3<f64>, facing: &Vector3<f64>) -> Rgb {
        let around = self.plan.around(rest);
        let mut sum = [0.0; 3];
        for (piece, [arrives, _]) in &self.lamps {
            let arrives: Vector3<f64> = around.iter().map(|(i, share)| *share * arrives[*i]).sum();
            let lit = (-arrives.dot(facing)).max(0.0);
            sum = [0, 1, 2].map(|part| sum[part] + lit * piece.color[part]);
        }
        sum
    }

    /// Light of each colour of lamp that arrives at a place at rest, and as deep as layers give way: pieces of a colour
    /// together, each its way times its density.
    pub(crate) fn by_color(&self, rest: &Point3<f64>) -> Vec<(Rgb, [Vector3<f64>; 2])> {
        let around = self.plan.around(rest);
        let mut colors: Vec<(Rgb, [Vector3<f64>; 2])> = Vec::new();
        for (piece, arrives) in &self.lamps {
            let at = |all: &Vec<Arrives>| around.iter().map(|(i, share)| *share * all[*i]).sum();
            let both: [Vector3<f64>; 2] = arrives.each_ref().map(at);
            match colors.iter_mut().find(|(color, _)| *color == piece.color) {
                Some((_, sums)) => (0..2).for_each(|k| sums[k] += both[k]),
                None => colors.push((piece.color, both)),
            }
        }
        colors
    }

    /// What bounces on, at places that look anywhere.
    pub(crate) fn bounced(&self) -> Rgb {
        self.mean.map(|part| self.constants.bounce.value * self.coat.diffuse * part)
    }

    /// What the coat sends back.
    pub(crate) fn coat(&self) -> Coat {
        self.coat
    }

    /// What is sent along a ray from a place that looks along `facing`, whose foot on the surface at rest is `rest`.
    pub(super) fn lit(
        &self,
        rest: &Point3<f64>,
        facing: &Vector3<f64>,
        direction: &Vector3<f64>,
        depth_mm: f64,
        is_hidden: &mut dyn FnMut(&Emitter, &Vector3<f64>) -> bool,
    ) -> Rgb {
        let around = self.plan.around(rest);
        let share_deep = (depth_mm / self.soft_mm).clamp(0.0, 1.0);
        let mut sum = self.bounced();
        for (piece, [at_rest, deep]) in &self.lamps {
            let mut arrives = Vector3::zeros();
            for (i, share) in &around {
                arrives += *share * ((1.0 - share_deep) * at_rest[*i] + share_deep * deep[*i]);
            }
            let density = arrives.norm();
            if density <= 0.0 {
                continue;
            }
            let way = arrives / density;
            if facing.dot(&way) >= 0.0 || is_hidden(piece, &way) {
                continue;
            }
            let sent = density * self.coat.sends(facing, &way, &-direction);
            sum = [0, 1, 2].map(|part| sum[part] + sent * piece.color[part]);
        }
        sum
    }

    /// For many pictures by the same rays: what nothing has changed is not painted again.
    pub(super) fn prepare(&mut self, map: &DepthMap<'_>) {
        let sigmas = Sigmas::default();
        let seen = Seen { map, sigmas: &sigmas, deepest: None, surface_px: 0, answer: None };
        self.at_rest = Some(self.paint(&seen).light);
    }

    pub(super) fn paint(&self, seen: &Seen<'_>) -> Painted {
        let map = seen.map;
        let beside = [self.constants.beside_grey.value; 3];
        let marks = moved(self.sensor, seen.answer);
        let height_mm = self.height_mm();
        let pegs = Pegs::of(&marks, height_mm, SHADOW_MM);
        let dent = seen.answer.and_then(|answer| {
            // A place on its way is as far from where the surface is as it lies below it.
            let slack_mm = answer.limits_mm()[0] + self.coat_mm;
            Dent::of(map, self.touch).map(|dent| (answer, dent, slack_mm))
        });
        let normals = map.normal_in_sensor();
        let places: Vec<(Point3<f64>, Vector3<f64>)> =
            map.point_in_sensor().zip(map.direction_in_sensor()).collect();
        let ray = |near: &mut Vec<u32>, i: usize| {
            if map.label()[i] == NO_LABEL {
                return beside;
            }
            let ((place, direction), outward) = (places[i], normals[i]);
            if let Some(known) = &self.at_rest
                && !map.has_moved(i)
                && dent.is_none_or(|(_, dent, slack_mm)| !self.may_shade(&dent, &place, slack_mm))
            {
                return known[i];
            }
            // The coat's inner face, which light meets.
            let inwards_mm = self.coat_mm / outward.dot(&direction).max(LEAST_COSINE);
            let mut at = place - inwards_mm * direction;
            let mut facing = -outward;
            pegs.near(&at, near);
            let mut send = 1.0;
            if self.is_printed {
                let is_in =
                    |peg: &Peg| (peg.centre + peg.radius_mm * peg.axis - at).norm() < peg.radius_mm;
                if near.iter().map(|i| pegs.peg(*i)).any(is_in) {
                    let [_, dark] = &self.constants.marks;
                    send = dark.value / self.coat.diffuse;
                }
            } else if let Some((hit_mm, normal)) = {
                let from = at - SHADOW_MM * direction;
                pegs.entry(near, &from, &direction).filter(|(hit_mm, _)| *hit_mm < SHADOW_MM)
            } {
                at -= (SHADOW_MM - hit_mm) * direction;
                facing = normal;
            }
            let (depth_mm, at_rest) = self.touch.depth_mm(&place);
            let rest = place + depth_mm * at_rest;
            let from = at + OFF_MM * facing;
            let mut is_hidden = |_: &Emitter, way: &Vector3<f64>| {
                let towards = -way;
                let by_mark = !self.is_printed
                    && pegs.entry(near, &from, &towards).is_some_and(|(mm, _)| mm < SHADOW_MM);
                by_mark
                    || dent.is_some_and(|(answer, dent, slack_mm)| {
                        dent.is_near(&from, &towards, slack_mm)
                            && self.is_behind(answer, &from, &towards)
                    })
            };
            let light = self.lit(&rest, &facing, &direction, depth_mm, &mut is_hidden);
            light.map(|part| self.exposure * send * part)
        };
        let light = (0..places.len()).into_par_iter().map_init(Vec::new, ray).collect();
        Painted { light, thickness_mm: Vec::new(), marks }
    }

    /// How far marks stand out of the coat, mm.
    fn height_mm(&self) -> f64 {
        let Some(Mark { point, .. }) = self.sensor.marks.first().filter(|_| !self.is_printed)
        else {
            return 0.0;
        };
        self.touch.depth_mm(point).0 - self.coat_mm
    }

    /// Whether the shadow of what is pressed in may fall on a place at rest: light goes about as at the places of the table around it.
    fn may_shade(&self, dent: &Dent, rest: &Point3<f64>, slack_mm: f64) -> bool {
        let far_mm = dent.radius_mm + SHADOW_REACH_MM + slack_mm;
        if (rest - dent.centre).norm() > far_mm {
            return false;
        }
        let around = self.plan.around(rest);
        self.lamps.iter().any(|(_, [at_rest, _])| {
            around.iter().any(|(i, _)| {
                let towards = (-at_rest[*i]).try_normalize(0.0);
                towards.is_some_and(|way| dent.is_near(rest, &way, slack_mm + BESIDE_MM))
            })
        })
    }

    /// Whether the moved surface is between a place of it and a lamp.
    fn is_behind(&self, answer: &Answer<'_>, from: &Point3<f64>, towards: &Vector3<f64>) -> bool {
        let [deepest_mm, _] = answer.limits_mm();
        for step in 1..=SHADOW_STEPS {
            let share = f64::from(step) / f64::from(SHADOW_STEPS);
            let place = from + share * share * SHADOW_REACH_MM * towards;
            let (depth_mm, outward) = self.touch.depth_mm(&place);
            // Light that is once above all that moves stays there.
            if depth_mm > deepest_mm + self.coat_mm {
                return false;
            }
            let now_mm = depth_mm + answer.outwards_mm(&(place + depth_mm * outward), &outward);
            if now_mm < self.coat_mm - BEHIND_MM {
                return true;
            }
        }
        false
    }
}

/// The least thickness of a coat at some places of the surface, mm: that beside marks.
fn thinnest(touch: &TouchSurface, coat: &fabkit_geometry::CompiledSolid) -> f64 {
    let Ok(points) = SurfacePoints::new(touch) else { return 0.0 };
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    let plan = Plan::of(&points);
    let places = plan.places(&points).into_iter().filter_map(|(place, _)| place);
    let mut all: Vec<f64> = places
        .filter_map(|(point, outward)| {
            let ray = fabkit_geometry::Ray { origin: point + outward, direction: -outward };
            coat.stretches_into(&ray, &mut scratch, &mut found);
            found.first().map(|[from, to]| to - from)
        })
        .collect();
    all.sort_by(f64::total_cmp);
    // At the foot itself there may be less.
    all.get(all.len() / 4).copied().unwrap_or(0.0)
}
