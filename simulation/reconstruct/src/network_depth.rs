//! Reconstruction of depth by a trained network.
//!
//! The input is that of R-Tac0's authors: both images are blurred, the loss of intensity against rest is reduced by a
//! small offset, clipped and scaled to 1. It is 0 without contact, where depth is 0 too. A [`NetworkCard`] states the
//! parameters for a network; a network without a card is treated as the published one.

use std::path::{Path, PathBuf};

use fabkit_capture::plausibility::CheckedImage;
use fabkit_designs::design_hash;
use fabkit_files::Error;
use fabkit_files::memory::{self, MemoryHint};
use fabkit_files::reading::{self, ExpectedFile};
use fabkit_geometry::Point3;
use fabkit_network::Network;
use fabkit_scene::SensorView;
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};

use super::drift::{LEAST_GREY, estimate_relative_brightness};
use super::{DepthResult, ReconstructError};

/// Name and version of the card's file format.
const FORMAT: &str = "fabkit-network-card";
const VERSION: u64 = 1;
/// Intensity of a value of 1 in an image.
const WHITE: f32 = 255.0;
/// Largest width of the blur's window, px: wider ones do not serve against a camera's noise.
const MOST_BLUR_PX: usize = 31;
/// Radius around the tip's pixel beyond which R-Tac0's authors mask their images, px.
const PUBLISHED_MASK_PX: f32 = 207.0;

const NETWORK: ExpectedFile = ExpectedFile {
    what: "a network",
    max_bytes: 64 << 20,
    hint: "depth networks of tactile sensors are files of a few megabytes at most",
};
const CARD: ExpectedFile = ExpectedFile {
    what: "a network's card",
    max_bytes: 1 << 20,
    hint: "a card states in a few lines the input and output of a network",
};

/// Card of a network: its required input and the meaning of its output.
///
/// ```
/// use fabkit_reconstruct::{InputNormalisation, NetworkCard};
///
/// let text = r#"{
///     "sensor": "rtac0", "design_hash": null, "training": "4,000 simulated presses", "output_mm": 2.0,
///     "input": {"blur_px": 5, "blur_sigma_px": 5.0, "offset_grey": 3.0, "maximum_grey": 47.0},
///     "mask": {"center_px": null, "radius_px": 207.0}
/// }"#;
/// let card: NetworkCard = serde_json::from_str(text)?;
/// assert_eq!(card.input, InputNormalisation::PUBLISHED);
/// assert!(card.held_out.is_null());
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct NetworkCard {
    /// Name of the sensor whose images it was trained on.
    pub sensor: Option<String>,
    /// Hash of that sensor's design, as in manifests.
    pub design_hash: Option<String>,
    /// Normalisation of the input.
    pub input: InputNormalisation,
    /// Depth for a network output of 1, mm.
    pub output_mm: f32,
    /// Region in which images show the sensor; the whole image if missing.
    pub mask: Option<MaskCircle>,
    /// Description of the training set.
    pub training: Option<String>,
    /// Errors on data that was not trained on, in the writer's form.
    #[serde(default)]
    pub held_out: Value,
}

/// Conversion of an image and the one at rest to a network's input.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct InputNormalisation {
    /// Number of pixels along each side of the blur's window, odd; 1 for no blur.
    pub blur_px: usize,
    /// Standard deviation of the blur, px.
    pub blur_sigma_px: f32,
    /// Whether an image is first scaled until most of it is as bright as at rest.
    #[serde(default)]
    pub as_bright_as_rest: bool,
    /// Loss of intensity that counts as none.
    pub offset_grey: f32,
    /// Further loss of intensity at which the input reaches its maximum of 1.
    pub maximum_grey: f32,
}

/// A circle in the image.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct MaskCircle {
    /// Column and row of its centre, px; `None` for the pixel of the tip.
    pub center_px: Option<[f32; 2]>,
    /// Radius, px.
    pub radius_px: f32,
}

impl InputNormalisation {
    /// Normalisation of R-Tac0's published network.
    pub const PUBLISHED: Self = Self {
        blur_px: 5,
        blur_sigma_px: 5.0,
        as_bright_as_rest: false,
        offset_grey: 3.0,
        maximum_grey: 47.0,
    };
}

/// A network with its card.
///
/// ```
/// use std::path::Path;
///
/// use fabkit_reconstruct::DepthNetwork;
/// // A network's card lies beside it.
/// assert_eq!(DepthNetwork::card_path(Path::new("nets/depth.onnx")), Path::new("nets/depth.json"));
/// let missing = DepthNetwork::read(Path::new("no-such-network.onnx")).unwrap_err();
/// assert!(missing.to_string().contains("no-such-network.onnx"));
/// ```
#[derive(Clone, Debug)]
pub struct DepthNetwork {
    file: PathBuf,
    network: Network,
    /// Card of the network; `None` without a card file.
    card: Option<NetworkCard>,
}

