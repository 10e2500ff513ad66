//! Grey images and their files.

use fabkit_image::{DecodedImage, ImageFileError, PixelValues};

/// Largest number of pixels of an image.
pub const MAX_PIXELS: u64 = 64 << 20;
/// Longest side of an image, px.
pub const MAX_SIDE_PX: u32 = 16_384;
/// Smallest largest value of an image of 16 bits, as a share of the range: 12 bits that were not shifted stay below.
const LEAST_RANGE: f32 = 1.0 / 16.0;
/// Shortest side of an image, px: below, a pin or a board's corner has too few pixels to be detected.
pub const MIN_SIDE_PX: u32 = 64;

/// Grey image of intensities from 0 for black to 1 for the largest value that its file can hold.
///
/// ```
/// use fabkit_calibration::image::{GreyImage, ImageError};
/// // Row by row: a ramp that gets brighter to the right.
/// let values = (0..96 * 64).map(|i| (i % 96) as f32 / 255.0).collect();
/// let image = GreyImage::new(96, 64, values)?;
/// assert_eq!((image.at(51, 3), image.at(0, 3)), (0.2, 0.0));
/// // As a file of 8 bits and back.
/// assert_eq!(GreyImage::read(&image.to_png())?, image);
/// let small = GreyImage::new(32, 32, vec![0.5; 32 * 32]).unwrap_err();
/// assert_eq!(small, ImageError::Size { width_px: 32, height_px: 32 });
/// # Ok::<(), ImageError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GreyImage {
    width_px: usize,
    height_px: usize,
    /// Intensities row by row from the top.
    values: Vec<f32>,
}

/// Reason why an image cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// The file is no image, or a damaged one.
    #[error(transparent)]
    Unreadable(#[from] ImageFileError),
    /// The values are not one finite intensity for each pixel.
    #[error("needs one finite brightness per pixel")]
    Values,
    /// All values lie in the lowest sixteenth of the range of a file of 16 bits.
    #[error(
        "no value exceeds {largest} of {range}: too dark, or fewer bits than the file has room for; multiply 12 bits in 16 by 16"
    )]
    NarrowRange {
        /// Largest value in the file, weighted over its colours.
        largest: u32,
        /// Largest value that the file can hold.
        range: u32,
    },
    /// The image is too large or too small.
    #[error(
        "{width_px} x {height_px} px; sides are {MIN_SIDE_PX} px to {MAX_SIDE_PX} px, {MAX_PIXELS} pixels in all"
    )]
    Size {
        /// Width, px.
        width_px: u32,
        /// Height, px.
        height_px: u32,
    },
}

impl GreyImage {
    /// Creates an image from intensities row by row from the top.
    ///
    /// # Errors
    /// Returns [`ImageError::Size`] outside the limits, or [`ImageError::Values`] if the number of values is not width
    /// times height or one is not finite.
    pub fn new(width_px: u32, height_px: u32, values: Vec<f32>) -> Result<Self, ImageError> {
        check_size(width_px, height_px)?;
        let (width_px, height_px) = (width_px as usize, height_px as usize);
        if values.len() != width_px * height_px || values.iter().any(|v| !v.is_finite()) {
            return Err(ImageError::Values);
        }
        Ok(Self { width_px, height_px, values })
    }

    /// Reads width and height of an image file, px, from its header, so that a large image can be refused before it is
    /// decoded.
    ///
    /// # Errors
    /// Fails if the header is unreadable, or for a size outside the limits.
    pub fn size_px(bytes: &[u8]) -> Result<[u32; 2], ImageError> {
        let [width_px, height_px] = fabkit_image::read_size_px(bytes)?;
        check_size(width_px, height_px)?;
        Ok([width_px, height_px])
    }

    /// Reads a PNG, JPEG, TIFF or BMP file. Colours are weighted as in ITU-R BT.709; transparency is ignored.
    ///
    /// # Errors
    /// Fails for an unreadable file or a size outside the limits. The size is checked before anything is decoded.
    pub fn read(bytes: &[u8]) -> Result<Self, ImageError> {
        Self::size_px(bytes)?;
        let DecodedImage { width_px, height_px, channels, values } =
            fabkit_image::read(bytes, MAX_PIXELS)?;
        let values = match values {
            PixelValues::U8(values) => grey(&values, channels, f32::from(u8::MAX)),
            PixelValues::U16(values) => {
                let values = grey(&values, channels, f32::from(u16::MAX));
                check_range(&values)?;
                values
            }
        };
        Self::new(width_px, height_px, values)
    }

