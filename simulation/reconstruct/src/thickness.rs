//! Depth from what is missing of a layer's light.

use std::path::Path;

use fabkit_capture::{LayerScene, LightConstants, Thins, ray_mm};
use fabkit_files::Error;
use fabkit_geometry::Lighting;
use fabkit_scene::pressing::{Contact, Linear};
use fabkit_scene::{Cast, SensorView};

use super::drift::{LEAST_GREY, brighter};
use super::sharpen::Sharpener;
use super::{ReconstructError, Reconstructed};

/// Of a grey value of 255 in a picture.
const WHITE: f32 = 255.0;
/// Rays that meet the surface flatter than this see it as if they met it so, cosine.
const LEAST_COSINE: f64 = 0.2;
/// Fewer pixels that are bright enough, as a part of those that see the surface, are no picture of it.
const LEAST_LIT: f64 = 0.25;
/// So much darker than at rest, in the mean of a square around it, something presses, grey. Chosen: three times what the mean of a square
/// of R-Tac0's pictures differs by from one picture at rest to the next.
const CONTACT_GREY: f32 = 3.0;
/// No layer sends more back than this part of the light.
const MOST_BACK: f32 = 0.98;
/// Half a side of that square, px.
const AROUND: usize = 2;
/// What pixels at rest say, each list row by row: what is computed for all of them at once lies together.
#[derive(Clone, Debug, Default)]
struct Laws {
    /// Grey values at rest; 0 where nothing is said.
    at_rest: Vec<f32>,
    /// Light that is sent back at rest, as a part of what an endless layer sends.
    back: Vec<f32>,
    /// How much less of it for each grey value darker.
    per_grey: Vec<f32>,
    /// Depth if nothing were left of the layers, mm; not a number where no surface is seen.
    most_mm: Vec<f32>,
    /// One over the path at rest, in units of what the law makes of `back`.
    over_path: Vec<f32>,
}

/// Knows how bright layers are at rest.
#[derive(Clone, Debug)]
pub(super) struct Thickness {
    size_px: [usize; 2],
    laws: Laws,
    sharpener: Sharpener,
}

impl Thickness {
    /// From a sensor as its camera sees it, and brightness at rest, which came from `file`.
    ///
    /// # Errors
    /// Layers that cannot be pressed; a picture of something else.
    pub fn new(
        scene: &SensorView,
        lighting: &Lighting,
        constants: &LightConstants,
        (file, reference): (&Path, &[f32]),
    ) -> Result<Self, Error> {
        let sensor = &scene.project.design.sensor;
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let layers = LayerScene::of(sensor, lighting, constants)?;
        let thins = Thins::of(&layers, sensor)?;
        let (law, ground) =
            (constants.layer(), constants.ground_grey.value / constants.layer_grey.value);
        let cast = Cast::at_rest(Contact::Linear(Linear::default()));
        let (surface_px, sharpener, laws) = scene.cast(&cast, |seen| {
            let at_rest = layers.seen_at_rest(seen.map);
            let cosines = seen.map.incidence_rad().map(|rad| rad.cos().max(LEAST_COSINE));
            let sigma_px = constants.spread_mm.value / ray_mm(seen.map);
            let mut laws = Laws::default();
            for ((seen, cosine), value) in at_rest.iter().zip(cosines).zip(reference) {
                let grey = f64::from(WHITE * value);
                laws.push(seen.filter(|_| grey >= LEAST_GREY).map(|seen| {
                    let back = law.reflectance(seen.path_mm);
                    let most_mm = seen.thick_mm / thins.at(&seen.place) / cosine;
                    [grey, back, (back + ground) / grey, most_mm, (1.0 - back) / back]
                }));
            }
            let surface_px = at_rest.iter().flatten().count();
            Ok::<_, Error>((surface_px, Sharpener::new(size_px, sigma_px), laws))
        })?;
        let lit = laws.at_rest.iter().filter(|grey| **grey > 0.0).count();
        if (lit as f64) < LEAST_LIT * surface_px as f64 {
            return Err(ReconstructError::Dark { file: file.into(), least_grey: LEAST_GREY }.into());
        }
        Ok(Self { size_px, laws, sharpener })
    }

