//! The gate that images pass before anything is computed from them.

use std::path::{Path, PathBuf};

use fabkit_files::Error;

use super::cells::{BestFit, Cells};
use super::expected::{DrawnLight, ExpectedLight};
use super::{ImageFault, ImplausibleImage, Judged, Judgement};
use crate::{CapturedImage, check_size};

/// Smallest largest value of an image, as a share of the range. 12 bits in 16 stay below it; the darkest real image that
/// was measured reaches 174 of 255.
const LEAST_RANGE: f64 = 1.0 / 16.0;
/// Smallest brightness of the surface relative to the drawn light. Real units of R-Tac0 and 9DTact have 0.96 and 0.98,
/// simulated units 0.9 to 1.1; a quarter is two stops of exposure.
const LEAST_LEVEL: f64 = 0.25;
/// Largest mean saturation of an image of a sensor with white light. Measured: 0.02 (a real 9DTact), and 0.35 to 0.77
/// in images of sensors with coloured lamps, real ones too.
const MOST_SATURATION: f64 = 0.25;
/// Smallest similarity with the drawn coloured light: in the middle between simulated units off their drawings (0.94 at
/// least: eight units of each pad, three of ShadowTac, with noise) and images of other sensors (0.71 at most).
const LEAST_SIMILARITY: f64 = 0.82;
/// Gain of similarity by exchanging colours or turning from which an image is taken to be exchanged or turned. Units
/// differ by 0.003 there, exchanged colours by 0.2 and more.
const REARRANGED_GAIN: f64 = 0.1;
/// Similarity from which a rearranged image counts as found again. Images with low contrast and a large contact (a real
/// 9DTact under a ball: 0.48) resemble nothing, and must not be refused for that.
const FOUND_AGAIN: f64 = 0.82;
/// Limits of the median brightness relative to the image at rest. Reconstruction undoes a drift of a tenth. Real
/// captures of three sensors have 0.99 to 1.04; a large contact in translucent layers darkens more than half of them.
const EXPOSURE_RATIO: [f64; 2] = [0.8, 1.1];
/// Smallest value of a cell whose ratio counts: an intensity of 8.
const LEAST_LIT: f64 = 8.0 / 255.0;

/// An image that passed an [`ImageGate`].
///
/// ```
/// use std::path::Path;
///
/// use fabkit_capture::CapturedImage;
/// use fabkit_capture::plausibility::{ExpectedLight, ImageGate};
/// let image = CapturedImage { size_px: [2, 1], channels: 1, values: vec![0.5, 0.6] };
/// let expected = ExpectedLight::unknown([2, 1], "no light is drawn");
/// let gate = ImageGate::new(expected, Path::new("rest.png"), image.clone())?.accept()?;
/// assert_eq!((gate.reference().image(), gate.reference().file()), (&image, Path::new("rest.png")));
/// # Ok::<(), fabkit_files::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedImage {
    file: PathBuf,
    image: CapturedImage,
}

impl CheckedImage {
    /// Returns the path of the image.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Returns the image.
    pub fn image(&self) -> &CapturedImage {
        &self.image
    }

    /// Returns the luminance of each pixel.
    pub fn grey(&self) -> Vec<f32> {
        self.image.clone().grey()
    }
}

/// Gate for the images of one camera: with the drawn light of its sensor and the image at rest.
#[derive(Clone, Debug)]
pub struct ImageGate {
    pub(super) expected: ExpectedLight,
    reference: CheckedImage,
    cells: Cells,
}

impl ImageGate {
    /// Creates a gate from the image at rest, which was read from `file`, and compares it with the drawn light: number
    /// range, level, order of colours, turn.
    ///
    /// # Errors
    /// Returns an error for an image of another size, or with values that are no finite numbers.
    pub fn new(
        expected: ExpectedLight,
        file: &Path,
        reference: CapturedImage,
    ) -> Result<Judged<Self>, Error> {
        check_size(file, &reference, expected.size_px())?;
        let mut judgement = judge_values(file, &reference)?;
        let cells = Cells::from_image(&reference);
        match &expected.drawn {
            Ok(drawn) => judge_light(&mut judgement, file, drawn, &cells, reference.channels),
            Err(why) => {
                for what in ["level", "order_of_colors", "turn", "other_sensor"] {
                    judgement.leave_open(what, why);
                }
            }
        }
        let reference = CheckedImage { file: file.to_owned(), image: reference };
        Ok(Judged::new(Self { expected, reference, cells }, judgement))
    }

    /// Returns the image at rest.
    pub fn reference(&self) -> &CheckedImage {
        &self.reference
    }

