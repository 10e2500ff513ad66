//! What shines in a sensor, and how much of that arrives where.

use std::f64::consts::PI;

use fabkit_geometry::{
    Assembly, Body, Clarity, CompiledSolid, InvalidSolid, Kind, LampGroup, Lighting, Point3, Ray,
    Rgb, Sensor, Shows, Solid, Vector3, WHITE,
};
use fabkit_optics::{InvalidStack, Stack, Tracer};
use rayon::prelude::*;

use crate::{Arrival, Planes};

/// Lines along each side of what shines, at which its faces are asked.
const LINES: usize = 16;
/// The same along three axes: as many pieces in all, about.
const LINES_ALL_AROUND: usize = 10;
/// Pieces of all lamps together, about, where each throws shadows of its own.
const PIECES_WITH_SHADOWS: usize = 24;
/// What comes through a diffuser. Chosen; what else shines beside one is compared with it.
const THROUGH: f64 = 0.5;
/// Light that comes within this distance of a lamp has arrived, mm.
const THERE_MM: f64 = 1e-3;
/// Places start that far off the layer they belong to, mm.
const OFF_MM: f64 = 1e-3;

/// Light that is flatter than this goes through a layer as if it were this steep, cosine.
const LEAST_COSINE: f64 = 0.05;

/// Why nobody knows how a sensor is lit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoLight {
    /// No body shines.
    #[error("`{sensor}` has no lamps that shine at its surface")]
    NoLamps {
        /// The sensor.
        sensor: String,
    },
    /// What shines is no solid.
    #[error(transparent)]
    Solid(#[from] InvalidSolid),
    /// Bodies that no light can be followed through.
    #[error(transparent)]
    Stack(#[from] InvalidStack),
}

/// A piece of a face that shines as paper does, to all sides alike (Lambert).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Its middle, sensor frame, mm.
    pub place: Point3<f64>,
    /// Out of what shines, unit.
    pub outward: Vector3<f64>,
    /// Area, mm2, times how bright it is.
    pub power: f64,
    /// Its light.
    pub color: Rgb,
    /// Which lamp it is of, by number.
    pub lamp: usize,
}

/// All that shines of a sensor, and what stands in its way.
#[derive(Debug)]
pub struct Emitters {
    emitters: Vec<Emitter>,
    planes: Planes,
    stack: Stack,
    /// What shines, in words.
    pub what: String,
}

impl Emitters {
    /// What is switched on of a sensor: the faces of lamps that look along their bodies' z axes, as far as something
    /// translucent that is not cast does not cover them; and all faces of this diffuser, each place as bright as the
    /// lamps make it from behind.
    ///
    /// # Errors
    /// Nothing shines; bodies that are none, or that light cannot be followed through.
    pub fn of(sensor: &Sensor, lighting: &Lighting) -> Result<Self, NoLight> {
        let no_lamps = || NoLight::NoLamps { sensor: sensor.name.clone() };
        let in_use = Assembly::sensor();
        let count = |group: &LampGroup| {
            let body = sensor.body(&group.body);
            let places = body.map_or(&[][..], |body| &body.placements);
            places.iter().filter(|place| place.assembly == in_use).count()
        };
        let lines = lines(lighting, lighting.lamps.iter().map(count).sum());
        let mut lamps = Vec::new();
        for group in &lighting.lamps {
            let body = sensor.body(&group.body).ok_or_else(no_lamps)?;
            let solid = body.lamp.as_ref().ok_or_else(no_lamps)?;
            let first = lamps.last().map_or(0, |lamp: &Emitter| lamp.lamp + 1);
            let mut found = faces(body, solid, Shines::Forwards, lines)?;
            for piece in &mut found {
                piece.color = group.color(piece.lamp);
                piece.lamp += first;
            }
            lamps.extend(found);
        }
        if lamps.is_empty() {
            return Err(no_lamps());
        }
        let spreads = |body: &&Body| {
            body.clarity() == Clarity::Translucent && body.kind != Kind::Cast && body.lamp.is_none()
        };
        // Light is taken to go straight, but for level plates: what else bends it is left out.
        let planes = Planes::of(sensor)?;
        let stack = Stack::straight(&without_shown(sensor, lighting))?;
        let own =
            Self { emitters: lamps, planes, stack, what: format!("{}s", lighting.lamps[0].body) };
        // What makes things glow does not come through what spreads light: white plastic swallows it.
        let diffuser = sensor.bodies.iter().find(spreads).filter(|_| !lighting.glows());
        let Some(diffuser) = diffuser else { return Ok(own) };
        let mut spread = faces(diffuser, &diffuser.solid, Shines::AllAround, LINES_ALL_AROUND)?;
        for piece in &mut spread {
            let from_behind = |lamp: &Emitter| lamp.shines_on(&piece.place, &-piece.outward);
            // What comes through is spread anew: over pi.
            let lit = own.emitters.iter().map(|lamp| THROUGH * lamp.power * from_behind(lamp) / PI);
            let color = [0, 1, 2].map(|part| {
                let colored = own.emitters.iter().zip(lit.clone());
                colored.map(|(lamp, lit)| lit * lamp.color[part]).sum::<f64>()
            });
            let brightest = color.iter().copied().fold(0.0, f64::max);
            piece.power *= brightest;
            piece.color = color.map(|part| if brightest > 0.0 { part / brightest } else { 0.0 });
        }
        spread.retain(|piece| piece.power > 0.0);
        if spread.is_empty() {
            return Ok(own);
        }
        let what = format!("{}, as bright as the lamps make it from behind", diffuser.name);
        Ok(Self { emitters: spread, what, ..own })
    }