    /// What a picture of brightness from 0 to 1 shows, row by row; as many values as pixels.
    pub fn of_values(&self, values: &[f32]) -> Reconstructed {
        let brighter = brighter(&self.laws.at_rest, values);
        let (mut darker, contact) = self.darker(values, WHITE / brighter);
        self.sharpener.apply(&mut darker, &contact);
        self.laws.to_depth_mm(&mut darker);
        Reconstructed { depth_mm: darker, contact, brighter }
    }

    /// How much darker than at rest each pixel is, grey, and where the mean over a square around it is so much so that
    /// something presses: nowhere where no surface is seen, and at the border.
    fn darker(&self, values: &[f32], scale: f32) -> (Vec<f32>, Vec<bool>) {
        const SIDE: usize = 2 * AROUND + 1;
        const LEAST: f32 = CONTACT_GREY * (SIDE * SIDE) as f32;
        let [width, _] = self.size_px;
        let mut darker = Vec::with_capacity(values.len());
        let mut touched = vec![false; values.len()];
        // Sums along the rows of the square, in turn, and over all of them. Row after row, as long as it is at hand.
        let mut along: [Vec<f32>; SIDE] = std::array::from_fn(|_| vec![0.0; width]);
        let mut sums = vec![0.0f32; width];
        let rows = self.laws.at_rest.chunks_exact(width).zip(values.chunks_exact(width));
        for (row, (at_rest, values)) in rows.enumerate() {
            darker.extend(at_rest.iter().zip(values).map(|(rest, value)| rest - scale * value));
            let values = &darker[row * width..];
            let own = &mut along[row % SIDE][AROUND..width - AROUND];
            own.copy_from_slice(&values[..width - 2 * AROUND]);
            for k in 1..SIDE {
                for (sum, value) in own.iter_mut().zip(&values[k..]) {
                    *sum += value;
                }
            }
            let Some(middle) = row.checked_sub(AROUND).filter(|middle| *middle >= AROUND) else {
                continue;
            };
            sums.copy_from_slice(&along[(middle - AROUND) % SIDE]);
            for other in middle - AROUND + 1..=row {
                for (sum, value) in sums.iter_mut().zip(&along[other % SIDE]) {
                    *sum += value;
                }
            }
            let here = middle * width..(middle + 1) * width;
            let at_rest = &self.laws.at_rest[here.clone()];
            for ((touched, sum), rest) in touched[here].iter_mut().zip(&sums).zip(at_rest) {
                *touched = *rest > 0.0 && *sum > LEAST;
            }
        }
        (darker, touched)
    }
}

impl Laws {
    /// Of one more pixel: each list's value.
    fn push(&mut self, law: Option<[f64; 5]>) {
        let [at_rest, back, per_grey, most_mm, over_path] =
            law.unwrap_or([0.0, 0.0, 0.0, f64::NAN, 0.0]).map(|value| value as f32);
        self.at_rest.push(at_rest);
        self.back.push(back);
        self.per_grey.push(per_grey);
        self.most_mm.push(most_mm);
        self.over_path.push(over_path);
    }

    /// From how much darker each pixel is to its depth, mm.
    fn to_depth_mm(&self, darker: &mut [f32]) {
        let laws = self.back.iter().zip(&self.per_grey).zip(&self.most_mm).zip(&self.over_path);
        for (value, (((back, per_grey), most_mm), over_path)) in darker.iter_mut().zip(laws) {
            // No more than all of the layers can be missing, and brighter than endless ones none are.
            let back = (back - per_grey * *value).clamp(0.0, MOST_BACK);
            *value = most_mm * (1.0 - back / (1.0 - back) * over_path);
        }
    }
}