    /// Compares an image, which was read from `file`, with the one at rest: number range, exposure, order of colours,
    /// turn.
    ///
    /// # Errors
    /// Returns an error for an image of another size, or with values that are no finite numbers.
    pub fn check(&self, file: &Path, image: CapturedImage) -> Result<Judged<CheckedImage>, Error> {
        check_size(file, &image, self.expected.size_px())?;
        let mut judgement = judge_values(file, &image)?;
        let cells = Cells::from_image(&image);
        let everywhere = vec![true; cells.values.len()];
        let [rest, now] = if image.channels == self.reference.image.channels {
            [self.cells.clone(), cells]
        } else {
            [self.cells.to_grey(), cells.to_grey()]
        };
        let fit = rest.find_best_fit(&now, &everywhere);
        judge_arrangement(&mut judgement, file, &fit, "the image at rest");
        if self.expected.has_moving_markers {
            // A dot of less than a pixel that moves takes its light along: TacTip's image has 57 of them, and nothing else.
            judgement.leave_open("exposure", "this light shows markers, which move");
        } else if let Some(ratio) = median_ratio(&rest, &now) {
            let limits = EXPOSURE_RATIO;
            if !(limits[0]..=limits[1]).contains(&ratio) {
                judgement.find(file, ImageFault::OtherExposure { ratio, limits });
            }
        } else {
            judgement.leave_open("exposure", "nothing is lit in the image at rest");
        }
        Ok(Judged::new(CheckedImage { file: file.to_owned(), image }, judgement))
    }
}

/// Judges the values themselves. Nothing can be computed from values that are no numbers, so they are an error.
fn judge_values(file: &Path, image: &CapturedImage) -> Result<Judgement, Error> {
    let count = image.values.iter().filter(|value| !value.is_finite()).count();
    if count > 0 {
        let fault = ImageFault::NotFinite { count, of: image.values.len() };
        return Err(ImplausibleImage { file: file.to_owned(), fault }.into());
    }
    let mut judgement = Judgement::default();
    let largest = f64::from(image.values.iter().copied().fold(0.0, f32::max));
    if largest < LEAST_RANGE {
        judgement.find(file, ImageFault::NarrowRange { largest, least: LEAST_RANGE });
    }
    Ok(judgement)
}

/// Judges an image at rest by the drawn light.
fn judge_light(
    judgement: &mut Judgement,
    file: &Path,
    drawn: &DrawnLight,
    cells: &Cells,
    channels: usize,
) {
    let among = &drawn.is_surface;
    let as_seen = if drawn.is_colored && channels == 3 { cells.clone() } else { cells.to_grey() };
    let wanted = if channels == 3 { drawn.cells.clone() } else { drawn.cells.to_grey() };
    let ratios = wanted.values.iter().zip(&as_seen.values).zip(among);
    let ratios = ratios.filter(|((drawn, _), is_surface)| **is_surface && sum(drawn) > 0.0);
    match median(ratios.map(|((drawn, seen), _)| sum(seen) / sum(drawn)).collect()) {
        Some(level) if level < LEAST_LEVEL => {
            judgement.find(file, ImageFault::Level { level, least: LEAST_LEVEL });
        }
        Some(_) => {}
        None => judgement.leave_open("level", "no part of the drawn image shows lit surface alone"),
    }
    if !drawn.is_colored {
        judgement.leave_open("order_of_colors", "the drawn light is white");
        judgement.leave_open(
            "other_sensor",
            "in white light, units of one sensor differ as much as sensors",
        );
        let lit = cells.values.iter().zip(among);
        let lit = lit.filter(|(rgb, is_surface)| **is_surface && sum(rgb) > 3.0 * LEAST_LIT);
        let saturations: Vec<f64> = lit.map(|(rgb, _)| saturation(rgb)).collect();
        let saturation = saturations.iter().sum::<f64>() / saturations.len().max(1) as f64;
        if saturation > MOST_SATURATION {
            judgement.find(file, ImageFault::Colored { saturation, most: MOST_SATURATION });
        }
    }
    let fit = wanted.find_best_fit(&as_seen, among);
    if drawn.is_colored && !fit.tells_colors {
        judgement.leave_open("order_of_colors", "the image, or the drawn light, has no colours");
    }
    if !fit.tells_turns {
        judgement.leave_open("turn", "the drawn light looks the same when it is turned");
    } else if drawn.is_colored {
        judgement.leave_open(
            "mirrored_with_exchanged_colors",
            "lamps of two colours that face each other look the same then",
        );
    }
    let is_rearranged = judge_arrangement(judgement, file, &fit, "the drawn light");
    if drawn.is_colored && channels == 3 && !is_rearranged && fit.as_given < LEAST_SIMILARITY {
        let (similarity, least) = (fit.as_given, LEAST_SIMILARITY);
        judgement.find(file, ImageFault::OtherLight { similarity, least });
    }
}

