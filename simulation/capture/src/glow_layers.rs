//! Rendering of layers that fluoresce in light that the camera does not see.

use fabkit_depth::ground_truth::{DepthMap, NO_LABEL};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Point3, Ray, Rgb, Scratch, Sensor, Vector3, VisibleEffect};
use fabkit_light::fluorescence;
use fabkit_scene::press_simulation::ContactSolution;
use rayon::prelude::*;

use super::scene::{LayerGeometry, path_length_mm, surface_middle};
use super::{LightConstants, RenderedLight};

/// Distance before the layers at which rays start, mm.
const BEFORE_MM: f64 = 0.5;

/// A sensor in a lighting that makes its layers glow.
#[derive(Debug)]
pub(super) struct GlowScene<'a> {
    scene: LayerGeometry<'a>,
    colors: Vec<Rgb>,
    constants: &'a LightConstants,
    pub(super) exposure: f64,
}

impl<'a> GlowScene<'a> {
    pub(super) fn new(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let scene = LayerGeometry::new(sensor, lighting, constants)?;
        let VisibleEffect::Fluorescence { layers } = &lighting.effect else {
            return Err(Error::bug("no glow"));
        };
        let colors = layers.iter().map(|(_, color)| *color).collect();
        let mut own = Self { scene, colors, constants, exposure: 1.0 };
        let brightest = surface_middle(own.scene.touch).map_or(0.0, |(rest, outward)| {
            let scratch = &mut Scratch::default();
            let light = own.ray_light((&rest, &outward), &outward, 1.0, scratch);
            light.map_or(0.0, |light| light.into_iter().fold(0.0, f64::max))
        });
        // The exposure puts the middle of the surface at rest at `middle_grey`.
        if let Some(middle) = constants.middle_grey.as_ref().filter(|_| brightest > 0.0) {
            own.exposure = middle.value / brightest
                * constants.exposure_limit_factor(own.scene.relative_peak());
        }
        Ok(own)
    }

    pub(super) fn words(&self) -> [String; 2] {
        [format!("glow of {}", self.scene.layers.join(" and ")), self.scene.lamps.clone()]
    }

    pub(super) fn paint(
        &self,
        map: &DepthMap<'_>,
        answer: Option<&ContactSolution<'_>>,
    ) -> RenderedLight {
        let scene = &self.scene;
        let beside = ([self.constants.beside_grey.value; 3], f64::NAN);
        let lower = answer.and_then(|answer| answer.lower_face(scene.innermost()));
        let aside = answer.map(|answer| answer.tangential_field(scene.innermost()));
        let places: Vec<(Point3<f64>, Vector3<f64>)> =
            map.point_in_sensor().zip(map.direction_in_sensor()).collect();
        let ray =
            |(scratch, found): &mut (Scratch, Vec<[f64; 2]>),
             ((place, direction), label): (&(Point3<f64>, Vector3<f64>), &u16)| {
                if *label == NO_LABEL {
                    return beside;
                }
                let (depth_mm, outward) = scene.touch.depth_mm(place);
                let foot = place + depth_mm * outward;
                let Some(thick_mm) = scene.thickness_mm((&foot, &outward), scratch, found) else {
                    return beside;
                };
                let lower_mm = lower.as_ref().map_or(0.0, |lower| lower.outwards_mm(&foot));
                let thickness_mm = (thick_mm - depth_mm - lower_mm).max(0.0);
                // The layers here were beside this place at rest: material keeps its order and its shares of the
                // thickness.
                let aside_mm = aside
                    .as_ref()
                    .map_or_else(Vector3::zeros, |aside| aside.displacement_mm(&foot, &outward));
                let (off_mm, outward) = scene.touch.depth_mm(&(foot - aside_mm));
                let rest = foot - aside_mm + off_mm * outward;
                match self.ray_light((&rest, &outward), direction, thickness_mm / thick_mm, scratch)
                {
                    Some(light) => (light, thickness_mm),
                    None => beside,
                }
            };
        let memory = || (Scratch::default(), Vec::new());
        let rays: Vec<(Rgb, f64)> =
            places.par_iter().zip(map.label()).map_init(memory, ray).collect();
        let (light, thickness_mm) = rays.into_iter().unzip();
        RenderedLight { light, thickness_mm, marks: Vec::new(), not_known: Vec::new() }
    }

    /// Computes the light of a ray that meets the surface at `rest`, with all layers at `share` of their thickness at
    /// rest. `None` where the ray meets no layers.
    fn ray_light(
        &self,
        (rest, outward): (&Point3<f64>, &Vector3<f64>),
        direction: &Vector3<f64>,
        share: f64,
        scratch: &mut Scratch,
    ) -> Option<Rgb> {
        let thick_mm = self.scene.thickness_mm((rest, outward), scratch, &mut Vec::new())?;
        let slants = [self.scene.lit.slant(rest), path_length_mm(1.0, outward, direction)];
        let before_mm = thick_mm * slants[1] + BEFORE_MM;
        let ray = Ray { origin: rest - before_mm * direction, direction: *direction };
        let per_mm = self.constants.uv_per_mm.value;
        let (mut sum, mut left) = ([0.0; 3], 1.0);
        for (from, to, layer) in self.scene.stretches(&ray, scratch) {
            // Whatever the ray meets behind `before_mm` is the opposite side of the sensor.
            let length_mm = share * (to.min(before_mm) - from.max(0.0));
            // Light of inner layers is attenuated by the layers before them.
            if length_mm > 0.0 {
                let (glows, passes) = fluorescence(per_mm, length_mm / slants[1], slants);
                sum = [0, 1, 2].map(|part| sum[part] + left * glows * self.colors[layer][part]);
                left *= passes;
            }
        }
        let lit = self.exposure * self.scene.lit.irradiance(rest);
        Some(sum.map(|part| lit * part))
    }
}
