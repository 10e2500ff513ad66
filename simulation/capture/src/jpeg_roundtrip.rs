//! JPEG compression of simulated captures.

use fabkit_files::Error;
use fabkit_image::{PixelValues, encode_jpeg, read};

/// Encodes intensities, 0 to 255, as JPEG and decodes them again. Returns integers.
pub(super) fn jpeg_roundtrip(
    grey: &[f64],
    size_px: [u32; 2],
    quality: u8,
) -> Result<Vec<f64>, Error> {
    let values: Vec<u8> = grey.iter().map(|grey| grey.round().clamp(0.0, 255.0) as u8).collect();
    let file = encode_jpeg(size_px, &values, quality).map_err(Error::bug)?;
    let most_pixels = size_px.iter().map(|px| u64::from(*px)).product();
    match read(&file, most_pixels).map_err(Error::bug)?.values {
        PixelValues::U8(values) => Ok(values.into_iter().map(f64::from).collect()),
        PixelValues::U16(_) => Err(Error::bug("JPEG has eight bits")),
    }
}