impl DepthNetwork {
    /// Returns the path of a network's card: the same name with the extension `.json`.
    pub fn card_path(network: &Path) -> PathBuf {
        network.with_extension("json")
    }

    /// Reads an ONNX file, and its card if there is one.
    ///
    /// # Errors
    /// Returns an error for files that cannot be read, networks with unsupported layers, and a card of another format.
    pub fn read(file: &Path) -> Result<Self, Error> {
        let bytes = reading::read(file, NETWORK)?;
        let wrong = |error| {
            let (file, source) = (file.to_owned(), Box::new(error));
            ReconstructError::Network { file, source }
        };
        let network = Network::read(&bytes).map_err(wrong)?;
        let path = Self::card_path(file);
        // A network named `.json` cannot have a card of the same name.
        let card = if path.exists() && path != file { Some(read_card(&path)?) } else { None };
        Ok(Self { file: file.to_owned(), network, card })
    }

    /// Describes the network and its training in a sentence.
    pub fn words(&self) -> String {
        let file = self.file.display();
        let Some(card) = &self.card else {
            return format!(
                "{file} has no card and is used like R-Tac0's published network: input blurred by 5 x 5 px, intensities 3 to 50 below rest, within {PUBLISHED_MASK_PX:.0} px of the tip; output times 2 mm"
            );
        };
        let sensor = card.sensor.as_deref().unwrap_or("an unnamed sensor");
        let training = card.training.as_deref().unwrap_or("unnamed data");
        format!("{file} was trained for {sensor} on {training}")
    }

    /// Returns a warning if the network was trained for another design.
    pub fn warning(&self, scene: &SensorView) -> Option<String> {
        let hash = self.card.as_ref()?.design_hash.as_ref()?;
        let design = &scene.project.design;
        (*hash != design_hash(design)).then(|| {
            format!(
                "{} was trained for another design than this {}; its depth is only as good as the designs are alike",
                self.file.display(),
                design.sensor.name
            )
        })
    }

    /// Returns the network's data for documents.
    pub fn document(&self, scene: &SensorView) -> Value {
        let card = self.card.as_ref();
        json!({
            "file": self.file.display().to_string(),
            "parameters": self.network.parameters(),
            "products_a_pixel": self.network.multiplications_per_pixel(),
            "has_card": card.is_some(),
            "design_hash": card.and_then(|card| card.design_hash.as_ref()),
            "training": card.and_then(|card| card.training.as_ref()),
            "held_out": card.map(|card| &card.held_out),
            "warning": self.warning(scene),
        })
    }
}

fn read_card(path: &Path) -> Result<NetworkCard, Error> {
    let text = reading::read_text(path, CARD)?;
    let wrong = |what: String| ReconstructError::Card { file: path.to_owned(), what };
    let value: Value =
        serde_json::from_str(&text).map_err(|error| wrong(format!("is no JSON: {error}")))?;
    if value["format"] != FORMAT || value["version"] != VERSION {
        return Err(wrong(format!("is not of the format {FORMAT} {VERSION}")).into());
    }
    let card: NetworkCard =
        serde_json::from_value(value).map_err(|error| wrong(format!("has {error}")))?;
    // Unusable values are refused here, so that errors name the card's file.
    let InputNormalisation { blur_px, blur_sigma_px, offset_grey, maximum_grey, .. } = card.input;
    if blur_px % 2 == 0 || blur_px > MOST_BLUR_PX {
        return Err(wrong(format!(
            "has blur_px {blur_px}, which is no odd number up to {MOST_BLUR_PX}"
        ))
        .into());
    }
    let radius_px = card.mask.map_or(1.0, |mask| mask.radius_px);
    for (name, number) in [
        ("blur_sigma_px", blur_sigma_px),
        ("maximum_grey", maximum_grey),
        ("output_mm", card.output_mm),
        ("radius_px", radius_px),
    ] {
        if !(number > 0.0 && number.is_finite()) {
            return Err(wrong(format!("has no {name} above zero")).into());
        }
    }
    if !(offset_grey >= 0.0 && offset_grey.is_finite()) {
        return Err(wrong("has an offset_grey below zero".to_owned()).into());
    }
    Ok(card)
}