    /// Each piece that shines.
    pub fn pieces(&self) -> &[Emitter] {
        &self.emitters
    }

    /// How light of a piece arrives at a place below the layer that it belongs to, if no opaque body hides it; its
    /// density counts for all of the piece.
    pub fn arrival(
        &self,
        emitter: &Emitter,
        place: &Point3<f64>,
        tracer: &mut Tracer<'_>,
    ) -> Option<Arrival> {
        let mut found = self.planes.arrival(&emitter.place, place)?;
        found.density *= emitter.power * found.leaves.dot(&emitter.outward).max(0.0);
        let is_free = found.density > 0.0 && {
            let corners = match self.planes.is_empty() {
                true => vec![*place, emitter.place],
                false => vec![*place, found.bends[1], found.bends[0], emitter.place],
            };
            corners.windows(2).all(|pair| is_free(&pair[0], &pair[1], tracer))
        };
        is_free.then_some(found)
    }

    /// For [`Emitters::arrival`]; one per thread.
    pub fn tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.stack)
    }

    /// How much light arrives straight from what shines at places that look along unit normals, relative: by both
    /// cosines and the square of the distance, without what an opaque body hides, with what level plates bend.
    pub fn irradiance(&self, places: &[(Point3<f64>, Vector3<f64>)]) -> Vec<Rgb> {
        self.gathered(places, |cosine| cosine)
    }

    /// The same light, each part times how much longer its way through a layer with this refractive index is than the layer
    /// is thick. Light that comes through air is bent where it enters; that of level plates has been bent there.
    pub fn slanted(&self, places: &[(Point3<f64>, Vector3<f64>)], index: f64) -> Vec<Rgb> {
        let index = if self.planes.is_empty() { index } else { 1.0 };
        self.gathered(places, |cosine| cosine / inside(cosine, index))
    }

    /// What arrives at places, each part by what its cosine there makes of it.
    fn gathered(
        &self,
        places: &[(Point3<f64>, Vector3<f64>)],
        part: impl Fn(f64) -> f64 + Sync,
    ) -> Vec<Rgb> {
        let arrives = |tracer: &mut Tracer<'_>, (place, facing): &(Point3<f64>, Vector3<f64>)| {
            let from = place + OFF_MM * facing;
            let mut sum = [0.0; 3];
            for emitter in &self.emitters {
                // From behind no way need be followed.
                if (emitter.place - from).dot(facing) <= 0.0 && self.planes.is_empty() {
                    continue;
                }
                let Some(found) = self.arrival(emitter, &from, tracer) else { continue };
                let lit = found.density * part((-found.arrives.dot(facing)).max(0.0));
                sum = [0, 1, 2].map(|part| sum[part] + lit * emitter.color[part]);
            }
            sum
        };
        let places = places.par_iter();
        places.map_init(|| self.tracer(), |tracer, at| arrives(tracer, at)).collect()
    }
}

/// How much longer the way of light that is the same from all sides is within a layer than the layer is thick, on average of
/// what enters: of light from air into a refractive index n, 2 n (n - sqrt(n^2 - 1)), Snell's law under Lambert's.
///
/// ```
/// // Without bending 2, as known of diffuse light; into glass nearly straight.
/// assert!((fabkit_light::diffuse_slant(1.0) - 2.0).abs() < 1e-12);
/// assert!((fabkit_light::diffuse_slant(1.5) - 1.146).abs() < 1e-3);
/// ```
pub fn diffuse_slant(index: f64) -> f64 {
    2.0 * index * (index - (index * index - 1.0).max(0.0).sqrt())
}

