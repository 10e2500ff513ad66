//! Reads pictures that cameras took: PNG, JPEG, TIFF and BMP, told apart by their first bytes. Writes JPEG as cameras do.
//!
//! Values are those of the file, row by row from the top, without what viewers add: colour profiles are
//! not applied, and orientation tags are left alone, because calibration wants pixels where the chip has
//! them. Transparency is dropped. Of a TIFF the first picture counts.
//!
//! ```
//! let file = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/colour.jpg"));
//! assert_eq!(fabkit_picture::size_px(file)?, [16, 12]);
//! let picture = fabkit_picture::read(file, 1000)?;
//! assert_eq!((picture.channels, picture.values.len()), (3, 3 * 16 * 12));
//! # Ok::<(), fabkit_picture::PictureError>(())
//! ```

#![forbid(unsafe_code)]

mod formats;

use formats::Format;

/// How files of these kinds end, in lower case.
pub const ENDINGS: [&str; 6] = ["png", "jpg", "jpeg", "tif", "tiff", "bmp"];

/// What a file holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Values of a pixel: 1 for grey, 3 for red, green, blue.
    pub channels: u32,
    /// Row by row from the top.
    pub values: Values,
}

/// The values of all pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Values {
    /// Of 8 bits, or fewer spread over 8.
    U8(Vec<u8>),
    /// Of 16 bits.
    U16(Vec<u16>),
}

impl Values {
    /// One of them, 0 to 1 for the largest that the file could hold.
    pub fn get(&self, i: usize) -> Option<f32> {
        match self {
            Self::U8(values) => values.get(i).map(|v| f32::from(*v) / 255.0),
            Self::U16(values) => values.get(i).map(|v| f32::from(*v) / 65535.0),
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Why a picture cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// It begins like no picture.
    #[error("not a readable PNG, JPEG, TIFF or BMP picture")]
    Unknown,
    /// Damaged, or of a kind that cameras do not write.
    #[error("not a readable {format}: {reason}")]
    Unreadable {
        /// Which kind it began as.
        format: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// More pixels than asked for.
    #[error("{width_px} x {height_px} px are more than {most} pixels")]
    TooLarge {
        /// Columns.
        width_px: u32,
        /// Rows.
        height_px: u32,
        /// The limit.
        most: u64,
    },
}

/// Whether a file's name ends as one of these pictures does.
///
/// ```
/// assert!(fabkit_picture::is_named_as_one("01_05.JPG") && !fabkit_picture::is_named_as_one("jpg"));
/// ```
pub fn is_named_as_one(name: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, end)| ENDINGS.contains(&&*end.to_ascii_lowercase()))
}

/// Width and height, px, from the header: to refuse a picture before anything is decoded.
///
/// # Errors
/// [`PictureError`], but never [`PictureError::TooLarge`].
pub fn size_px(bytes: &[u8]) -> Result<[u32; 2], PictureError> {
    Format::of(bytes).ok_or(PictureError::Unknown)?.size_px(bytes)
}

/// Reads a picture of at most so many pixels. Memory is that of the result, and of the file's own values
/// where they are wider.
///
/// # Errors
/// [`PictureError`]; sizes are checked before anything is decoded.
pub fn read(bytes: &[u8], most_pixels: u64) -> Result<Picture, PictureError> {
    let format = Format::of(bytes).ok_or(PictureError::Unknown)?;
    let [width_px, height_px] = format.size_px(bytes)?;
    if u64::from(width_px) * u64::from(height_px) > most_pixels {
        return Err(PictureError::TooLarge { width_px, height_px, most: most_pixels });
    }
    let (samples, values) = format.values(bytes)?;
    let channels = if samples < 3 { 1 } else { 3 };
    let values = match values {
        Values::U8(values) => Values::U8(first(values, samples, channels)),
        Values::U16(values) => Values::U16(first(values, samples, channels)),
    };
    if values.len() != width_px as usize * height_px as usize * channels {
        return Err(format.unreadable("it holds fewer pixels than it says"));
    }
    Ok(Picture { width_px, height_px, channels: channels as u32, values })
}

/// Writes values of 8 bits, row by row, as JPEG of a quality from 1 to 100: one channel as grey, three as red, green and
/// blue, their colours as fine as their brightness. The same bytes on every machine.
///
/// ```
/// let grey = [90; 16 * 8];
/// let file = fabkit_picture::jpeg([16, 8], &grey, 70)?;
/// let back = fabkit_picture::read(&file, 1000)?;
/// assert_eq!((back.width_px, back.height_px, back.channels), (16, 8, 1));
/// # Ok::<(), fabkit_picture::PictureError>(())
/// ```
///
/// # Errors
/// Other than one or three values a pixel, or a side of 0 or of more than 65,535 px.
pub fn jpeg(
    [width, height]: [u32; 2],
    values: &[u8],
    quality: u8,
) -> Result<Vec<u8>, PictureError> {
    formats::jpeg([width, height], values, quality)
}

/// The first `channels` of each pixel's samples: those behind are transparency.
fn first<T: Copy>(mut values: Vec<T>, samples: usize, channels: usize) -> Vec<T> {
    if samples != channels {
        let pixels = values.len() / samples;
        for pixel in 0..pixels {
            values.copy_within(pixel * samples..pixel * samples + channels, pixel * channels);
        }
        values.truncate(pixels * channels);
    }
    values
}