/// A network with the image at rest of one sensor.
#[derive(Clone, Debug)]
pub(super) struct NetworkReconstructor {
    file: PathBuf,
    network: Network,
    input: InputNormalisation,
    output_mm: f32,
    columns: usize,
    /// Weights of the blur along one side of its window.
    blur: Vec<f32>,
    /// Blurred intensities at rest; minus infinity outside the mask.
    at_rest: Vec<f32>,
    /// Intensities at rest without blur, 0 where too dark for a comparison; `None` if images are not scaled to rest.
    compared: Option<Vec<f32>>,
}

impl NetworkReconstructor {
    /// Prepares a network with the luminance at rest, 0 to 1.
    ///
    /// # Errors
    /// Returns an error for a network that needs more memory than allowed.
    pub fn new(
        known: &DepthNetwork,
        scene: &SensorView,
        reference: &CheckedImage,
    ) -> Result<Self, Error> {
        let DepthNetwork { network, card, file } = known;
        let reference = reference.grey();
        let threads = rayon::current_num_threads() as u64;
        // Each thread has buffers of its own.
        memory::check_memory(
            "this network",
            threads * network.bytes_a_thread(),
            MemoryHint::Network,
        )?;
        let columns = scene.viewpoint.camera().width_px() as usize;
        let input = card.as_ref().map_or(InputNormalisation::PUBLISHED, |card| card.input);
        let published = Some(MaskCircle { center_px: None, radius_px: PUBLISHED_MASK_PX });
        // A card without a mask means the whole image; only without a card the published mask applies.
        let mask = card.as_ref().map_or(published, |card| card.mask);
        let weights = gaussian_weights(input.blur_px, input.blur_sigma_px);
        let mut at_rest = blur(&reference, columns, &weights);
        if let Some((middle, radius_px)) =
            mask.and_then(|mask| Some((mask.middle(scene)?, mask.radius_px)))
        {
            for (i, grey) in at_rest.iter_mut().enumerate() {
                let [x, y] = [i % columns, i / columns].map(|px| px as f32);
                // Nothing is darker than minus infinity, so the input is 0 outside the mask.
                if (x - middle[0]).hypot(y - middle[1]) > radius_px {
                    *grey = f32::NEG_INFINITY;
                }
            }
        }
        let compared = input.as_bright_as_rest.then(|| {
            let told = |(value, at_rest): (&f32, &f32)| {
                let grey = WHITE * value;
                if f64::from(grey) < LEAST_GREY || at_rest.is_infinite() { 0.0 } else { grey }
            };
            reference.iter().zip(&at_rest).map(told).collect()
        });
        let output_mm = card.as_ref().map_or(2.0, |card| card.output_mm);
        Ok(Self {
            file: file.clone(),
            network: network.clone(),
            input,
            output_mm,
            columns,
            blur: weights,
            at_rest,
            compared,
        })
    }

    /// Reconstructs depth from the luminance of an image.
    ///
    /// # Errors
    /// Returns an error for output that is not finite.
    pub fn reconstruct(&self, image: &CheckedImage) -> Result<DepthResult, Error> {
        let (picture, image) = (image.file(), &image.grey());
        let InputNormalisation { offset_grey, maximum_grey, .. } = self.input;
        let compared = self.compared.as_ref();
        let brighter =
            compared.map_or(1.0, |compared| estimate_relative_brightness(compared, image));
        // The image is divided by its relative brightness.
        let scale = brighter.recip();
        let mut input = blur(image, self.columns, &self.blur);
        for (grey, at_rest) in input.iter_mut().zip(&self.at_rest) {
            *grey =
                (at_rest - scale * *grey - offset_grey).max(0.0).min(maximum_grey) / maximum_grey;
        }
        // The network is only run there.
        let contact = input.iter().map(|input| *input > 0.0).collect();
        let mut depth_mm = self.network.run_nonzero(&input, self.columns).map_err(Error::bug)?;
        depth_mm.iter_mut().for_each(|depth| *depth *= self.output_mm);
        self.check_finite(picture, &depth_mm)?;
        let size_px = [self.columns, depth_mm.len() / self.columns];
        Ok(DepthResult { size_px, depth_mm, contact, relative_brightness: brighter })
    }
}

impl NetworkReconstructor {
    /// Checks that the depth of an image, which was read from `picture`, consists of numbers.
    fn check_finite(&self, picture: &Path, depth_mm: &[f32]) -> Result<(), ReconstructError> {
        let mut wrong = depth_mm.iter().enumerate().filter(|(_, mm)| !mm.is_finite());
        let Some((first, value)) = wrong.next() else { return Ok(()) };
        Err(ReconstructError::NetworkNotFinite {
            file: self.file.clone(),
            picture: picture.to_owned(),
            count: 1 + wrong.count(),
            of: depth_mm.len(),
            at_px: [first % self.columns, first / self.columns],
            value: *value,
        })
    }
}

