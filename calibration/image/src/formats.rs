//! The decoder of each file format, and the JPEG encoder.

use std::io::Cursor;

use tiff::decoder::DecodingResult;
use tiff::tags::{PlanarConfiguration, Tag};
use zune_bmp::BmpDecoder;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use crate::{ImageFileError, PixelValues};

/// Memory that a decoder may use besides the image itself, bytes: rows, palettes, texts.
const DECODER_OVERHEAD_BYTES: usize = 32 << 20;
/// Size of the widest pixels that are decoded, bytes: four values of 16 bits.
const MAX_PIXEL_BYTES: usize = 8;

/// Encodes an image as JPEG; see [`crate::encode_jpeg`].
pub(crate) fn encode_jpeg(
    size_px: [u32; 2],
    values: &[u8],
    quality: u8,
) -> Result<Vec<u8>, ImageFileError> {
    let wrong = |reason: &str| Format::Jpeg.unreadable(reason);
    // A side above 65,535 px becomes 0, so that no number of channels fits and it is refused below.
    let [width, height] = size_px.map(|px| u16::try_from(px).unwrap_or(0));
    let pixels = usize::from(width) * usize::from(height);
    let color = match values.len().checked_div(pixels) {
        Some(1) => jpeg_encoder::ColorType::Luma,
        Some(3) => jpeg_encoder::ColorType::Rgb,
        _ => return Err(wrong("such an image cannot be written")),
    };
    let mut file = Vec::new();
    let mut encoder = jpeg_encoder::Encoder::new(&mut file, quality.clamp(1, 100));
    encoder.set_sampling_factor(jpeg_encoder::SamplingFactor::F_1_1);
    encoder.encode(values, width, height, color).map_err(|e| wrong(&e.to_string()))?;
    Ok(file)
}

/// Format of an image file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Png,
    Jpeg,
    Tiff,
    Bmp,
}

/// Samples per pixel, and the values of all pixels.
type Decoded = (usize, PixelValues);

