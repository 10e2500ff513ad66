//! A sensor as its light meets it: the layer whose thickness is seen, and how it is lit.

use fabkit_geometry::{
    Assembly, Clarity, CompiledSolid, Kind, Point3, Pose, Ray, Scratch, Sensor, SurfacePoints,
    TouchSurface, Vector3,
};
use fabkit_light::Emitters;

use super::lit::Lit;
use super::{CaptureError, LightConstants};
use crate::Error;

/// Rays that meet the layer flatter than this see it as if they met it so, cosine.
const LEAST_COSINE: f64 = 0.2;

/// What of a sensor makes its picture.
#[derive(Debug)]
pub struct Scene<'a> {
    /// The surface that is pressed.
    pub touch: &'a TouchSurface,
    /// The layer's name.
    pub layer: String,
    /// What shines, in words.
    pub lamps: String,
    pub(crate) lit: Lit,
    solid: CompiledSolid,
    pupil: Point3<f64>,
}

impl<'a> Scene<'a> {
    /// Of a sensor that shows touch by one translucent layer.
    ///
    /// # Errors
    /// [`CaptureError`]: it shows touch otherwise, or nothing lights it.
    pub fn of(sensor: &'a Sensor, constants: &LightConstants) -> Result<Self, Error> {
        let other = |shows: &str| CaptureError::OtherLight {
            sensor: sensor.name.clone(),
            shows: shows.to_owned(),
        };
        let touch =
            sensor.touch.as_ref().ok_or_else(|| other("it has no surface of known shape"))?;
        let in_use = Assembly::sensor();
        let layers = sensor.bodies.iter().filter(|body| {
            body.kind == Kind::Cast
                && body.clarity() == Clarity::Translucent
                && body.placements.iter().any(|place| place.assembly == in_use)
        });
        let layers: Vec<_> = layers.collect();
        let [layer] = layers[..] else {
            return Err(other("not exactly one of its cast layers is translucent").into());
        };
        let place = layer.placements.iter().find(|place| place.assembly == in_use);
        let pose = place.map_or_else(Pose::identity, |place| place.assembly_from_body);
        let solid = CompiledSolid::new(&layer.solid.clone().placed(pose)).map_err(Error::bug)?;
        let emitters = Emitters::of(sensor).map_err(CaptureError::NoLight)?;
        let points = SurfacePoints::new(touch).map_err(Error::bug)?;
        let inner_mm = |point: &Point3<f64>, outward: &Vector3<f64>| {
            below(&solid, (point, outward), &mut Scratch::default(), &mut Vec::new())
                .map_or(0.0, |[_, to]| to)
        };
        let lit = Lit::new(&points, &emitters, inner_mm, constants.bounce.value);
        let lit = lit.ok_or_else(|| CaptureError::Dark { sensor: sensor.name.clone() })?;
        let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
        let (layer, lamps) = (layer.name.clone(), emitters.what);
        Ok(Self { touch, layer, lamps, lit, solid, pupil })
    }

    /// How much light there is in the middle of the surface, and how long the path in the layer is there, mm.
    pub(super) fn middle(&self) -> Option<[f64; 2]> {
        let (point, outward) = match SurfacePoints::new(self.touch).ok()? {
            SurfacePoints::Dome(dome) => dome.towards(0.0, 0.0)?,
            SurfacePoints::Plane(pad) => {
                pad.at(pad.bounds_mm().map(|[least, most]| f64::midpoint(least, most)))?
            }
        };
        Some([self.lit.at(&point), self.paths_mm(&point, &outward, 0.0)[0]])
    }

    /// How thick the layer is below a point of the surface at rest, along the normal, mm; nothing where it is not.
    pub(crate) fn thickness_mm(
        &self,
        place: (&Point3<f64>, &Vector3<f64>),
        scratch: &mut Scratch,
        found: &mut Vec<[f64; 2]>,
    ) -> Option<f64> {
        below(&self.solid, place, scratch, found).map(|[from, to]| to - from)
    }

    /// How long the camera's path in the layer is at rest, and where it has become so much thicker, mm; from where the
    /// design has the camera, straight.
    pub(crate) fn paths_mm(
        &self,
        rest: &Point3<f64>,
        outward: &Vector3<f64>,
        gains_mm: f64,
    ) -> [f64; 2] {
        let thick_mm = self
            .thickness_mm((rest, outward), &mut Scratch::default(), &mut Vec::new())
            .unwrap_or(0.0);
        let direction = (rest - self.pupil).normalize();
        [0.0, gains_mm].map(|gains_mm| along((thick_mm + gains_mm).max(0.0), outward, &direction))
    }
}

/// Along a path a layer is longer than along the normal, as its faces are parallel, about.
pub(super) fn along(thickness_mm: f64, outward: &Vector3<f64>, direction: &Vector3<f64>) -> f64 {
    thickness_mm / outward.dot(direction).max(LEAST_COSINE)
}

/// From where to where a solid lies below a point, along a normal, mm.
fn below(
    solid: &CompiledSolid,
    (point, outward): (&Point3<f64>, &Vector3<f64>),
    scratch: &mut Scratch,
    found: &mut Vec<[f64; 2]>,
) -> Option<[f64; 2]> {
    // From a little outside, so that the surface itself is crossed.
    let ray = Ray { origin: point + outward, direction: -outward };
    solid.stretches_into(&ray, scratch, found);
    found.first().map(|[from, to]| [from - 1.0, to - 1.0])
}
