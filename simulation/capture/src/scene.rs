//! A sensor that shows touch by the thickness of translucent layers: those layers, and how they are lit.

use fabkit_files::Error;
use fabkit_geometry::{
    Assembly, Body, CompiledSolid, Lighting, Point3, Pose, Ray, Scratch, Sensor, Shows,
    SurfacePoints, TouchSurface, Vector3,
};
use fabkit_light::Emitters;

use super::lit::Lit;
use super::{CaptureError, LightConstants};

/// Rays that meet the layer flatter than this see it as if they met it so, cosine.
const LEAST_COSINE: f64 = 0.2;

/// Layers nearer to each other than this touch, mm.
const TOUCHING_MM: f64 = 1e-3;

/// What of a sensor makes its picture.
#[derive(Debug)]
pub struct Scene<'a> {
    /// The surface that is pressed.
    pub touch: &'a TouchSurface,
    /// The layers' names, from the inside out.
    pub layers: Vec<String>,
    /// What shines, in words.
    pub lamps: String,
    /// Irradiance on the surface, and by which lamps.
    pub lit: Lit,
    solids: Solids,
    /// How far off the core of their mold stands.
    core_off_mm: Vector3<f64>,
    pupil: Point3<f64>,
}

impl<'a> Scene<'a> {
    /// Of a sensor in a light that shows the thickness of layers.
    ///
    /// # Errors
    /// [`CaptureError`]: it shows touch otherwise, or nothing lights it.
    pub fn of(
        sensor: &'a Sensor,
        lighting: &Lighting,
        constants: &LightConstants,
    ) -> Result<Self, Error> {
        let layers: Vec<String> = match &lighting.shows {
            Shows::Thickness { layers } => layers.clone(),
            Shows::Glow { layers } => layers.iter().map(|(layer, _)| layer.clone()).collect(),
            _ => Vec::new(),
        };
        let touch = sensor.touch.as_ref();
        let touch = touch.ok_or_else(|| CaptureError::NoSurface { sensor: sensor.name.clone() })?;
        let missing = || CaptureError::OtherLight { sensor: sensor.name.clone() };
        let bodies = layers.iter().map(|layer| sensor.body(layer).ok_or_else(missing));
        let bodies = bodies.collect::<Result<Vec<_>, _>>()?;
        if bodies.is_empty() {
            return Err(missing().into());
        }
        // Light that makes layers glow is used up on its own way.
        let slanted_in =
            lighting.glows().then(|| bodies[0].substance.refractive_index.unwrap_or(1.0));
        let solids = bodies.into_iter().map(in_use).collect::<Result<Vec<_>, _>>()?;
        let solids = Solids(solids);
        let emitters = Emitters::of(sensor, lighting).map_err(CaptureError::NoLight)?;
        let points = SurfacePoints::new(touch).map_err(Error::bug)?;
        let inner_mm = |point: &Point3<f64>, outward: &Vector3<f64>| {
            let extent = solids.extent((point, outward), &mut Scratch::default(), &mut Vec::new());
            extent.map_or(0.0, |[_, to]| to)
        };
        let lit = Lit::new(&points, &emitters, inner_mm, constants.bounce.value, slanted_in);
        let lit = lit.ok_or_else(|| CaptureError::Dark { sensor: sensor.name.clone() })?;
        let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
        let lamps = emitters.what;
        let core_off_mm = constants.core_off_mm;
        Ok(Self { touch, layers, lamps, lit, solids, core_off_mm, pupil })
    }

    /// How much light there is in the middle of the surface, and how long the path in the layer is there, mm.
    pub(super) fn middle(&self) -> Option<[f64; 2]> {
        let (point, outward) = middle_of(self.touch)?;
        Some([self.lit.at(&point), self.paths_mm(&point, &outward, 0.0)[0]])
    }

    /// The most light anywhere but near the foot, over that in the middle.
    pub(super) fn brightest(&self) -> f64 {
        let middle = middle_of(self.touch).map_or(1.0, |(point, _)| self.lit.at(&point));
        self.lit.most() / middle
    }