/// The cosine behind a face of a refractive index that light from air meets with this one.
fn inside(cosine: f64, index: f64) -> f64 {
    let sine_squared = (1.0 - cosine * cosine).max(0.0) / (index * index);
    (1.0 - sine_squared).max(0.0).sqrt().max(LEAST_COSINE)
}

impl Emitter {
    /// Both cosines over the square of the distance, 1/mm2.
    fn shines_on(&self, place: &Point3<f64>, facing: &Vector3<f64>) -> f64 {
        let way = self.place - place;
        let square = way.norm_squared();
        let both = way.dot(facing).max(0.0) * (-way.dot(&self.outward)).max(0.0);
        if square > 0.0 { both / (square * square) } else { 0.0 }
    }
}

/// Whether no opaque body is between two places.
fn is_free(from: &Point3<f64>, to: &Point3<f64>, tracer: &mut Tracer<'_>) -> bool {
    let way = to - from;
    let distance_mm = way.norm();
    if distance_mm < THERE_MM {
        return true;
    }
    let path = tracer.follow(&Ray { origin: *from, direction: way / distance_mm });
    path.lead_mm + path.end_mm > distance_mm - THERE_MM
}

/// A sensor without what a light shows standing out of something: its shadows are told from where it has moved to.
fn without_shown(sensor: &Sensor, lighting: &Lighting) -> Sensor {
    let mut without = sensor.clone();
    let is_shown = |name: &String| match &lighting.shows {
        Shows::Slopes { coat, printed } => name == coat || printed.as_ref() == Some(name),
        Shows::Marks { marks } => name == marks,
        Shows::Thickness { .. } | Shows::Glow { .. } | Shows::Columns { .. } => false,
    };
    without.bodies.retain(|body| !is_shown(&body.name));
    without
}

/// Which faces shine.
#[derive(Clone, Copy, PartialEq)]
enum Shines {
    /// Those that look along the body's z axis: a lamp's.
    Forwards,
    /// All: those of what spreads light.
    AllAround,
}

/// Lines along each side of a lamp: fewer where there are many lamps, and where shadows are told from each piece.
fn lines(lighting: &Lighting, lamps: usize) -> usize {
    match lighting.shows {
        Shows::Slopes { .. } => {
            ((PIECES_WITH_SHADOWS / lamps.max(1)) as f64).sqrt().floor().max(1.0) as usize
        }
        _ if lamps > 2 => LINES / 4,
        _ => LINES,
    }
}

/// Pieces of the faces of a solid in its body's places, equally bright, by their number.
fn faces(
    body: &Body,
    solid: &Solid,
    shines: Shines,
    lines: usize,
) -> Result<Vec<Emitter>, NoLight> {
    let mut pieces = Vec::new();
    // In the body's own frame, so that every lamp is divided alike.
    let compiled = CompiledSolid::new(solid)?;
    let mut own = Vec::new();
    for axis in 0..3 {
        if axis == 2 || shines == Shines::AllAround {
            add_along(axis, &compiled, lines, &mut own);
        }
    }
    if shines == Shines::Forwards {
        own.retain(|piece| piece.outward.z > 0.0);
    }
    let places = body.placements.iter().filter(|place| place.assembly == Assembly::sensor());
    for (lamp, place) in places.enumerate() {
        let pose = &place.assembly_from_body;
        pieces.extend(own.iter().map(|piece| Emitter {
            place: pose.point(piece.place),
            outward: pose.vector(piece.outward),
            lamp,
            ..*piece
        }));
    }
    Ok(pieces)
}

/// The pieces of faces that look along an axis more than along any other, either way.
fn add_along(axis: usize, solid: &CompiledSolid, lines: usize, pieces: &mut Vec<Emitter>) {
    let (bounds, size) = (solid.bounds(), solid.bounds().size_mm());
    let [first, second] = [(axis + 1) % 3, (axis + 2) % 3];
    let steps = [first, second].map(|side| size[side] / lines as f64);
    let mut direction = Vector3::zeros();
    direction[axis] = 1.0;
    for i in 0..lines * lines {
        let mut origin = bounds.min;
        origin[axis] -= 1.0;
        origin[first] += (0.5 + (i % lines) as f64) * steps[0];
        origin[second] += (0.5 + (i / lines) as f64) * steps[1];
        let line = Ray { origin, direction };
        for crossing in solid.crossings(&line) {
            let outward = crossing.normal;
            let slope = outward[axis].abs();
            if slope >= outward[first].abs() && slope > outward[second].abs() {
                let power = steps[0] * steps[1] / slope;
                let place = line.at(crossing.t);
                pieces.push(Emitter { place, outward, power, color: WHITE, lamp: 0 });
            }
        }
    }
}
