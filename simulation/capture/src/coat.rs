//! Rendering of a reflective coat under coloured light sources: shading by slopes, and shadows on the coat.

use fabkit_depth::ground_truth::{
    DepthMap, NO_LABEL, StandardDeviations, SurfaceDisplacement as _,
};
use fabkit_files::Error;
use fabkit_geometry::{
    Lighting, Marker, Point3, Rgb, Scratch, Sensor, SurfacePoints, TouchSurface, Vector3,
    VisibleEffect, WHITE,
};
use fabkit_light::{Coat, Emitter, Emitters, RaisedMarker};
use fabkit_scene::CastResult;
use fabkit_scene::press_simulation::ContactSolution;
use rayon::prelude::*;

use super::marker_index::{BoundingBall, MarkerIndex};
use super::scene::surface_middle;
use super::surface_table::{SurfaceGrid, SurfacePlace};
use super::surfaces::USUAL_COAT;
use super::{CameraGain, CaptureError, LightConstants, RenderedLight, displaced_markers};

/// Distance beyond which markers that stand out of the coat throw no shadow, mm.
const MARKER_SHADOW_MM: f64 = 2.5;
/// Smallest cosine between ray and normal. Flatter rays are treated as if they had it.
const LEAST_COSINE: f64 = 0.2;
/// Number of steps along a shadow ray in which the deformed surface is searched, and length of the search, mm.
const SHADOW_STEPS: u32 = 16;
const SHADOW_REACH_MM: f64 = 8.0;
/// Depth behind the surface's inner face from which light counts as blocked, mm.
const BEHIND_MM: f64 = 0.02;
/// Largest lateral distance between light paths from neighbouring places of the table, mm.
const BESIDE_MM: f64 = 0.5;
/// Number of rings around the middle of the dent, each with the largest depth in it or beyond, and least radius of all
/// rings, mm.
const RINGS: usize = 8;
const LEAST_DENT_MM: f64 = 1.0;
/// Offset of a shadow ray's start from the surface, mm.
const SHADOW_OFFSET_MM: f64 = 1e-3;
/// Maximum number of ray-marching steps.
const MOST_STEPS: u32 = 256;

/// A sensor in a lighting that shows the slopes of its coat.
#[derive(Debug)]
pub struct CoatScene<'a> {
    sensor: &'a Sensor,
    touch: &'a TouchSurface,
    coat_name: String,
    /// Thickness of the coat, mm.
    coat_mm: f64,
    /// Whether markers are printed dark on the coat, rather than standing out of it.
    is_printed: bool,
    plan: SurfaceGrid,
    /// Colour of each emitter's light that the coat sends back: gloss takes the coat's colour, as that of metal powder
    /// does.
    colors: Vec<Rgb>,
    /// Colour of the coat, relative to its mean.
    tint: Rgb,
    /// Irradiance vectors at the table's places, place by place, in blocks of [`LANES`] emitters.
    arrives: Vec<Beams>,
    /// Unit directions towards the emitters at rest; `None` where no light arrives.
    comes_from: Vec<Option<Vector3<f64>>>,
    soft_mm: f64,
    mean: Rgb,
    constants: &'a LightConstants,
    coat: Coat,
    pub(super) exposure: f64,
    pub(super) camera_gain: CameraGain,
    words: [String; 2],
    /// Light and normal of each ray at rest, kept where many captures share the same rays.
    at_rest: Option<(Vec<Rgb>, Vec<Vector3<f64>>)>,
}

/// Bounding volume of the dented surface, as far as it is seen, for shadow tests: a ball.
#[derive(Clone, Copy)]
struct Dent {
    centre: Point3<f64>,
    radius_mm: f64,
    /// Width of the rings around the centre, measured on the surface at rest, mm.
    ring_mm: f64,
    /// Largest depth of the surface in each ring or beyond it, mm.
    deepest_mm: [f64; RINGS],
}