    /// The innermost layer.
    pub fn innermost(&self) -> &str {
        &self.layers[0]
    }

    /// Stretches of a straight path in each layer, in order, from where to where and in which, mm.
    pub(super) fn stretches(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<(f64, f64, usize)> {
        self.solids.stretches(ray, scratch)
    }

    /// How thick the layers are together below a point of the surface at rest, along the normal, mm; nothing where they
    /// are not.
    pub fn thickness_mm(
        &self,
        place: (&Point3<f64>, &Vector3<f64>),
        scratch: &mut Scratch,
        found: &mut Vec<[f64; 2]>,
    ) -> Option<f64> {
        let drawn = self.solids.extent(place, scratch, found).map(|[from, to]| to - from);
        // Where the core stands nearer to the surface, less is around it.
        drawn.map(|mm| (mm - self.core_off_mm.dot(place.1)).max(0.0))
    }

    /// How long the camera's path in the layer is at rest, and where it has become so much thicker, mm; from where the
    /// design has the camera, straight.
    pub fn paths_mm(&self, rest: &Point3<f64>, outward: &Vector3<f64>, gains_mm: f64) -> [f64; 2] {
        let thick_mm = self
            .thickness_mm((rest, outward), &mut Scratch::default(), &mut Vec::new())
            .unwrap_or(0.0);
        let direction = (rest - self.pupil).normalize();
        [0.0, gains_mm].map(|gains_mm| along((thick_mm + gains_mm).max(0.0), outward, &direction))
    }
}

/// A body in its place in the finished sensor.
pub fn in_use(body: &Body) -> Result<CompiledSolid, Error> {
    let place = body.placements.iter().find(|place| place.assembly == Assembly::sensor());
    let pose = place.map_or_else(Pose::identity, |place| place.assembly_from_body);
    CompiledSolid::new(&body.solid.clone().placed(pose)).map_err(Error::bug)
}

/// The middle of the surface and its normal.
pub fn middle_of(touch: &TouchSurface) -> Option<(Point3<f64>, Vector3<f64>)> {
    match SurfacePoints::new(touch).ok()? {
        SurfacePoints::Dome(dome) => dome.towards(0.0, 0.0),
        SurfacePoints::Plane(pad) => {
            pad.at(pad.bounds_mm().map(|[least, most]| f64::midpoint(least, most)))
        }
    }
}

/// Along a path a layer is longer than along the normal, as its faces are parallel, about.
pub(super) fn along(thickness_mm: f64, outward: &Vector3<f64>, direction: &Vector3<f64>) -> f64 {
    thickness_mm / outward.dot(direction).max(LEAST_COSINE)
}

/// Layers, from the inside out.
#[derive(Debug)]
struct Solids(Vec<CompiledSolid>);

impl Solids {
    fn stretches(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<(f64, f64, usize)> {
        let mut all = Vec::new();
        for (layer, solid) in self.0.iter().enumerate() {
            let mut found = Vec::new();
            solid.stretches_into(ray, scratch, &mut found);
            all.extend(found.into_iter().map(|[from, to]| (from, to, layer)));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }

    /// From where to where they lie below a point, along a normal, mm, one after the other, whatever goes into what.
    fn extent(
        &self,
        (point, outward): (&Point3<f64>, &Vector3<f64>),
        scratch: &mut Scratch,
        found: &mut Vec<[f64; 2]>,
    ) -> Option<[f64; 2]> {
        // From a little outside, so that the surface itself is crossed.
        let ray = Ray { origin: point + outward, direction: -outward };
        if let [only] = &self.0[..] {
            only.stretches_into(&ray, scratch, found);
            return found.first().map(|[from, to]| [from - 1.0, to - 1.0]);
        }
        let mut extent: Option<[f64; 2]> = None;
        for (from, to, _) in self.stretches(&ray, scratch) {
            match &mut extent {
                None => extent = Some([from, to]),
                Some([_, last]) if from - *last < TOUCHING_MM => *last = last.max(to),
                Some(_) => break,
            }
        }
        extent.map(|[from, to]| [from - 1.0, to - 1.0])
    }
}
