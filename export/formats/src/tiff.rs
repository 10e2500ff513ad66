//! Maps as TIFF (Adobe, "TIFF Revision 6.0", 1992), 32-bit floating point, uncompressed.

use crate::ExportError;

const SHORT: u16 = 3;
const LONG: u16 = 4;

/// Writes a grey image of `float32`, row by row from the top, little-endian, as one strip.
///
/// # Errors
/// [`ExportError::ImageSize`] if size and pixels do not match or the image is empty; [`ExportError::TooLarge`] beyond
/// the format's 4 GiB.
///
/// ```
/// let file = fabkit_export::float_tiff(2, 1, &[0.5, -1.25])?;
/// assert!(file.starts_with(b"II*\0"));
/// assert_eq!(file[file.len() - 4..], (-1.25f32).to_le_bytes());
/// assert!(fabkit_export::float_tiff(2, 2, &[0.0; 3]).is_err());
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn float_tiff(width_px: u32, height_px: u32, values: &[f32]) -> Result<Vec<u8>, ExportError> {
    let needed = u64::from(width_px) * u64::from(height_px);
    if needed == 0 || needed != values.len() as u64 {
        return Err(ExportError::ImageSize { width_px, height_px, needed, found: values.len() });
    }
    // Tags must be in ascending order; see sections 4 and 19 of the specification.
    const TAGS: u32 = 10;
    const DATA_AT: u32 = 8 + 2 + 12 * TAGS + 4;
    let limit = u64::from(u32::MAX - DATA_AT);
    let bytes_of_data = 4 * needed;
    if bytes_of_data > limit {
        return Err(ExportError::TooLarge { what: "a TIFF", needed: bytes_of_data, limit });
    }
    let tags: [(u16, u16, u32); TAGS as usize] = [
        (256, LONG, width_px),
        (257, LONG, height_px),
        (258, SHORT, 32),                  // bits per sample
        (259, SHORT, 1),                   // uncompressed
        (262, SHORT, 1),                   // 0 is black
        (273, LONG, DATA_AT),              // offset of the strip
        (277, SHORT, 1),                   // samples per pixel
        (278, LONG, height_px),            // rows per strip
        (279, LONG, bytes_of_data as u32), // length of the strip
        (339, SHORT, 3),                   // IEEE floating point
    ];
    let mut bytes = b"II\x2a\0\x08\0\0\0".to_vec();
    bytes.extend((TAGS as u16).to_le_bytes());
    for (tag, kind, value) in tags {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(1u32.to_le_bytes());
        // A short occupies the first half of the field; a little-endian 32-bit number puts it there.
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend(0u32.to_le_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_follow_the_directory() {
        let values: Vec<f32> = (0..6).map(|i| i as f32 * 0.5).collect();
        let bytes = float_tiff(3, 2, &values).unwrap();
        let start = bytes.len() - 24;
        assert_eq!(start, 8 + 2 + 120 + 4);
        assert_eq!(bytes[start + 4..start + 8], 0.5f32.to_le_bytes());
        assert!(matches!(float_tiff(2, 2, &values), Err(ExportError::ImageSize { .. })));
        assert!(float_tiff(0, 0, &[]).is_err());
    }
}
