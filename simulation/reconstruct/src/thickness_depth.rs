//! Reconstruction of depth from the loss of a layer's light.

use fabkit_capture::plausibility::CheckedImage;
use fabkit_capture::{LayerScene, LightConstants, ThicknessChange, ray_spacing_mm};
use fabkit_files::Error;
use fabkit_geometry::Lighting;
use fabkit_scene::press_simulation::{ContactModel, LinearOptions};
use fabkit_scene::{Cast, SensorView};

use super::drift::{LEAST_GREY, estimate_relative_brightness};
use super::sharpen::Sharpener;
use super::{DepthResult, ReconstructError};

/// Intensity of a value of 1 in an image.
const WHITE: f32 = 255.0;
/// Smallest cosine between ray and normal. Flatter rays are treated as if they had it.
const LEAST_COSINE: f64 = 0.2;
/// Minimum share of lit pixels among those that see the surface, for an image at rest.
const LEAST_LIT: f64 = 0.25;
/// Loss of intensity, in the mean of a square, above which its middle is in contact. Chosen: three times the difference
/// of such means between images at rest of R-Tac0.
const CONTACT_LOSS: f32 = 3.0;
/// Largest reflectance of a layer, relative to an infinitely thick one.
const MOST_BACK: f32 = 0.98;
/// Half the side of that square, px.
const HALF_SIDE: usize = 2;
/// Calibration of each pixel at rest. Separate lists allow vectorised loops over all pixels.
#[derive(Clone, Debug, Default)]
struct PixelCalibration {
    /// Intensities at rest; 0 for unusable pixels.
    at_rest: Vec<f32>,
    /// Reflectance of the layer at rest, relative to an infinitely thick one.
    back: Vec<f32>,
    /// Loss of reflectance per loss of intensity.
    per_grey: Vec<f32>,
    /// Depth at which nothing would be left of the layers, mm; NaN where no surface is seen.
    most_mm: Vec<f32>,
    /// Inverse of the path at rest, in units of `back / (1 - back)`.
    over_path: Vec<f32>,
}

/// Model of a sensor that shows thickness, calibrated with the image at rest.
#[derive(Clone, Debug)]
pub(super) struct ThicknessModel {
    size_px: [usize; 2],
    laws: PixelCalibration,
    sharpener: Sharpener,
}

/// Memory per ray of the model, bytes: what rays meet at rest, five numbers of the law, ray spacing, and intensities of images
/// at rest and pressed. Derived by counting.
const LAYER_BYTES: u64 = 48 + 20 + 32 + 4 * 3 * 4;

impl ThicknessModel {
    /// Creates the model from the view of a sensor and its luminance at rest.
    ///
    /// # Errors
    /// Returns an error for layers that cannot be pressed, and for an image that shows something else.
    pub fn new(
        scene: &SensorView,
        lighting: &Lighting,
        constants: &LightConstants,
        reference: &CheckedImage,
    ) -> Result<Self, Error> {
        let sensor = &scene.project.design.sensor;
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let (file, reference) = (reference.file(), reference.grey());
        let layers = LayerScene::new(sensor, lighting, constants)?;
        let thins = ThicknessChange::compute(&layers, sensor)?;
        let (law, ground) =
            (constants.layer(), constants.ground_grey.value / constants.layer_grey.value);
        let cast = Cast::at_rest(ContactModel::Linear(LinearOptions::default()));
        let (surface_px, sharpener, laws) = scene.cast(&cast, LAYER_BYTES, |seen| {
            let at_rest = layers.seen_at_rest(seen.map);
            let cosines = seen.map.incidence_rad().map(|rad| rad.cos().max(LEAST_COSINE));
            let sigma_px = constants.spread_mm.value / ray_spacing_mm(seen.map);
            let mut laws = PixelCalibration::default();
            for ((seen, cosine), value) in at_rest.iter().zip(cosines).zip(&reference) {
                let grey = f64::from(WHITE * value);
                // Too dark pixels and those without a layer get the neutral entry.
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
            return Err(
                ReconstructError::TooDark { file: file.into(), least_grey: LEAST_GREY }.into()
            );
        }
        Ok(Self { size_px, laws, sharpener })
    }

    /// Reconstructs depth from the luminance of an image.
    pub fn reconstruct(&self, image: &CheckedImage) -> DepthResult {
        let values = image.grey();
        let brighter = estimate_relative_brightness(&self.laws.at_rest, &values);
        let (mut darker, contact) = self.intensity_loss(&values, WHITE / brighter);
        self.sharpener.apply(&mut darker, &contact);
        self.laws.to_depth_mm(&mut darker);
        DepthResult {
            size_px: self.size_px,
            depth_mm: darker,
            contact,
            relative_brightness: brighter,
        }
    }

    /// Returns the loss of intensity of each pixel, and whether its mean over a square around the pixel shows contact.
    /// There is no contact where no surface is seen and at the border.
    fn intensity_loss(&self, values: &[f32], scale: f32) -> (Vec<f32>, Vec<bool>) {
        const SIDE: usize = 2 * HALF_SIDE + 1;
        const LEAST: f32 = CONTACT_LOSS * (SIDE * SIDE) as f32;
        let [width, _] = self.size_px;
        let mut darker = Vec::with_capacity(values.len());
        let mut touched = vec![false; values.len()];
        // Row sums of the square in a ring buffer, and their total. Each row is finished while it is still in the
        // cache.
        let mut along: [Vec<f32>; SIDE] = std::array::from_fn(|_| vec![0.0; width]);
        let mut sums = vec![0.0f32; width];
        let rows = self.laws.at_rest.chunks_exact(width).zip(values.chunks_exact(width));
        for (row, (at_rest, values)) in rows.enumerate() {
            darker.extend(at_rest.iter().zip(values).map(|(rest, value)| rest - scale * value));
            let values = &darker[row * width..];
            let own = &mut along[row % SIDE][HALF_SIDE..width - HALF_SIDE];
            own.copy_from_slice(&values[..width - 2 * HALF_SIDE]);
            for k in 1..SIDE {
                for (sum, value) in own.iter_mut().zip(&values[k..]) {
                    *sum += value;
                }
            }
            // The square around `middle` is complete once its last row has been summed.
            let Some(middle) = row.checked_sub(HALF_SIDE).filter(|middle| *middle >= HALF_SIDE)
            else {
                continue;
            };
            sums.copy_from_slice(&along[(middle - HALF_SIDE) % SIDE]);
            for other in middle - HALF_SIDE + 1..=row {
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

impl PixelCalibration {
    /// Appends the values of one pixel.
    fn push(&mut self, law: Option<[f64; 5]>) {
        let [at_rest, back, per_grey, most_mm, over_path] =
            law.unwrap_or([0.0, 0.0, 0.0, f64::NAN, 0.0]).map(|value| value as f32);
        self.at_rest.push(at_rest);
        self.back.push(back);
        self.per_grey.push(per_grey);
        self.most_mm.push(most_mm);
        self.over_path.push(over_path);
    }

    /// Converts the loss of intensity of each pixel in place to its depth, mm.
    fn to_depth_mm(&self, darker: &mut [f32]) {
        let laws = self.back.iter().zip(&self.per_grey).zip(&self.most_mm).zip(&self.over_path);
        for (value, (((back, per_grey), most_mm), over_path)) in darker.iter_mut().zip(laws) {
            // At most all of the layers is missing, and at most an infinitely thick layer is there.
            let back = (back - per_grey * *value).clamp(0.0, MOST_BACK);
            *value = most_mm * (1.0 - back / (1.0 - back) * over_path);
        }
    }
}