impl Dent {
    fn from_map(map: &DepthMap<'_>, touch: &TouchSurface) -> Option<Self> {
        let pressed = |i: usize| {
            let (place, _) = map.arrival(i).filter(|_| map.has_moved(i))?;
            let (depth_mm, outward) = touch.depth_mm(&place);
            (depth_mm > BEHIND_MM).then(|| (place.coords, depth_mm, depth_mm * outward))
        };
        let places: Vec<_> = (0..map.range_mm().len()).filter_map(pressed).collect();
        if places.is_empty() {
            return None;
        }
        let sum: Vector3<f64> = places.iter().map(|(place, ..)| place).sum();
        let centre = sum / places.len() as f64;
        let far_mm = |place: &Vector3<f64>| (place - centre).norm();
        let radius_mm = places.iter().map(|(place, ..)| far_mm(place)).fold(0.0, f64::max);
        let feet = || places.iter().map(|(place, depth_mm, up)| (far_mm(&(place + up)), *depth_mm));
        let ring_mm = feet().map(|(far_mm, _)| far_mm).fold(LEAST_DENT_MM, f64::max) / RINGS as f64;
        let mut deepest_mm = [0.0; RINGS];
        for (far_mm, depth_mm) in feet() {
            let within = ((far_mm / ring_mm) as usize).min(RINGS - 1);
            // A depth counts for its ring and all inner ones, which makes each entry a maximum outwards.
            deepest_mm[..=within].iter_mut().for_each(|known| *known = depth_mm.max(*known));
        }
        Some(Self { centre: Point3::from(centre), radius_mm, ring_mm, deepest_mm })
    }

    /// Returns an upper bound of the depth, mm, of surface points whose foot at rest has this distance from the centre.
    /// Rays sample each ring and its inner neighbour, one of which is at least as deep. The middle has no inner
    /// neighbour, hence no bound.
    fn deepest_mm(&self, far_mm: f64) -> f64 {
        match (far_mm / self.ring_mm) as usize {
            0 => f64::INFINITY,
            ring if ring <= RINGS => self.deepest_mm[ring - 1],
            _ => 0.0,
        }
    }

    /// Returns whether light that travels on from a place may pass within the ball and `slack_mm` of it.
    fn is_near(&self, from: &Point3<f64>, towards: &Vector3<f64>, slack_mm: f64) -> bool {
        let way = self.centre - from;
        let along_mm = way.dot(towards).clamp(0.0, SHADOW_REACH_MM);
        (way - along_mm * towards).norm_squared() < (self.radius_mm + slack_mm).powi(2)
    }
}

/// Irradiance vector: direction of light times its density; zero without light.
type IrradianceVector = Vector3<f64>;

/// Number of emitters processed per block, for vectorisation.
const LANES: usize = 8;

/// Irradiance vectors of a block of emitters at a place, by x, y and z: on the surface at rest, and at full depth of
/// the soft layers.
type Beams = [[[f64; LANES]; 3]; 2];

fn irradiance_vectors(beams: &[Beams], piece: usize) -> [IrradianceVector; 2] {
    let of = |part: &[[f64; LANES]; 3]| Vector3::from(part.map(|axis| axis[piece % LANES]));
    beams[piece / LANES].each_ref().map(of)
}

