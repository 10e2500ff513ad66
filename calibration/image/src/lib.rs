//! Reads images that cameras took (PNG, JPEG, TIFF and BMP, recognised by their first bytes) and writes JPEG.
//!
//! Values are those of the file, row by row from the top. Colour profiles and orientation tags are ignored, because
//! calibration needs pixels where the image sensor has them. Transparency is dropped. Only the first image of a TIFF
//! file is read.
//!
//! ```
//! let file = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/colour.jpg"));
//! assert_eq!(fabkit_image::read_size_px(file)?, [16, 12]);
//! let image = fabkit_image::read(file, 1000)?;
//! assert_eq!((image.channels, image.values.len()), (3, 3 * 16 * 12));
//! # Ok::<(), fabkit_image::ImageFileError>(())
//! ```

#![forbid(unsafe_code)]

mod formats;

use formats::Format;

/// File name extensions of the readable formats, in lower case.
pub const EXTENSIONS: [&str; 6] = ["png", "jpg", "jpeg", "tif", "tiff", "bmp"];

/// Decoded image.
///
/// ```
/// use fabkit_image::PixelValues;
/// // Red rises by 15 to the right and green by 20 downwards; blue falls by 9 along both.
/// let file = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/colour.png"));
/// let image = fabkit_image::read(file, 1000)?;
/// let PixelValues::U8(values) = &image.values else { panic!("8 bits") };
/// let (x, y) = (3, 2);
/// let first = (image.channels * (y * image.width_px + x)) as usize;
/// assert_eq!(values[first..first + 3], [45, 40, 255 - 45]);
/// # Ok::<(), fabkit_image::ImageFileError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecodedImage {
    /// Number of columns.
    pub width_px: u32,
    /// Number of rows.
    pub height_px: u32,
    /// Number of values per pixel: 1 for grey, 3 for red, green and blue.
    pub channels: u32,
    /// Values row by row from the top, the channels of a pixel next to each other.
    pub values: PixelValues,
}

/// Values of all pixels, in the depth of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PixelValues {
    /// Values of 8 bits. Files with fewer bits are expanded to 8.
    U8(Vec<u8>),
    /// Values of 16 bits.
    U16(Vec<u16>),
}

impl PixelValues {
    /// Returns value `i` scaled to 0 to 1, where 1 is the largest value that its depth can hold. `None` beyond the end.
    ///
    /// ```
    /// use fabkit_image::PixelValues;
    /// // White is 1 in every depth.
    /// assert_eq!(PixelValues::U8(vec![0, 51, 255]).get(1), Some(0.2));
    /// assert_eq!(PixelValues::U16(vec![0, 65_535]).get(1), Some(1.0));
    /// assert_eq!(PixelValues::U16(vec![0, 65_535]).get(2), None);
    /// ```
    pub fn get(&self, i: usize) -> Option<f32> {
        match self {
            Self::U8(values) => values.get(i).map(|v| f32::from(*v) / 255.0),
            Self::U16(values) => values.get(i).map(|v| f32::from(*v) / 65535.0),
        }
    }

    /// Returns the number of values: pixels times channels.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
        }
    }

    /// Returns whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Reason why an image cannot be read or written.
///
/// ```
/// use fabkit_image::{ImageFileError, encode_jpeg, read};
/// assert_eq!(read(b"GIF89a", 1000), Err(ImageFileError::UnknownFormat));
/// let file = encode_jpeg([16, 8], &[90; 16 * 8], 70)?;
/// let refused = read(&file, 100).unwrap_err();
/// assert_eq!(refused.to_string(), "16 x 8 px are more than 100 pixels");
/// let half = read(&file[..file.len() / 2], 1000).unwrap_err();
/// assert!(matches!(half, ImageFileError::Unreadable { format: "JPEG", .. }));
/// # Ok::<(), ImageFileError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageFileError {
    /// The first bytes belong to none of the four formats.
    #[error("not a readable PNG, JPEG, TIFF or BMP image")]
    UnknownFormat,
    /// The file is damaged, or uses a variant of its format that cameras do not write.
    #[error("not a readable {format}: {reason}")]
    Unreadable {
        /// Format that the first bytes announce.
        format: &'static str,
        /// Message of the decoder or encoder.
        reason: String,
    },
    /// The image has more pixels than the caller allows.
    #[error("{width_px} x {height_px} px are more than {max_pixels} pixels")]
    TooLarge {
        /// Number of columns.
        width_px: u32,
        /// Number of rows.
        height_px: u32,
        /// Largest number of pixels allowed.
        max_pixels: u64,
    },
}