/// Finds an image that fits after a change, and not as it is. Returns whether it was found.
fn judge_arrangement(
    judgement: &mut Judgement,
    file: &Path,
    fit: &BestFit,
    against: &'static str,
) -> bool {
    let Some((best, changes)) = &fit.best else { return false };
    let (best, as_given) = (*best, fit.as_given);
    if best < FOUND_AGAIN || best - as_given < REARRANGED_GAIN {
        return false;
    }
    let changes = changes.iter().map(super::cells::Rearrangement::words).collect();
    judgement.find(file, ImageFault::Rearranged { against, changes, best, as_given });
    true
}

fn median_ratio(rest: &Cells, now: &Cells) -> Option<f64> {
    let lit = rest.values.iter().flatten().zip(now.values.iter().flatten());
    let lit = lit.filter(|(rest, _)| **rest >= LEAST_LIT);
    median(lit.map(|(rest, now)| now / rest).collect())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    values.sort_by(f64::total_cmp);
    values.get(middle).copied()
}

fn sum(rgb: &[f64; 3]) -> f64 {
    rgb.iter().sum()
}

fn saturation(rgb: &[f64; 3]) -> f64 {
    let least = rgb.iter().copied().fold(f64::INFINITY, f64::min);
    let most = rgb.iter().copied().fold(0.0, f64::max);
    if most > 0.0 { (most - least) / most } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lamps in red from the left and green from the top, blue everywhere; `of` changes the intensities.
    fn image(of: impl Fn([f32; 3]) -> [f32; 3]) -> CapturedImage {
        let pixel = |i: usize| {
            let [x, y] = [(i % 96) as f32 / 95.0, (i / 96) as f32 / 71.0];
            of([0.2 + 0.6 * (1.0 - x), 0.2 + 0.6 * (1.0 - y), 0.4])
        };
        let values = (0..96 * 72).flat_map(pixel).collect();
        CapturedImage { size_px: [96, 72], channels: 3, values }
    }

    fn codes(judgement: &Judgement) -> Vec<&'static str> {
        judgement.findings.iter().map(|one| one.fault.code()).collect()
    }

    fn gate(rest: CapturedImage) -> Judged<ImageGate> {
        let cells = Cells::from_image(&image(|rgb| rgb));
        let count = cells.values.len();
        let drawn = DrawnLight {
            cells,
            is_surface: vec![true; count],
            limit_mm: vec![3.0; count],
            is_colored: true,
        };
        let expected =
            ExpectedLight { size_px: [96, 72], drawn: Ok(drawn), has_moving_markers: false };
        ImageGate::new(expected, Path::new("rest.png"), rest).unwrap()
    }

    #[test]
    fn images_at_rest_are_compared_with_the_drawn_light() {
        // Another white balance and exposure is another unit.
        let unit = gate(image(|[r, g, b]| [0.9 * r, 1.1 * g, 0.7 * b]));
        assert!(unit.judgement().is_plausible(), "{:?}", unit.judgement());
        let bgr = gate(image(|[r, g, b]| [b, g, r]));
        assert_eq!(codes(bgr.judgement()), ["rearranged"]);
        assert!(bgr.judgement().findings[0].to_string().contains("red and blue exchanged"));
        // Green that is brightest where red is: no change of the drawn light makes this.
        let other = gate(image(|[r, _, b]| [r, r, b]));
        assert_eq!(codes(other.judgement()), ["other_light"]);
        assert_eq!(codes(gate(image(|rgb| rgb.map(|v| 0.2 * v))).judgement()), ["other_level"]);
        let narrow = gate(image(|rgb| rgb.map(|v| v / 16.0)));
        assert_eq!(codes(narrow.judgement()), ["narrow_range", "other_level"]);
    }

    #[test]
    fn images_are_compared_with_the_one_at_rest() {
        let gate = gate(image(|rgb| rgb)).accept().unwrap();
        let check = |image| codes(gate.check(Path::new("a.png"), image).unwrap().judgement());
        // Just within the limits of exposure, and just beyond them.
        assert!(check(image(|rgb| rgb.map(|v| 0.81 * v))).is_empty());
        assert!(check(image(|rgb| rgb.map(|v| 1.09 * v))).is_empty());
        assert_eq!(check(image(|rgb| rgb.map(|v| 0.79 * v))), ["other_exposure"]);
        assert_eq!(check(image(|rgb| rgb.map(|v| 1.11 * v))), ["other_exposure"]);
        assert!(check(image(|[r, g, b]| [b, g, r])).contains(&"rearranged"));
        let error = gate.check(Path::new("a.png"), image(|[r, g, _]| [r, g, f32::NAN]));
        let message = error.unwrap_err().to_string();
        assert_eq!(message, "a.png: 6912 of 20736 values are no finite numbers");
    }
}