impl<'a> CoatScene<'a> {
    /// Tabulates the light on the coat for this lighting, and sets the exposure.
    ///
    /// # Errors
    /// Returns an error for light sources or bodies that light cannot be traced through.
    pub fn new(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let missing = || CaptureError::UnknownLighting { sensor: sensor.name.clone() };
        let VisibleEffect::Slopes { coat, printed } = &lighting.effect else {
            return Err(missing().into());
        };
        let touch = sensor.touch.as_ref();
        let touch = touch.ok_or_else(|| CaptureError::NoSurface { sensor: sensor.name.clone() })?;
        let (middle, outward) = surface_middle(touch).ok_or_else(missing)?;
        let body = sensor.body(coat).ok_or_else(missing)?;
        // A marker in the middle would make the coat thicker there, so its thickness is sampled all over the surface.
        let solid = super::scene::placed_solid(body)?;
        let coat_mm = coat_thickness_mm(touch, &solid);
        let emitters = Emitters::new(sensor, lighting).map_err(CaptureError::NoLight)?;
        let points = SurfacePoints::new(touch).map_err(Error::bug)?;
        let plan = SurfaceGrid::new(&points);
        let soft_mm = touch.max_indentation_mm();
        let places = plan.places(&points);
        let arrives = |below_mm: f64| -> Vec<Vec<IrradianceVector>> {
            let below = |(point, outward): SurfacePlace| point - below_mm * outward;
            let known: Vec<Option<Point3<f64>>> =
                places.iter().map(|(place, _)| place.map(below)).collect();
            let of_piece = |piece: &Emitter| {
                let mut tracer = emitters.tracer();
                let mut arrives = |place: &Point3<f64>| {
                    let found = emitters.arrival(piece, place, &mut tracer);
                    found.map_or_else(Vector3::zeros, |found| {
                        found.density * found.arrival_direction
                    })
                };
                known
                    .iter()
                    .map(|place| place.as_ref().map_or_else(Vector3::zeros, &mut arrives))
                    .collect()
            };
            emitters.pieces().par_iter().map(of_piece).collect()
        };
        // Two depths suffice: irradiance in between is interpolated linearly.
        let [at_rest, deep] =
            [coat_mm + SHADOW_OFFSET_MM, coat_mm + SHADOW_OFFSET_MM + soft_mm].map(arrives);
        let colors: Vec<Rgb> = emitters.pieces().iter().map(|piece| piece.color).collect();
        let blocks = colors.len().div_ceil(LANES);
        let mut arrives = vec![Beams::default(); places.len() * blocks];
        let mut comes_from = Vec::new();
        for place in 0..places.len() {
            for piece in 0..colors.len() {
                let both = [at_rest[piece][place], deep[piece][place]];
                let beams = &mut arrives[place * blocks + piece / LANES];
                for (part, axis) in (0..2).flat_map(|part| (0..3).map(move |axis| (part, axis))) {
                    beams[part][axis][piece % LANES] = both[part][axis];
                }
                comes_from.push((-both[0]).try_normalize(0.0));
            }
        }
        // A camera without colours sees the mean.
        let tint = if lighting.is_colored() { constants.coat_tint } else { WHITE };
        let marks = match (printed, sensor.marks.len()) {
            (_, 0) => String::new(),
            (Some(_), count) => format!(" with {count} dark markers"),
            (None, count) => format!(" with {count} dimples"),
        };
        let words = [format!("slopes of {coat}{marks}", coat = body.name), emitters.description];
        let mut own = Self {
            sensor,
            touch,
            coat_name: body.name.clone(),
            coat_mm,
            is_printed: printed.is_some(),
            plan,
            colors,
            tint,
            arrives,
            comes_from,
            soft_mm,
            mean: [0.0; 3],
            constants,
            coat: coat_of(USUAL_COAT),
            exposure: 1.0,
            camera_gain: CameraGain::NONE,
            words,
            at_rest: None,
        };
        // Repeatedly reflected light is proportional to the mean irradiance over the surface.
        let mut sums = ([0.0; 3], 0.0);
        for (place, share) in &places {
            let Some((point, outward)) = place else { continue };
            let straight = own.direct_light(point, &-outward);
            sums.0 = [0, 1, 2].map(|part| sums.0[part] + share * straight[part]);
            sums.1 += share;
        }
        own.mean = sums.0.map(|sum| sum / sums.1);
        if own.mean.iter().all(|part| *part <= 0.0) {
            return Err(CaptureError::Dark { sensor: sensor.name.clone() }.into());
        }
        let brightest = |own: &Self| {
            let lit = own.shade(&middle, &-outward, &outward, 0.0, |_| false);
            lit.into_iter().fold(0.0, f64::max)
        };
        let usual = brightest(&own);
        let tinted = |color: Rgb| [0, 1, 2].map(|part| tint[part] * color[part]);
        own.coat = coat_of(constants.coat.each_ref().map(|constant| constant.value));
        own.colors = own.colors.iter().copied().map(tinted).collect();
        own.mean = tinted(own.mean);
        let drawn = brightest(&own);
        own.camera_gain = CameraGain::new(usual / drawn);
        if let Some(grey) = &constants.middle_grey {
            own.exposure = if own.camera_gain.light_factor() < 1.0 {
                // As much as the usual coat gets, amplified; a coat that sends back nothing stays black.
                CameraGain::most() * grey.value / usual
            } else {
                grey.value / drawn
            };
        }
        Ok(own)
    }

    pub(super) fn words(&self) -> [String; 2] {
        self.words.clone()
    }