/// Returns whether a file name ends with one of [`EXTENSIONS`], in upper or lower case.
///
/// ```
/// assert!(fabkit_image::has_image_extension("01_05.JPG") && !fabkit_image::has_image_extension("jpg"));
/// ```
pub fn has_image_extension(name: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, end)| EXTENSIONS.contains(&&*end.to_ascii_lowercase()))
}

/// Returns width and height, px, from the header of a file, so that a large image can be refused before it is decoded.
///
/// # Errors
/// Returns any [`ImageFileError`] except [`ImageFileError::TooLarge`].
///
/// ```
/// // The first kilobytes of a large file are enough; here 40 bytes of a PNG.
/// let file = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/deep.png"));
/// assert_eq!(fabkit_image::read_size_px(&file[..40])?, [16, 12]);
/// assert!(fabkit_image::read(&file[..40], 1000).is_err());
/// # Ok::<(), fabkit_image::ImageFileError>(())
/// ```
pub fn read_size_px(bytes: &[u8]) -> Result<[u32; 2], ImageFileError> {
    Format::from_first_bytes(bytes).ok_or(ImageFileError::UnknownFormat)?.size_px(bytes)
}

/// Reads an image of at most `most_pixels` pixels.
///
/// Memory: the result, and the file's own values where they have more channels.
///
/// # Errors
/// Returns a [`ImageFileError`]. The size is checked before anything is decoded.
///
/// ```
/// use fabkit_image::PixelValues;
/// // 16 bits stay 16 bits: 4000 more with each column.
/// let file = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/deep.png"));
/// let PixelValues::U16(values) = fabkit_image::read(file, 16 * 12)?.values else { panic!() };
/// assert_eq!(values[..3], [0, 4000, 8000]);
/// // Transparency is dropped.
/// let file = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/alpha.png"));
/// assert_eq!(fabkit_image::read(file, 16 * 12)?.channels, 3);
/// # Ok::<(), fabkit_image::ImageFileError>(())
/// ```
pub fn read(bytes: &[u8], most_pixels: u64) -> Result<DecodedImage, ImageFileError> {
    let format = Format::from_first_bytes(bytes).ok_or(ImageFileError::UnknownFormat)?;
    let [width_px, height_px] = format.size_px(bytes)?;
    if u64::from(width_px) * u64::from(height_px) > most_pixels {
        return Err(ImageFileError::TooLarge { width_px, height_px, max_pixels: most_pixels });
    }
    let (samples, values) = format.values(bytes)?;
    // One sample is grey and two are grey with alpha; three are RGB and four RGBA.
    let channels = if samples < 3 { 1 } else { 3 };
    let values = match values {
        PixelValues::U8(values) => PixelValues::U8(keep_first_channels(values, samples, channels)),
        PixelValues::U16(values) => {
            PixelValues::U16(keep_first_channels(values, samples, channels))
        }
    };
    if values.len() != width_px as usize * height_px as usize * channels {
        return Err(format.unreadable("it holds fewer pixels than it says"));
    }
    Ok(DecodedImage { width_px, height_px, channels: channels as u32, values })
}

/// Encodes values of 8 bits, row by row, as JPEG of a quality from 1 to 100. One channel is written as grey, three as
/// red, green and blue without chroma subsampling. The bytes are the same on every machine.
///
/// ```
/// let grey = [90; 16 * 8];
/// let file = fabkit_image::encode_jpeg([16, 8], &grey, 70)?;
/// let back = fabkit_image::read(&file, 1000)?;
/// assert_eq!((back.width_px, back.height_px, back.channels), (16, 8, 1));
/// # Ok::<(), fabkit_image::ImageFileError>(())
/// ```
///
/// # Errors
/// Fails unless there are one or three values per pixel and both sides are 1 to 65,535 px.
pub fn encode_jpeg(
    [width, height]: [u32; 2],
    values: &[u8],
    quality: u8,
) -> Result<Vec<u8>, ImageFileError> {
    formats::encode_jpeg([width, height], values, quality)
}

/// Keeps the first `channels` samples of each pixel; the remaining one is transparency. Works in place.
fn keep_first_channels<T: Copy>(mut values: Vec<T>, samples: usize, channels: usize) -> Vec<T> {
    if samples != channels {
        let pixels = values.len() / samples;
        for pixel in 0..pixels {
            values.copy_within(pixel * samples..pixel * samples + channels, pixel * channels);
        }
        values.truncate(pixels * channels);
    }
    values
}
