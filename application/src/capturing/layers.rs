//! Translucent layers over black: the thicker, the brighter.

use fabkit_depth::truth::{DepthMap, NO_LABEL};
use fabkit_geometry::{Lighting, Point3, Rgb, Scratch, Sensor};
use fabkit_light::Spread;
use rayon::prelude::*;

use super::scene::{Scene, along};
use super::{LightConstants, Painted, ray_mm};
use crate::Error;
use crate::pressing::Answer;

/// Layers that differ by less are as thick everywhere, mm.
const EVEN_MM: f64 = 1e-6;

/// A sensor in a light that shows how thick its layers are.
#[derive(Debug)]
pub(crate) struct LayerScene<'a> {
    pub(super) scene: Scene<'a>,
    pub(super) constants: &'a LightConstants,
    pub(super) exposure: f64,
    /// How far neighbouring rays meet the surface from each other, mm, where maps are parts of a picture.
    ray_mm: Option<f64>,
    /// What all rays see at rest, where that is kept.
    at_rest: Option<AtRest>,
}

/// What a ray sees of layers that nothing presses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenAtRest {
    /// Where it meets the surface, sensor frame, mm.
    pub place: Point3<f64>,
    /// How thick they are there along the normal, mm, and along the ray.
    pub thick_mm: f64,
    pub path_mm: f64,
}

/// What each ray sees while nothing presses.
#[derive(Debug)]
struct AtRest {
    /// Where the surface is met, mm.
    range_mm: Vec<f64>,
    /// Grey value and thickness, before light spreads.
    seen: Vec<(f64, f64)>,
    /// How light spreads.
    spread: Spread,
    /// Grey values when it has.
    grey: Vec<f64>,
    /// How thick the layers are everywhere, mm, if they are.
    even_mm: Option<f64>,
}

impl<'a> LayerScene<'a> {
    pub(crate) fn of(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let scene = Scene::of(sensor, lighting, constants)?;
        let exposure = scene.middle().map_or(1.0, |[lit, mm]| constants.exposure(lit, mm))
            * constants.dimmer(scene.brightest());
        Ok(Self { scene, constants, exposure, ray_mm: None, at_rest: None })
    }

    /// The same for parts of the picture that is as fine as this map.
    pub(crate) fn for_parts_of(self, map: &DepthMap<'_>) -> Self {
        Self { ray_mm: Some(ray_mm(map)), ..self }
    }

    pub(super) fn words(&self) -> [String; 2] {
        [format!("thickness of {}", self.scene.layers.join(" and ")), self.scene.lamps.clone()]
    }

    /// Keeps what rays see of a surface at rest: where a press moves nothing, that is seen again.
    pub(super) fn prepare(&mut self, map: &DepthMap<'_>) {
        let seen = self.rays(self.constants, map, None);
        let spread = self.spread(self.constants, map, &seen);
        let mut grey: Vec<f64> = seen.iter().map(|(grey, _)| *grey).collect();
        spread.apply(&mut grey);
        let range_mm = map.range_mm().to_vec();
        let known = seen.iter().map(|(_, mm)| *mm).filter(|mm| mm.is_finite());
        let [least, most] = known.fold([f64::INFINITY, 0.0], |[least, most], mm| {
            [f64::min(least, mm), f64::max(most, mm)]
        });
        let even_mm = (most - least < EVEN_MM).then_some(f64::midpoint(least, most));
        self.at_rest = Some(AtRest { range_mm, seen, spread, grey, even_mm });
    }

    pub(crate) fn paint(&self, map: &DepthMap<'_>, answer: Option<&Answer<'_>>) -> Painted {
        self.paint_by(self.constants, map, answer)
    }