impl MaskCircle {
    /// Returns its centre; `None` if the camera model has no pixel for the tip.
    fn middle(&self, scene: &SensorView) -> Option<[f32; 2]> {
        if self.center_px.is_some() {
            return self.center_px;
        }
        let touch = scene.project.design.sensor.touch.as_ref()?;
        let viewpoint = &scene.viewpoint;
        let tip = Point3::new(0.0, 0.0, touch.apex_z_mm());
        let tip = viewpoint.sensor_from_camera.inverse().point(tip);
        let pixel = viewpoint.camera().project(&tip).ok()?;
        Some([pixel.x as f32, pixel.y as f32])
    }
}

/// Returns Gaussian weights of `sigma_px` over `count` pixels with a sum of 1.
fn gaussian_weights(count: usize, sigma_px: f32) -> Vec<f32> {
    let bell = |i: usize| {
        let away = (i as f32 - (count / 2) as f32) / sigma_px;
        (-away * away / 2.0).exp()
    };
    let sum: f32 = (0..count).map(bell).sum();
    (0..count).map(|i| bell(i) / sum).collect()
}

/// Returns the intensities of a blurred image. Beyond the border the image is mirrored without repeating the border's
/// pixels, as in OpenCV.
fn blur(image: &[f32], columns: usize, weights: &[f32]) -> Vec<f32> {
    let (half, rows) = (weights.len() / 2, image.len() / columns);
    // Index of the pixel that stands for `at`. Images smaller than the window are clamped.
    let back = |at: isize, count: usize| {
        let last = count as isize - 1;
        let at = at.abs().min(2 * last);
        (if at > last { 2 * last - at } else { at }).max(0) as usize
    };
    let mut found = vec![0.0; image.len()];
    found.par_chunks_exact_mut(columns).enumerate().for_each(|(row, found)| {
        // Down the columns first, then along the row, which has `half` more pixels on each side.
        let mut down = vec![0.0; columns + 2 * half];
        for (i, weight) in weights.iter().enumerate() {
            let from = back(row as isize + i as isize - half as isize, rows) * columns;
            let from = &image[from..from + columns];
            let weight = WHITE * weight;
            down[half..].iter_mut().zip(from).for_each(|(down, value)| *down += weight * value);
        }
        for i in 0..half {
            let [left, right] = [i as isize - half as isize, (columns + i) as isize];
            down[i] = down[half + back(left, columns)];
            down[half + columns + i] = down[half + back(right, columns)];
        }
        for (i, weight) in weights.iter().enumerate() {
            found.iter_mut().zip(&down[i..]).for_each(|(found, down)| *found += weight * down);
        }
    });
    found
}

#[cfg(test)]
mod tests {
    use super::{blur, gaussian_weights};

    #[test]
    fn a_blur_keeps_what_is_even_and_spreads_what_is_not() {
        let bell = gaussian_weights(5, 5.0);
        assert!((bell.iter().sum::<f32>() - 1.0).abs() < 1e-6 && bell[0] < bell[2]);
        let even = blur(&[0.5; 8 * 6], 8, &bell);
        assert!(even.iter().all(|grey| (grey - 127.5).abs() < 1e-3), "{even:?}");
        let mut one = vec![0.0; 9 * 9];
        one[4 * 9 + 4] = 1.0;
        let spread = blur(&one, 9, &bell);
        for (row, column) in [(4, 4), (2, 4), (2, 6), (4, 7)] {
            let wanted = if column < 7 { 255.0 * bell[row - 2] * bell[column - 2] } else { 0.0 };
            assert!((spread[row * 9 + column] - wanted).abs() < 1e-4);
        }
        // A pixel in the corner is seen from beyond the border by its neighbours, not by itself again.
        let mut corner = vec![0.0; 4 * 4];
        corner[0] = 1.0;
        let found = blur(&corner, 4, &gaussian_weights(3, 1.0));
        let [side, middle, _] = gaussian_weights(3, 1.0)[..] else { unreachable!() };
        assert!((found[0] - 255.0 * middle * middle).abs() < 1e-4);
        assert!((found[1] - 255.0 * side * middle).abs() < 1e-4);
        // Smaller than the window.
        assert!((blur(&[0.2], 1, &bell)[0] - 51.0).abs() < 1e-4);
    }
}
