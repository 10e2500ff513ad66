//! Detection of pin marks from an image without contact and one with it.
//!
//! A contact darkens the sensing surface. The logarithm of the ratio of the two images does not depend on how bright a
//! place is. Its slow part (drift of the illumination, overall strain of the gel) is removed as the local median. The
//! rest is noise of a known size, pin marks, and the thin rims of edges that moved a little. Bubbles and scratches are
//! in both images and cancel. Reflections saturate or brighten and are left out.

mod difference;
mod mark_regions;

use nalgebra::Point2;

pub use difference::{DetectionError, background_cell_px};

use crate::image::GreyImage;
use crate::significance::{Detected, Detections, Significance};
use difference::ImageDifference;

/// Sign of the change of intensity at a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Polarity {
    /// Contacts are darker, as where a translucent layer gets thinner over a black skin.
    #[default]
    Darker,
    /// Contacts are brighter.
    Brighter,
}

/// Criteria for pin marks. Lengths are fractions of the image's shorter side, so that the same values serve every
/// camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionOptions {
    /// Sign of the change of intensity at a contact.
    pub polarity: Polarity,
    /// Smallest diameter of a mark at half its contrast.
    pub min_diameter: f64,
    /// Largest diameter of a mark at half its contrast.
    pub max_diameter: f64,
    /// Smallest contrast of any mark: natural logarithm of the ratio of intensities.
    pub min_contrast: f64,
    /// Contrast from which a mark is one, however much stronger others are. Below, it must have a third of the strongest
    /// change.
    pub certain_contrast: f64,
    /// Shorter side, px, of the whole image if the two images are parts of it; `None` if they are whole.
    pub part_of_px: Option<u32>,
}

impl Default for DetectionOptions {
    fn default() -> Self {
        Self {
            polarity: Polarity::Darker,
            min_diameter: 0.012,
            max_diameter: 0.12,
            // Images of one untouched unit differ by up to 0.011 (9DTact as published): a third of this.
            min_contrast: 0.03,
            certain_contrast: 0.12,
            part_of_px: None,
        }
    }
}

/// Mark of a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinMark {
    /// Centre of the mark, px; pixel centres lie at integers.
    pub pixel: Point2<f64>,
    /// Standard deviation of each coordinate of the centre, px, from the image's noise and from hidden parts of a cut
    /// mark. The play of the pin is not included.
    pub sigma_px: f64,
    /// Natural logarithm of the ratio of intensities at the strongest point.
    pub contrast: f64,
    /// Contrast in standard deviations of the noise.
    pub significance: Significance,
    /// Diameter of a disc with the area of the mark at half its contrast, px.
    pub diameter_px: f64,
    /// Fraction of the outline that borders on dark or saturated pixels or the image's border: the rest of the mark may
    /// be hidden there.
    pub hidden_outline: f64,
}

impl Detected for PinMark {
    fn contrast(&self) -> f64 {
        // As a fraction of the intensity, which people expect.
        1.0 - (-self.contrast).exp()
    }

    fn significance(&self) -> Significance {
        self.significance
    }
}

/// Reason why a change is not a pin's mark.
///
/// ```
/// use fabkit_calibration::image::GreyImage;
/// use fabkit_calibration::pin_detection::{DetectionOptions, RejectionReason, detect};
/// // A dark spot in the middle of 240 x 180 px that fades over these distances.
/// let image = |depth: f64, [reach_x_px, reach_y_px]: [f64; 2]| {
///     let value = |i: usize| {
///         let (x, y) = ((i % 240) as f64, (i / 240) as f64);
///         let texture = 0.002 * ((7 * i) % 13) as f64 / 13.0;
///         let far = ((x - 120.0) / reach_x_px).powi(2) + ((y - 90.0) / reach_y_px).powi(2);
///         ((0.6 + texture) * (1.0 - depth * (-far).exp())) as f32
///     };
///     GreyImage::new(240, 180, (0..240 * 180).map(value).collect()).unwrap()
/// };
/// let options = DetectionOptions::default();
/// let find = |reach_px| detect(&image(0.0, [1.0; 2]), &image(0.4, reach_px), &options).unwrap();
/// let round = find([5.0, 5.0]);
/// assert_eq!((round.marks.kept().len(), round.rejected.len()), (1, 0));
/// // The rim of an edge that moved is no pin.
/// let rim = find([30.0, 3.0]);
/// assert_eq!((rim.marks.kept().len(), rim.rejected[0].1), (0, RejectionReason::Elongated));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RejectionReason {
    /// Smaller than a pin's mark.
    TooSmall,
    /// Larger than a pin's mark.
    TooLarge,
    /// Long and thin, like the rim of an edge that moved.
    Elongated,
    /// Mostly hidden, so that its centre is unknown.
    Hidden,
}

/// Result of the detection in a pair of images.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// Pin marks, the strongest first, and the fainter spots that were left out.
    pub marks: Detections<PinMark>,
    /// Changes of sufficient contrast that are not pins, with their strongest pixel.
    pub rejected: Vec<(Point2<f64>, RejectionReason)>,
    /// Standard deviation of the smoothed logarithm of the ratio where nothing touches.
    pub noise: f64,
    /// Fraction of lit pixels that are saturated in either image, 0 to 1: marks are cut there.
    pub saturated_fraction: f64,
}

/// Finds the marks of pins in `pressed`, compared with `reference`, the image without contact.
///
/// # Errors
/// Returns a [`DetectionError`] for images of different size, identical, saturated or dark images.
///
/// ```
/// use fabkit_calibration::image::GreyImage;
/// use fabkit_calibration::pin_detection::{DetectionOptions, detect};
/// // A bright surface, and the same under another exposure with one mark at (100.25, 60).
/// let image = |gain: f64, depth: f64| {
///     let value = |i: usize| {
///         let (x, y) = ((i % 200) as f64, (i / 200) as f64);
///         let texture = 0.002 * ((7 * i) % 13) as f64 / 13.0 * gain;
///         let r2 = (x - 100.25).powi(2) + (y - 60.0).powi(2);
///         (gain * (0.6 + texture) * (1.0 - depth * (-r2 / 18.0).exp())) as f32
///     };
///     GreyImage::new(200, 150, (0..200 * 150).map(value).collect()).unwrap()
/// };
/// let found = detect(&image(1.0, 0.0), &image(0.9, 0.4), &DetectionOptions::default()).unwrap();
/// assert_eq!(found.marks.kept().len(), 1);
/// assert!((found.marks.kept()[0].pixel.x - 100.25).abs() < 0.02);
/// ```
pub fn detect(
    reference: &GreyImage,
    pressed: &GreyImage,
    options: &DetectionOptions,
) -> Result<Detection, DetectionError> {
    let difference = ImageDifference::new(reference, pressed, options)?;
    Ok(mark_regions::find(&difference, options))
}
