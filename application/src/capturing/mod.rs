//! The picture that a sensor's camera would take, simulated, with the truth that it shows.
//!
//! Sensors that show touch by the thickness of a translucent layer over black, lit from within. Thickness and paths are
//! those of the drawn bodies; what a press does to them is what [`crate::pressing`] says.

mod constants;
mod document;
mod lit;
mod scene;

use fabkit_depth::truth::{DepthMap, NO_LABEL};
use fabkit_geometry::{Point3, Scratch, Vector3};
use fabkit_light::{Chip, NoLight, drift, spread};
use rayon::prelude::*;

pub use constants::{Constant, Known, LightConstants};
pub use document::{comment, document};
pub use scene::Scene;

use self::scene::along;
use crate::Error;
use crate::error::{ErrorKind, Explained};
use crate::pressing::Answer;
use crate::scene::{Cast, Seen, SensorView};

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// It shows touch in another way.
    #[error("`{sensor}` does not show touch by a translucent layer over black: {shows}")]
    OtherLight {
        /// The sensor.
        sensor: String,
        /// How it is drawn.
        shows: String,
    },
    /// Nobody knows how it is lit.
    #[error(transparent)]
    NoLight(#[from] NoLight),
    /// Lamps that do not reach the surface.
    #[error("no light of `{sensor}`'s lamps reaches its surface: opaque bodies are in the way")]
    Dark {
        /// The sensor.
        sensor: String,
    },
}

impl Explained for CaptureError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::OtherLight { .. } => {
                "take a sensor like rtac0 or 9dtact; `depth` and `press` know the truth of the others"
            }
            Self::NoLight(NoLight::NoLamps { .. }) => "draw its lamps",
            Self::Dark { .. } => "`fabkit check` says what is in the way",
            Self::NoLight(_) => return None,
        };
        Some(hint.to_owned())
    }
}

/// What to take a picture of.
#[derive(Clone, Debug)]
pub struct Capturing<'a> {
    /// What presses, and how the layers answer; a sample is a ray, a pixel the mean of its own.
    pub cast: Cast<'a>,
    /// What the light rests on.
    pub constants: LightConstants,
    /// For the noise; nothing for none, and no drift.
    pub seed: Option<u64>,
}

/// A picture, with what it was made from.
#[derive(Clone, Debug)]
pub struct Captured {
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// Row by row, 0 to 255, not rounded.
    pub grey: Vec<f64>,
    /// How thick the layer is that each ray meets, mm; NaN where it meets none. Row by row, `samples` times as many.
    pub thickness_mm: Vec<f64>,
    /// By what all light was multiplied.
    pub exposure: f64,
    /// How much brighter than others this picture is, grey.
    pub drift_grey: f64,
    /// The layer's name.
    pub layer: String,
    /// What shines, in words.
    pub lamps: String,
    /// What the soft layers answered, as JSON.
    pub elastic: Option<serde_json::Value>,
    /// How the surface answered.
    pub contact_level: &'static str,
}

impl Captured {
    /// Least and largest grey value where the surface is seen.
    pub fn range_grey(&self) -> [f64; 2] {
        let ends = |[low, high]: [f64; 2], grey: &f64| [low.min(*grey), high.max(*grey)];
        self.grey.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends)
    }
}

impl Capturing<'_> {
    /// Takes the picture; `also` sees the truth that it shows.
    ///
    /// # Errors
    /// A sensor whose light is not known here, and what [`SensorView::cast`] says.
    pub fn take(
        &self,
        scene: &SensorView,
        also: impl FnOnce(&Seen<'_>) -> Result<(), Error>,
    ) -> Result<Captured, Error> {
        let light = Scene::of(&scene.project.design.sensor, &self.constants)?;
        let exposure = light.middle().map_or(1.0, |[lit, mm]| self.constants.exposure(lit, mm));
        let drift_grey = self.seed.map_or(0.0, |seed| drift(self.constants.drift.value, seed));
        scene.cast(&self.cast, |seen| {
            also(&seen)?;
            let rays = self.rays(&light, exposure, seen.map, seen.answer);
            let (mut grey, thickness_mm): (Vec<f64>, Vec<f64>) = rays.into_iter().unzip();
            let is_layer: Vec<bool> = thickness_mm.iter().map(|mm| mm.is_finite()).collect();
            let width = seen.map.width_px() as usize;
            let sigma_px = self.constants.spread_mm.value / ray_mm(seen.map);
            spread(&mut grey, &is_layer, width, sigma_px);
            let size_px = [seen.map.width_px(), seen.map.height_px()];
            let size_px = size_px.map(|side| side / self.cast.samples);
            Ok::<_, Error>(Captured {
                grey: self.recorded(&grey, size_px, drift_grey),
                size_px,
                thickness_mm,
                exposure,
                drift_grey,
                layer: light.layer.clone(),
                lamps: light.lamps.clone(),
                elastic: seen.answer.map(crate::pressing::answer),
                contact_level: self.cast.contact.name(),
            })
        })
    }

    /// Grey value and thickness that each ray meets.
    fn rays(
        &self,
        scene: &Scene<'_>,
        exposure: f64,
        map: &DepthMap<'_>,
        answer: Option<&Answer<'_>>,
    ) -> Vec<(f64, f64)> {
        let constants = &self.constants;
        let (law, beside) = (constants.layer(), (constants.beside_grey.value, f64::NAN));
        let lower = answer.and_then(|answer| answer.lower_face(&scene.layer));
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
                (exposure * scene.lit.at(&rest) * sent, thickness_mm)
            };
        let memory = || (Scratch::default(), Vec::new());
        places.par_iter().zip(map.label()).map_init(memory, ray).collect()
    }

    /// What the chip makes of it: means over the samples of each pixel, with drift and noise.
    fn recorded(&self, rays: &[f64], [width, height]: [u32; 2], drift_grey: f64) -> Vec<f64> {
        let samples = self.cast.samples as usize;
        let (chip, seed) = match self.seed {
            Some(seed) => (self.constants.chip(), seed),
            None => (Chip::IDEAL, 0),
        };
        let (width, height) = (width as usize, height as usize);
        let pixel = |pixel: usize| {
            let first = pixel / width * samples * width * samples + pixel % width * samples;
            let rows = (0..samples).map(|row| first + row * width * samples);
            let all = rows.flat_map(|begin| &rays[begin..begin + samples]);
            let mean = all.sum::<f64>() / (samples * samples) as f64;
            chip.records(mean + drift_grey, seed, pixel as u64)
        };
        (0..width * height).map(pixel).collect()
    }
}

/// How far neighbouring rays meet the surface from each other, mm: the median along rows.
fn ray_mm(map: &DepthMap<'_>) -> f64 {
    let places: Vec<Point3<f64>> = map.point_in_sensor().collect();
    let width = map.width_px() as usize;
    let both = |pair: &[usize; 2]| pair.iter().all(|i| map.label()[*i] != NO_LABEL);
    let beside = (1..places.len()).filter(|i| i % width != 0).map(|i| [i - 1, i]).filter(both);
    let mut apart: Vec<f64> = beside.map(|[a, b]| (places[b] - places[a]).norm()).collect();
    apart.sort_by(f64::total_cmp);
    apart.get(apart.len() / 2).copied().unwrap_or(f64::INFINITY)
}
