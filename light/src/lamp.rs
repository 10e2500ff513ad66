//! What shines in a sensor, and how much of that arrives where.

use fabkit_geometry::{
    Assembly, Body, Clarity, CompiledSolid, InvalidSolid, Kind, Point3, Ray, Sensor, Solid, Vector3,
};
use fabkit_optics::{InvalidStack, Stack, Tracer};
use rayon::prelude::*;

/// Lines along each side of what shines, at which its faces are asked.
const LINES: usize = 16;
/// The same along three axes: as many pieces in all, about.
const LINES_ALL_AROUND: usize = 10;
/// Light that comes within this distance of a lamp has arrived, mm.
const THERE_MM: f64 = 1e-3;
/// Places start that far off the layer they belong to, mm.
const OFF_MM: f64 = 1e-3;

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
struct Emitter {
    place: Point3<f64>,
    outward: Vector3<f64>,
    /// Area, mm2, times how bright it is.
    power: f64,
}

/// All that shines of a sensor, and what stands in its way.
#[derive(Debug)]
pub struct Emitters {
    emitters: Vec<Emitter>,
    stack: Stack,
    /// What shines, in words.
    pub what: String,
}

impl Emitters {
    /// The upper faces of a sensor's lamps; where something translucent that is not cast is there, all faces of this
    /// diffuser instead, each place as bright as its lamps make it from behind.
    ///
    /// # Errors
    /// Nothing shines; bodies that are none, or that light cannot be followed through.
    pub fn of(sensor: &Sensor) -> Result<Self, NoLight> {
        let lamps = faces(sensor, Shines::Upwards, |body| body.lamp.clone())?;
        let no_lamps = || NoLight::NoLamps { sensor: sensor.name.clone() };
        if lamps.is_empty() {
            return Err(no_lamps());
        }
        let spreads = |body: &&Body| {
            body.clarity() == Clarity::Translucent && body.kind != Kind::Cast && body.lamp.is_none()
        };
        let diffuser = sensor.bodies.iter().find(spreads).map(|body| body.name.clone());
        let (emitters, what) = match diffuser {
            None => (lamps, "the lamps' upper faces".to_owned()),
            Some(name) => {
                let of_diffuser = |body: &Body| (body.name == name).then(|| body.solid.clone());
                let mut faces = faces(sensor, Shines::AllAround, of_diffuser)?;
                for piece in &mut faces {
                    piece.power *= lamps
                        .iter()
                        .map(|lamp| lamp.shines_on(&piece.place, &-piece.outward))
                        .sum::<f64>();
                }
                faces.retain(|piece| piece.power > 0.0);
                (faces, format!("{name}, as bright as the lamps make it from behind"))
            }
        };
        // Light is taken to go straight: what bends it between lamp and layer is left out.
        let stack = Stack::straight(sensor)?;
        match emitters.iter().any(|emitter| emitter.power > 0.0) {
            true => Ok(Self { emitters, stack, what }),
            false => Err(no_lamps()),
        }
    }

    /// How much light arrives straight from what shines at places that look along unit normals, relative: by both
    /// cosines and the square of the distance, without what an opaque body hides.
    pub fn irradiance(&self, places: &[(Point3<f64>, Vector3<f64>)]) -> Vec<f64> {
        let arrives = |tracer: &mut Tracer<'_>, (place, facing): &(Point3<f64>, Vector3<f64>)| {
            let from = place + OFF_MM * facing;
            let mut sum = 0.0;
            for emitter in &self.emitters {
                let arrives = emitter.shines_on(&from, facing) * emitter.power;
                if arrives > 0.0 && emitter.is_seen_from(&from, tracer) {
                    sum += arrives;
                }
            }
            sum
        };
        let places = places.par_iter();
        places.map_init(|| Tracer::new(&self.stack), |tracer, at| arrives(tracer, at)).collect()
    }
}

impl Emitter {
    /// Both cosines over the square of the distance, 1/mm2.
    fn shines_on(&self, place: &Point3<f64>, facing: &Vector3<f64>) -> f64 {
        let way = self.place - place;
        let square = way.norm_squared();
        let both = way.dot(facing).max(0.0) * (-way.dot(&self.outward)).max(0.0);
        if square > 0.0 { both / (square * square) } else { 0.0 }
    }

    fn is_seen_from(&self, place: &Point3<f64>, tracer: &mut Tracer<'_>) -> bool {
        let way = self.place - place;
        let distance_mm = way.norm();
        let path = tracer.follow(&Ray { origin: *place, direction: way / distance_mm });
        path.lead_mm + path.end_mm > distance_mm - THERE_MM
    }
}

/// Which faces shine.
#[derive(Clone, Copy, PartialEq)]
enum Shines {
    /// Those that look up: a lamp's.
    Upwards,
    /// All: those of what spreads light.
    AllAround,
}

/// Pieces of the faces of some solids of a sensor, equally bright.
fn faces(
    sensor: &Sensor,
    shines: Shines,
    solid_of: impl Fn(&Body) -> Option<Solid>,
) -> Result<Vec<Emitter>, NoLight> {
    let mut pieces = Vec::new();
    for body in &sensor.bodies {
        let Some(solid) = solid_of(body) else { continue };
        // Fewer where there are many lamps.
        let lines = match shines {
            Shines::AllAround => LINES_ALL_AROUND,
            Shines::Upwards if body.placements.len() > 2 => LINES / 4,
            Shines::Upwards => LINES,
        };
        for place in body.placements.iter().filter(|place| place.assembly == Assembly::sensor()) {
            let solid = CompiledSolid::new(&solid.clone().placed(place.assembly_from_body))?;
            for axis in 0..3 {
                if axis == 2 || shines == Shines::AllAround {
                    add_along(axis, &solid, lines, &mut pieces);
                }
            }
        }
    }
    if shines == Shines::Upwards {
        pieces.retain(|piece| piece.outward.z > 0.0);
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
                pieces.push(Emitter { place: line.at(crossing.t), outward, power });
            }
        }
    }
}