    /// The same with other constants of the layer, where nothing is kept of the surface at rest.
    pub(crate) fn paint_by(
        &self,
        constants: &LightConstants,
        map: &DepthMap<'_>,
        answer: Option<&Answer<'_>>,
    ) -> Painted {
        let rays = self.rays(constants, map, answer);
        let mut grey: Vec<f64> = rays.iter().map(|(grey, _)| *grey).collect();
        match &self.at_rest {
            // Light that spreads adds up: of what has changed alone.
            Some(rest) => {
                grey.iter_mut().zip(&rest.seen).for_each(|(now, before)| *now -= before.0);
                rest.spread.apply(&mut grey);
                grey.iter_mut().zip(&rest.grey).for_each(|(change, before)| *change += before);
            }
            None => self.spread(constants, map, &rays).apply(&mut grey),
        }
        let light: Vec<Rgb> = grey.into_iter().map(|grey| [grey; 3]).collect();
        let thickness_mm = rays.into_iter().map(|(_, mm)| mm).collect();
        Painted { light, thickness_mm, marks: Vec::new() }
    }

    /// What each ray of a surface at rest sees of the layers; nothing of those that see none.
    pub(crate) fn seen_at_rest(&self, map: &DepthMap<'_>) -> Vec<Option<SeenAtRest>> {
        let ray = |(scratch, found): &mut (Scratch, Vec<[f64; 2]>), i: usize| {
            let (place, direction) = map.arrival(i).filter(|_| map.label()[i] != NO_LABEL)?;
            let (_, outward) = self.scene.touch.depth_mm(&place);
            let thick_mm = self.scene.thickness_mm((&place, &outward), scratch, found)?;
            let path_mm = along(thick_mm, &outward, &direction);
            Some(SeenAtRest { place, thick_mm, path_mm })
        };
        let memory = || (Scratch::default(), Vec::new());
        (0..map.range_mm().len()).into_par_iter().map_init(memory, ray).collect()
    }

    /// How light spreads where there is a layer.
    fn spread(
        &self,
        constants: &LightConstants,
        map: &DepthMap<'_>,
        seen: &[(f64, f64)],
    ) -> Spread {
        let is_layer = seen.iter().map(|(_, mm)| mm.is_finite()).collect();
        let ray_mm = self.ray_mm.unwrap_or_else(|| ray_mm(map));
        let sigma_px = constants.spread_mm.value / ray_mm;
        Spread::new(is_layer, map.width_px() as usize, sigma_px)
    }

    /// Grey value and thickness that each ray meets.
    fn rays(
        &self,
        constants: &LightConstants,
        map: &DepthMap<'_>,
        answer: Option<&Answer<'_>>,
    ) -> Vec<(f64, f64)> {
        let scene = &self.scene;
        let (law, beside) = (constants.layer(), (constants.beside_grey.value, f64::NAN));
        let lower = answer.and_then(|answer| answer.lower_face(scene.innermost()));
        let rest = self.at_rest.as_ref();
        let even_mm = rest.and_then(|rest| rest.even_mm);
        let ray = |(scratch, found): &mut (Scratch, Vec<[f64; 2]>), i: usize| {
            if let Some(rest) = rest.filter(|rest| map.range_mm()[i] == rest.range_mm[i]) {
                return rest.seen[i];
            }
            if map.label()[i] == NO_LABEL {
                return beside;
            }
            let Some((place, direction)) = map.arrival(i) else { return beside };
            // Where the surface was at rest, how far it has moved, and what lay below it.
            let (depth_mm, outward) = scene.touch.depth_mm(&place);
            let foot = place + depth_mm * outward;
            let thick_mm =
                even_mm.or_else(|| scene.thickness_mm((&foot, &outward), scratch, found));
            let Some(thick_mm) = thick_mm else { return beside };
            let lower_mm = lower.as_ref().map_or(0.0, |lower| lower.outwards_mm(&foot));
            let thickness_mm = (thick_mm - depth_mm - lower_mm).max(0.0);
            let path_mm = along(thickness_mm, &outward, &direction);
            let sent =
                constants.ground_grey.value + constants.layer_grey.value * law.reflectance(path_mm);
            (self.exposure * scene.lit.at(&foot) * sent, thickness_mm)
        };
        let memory = || (Scratch::default(), Vec::new());
        (0..map.range_mm().len()).into_par_iter().map_init(memory, ray).collect()
    }
}
