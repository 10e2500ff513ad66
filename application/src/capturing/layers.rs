//! Translucent layers over black: the thicker, the brighter.

use fabkit_depth::truth::{DepthMap, NO_LABEL};
use fabkit_geometry::{Lighting, Point3, Rgb, Scratch, Sensor, Vector3};
use fabkit_light::spread;
use rayon::prelude::*;

use super::scene::{Scene, along};
use super::{LightConstants, Painted, ray_mm};
use crate::Error;
use crate::pressing::Answer;

/// A sensor in a light that shows how thick its layers are.
pub(super) struct LayerScene<'a> {
    scene: Scene<'a>,
    constants: &'a LightConstants,
    pub(super) exposure: f64,
}

impl<'a> LayerScene<'a> {
    pub(super) fn of(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let scene = Scene::of(sensor, lighting, constants)?;
        let exposure = scene.middle().map_or(1.0, |[lit, mm]| constants.exposure(lit, mm))
            * constants.dimmer(scene.brightest());
        Ok(Self { scene, constants, exposure })
    }

    pub(super) fn words(&self) -> [String; 2] {
        [format!("thickness of {}", self.scene.layers.join(" and ")), self.scene.lamps.clone()]
    }

    pub(super) fn paint(&self, map: &DepthMap<'_>, answer: Option<&Answer<'_>>) -> Painted {
        let rays = self.rays(map, answer);
        let (mut grey, thickness_mm): (Vec<f64>, Vec<f64>) = rays.into_iter().unzip();
        let is_layer: Vec<bool> = thickness_mm.iter().map(|mm| mm.is_finite()).collect();
        let sigma_px = self.constants.spread_mm.value / ray_mm(map);
        spread(&mut grey, &is_layer, map.width_px() as usize, sigma_px);
        let light: Vec<Rgb> = grey.into_iter().map(|grey| [grey; 3]).collect();
        Painted { light, thickness_mm, marks: Vec::new() }
    }

    /// Grey value and thickness that each ray meets.
    fn rays(&self, map: &DepthMap<'_>, answer: Option<&Answer<'_>>) -> Vec<(f64, f64)> {
        let (scene, constants) = (&self.scene, self.constants);
        let (law, beside) = (constants.layer(), (constants.beside_grey.value, f64::NAN));
        let lower = answer.and_then(|answer| answer.lower_face(scene.innermost()));
        let places: Vec<(Point3<f64>, Vector3<f64>)> =
            map.point_in_sensor().zip(map.direction_in_sensor()).collect();
        let ray =
            |(scratch, found): &mut (Scratch, Vec<[f64; 2]>),
             ((place, direction), label): (&(Point3<f64>, Vector3<f64>), &u16)| {
                if *label == NO_LABEL {
                    return beside;
                }
                // Where the surface was at rest, how far it has moved, and what lay below it.
                let (depth_mm, outward) = scene.touch.depth_mm(place);
                let rest = place + depth_mm * outward;
                let Some(thick_mm) = scene.thickness_mm((&rest, &outward), scratch, found) else {
                    return beside;
                };
                let lower_mm = lower.as_ref().map_or(0.0, |lower| lower.outwards_mm(&rest));
                let thickness_mm = (thick_mm - depth_mm - lower_mm).max(0.0);
                let path_mm = along(thickness_mm, &outward, direction);
                let sent = constants.ground_grey.value
                    + constants.layer_grey.value * law.reflectance(path_mm);
                (self.exposure * scene.lit.at(&rest) * sent, thickness_mm)
            };
        let memory = || (Scratch::default(), Vec::new());
        places.par_iter().zip(map.label()).map_init(memory, ray).collect()
    }
}
