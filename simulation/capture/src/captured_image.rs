//! Reading of captured images.

use std::path::{Path, PathBuf};

use fabkit_calibration::pin_captures::PinCaptureError;
use fabkit_calibration::pin_captures::images::IMAGE_FILE;
use fabkit_files::memory::{MemoryGrant, MemoryHint};
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained, reading};
use fabkit_image::{DecodedImage, ImageFileError};

/// An image whose size differs from the camera's.
#[derive(Debug, thiserror::Error)]
#[error(
    "{}: {} x {} px; the camera takes {} x {} px",
    .file.display(), .size_px[0], .size_px[1], .expected_px[0], .expected_px[1]
)]
pub struct SizeMismatch {
    /// Path of the image.
    pub file: PathBuf,
    /// Width and height of the image, px.
    pub size_px: [usize; 2],
    /// Width and height that the camera takes, px.
    pub expected_px: [usize; 2],
}

impl Explained for SizeMismatch {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        Some("give the camera that took the images, or images as it takes them".into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::from_path("other_size", &self.file)
    }
}

/// Checks that an image read from `file` has the expected number of columns and rows.
///
/// # Errors
/// [`SizeMismatch`].
///
/// ```
/// use std::path::Path;
///
/// use fabkit_capture::{CapturedImage, check_size};
/// let image = CapturedImage { size_px: [2, 1], channels: 1, values: vec![0.5; 2] };
/// assert!(check_size(Path::new("a.png"), &image, [2, 1]).is_ok());
/// let error = check_size(Path::new("a.png"), &image, [640, 480]).unwrap_err();
/// assert_eq!(error.to_string(), "a.png: 2 x 1 px; the camera takes 640 x 480 px");
/// ```
pub fn check_size(
    file: &Path,
    image: &CapturedImage,
    expected_px: [usize; 2],
) -> Result<(), SizeMismatch> {
    if image.size_px == expected_px {
        return Ok(());
    }
    Err(SizeMismatch { file: file.to_owned(), size_px: image.size_px, expected_px })
}

/// Weights of red, green and blue in luminance, as in ITU-R BT.709.
const LUMINANCE_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// Maximum number of pixels of an image.
const MAX_PIXELS: u64 = 64 << 20;
/// Memory per pixel while an image is read, bytes: four values of 16 bits as decoded, twice for formats that are decoded as a
/// whole, three as numbers, and what the decoder keeps. Derived by counting.
const READING_BYTES: u64 = 2 * 8 + 3 * 4 + 8;

/// An image with values from 0 to 1, row by row.
///
/// ```
/// use fabkit_capture::CapturedImage;
/// // A green pixel and a white one.
/// let image = CapturedImage { size_px: [2, 1], channels: 3, values: vec![0.0, 1.0, 0.0, 1.0, 1.0, 1.0] };
/// let grey = image.grey();
/// assert!((grey[0] - 0.7152).abs() < 1e-6 && (grey[1] - 1.0).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CapturedImage {
    /// Number of columns and rows.
    pub size_px: [usize; 2],
    /// Number of values per pixel: 1, or 3 for red, green and blue.
    pub channels: usize,
    /// Values, as many as pixels times channels.
    pub values: Vec<f32>,
}

impl CapturedImage {
    /// Reads a PNG, JPEG, TIFF or BMP file.
    ///
    /// # Errors
    /// Returns an error for a file that cannot be read, or holds no usable image.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = reading::read(path, IMAGE_FILE)?;
        // Images of captures report the same errors as those of calibrations.
        let wrong = |error: ImageFileError| {
            let source = error.into();
            Error::from(PinCaptureError::Image { file: path.display().to_string(), source })
        };
        // By the header, before anything is decoded.
        let [width, height] = fabkit_image::read_size_px(&bytes).map_err(wrong)?;
        let what = format!("reading an image of {width} x {height} px");
        let pixels = u64::from(width) * u64::from(height);
        let _grant = MemoryGrant::request(&what, pixels * READING_BYTES, MemoryHint::Images)?;
        let DecodedImage { width_px, height_px, channels, values } =
            fabkit_image::read(&bytes, MAX_PIXELS).map_err(wrong)?;
        // `get` scales 8-bit and 16-bit values alike to 0 to 1.
        let mut scaled = Vec::with_capacity(values.len());
        scaled.extend((0..values.len()).filter_map(|i| values.get(i)));
        let size_px = [width_px, height_px].map(|px| px as usize);
        Ok(Self { size_px, channels: channels as usize, values: scaled })
    }

    /// Returns the luminance of each pixel.
    pub fn grey(self) -> Vec<f32> {
        let (colors, _) = self.values.as_chunks::<3>();
        match self.channels {
            3 => colors
                .iter()
                .map(|color| (0..3).map(|k| LUMINANCE_WEIGHTS[k] * color[k]).sum())
                .collect(),
            // A greyscale image is its own luminance.
            _ => self.values,
        }
    }
}