    /// Returns the irradiance vectors of all emitters at a place of the table.
    fn beams_at(&self, number: usize) -> &[Beams] {
        let blocks = self.colors.len().div_ceil(LANES);
        &self.arrives[number * blocks..][..blocks]
    }

    /// Returns the direct light on an area with a unit normal, without shadows of markers.
    fn direct_light(&self, rest: &Point3<f64>, facing: &Vector3<f64>) -> Rgb {
        let around = self.plan.weights_at(rest).map(|(i, share)| (self.beams_at(i), share));
        let mut sum = [0.0; 3];
        for (piece, color) in self.colors.iter().enumerate() {
            let arrives: Vector3<f64> =
                around.iter().map(|(at, share)| *share * irradiance_vectors(at, piece)[0]).sum();
            let lit = (-arrives.dot(facing)).max(0.0);
            sum = [0, 1, 2].map(|part| sum[part] + lit * color[part]);
        }
        sum
    }

    /// Returns the irradiance vectors for each colour of light source, at rest and at full depth of the soft layers.
    /// Emitters of one colour are summed.
    pub fn irradiance_by_color(&self, rest: &Point3<f64>) -> Vec<(Rgb, [Vector3<f64>; 2])> {
        let around = self.plan.weights_at(rest).map(|(i, share)| (self.beams_at(i), share));
        let mut colors: Vec<(Rgb, [Vector3<f64>; 2])> = Vec::new();
        for (piece, color) in self.colors.iter().enumerate() {
            let both: [Vector3<f64>; 2] = [0, 1].map(|k| {
                around.iter().map(|(at, share)| *share * irradiance_vectors(at, piece)[k]).sum()
            });
            match colors.iter_mut().find(|(known, _)| known == color) {
                Some((_, sums)) => (0..2).for_each(|k| sums[k] += both[k]),
                None => colors.push((*color, both)),
            }
        }
        colors
    }

    /// Returns the light from repeated reflections, the same for any orientation.
    pub fn reflected_light(&self) -> Rgb {
        self.mean.map(|part| self.constants.bounce.value * self.coat.diffuse * part)
    }

    /// Returns the reflectance model of the coat.
    pub fn coat(&self) -> Coat {
        self.coat
    }

    /// Returns the light along a ray from a place with the normal `facing`, whose foot on the undeformed surface is
    /// `rest`. `is_hidden` is called with the direction of each emitter's light.
    pub(super) fn shade(
        &self,
        rest: &Point3<f64>,
        facing: &Vector3<f64>,
        direction: &Vector3<f64>,
        depth_mm: f64,
        mut is_hidden: impl FnMut(&Vector3<f64>) -> bool,
    ) -> Rgb {
        let around = self.plan.weights_at(rest).map(|(i, share)| (self.beams_at(i), share));
        let share_deep = (depth_mm / self.soft_mm).clamp(0.0, 1.0);
        let mut sum = self.reflected_light();
        for (block, colors) in self.colors.chunks(LANES).enumerate() {
            let mut arrives = [[0.0; LANES]; 3];
            for (at, share) in &around {
                for (beam, part) in at[block].iter().zip([1.0 - share_deep, share_deep]) {
                    let share = share * part;
                    // On the surface at rest the deep half of the table is skipped.
                    if share == 0.0 {
                        continue;
                    }
                    for (sums, axis) in arrives.iter_mut().zip(beam) {
                        sums.iter_mut().zip(axis).for_each(|(sum, part)| *sum += share * part);
                    }
                }
            }
            for (lane, color) in colors.iter().enumerate() {
                let [x, y, z] = &arrives;
                let arrives = Vector3::new(x[lane], y[lane], z[lane]);
                // Light from behind the surface, or none at all.
                if facing.dot(&arrives) >= 0.0 {
                    continue;
                }
                let density = arrives.norm();
                let way = arrives / density;
                if is_hidden(&way) {
                    continue;
                }
                let sent = density * self.coat.reflect(facing, &way, &-direction);
                sum.iter_mut().zip(color).for_each(|(sum, part)| *sum += sent * part);
            }
        }
        sum
    }

    /// Renders the surface at rest, so that captures of presses only render what has changed.
    pub(super) fn prepare(&mut self, map: &DepthMap<'_>) {
        let sigmas = StandardDeviations::default();
        let seen = CastResult {
            map,
            sigmas: &sigmas,
            deepest: None,
            surface_px: 0,
            answer: None,
            gap: None,
        };
        self.at_rest = Some((self.paint(&seen).light, map.normal_in_sensor()));
    }