    /// Encodes the image as a grey PNG of 8 bits.
    pub fn to_png(&self) -> Vec<u8> {
        let bytes: Vec<u8> =
            self.values.iter().map(|v| (255.0 * v.clamp(0.0, 1.0)).round() as u8).collect();
        let mut file = Vec::new();
        // The casts are safe: sides were checked when the image was created.
        let mut encoder = png::Encoder::new(&mut file, self.width_px as u32, self.height_px as u32);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Eight);
        let written = encoder.write_header().and_then(|mut png| png.write_image_data(&bytes));
        written.expect("a header and rows of the promised size, written to memory");
        file
    }

    /// Width of the image, px.
    pub fn width_px(&self) -> usize {
        self.width_px
    }

    /// Height of the image, px.
    pub fn height_px(&self) -> usize {
        self.height_px
    }

    /// Intensities row by row from the top.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Returns the intensity of a pixel.
    ///
    /// # Panics
    /// Panics outside the image.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        assert!(x < self.width_px, "column {x} of {}", self.width_px);
        self.values[y * self.width_px + x]
    }

    /// Returns the image blurred by a Gaussian of standard deviation `sigma_px`; the border is repeated outwards.
    ///
    /// ```
    /// use fabkit_calibration::image::GreyImage;
    /// let mut values = vec![0.0; 64 * 64];
    /// values[64 * 30 + 20] = 1.0;
    /// let blurred = GreyImage::new(64, 64, values)?.blurred(2.0);
    /// // A point becomes a Gaussian: 1 / (2 pi sigma^2) in its middle, and as much light in all.
    /// assert!((blurred.at(20, 30) - 1.0 / (8.0 * std::f32::consts::PI)).abs() < 1e-3);
    /// assert!((blurred.values().iter().sum::<f32>() - 1.0).abs() < 1e-4);
    /// # Ok::<(), fabkit_calibration::image::ImageError>(())
    /// ```
    #[must_use]
    pub fn blurred(&self, sigma_px: f32) -> Self {
        let reach = (3.0 * sigma_px).ceil() as isize;
        let mut kernel: Vec<f32> =
            (-reach..=reach).map(|i| (-0.5 * (i as f32 / sigma_px).powi(2)).exp()).collect();
        let sum: f32 = kernel.iter().sum();
        kernel.iter_mut().for_each(|k| *k /= sum);
        // A Gaussian is separable: rows first, then columns.
        let along = |values: &[f32], length: usize, stride: usize, out: &mut [f32]| {
            for line in 0..values.len() / length {
                // Rows are contiguous; columns begin one pixel apart.
                let start = if stride == 1 { line * length } else { line };
                for i in 0..length {
                    let tap = |k: isize| {
                        let j = (i as isize + k).clamp(0, length as isize - 1) as usize;
                        values[start + j * stride]
                    };
                    out[start + i * stride] =
                        (-reach..=reach).zip(&kernel).map(|(k, weight)| weight * tap(k)).sum();
                }
            }
        };
        // Two passes with a one-dimensional kernel instead of one with its square.
        let mut rows = vec![0.0; self.values.len()];
        along(&self.values, self.width_px, 1, &mut rows);
        let mut both = vec![0.0; self.values.len()];
        along(&rows, self.height_px, self.width_px, &mut both);
        Self { values: both, ..*self }
    }
}

/// Converts pixels whose values go up to `white` to intensities.
fn grey<T: Copy + Into<f32>>(values: &[T], channels: u32, white: f32) -> Vec<f32> {
    let sample = |value: T| value.into() / white;
    if channels == 1 {
        return values.iter().map(|value| sample(*value)).collect();
    }
    let (pixels, _) = values.as_chunks::<3>();
    pixels
        .iter()
        .map(|[red, green, blue]| {
            0.2126 * sample(*red) + 0.7152 * sample(*green) + 0.0722 * sample(*blue)
        })
        .collect()
}

/// Checks that values of a file of 16 bits use its range. An image that is all black is not one of fewer bits; detectors
/// say what they miss in it.
fn check_range(values: &[f32]) -> Result<(), ImageError> {
    let largest = values.iter().copied().fold(0.0, f32::max);
    if largest == 0.0 || largest >= LEAST_RANGE {
        return Ok(());
    }
    let range = u32::from(u16::MAX);
    Err(ImageError::NarrowRange { largest: (largest * range as f32).round() as u32, range })
}

/// Checks the limits of an image's size.
fn check_size(width_px: u32, height_px: u32) -> Result<(), ImageError> {
    let sides = MIN_SIDE_PX..=MAX_SIDE_PX;
    let pixels = u64::from(width_px) * u64::from(height_px);
    if sides.contains(&width_px) && sides.contains(&height_px) && pixels <= MAX_PIXELS {
        Ok(())
    } else {
        Err(ImageError::Size { width_px, height_px })
    }
}
