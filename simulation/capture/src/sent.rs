//! Pictures as they come from cameras that send JPEG.

use fabkit_files::Error;
use fabkit_picture::{Values, jpeg, read};

/// What is left of grey values, 0 to 255, when they have been written as JPEG and read again: whole numbers.
pub(super) fn sent(grey: &[f64], size_px: [u32; 2], quality: u8) -> Result<Vec<f64>, Error> {
    let values: Vec<u8> = grey.iter().map(|grey| grey.round().clamp(0.0, 255.0) as u8).collect();
    let file = jpeg(size_px, &values, quality).map_err(Error::bug)?;
    let most_pixels = size_px.iter().map(|px| u64::from(*px)).product();
    match read(&file, most_pixels).map_err(Error::bug)?.values {
        Values::U8(values) => Ok(values.into_iter().map(f64::from).collect()),
        Values::U16(_) => Err(Error::bug("JPEG has eight bits")),
    }
}