    pub(super) fn paint(&self, seen: &CastResult<'_>) -> RenderedLight {
        let map = seen.map;
        let beside = [self.constants.beside_grey.value; 3];
        let marks = displaced_markers(self.sensor, seen.answer);
        let height_mm = self.height_mm();
        let pegs = MarkerIndex::new(&marks, height_mm, MARKER_SHADOW_MM);
        let dent = seen.answer.and_then(|answer| {
            // A point on a shadow ray is as far from the deformed surface as the surface lies below it.
            let slack_mm = answer.limits_mm()[0] + self.coat_mm;
            Dent::from_map(map, self.touch).map(|dent| (answer, dent, slack_mm))
        });
        let normals = match &self.at_rest {
            Some((_, at_rest)) => map.normals_from(at_rest.clone()),
            None => map.normal_in_sensor(),
        };
        let ray = |balls: &mut Vec<BoundingBall>, i: usize| {
            let is_seen = map.label()[i] != NO_LABEL;
            let seen = if is_seen { map.arrival(i) } else { self.grazing_hit(map, i) };
            let Some((place, direction)) = seen else { return beside };
            let outward = if is_seen { normals[i] } else { self.touch.depth_mm(&place).1 };
            if let Some((known, _)) = &self.at_rest
                && !map.has_moved(i)
                && dent.is_none_or(|(_, dent, slack_mm)| !self.may_shade(&dent, &place, slack_mm))
            {
                return known[i];
            }
            // Light meets the coat's inner face.
            let inwards_mm = self.coat_mm / outward.dot(&direction).max(LEAST_COSINE);
            let at = place - inwards_mm * direction;
            let mut facing = -outward;
            let mut from = at + SHADOW_OFFSET_MM * facing;
            let mut send = [1.0; 3];
            if self.is_printed {
                let is_in = |peg: &RaisedMarker| {
                    (peg.centre + peg.radius_mm * peg.axis - at).norm() < peg.radius_mm
                };
                if pegs.near(&at).any(is_in) {
                    let [_, dark] = &self.constants.marks;
                    // The shading below uses the coat's diffuse reflectance, so the dark one is set relative to it.
                    send = self.tint.map(|tint| match tint * self.coat.diffuse {
                        0.0 => 0.0,
                        coat => dark.value / coat,
                    });
                }
            } else {
                pegs.balls(&at, &from, balls);
                match pegs.first_hit(balls, &at, &direction) {
                    Some((back_mm, normal)) => {
                        from = at - back_mm * direction + SHADOW_OFFSET_MM * normal;
                        facing = normal;
                        pegs.balls(&at, &from, balls);
                    }
                    None if !is_seen => return beside,
                    None => {}
                }
            }
            let (depth_mm, at_rest) = self.touch.depth_mm(&place);
            let rest = place + depth_mm * at_rest;
            let is_hidden = |way: &Vector3<f64>| {
                let towards = -way;
                pegs.blocks(balls, &from, &towards)
                    || dent.is_some_and(|(answer, dent, slack_mm)| {
                        dent.is_near(&from, &towards, slack_mm)
                            && self.is_behind(answer, &dent, &from, &towards)
                    })
            };
            let light = self.shade(&rest, &facing, &direction, depth_mm, is_hidden);
            [0, 1, 2].map(|part| self.exposure * send[part] * light[part])
        };
        let rays = (0..normals.len()).into_par_iter();
        let light = rays.map_init(Vec::new, ray).collect();
        RenderedLight { light, thickness_mm: Vec::new(), marks, not_known: Vec::new() }
    }

    /// Finds where a ray that grazes a marker's rim would meet the surface. Such a ray ends on the coat's solid without
    /// a valid surface point, but the rim is visible.
    fn grazing_hit(&self, map: &DepthMap<'_>, pixel: usize) -> Option<(Point3<f64>, Vector3<f64>)> {
        let rays = map.rays();
        let name = rays.seen_by_names().get(usize::from(*rays.seen_by().get(pixel)?))?;
        let ray = rays.ray(pixel).filter(|_| !self.is_printed && *name == self.coat_name)?;
        // Sphere tracing: a point below the surface is at least its depth away from it.
        let mut at_mm = 0.0;
        for _ in 0..MOST_STEPS {
            let depth_mm = self.touch.depth_mm(&ray.at(at_mm)).0;
            at_mm += depth_mm;
            if depth_mm < SHADOW_OFFSET_MM {
                return Some((ray.at(at_mm), ray.direction));
            }
        }
        None
    }