impl Format {
    /// Recognises a format by the first bytes of a file.
    pub(crate) fn from_first_bytes(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'I', b'I', 42, 0, ..] | [b'M', b'M', 0, 42, ..] => Some(Self::Tiff),
            [b'B', b'M', ..] => Some(Self::Bmp),
            _ => None,
        }
    }

    /// Creates an error for a file of this format.
    pub(crate) fn unreadable(self, reason: impl ToString) -> ImageFileError {
        let format = match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
            Self::Bmp => "BMP",
        };
        ImageFileError::Unreadable { format, reason: reason.to_string() }
    }

    /// Reads width and height, px, from the header.
    pub(crate) fn size_px(self, bytes: &[u8]) -> Result<[u32; 2], ImageFileError> {
        let wrong = |reason: String| self.unreadable(reason);
        let small = |(width, height): (usize, usize)| {
            let sides = [u32::try_from(width).ok(), u32::try_from(height).ok()];
            sides[0].zip(sides[1]).map(|(w, h)| [w, h]).ok_or_else(|| wrong("its sides".into()))
        };
        match self {
            Self::Png => {
                let mut decoder = png(bytes);
                let header = decoder.read_header_info().map_err(|e| wrong(e.to_string()))?;
                // The header alone tells the size: nothing is decoded yet.
                Ok([header.width, header.height])
            }
            Self::Jpeg => {
                let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options());
                decoder.decode_headers().map_err(|e| wrong(e.to_string()))?;
                let info = decoder.info().ok_or_else(|| wrong("it has no size".into()))?;
                Ok([info.width.into(), info.height.into()])
            }
            Self::Tiff => {
                let size = tiff::decoder::Decoder::new(Cursor::new(bytes))
                    .and_then(|mut decoder| decoder.dimensions());
                size.map(|(width, height)| [width, height]).map_err(|e| wrong(e.to_string()))
            }
            Self::Bmp => {
                let mut decoder = BmpDecoder::new_with_options(ZCursor::new(bytes), options());
                decoder.decode_headers().map_err(|e| wrong(format!("{e:?}")))?;
                small(decoder.dimensions().ok_or_else(|| wrong("it has no size".into()))?)
            }
        }
    }

    /// Decodes the values of all pixels. The caller has checked the size before.
    pub(crate) fn values(self, bytes: &[u8]) -> Result<Decoded, ImageFileError> {
        match self {
            Self::Png => decode_png(bytes).map_err(|e| self.unreadable(e)),
            Self::Jpeg => self.decode_jpeg(bytes),
            Self::Tiff => self.decode_tiff(bytes),
            Self::Bmp => self.decode_bmp(bytes),
        }
    }

    /// Decodes a JPEG file.
    fn decode_jpeg(self, bytes: &[u8]) -> Result<Decoded, ImageFileError> {
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options());
        decoder.decode_headers().map_err(|e| self.unreadable(e))?;
        // Every colour space (YCbCr, CMYK) is converted to RGB; greyscale stays a single channel.
        let grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
        let space = if grey { ColorSpace::Luma } else { ColorSpace::RGB };
        decoder.set_options(options().jpeg_set_out_colorspace(space));
        let values = decoder.decode().map_err(|e| self.unreadable(e))?;
        Ok((if grey { 1 } else { 3 }, PixelValues::U8(values)))
    }

    fn decode_bmp(self, bytes: &[u8]) -> Result<Decoded, ImageFileError> {
        let mut decoder = BmpDecoder::new_with_options(ZCursor::new(bytes), options());
        let values = decoder.decode().map_err(|e| self.unreadable(format!("{e:?}")))?;
        let space = decoder.colorspace().ok_or_else(|| self.unreadable("it has no colours"))?;
        Ok((space.num_components(), PixelValues::U8(values)))
    }

    /// Decodes a TIFF file.
    fn decode_tiff(self, bytes: &[u8]) -> Result<Decoded, ImageFileError> {
        use tiff::ColorType::{Gray, GrayA, RGB, RGBA};
        let wrong = |e: tiff::TiffError| self.unreadable(e);
        let mut decoder = tiff::decoder::Decoder::new(Cursor::new(bytes)).map_err(wrong)?;
        let (width, height) = decoder.dimensions().map_err(wrong)?;
        let mut limits = tiff::decoder::Limits::default();
        limits.decoding_buffer_size = MAX_PIXEL_BYTES * width as usize * height as usize;
        limits.intermediate_buffer_size = limits.decoding_buffer_size + DECODER_OVERHEAD_BYTES;
        decoder = decoder.with_limits(limits);
        let samples = match decoder.colortype().map_err(wrong)? {
            Gray(8 | 16) => 1,
            GrayA(8 | 16) => 2,
            RGB(8 | 16) => 3,
            RGBA(8 | 16) => 4,
            other => {
                let reason = format!("{other:?}; write greyscale or RGB of 8 or 16 bits");
                return Err(self.unreadable(reason));
            }
        };
        // From a file with separate colour planes the `tiff` crate decodes only the first plane.
        let planes: Option<u16> =
            decoder.find_tag_unsigned(Tag::PlanarConfiguration).map_err(wrong)?;
        if samples > 1 && planes == Some(PlanarConfiguration::Planar.to_u16()) {
            return Err(self.unreadable("colours in separate planes; write them pixel by pixel"));
        }
        match decoder.read_image().map_err(wrong)? {
            DecodingResult::U8(values) => Ok((samples, PixelValues::U8(values))),
            DecodingResult::U16(values) => Ok((samples, PixelValues::U16(values))),
            _ => Err(self.unreadable("values that are no whole numbers of 8 or 16 bits")),
        }
    }
}

/// Returns the decoder options for JPEG and BMP. The limit of 65,536 px per side is loose on purpose: the caller checks
/// the number of pixels.
fn options() -> DecoderOptions {
    DecoderOptions::default().set_max_width(1 << 16).set_max_height(1 << 16).set_strict_mode(true)
}

fn png(bytes: &[u8]) -> png::Decoder<Cursor<&[u8]>> {
    let limits = png::Limits { bytes: DECODER_OVERHEAD_BYTES };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    // Palettes and depths below 8 bits are expanded to 8 bits.
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder
}

/// Decodes a PNG file.
fn decode_png(bytes: &[u8]) -> Result<Decoded, png::DecodingError> {
    let mut reader = png(bytes).read_info()?;
    let size = reader.output_buffer_size().ok_or(png::DecodingError::LimitsExceeded)?;
    let mut values = vec![0; size];
    let frame = reader.next_frame(&mut values)?;
    // An image of an animation may be smaller than the buffer that the header announces.
    values.truncate(frame.buffer_size());
    let values = match frame.bit_depth {
        png::BitDepth::Sixteen => {
            // PNG stores 16-bit samples in big-endian order.
            let (pairs, _) = values.as_chunks::<2>();
            PixelValues::U16(pairs.iter().map(|pair| u16::from_be_bytes(*pair)).collect())
        }
        _ => PixelValues::U8(values),
    };
    Ok((frame.color_type.samples(), values))
}
