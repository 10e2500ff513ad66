//! Images of 16 x 12 px that another library (Pillow) wrote in each format.

use fabkit_image::{DecodedImage, ImageFileError, PixelValues, read, read_size_px};

macro_rules! file {
    ($name:literal) => {
        ($name, &include_bytes!(concat!("data/", $name))[..])
    };
}

const PIXELS: u64 = 16 * 12;

/// Returns an image whose red rises to the right, green downwards, and whose blue falls along both.
fn colour() -> DecodedImage {
    let at = |x: u8, y: u8| [15 * x, 20 * y, 255 - 9 * (x + y)];
    let values = (0..12).flat_map(|y| (0..16).flat_map(move |x| at(x, y))).collect();
    DecodedImage { width_px: 16, height_px: 12, channels: 3, values: PixelValues::U8(values) }
}

fn grey() -> DecodedImage {
    let values = (0..12u8).flat_map(|y| (0..16u8).map(move |x| 10 * x + 8 * y)).collect();
    DecodedImage { channels: 1, values: PixelValues::U8(values), ..colour() }
}

fn deep() -> DecodedImage {
    let values = (0..12u16).flat_map(|y| (0..16u16).map(move |x| 4000 * x + 300 * y)).collect();
    DecodedImage { channels: 1, values: PixelValues::U16(values), ..colour() }
}

#[test]
fn values_are_those_of_the_image_in_every_format_without_loss() {
    let cases = [
        (file!("colour.png"), colour()),
        (file!("alpha.png"), colour()),
        (file!("colour.tif"), colour()),
        (file!("alpha.tif"), colour()),
        (file!("colour.bmp"), colour()),
        (file!("alpha.bmp"), colour()),
        (file!("grey.png"), grey()),
        (file!("grey.tif"), grey()),
        (file!("deep.png"), deep()),
        (file!("deep.tif"), deep()),
    ];
    for ((name, bytes), expected) in cases {
        assert_eq!(read_size_px(bytes), Ok([16, 12]), "{name}");
        assert_eq!(read(bytes, PIXELS), Ok(expected), "{name}");
    }
    // Its palette makes colours of its greys.
    let (_, bytes) = file!("grey.bmp");
    let greys = read(bytes, PIXELS).unwrap();
    for i in 0..PIXELS as usize {
        assert_eq!(greys.values.get(3 * i + 1), grey().values.get(i));
    }
}

#[test]
fn a_jpeg_is_as_near_as_its_quality_allows() {
    let cases = [
        (file!("colour.jpg"), colour()),
        (file!("progressive.jpg"), colour()),
        (file!("grey.jpg"), grey()),
    ];
    for ((name, bytes), expected) in cases {
        let found = read(bytes, PIXELS).unwrap();
        assert_eq!(
            (found.channels, found.values.len()),
            (expected.channels, expected.values.len())
        );
        // At quality 95 a coefficient is at most some 3 of 255 off, and a pixel sees several.
        let off = |i| (found.values.get(i).unwrap() - expected.values.get(i).unwrap()).abs();
        let worst = (0..found.values.len()).map(off).fold(0.0, f32::max);
        assert!(worst < 8.0 / 255.0, "{name}: {worst}");
    }
}

#[test]
fn what_cannot_be_read_is_refused_by_name() {
    let says = |(name, bytes): (&str, &[u8]), word: &str| {
        let error = read(bytes, PIXELS).unwrap_err().to_string();
        assert!(error.contains(word), "{name}: {error}");
    };
    says(
        file!("float.tif"),
        "not a readable TIFF: Gray(32); write greyscale or RGB of 8 or 16 bits",
    );
    says(file!("planar.tif"), "colours in separate planes");
    says(("text", b"no image"), "not a readable PNG, JPEG, TIFF or BMP image");
    let (_, bytes) = file!("colour.bmp");
    let most = PIXELS - 1;
    let too_large = ImageFileError::TooLarge { width_px: 16, height_px: 12, max_pixels: most };
    assert_eq!(read(bytes, most), Err(too_large));
}

#[test]
fn half_a_file_is_no_image() {
    for (name, bytes) in [
        file!("colour.png"),
        file!("colour.jpg"),
        file!("progressive.jpg"),
        file!("colour.tif"),
        file!("colour.bmp"),
    ] {
        for part in [1, 3, 8, 20, bytes.len() / 2] {
            assert!(read(&bytes[..part], PIXELS).is_err(), "{name}: {part} of {}", bytes.len());
        }
    }
}