    /// Returns the height of markers above the coat, mm; 0 for printed ones.
    fn height_mm(&self) -> f64 {
        let Some(Marker { point, .. }) = self.sensor.marks.first().filter(|_| !self.is_printed)
        else {
            return 0.0;
        };
        self.touch.depth_mm(point).0 - self.coat_mm
    }

    /// Returns whether the dent's shadow may fall on a place at rest. Light directions are taken from the table's
    /// neighbouring places.
    fn may_shade(&self, dent: &Dent, rest: &Point3<f64>, slack_mm: f64) -> bool {
        let far_mm = dent.radius_mm + SHADOW_REACH_MM + slack_mm;
        if (rest - dent.centre).norm() > far_mm {
            return false;
        }
        self.plan.weights_at(rest).iter().any(|(i, _)| {
            let all = &self.comes_from[i * self.colors.len()..][..self.colors.len()];
            all.iter().flatten().any(|way| dent.is_near(rest, way, slack_mm + BESIDE_MM))
        })
    }

    /// Returns whether the deformed surface lies between a place and a light source.
    fn is_behind(
        &self,
        answer: &ContactSolution<'_>,
        dent: &Dent,
        from: &Point3<f64>,
        towards: &Vector3<f64>,
    ) -> bool {
        let [deepest_mm, _] = answer.limits_mm();
        let mut last_mm = f64::INFINITY;
        for step in 1..=SHADOW_STEPS {
            // Quadratic steps: dense near the place, where shadows begin.
            let share = f64::from(step) / f64::from(SHADOW_STEPS);
            let place = from + share * share * SHADOW_REACH_MM * towards;
            let (depth_mm, outward) = self.touch.depth_mm(&place);
            // Light above the highest point of the deformed surface cannot be blocked further on.
            if depth_mm > deepest_mm + self.coat_mm {
                return false;
            }
            let foot = place + depth_mm * outward;
            // Above the ring's bound nothing can block the light. Where the light also moves away from the dent, the
            // search ends: in a convex body, the depth along a straight line is nowhere below its values at the ends.
            let far_mm = (foot - dent.centre).norm();
            let above_mm = dent.deepest_mm(far_mm) + self.coat_mm;
            if depth_mm > above_mm {
                let end = || from + SHADOW_REACH_MM * towards;
                if far_mm > last_mm && self.touch.depth_mm(&end()).0 > above_mm {
                    return false;
                }
                last_mm = far_mm;
                continue;
            }
            last_mm = far_mm;
            let now_mm = depth_mm + answer.outwards_mm(&foot, &outward);
            if now_mm < self.coat_mm - BEHIND_MM {
                return true;
            }
        }
        false
    }
}

fn coat_of([diffuse, gloss, exponent]: [f64; 3]) -> Coat {
    Coat { diffuse, gloss, exponent }
}

/// Returns the lower quartile of a coat's thickness over the surface, mm: its thickness beside markers.
fn coat_thickness_mm(touch: &TouchSurface, coat: &fabkit_geometry::CompiledSolid) -> f64 {
    let Ok(points) = SurfacePoints::new(touch) else { return 0.0 };
    let (mut scratch, mut found) = (Scratch::default(), Vec::new());
    let plan = SurfaceGrid::new(&points);
    let places = plan.places(&points).into_iter().filter_map(|(place, _)| place);
    let mut all: Vec<f64> = places
        .filter_map(|(point, outward)| {
            let ray = fabkit_geometry::Ray { origin: point + outward, direction: -outward };
            coat.stretches_into(&ray, &mut scratch, &mut found);
            found.first().map(|[from, to]| to - from)
        })
        .collect();
    all.sort_by(f64::total_cmp);
    // The very minimum may be an edge effect at the foot.
    all.get(all.len() / 4).copied().unwrap_or(0.0)
}
