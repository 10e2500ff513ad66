//! PNG images.

use crate::ExportError;

/// Writes an 8-bit sRGB PNG. `rgb` holds three bytes per pixel, row by row from the top.
///
/// # Errors
/// [`ExportError::ImageSize`] if size and pixels do not match or the image is empty.
///
/// ```
/// let red_dot = fabkit_export::png(1, 1, &[255, 0, 0])?;
/// assert_eq!(&red_dot[1..4], b"PNG");
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn png(width_px: u32, height_px: u32, rgb: &[u8]) -> Result<Vec<u8>, ExportError> {
    check(width_px, height_px, 3, rgb.len())?;
    encode(width_px, height_px, rgb, |encoder| {
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    })
}

/// Writes an 8-bit grey PNG, for masks, row by row from the top.
///
/// # Errors
/// [`ExportError::ImageSize`] if size and pixels do not match or the image is empty.
///
/// ```
/// let mask = fabkit_export::grey8_png(3, 2, &[0, 255, 0, 255, 0, 255])?;
/// // The header has width, height, bits per sample, and 0 for grey.
/// assert_eq!(mask[16..26], [0, 0, 0, 3, 0, 0, 0, 2, 8, 0]);
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn grey8_png(width_px: u32, height_px: u32, grey: &[u8]) -> Result<Vec<u8>, ExportError> {
    check(width_px, height_px, 1, grey.len())?;
    encode(width_px, height_px, grey, |encoder| encoder.set_color(png::ColorType::Grayscale))
}

/// Writes a 16-bit grey PNG, for values with a stated scale, row by row from the top.
///
/// # Errors
/// [`ExportError::ImageSize`] if size and pixels do not match or the image is empty.
///
/// ```
/// use fabkit_export::{ExportError, grey16_png};
///
/// let depth = grey16_png(2, 1, &[0, 65535])?;
/// assert_eq!(depth[24..26], [16, 0]);
/// assert!(matches!(grey16_png(2, 2, &[0; 3]), Err(ExportError::ImageSize { needed: 4, .. })));
/// # Ok::<(), ExportError>(())
/// ```
pub fn grey16_png(width_px: u32, height_px: u32, grey: &[u16]) -> Result<Vec<u8>, ExportError> {
    check(width_px, height_px, 1, grey.len())?;
    // PNG is big-endian.
    let data: Vec<u8> = grey.iter().flat_map(|value| value.to_be_bytes()).collect();
    encode(width_px, height_px, &data, |encoder| {
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
    })
}

/// Writes a grey or colour PNG with a `Comment` text that image tools show. `grey` holds one or three intensities per
/// pixel, 0 to 255; they are written with 8 bits, or with 16 where 255 becomes 65535.
///
/// # Errors
/// See [`grey16_png`]; also a comment that is not Latin-1.
///
/// ```
/// use fabkit_export::png_with_comment;
///
/// let grey = png_with_comment(2, 1, &[0.0, 127.5], true, "mean of 16 images")?;
/// assert_eq!(grey[24..26], [16, 0]); // 16 bits, grey
/// assert!(grey.windows(17).any(|text| text == b"mean of 16 images"));
/// let rgb = png_with_comment(2, 1, &[0.0, 10.0, 20.0, 30.0, 40.0, 50.0], false, "")?;
/// assert_eq!(rgb[24..26], [8, 2]); // 8 bits, RGB
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn png_with_comment(
    width_px: u32,
    height_px: u32,
    grey: &[f64],
    is_deep: bool,
    comment: &str,
) -> Result<Vec<u8>, ExportError> {
    let pixels = width_px as usize * height_px as usize;
    let is_colored = grey.len() == 3 * pixels;
    check(width_px, height_px, if is_colored { 3 } else { 1 }, grey.len())?;
    // 255 * 257 = 65535.
    let deep = |value: &f64| ((value * 257.0).round() as u16).to_be_bytes();
    let data: Vec<u8> = if is_deep {
        grey.iter().flat_map(deep).collect()
    } else {
        grey.iter().map(|value| value.round() as u8).collect()
    };
    // The closure cannot return the error of the text chunk, so it is kept for later.
    let mut unwritten = None;
    let bytes = encode(width_px, height_px, &data, |encoder| {
        encoder.set_color(if is_colored { png::ColorType::Rgb } else { png::ColorType::Grayscale });
        encoder.set_depth(if is_deep { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
        unwritten = encoder.add_text_chunk("Comment".to_owned(), comment.to_owned()).err();
    })?;
    match unwritten {
        Some(error) => Err(error.into()),
        None => Ok(bytes),
    }
}

fn check(width_px: u32, height_px: u32, channels: u64, found: usize) -> Result<(), ExportError> {
    let needed = channels * u64::from(width_px) * u64::from(height_px);
    if needed == 0 || needed != found as u64 {
        return Err(ExportError::ImageSize { width_px, height_px, needed, found });
    }
    Ok(())
}

/// Encodes an 8-bit image with fixed compression settings, unless `set` changes its depth.
fn encode(
    width_px: u32,
    height_px: u32,
    data: &[u8],
    set: impl FnOnce(&mut png::Encoder<&mut Vec<u8>>),
) -> Result<Vec<u8>, ExportError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width_px, height_px);
    encoder.set_depth(png::BitDepth::Eight);
    set(&mut encoder);
    // Set explicitly, so that another version's defaults do not change the bytes.
    encoder.set_filter(png::Filter::Adaptive);
    encoder.set_deflate_compression(png::DeflateCompression::Level(6));
    let mut writer = encoder.write_header()?;
    writer.write_image_data(data)?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back() {
        let (width_px, height_px) = (37u32, 23u32);
        let rgb: Vec<u8> = (0..3 * width_px * height_px).map(|i| (i * i / 7) as u8).collect();
        let bytes = png(width_px, height_px, &rgb).unwrap();
        assert_eq!(bytes, png(width_px, height_px, &rgb).unwrap());
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes[..])).read_info().unwrap();
        let mut read = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut read).unwrap();
        assert_eq!((info.width, info.height), (width_px, height_px));
        assert_eq!(read, rgb);
    }

    #[test]
    fn sixteen_bits_come_back() {
        let grey: Vec<u16> = (0..35u16).map(|i| i * 1873).collect();
        let bytes = grey16_png(7, 5, &grey).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes[..])).read_info().unwrap();
        let mut read = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut read).unwrap();
        let pairs = read.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
        assert!(pairs.eq(grey));
        assert!(grey16_png(7, 6, &[0; 35]).is_err());
    }

    #[test]
    fn sizes_that_do_not_match_are_refused() {
        assert!(matches!(png(2, 2, &[0; 11]), Err(ExportError::ImageSize { needed: 12, .. })));
        let grey = grey16_png(2, 2, &[0; 3]).unwrap_err().to_string();
        assert_eq!(grey, "2 x 2 pixels need 4 values, there are 3");
        assert!(matches!(png(0, 2, &[]), Err(ExportError::ImageSize { needed: 0, .. })));
        assert!(png(u32::MAX, u32::MAX, &[]).is_err());
    }
}
