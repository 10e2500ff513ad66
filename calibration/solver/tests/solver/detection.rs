//! Detection of pins in images with known truth.

use crate::support::{assembled, camera, captures, pins};
use fabkit_calibration::image::{GreyImage, ImageError};
use fabkit_calibration::model::Model;
use fabkit_calibration::pin_detection::{
    DetectionError, DetectionOptions, RejectionReason, background_cell_px, detect,
};
use fabkit_calibration::synthetic::SyntheticSensor;
use fabkit_geometry::sequences::SplitMix64;

fn bench(seed: u64) -> SyntheticSensor {
    SyntheticSensor::new(Model::new(camera(), assembled(90.0)), seed)
}

/// Changes each pixel by a function of its place.
fn changed(image: &GreyImage, change: impl Fn(usize, usize, f32) -> f32) -> GreyImage {
    let width = image.width_px();
    let values = image.values().iter().enumerate();
    let values = values.map(|(i, v)| change(i % width, i / width, *v)).collect();
    GreyImage::new(width as u32, image.height_px() as u32, values).unwrap()
}

#[test]
fn pins_are_found_where_they_are_in_any_light() {
    let pins = pins(&[("a", 0.5)]);
    let mut bench = bench(1);
    let reference = bench.reference(1.0).unwrap();
    let mut whitened = Vec::new();
    for (i, light) in [1.0, 0.7, 1.3].into_iter().enumerate() {
        let chosen = captures(&pins, 1, 5, &mut SplitMix64::new(i as u64)).remove(0);
        let capture = bench.capture(i, &chosen, light).unwrap();
        let found = detect(&reference, &capture.image, &DetectionOptions::default()).unwrap();
        assert_eq!(found.marks.kept().len(), 5, "light {light}: {:?}", found.rejected);
        for (hole, truth) in &capture.pins {
            let nearest = found
                .marks
                .kept()
                .iter()
                .min_by(|a, b| (a.pixel - truth).norm().total_cmp(&(b.pixel - truth).norm()));
            let error = nearest.unwrap().pixel - truth;
            // Oblique marks are not quite symmetric, which their sigma does not include.
            assert!(error.norm() < 0.35, "hole {hole}: {error}");
            whitened.push(error / nearest.unwrap().sigma_px);
        }
    }
    // Sigma is the image's noise: central marks must agree with it within an order of magnitude.
    whitened.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    assert!(whitened[3].norm() < 3.0, "{}", whitened[3]);
}

#[test]
fn reflections_rims_and_flicker_are_no_pins() {
    let pins = pins(&[("a", 0.5)]);
    let mut bench = bench(2);
    // A light source's reflection that saturates and moves, a bubble that stays, light that drifts across.
    let reference = bench.reference(1.0).unwrap();
    let reference = changed(&reference, |x, y, v| {
        let bubble = (x as f32 - 250.0).hypot(y as f32 - 300.0) < 8.0;
        let lamp = (x as f32 - 400.0).hypot(y as f32 - 300.0) < 14.0;
        if lamp {
            1.0
        } else if bubble {
            0.6 * v
        } else {
            v
        }
    });
    let chosen: Vec<_> = [1, 7, 12].iter().map(|i| &pins[*i]).collect();
    let capture = bench.capture(0, &chosen, 1.0).unwrap();
    let pressed = changed(&capture.image, |x, y, v| {
        let bubble = (x as f32 - 250.0).hypot(y as f32 - 300.0) < 8.0;
        let lamp = (x as f32 - 408.0).hypot(y as f32 - 300.0) < 14.0;
        let rim = ((x as f32 - 320.0).hypot(y as f32 - 240.0) - 200.0).abs() < 1.5;
        let drift = 1.0 + 0.25 * (y as f32 / 480.0 - 0.5);
        if lamp { 1.0 } else { v * drift * if bubble || rim { 0.6 } else { 1.0 } }
    });
    let found = detect(&reference, &pressed, &DetectionOptions::default()).unwrap();
    assert_eq!(found.marks.kept().len(), 3, "{:?}", found.marks);
    assert!(!found.rejected.is_empty());
    assert!(found.rejected.iter().all(|(_, reason)| *reason != RejectionReason::Hidden));
}

#[test]
fn nothing_is_found_where_nothing_touches() {
    let mut bench = bench(3);
    let reference = bench.reference(1.0).unwrap();
    let other = bench.reference(0.8).unwrap();
    let found = detect(&reference, &other, &DetectionOptions::default()).unwrap();
    assert!(found.marks.kept().is_empty() && found.rejected.is_empty());
}

#[test]
fn a_mark_cut_by_the_housing_is_less_certain() {
    let pins = pins(&[("a", 0.5)]);
    let mut bench = bench(4);
    let capture = bench.capture(0, &[&pins[0]], 1.0).unwrap();
    let truth = capture.pins[0].1;
    let edge = truth.x as usize + 2;
    let shade = |image: &GreyImage| changed(image, |x, _, v| if x > edge { 0.03 } else { v });
    let reference = bench.reference(1.0).unwrap();
    let options = DetectionOptions::default();
    let whole = detect(&reference, &capture.image, &options).unwrap().marks.kept()[0];
    let cut = detect(&shade(&reference), &shade(&capture.image), &options).unwrap();
    let cut = cut.marks.kept()[0];
    assert!(whole.hidden_outline < 0.05 && cut.hidden_outline > 0.1, "{cut:?}");
    assert!(cut.sigma_px > 5.0 * whole.sigma_px);
    assert!((cut.pixel - truth).norm() < 3.0 * cut.sigma_px, "{cut:?} {truth}");
}

#[test]
fn images_that_cannot_be_compared_are_refused() {
    let mut bench = bench(5);
    let reference = bench.reference(1.0).unwrap();
    let options = DetectionOptions::default();
    assert_eq!(detect(&reference, &reference, &options), Err(DetectionError::Identical));
    let small = GreyImage::new(320, 240, vec![0.5; 320 * 240]).unwrap();
    let error = detect(&reference, &small, &options).unwrap_err().to_string();
    assert_eq!(error, "[320, 240] px, but the reference has [640, 480] px");
    let white = changed(&reference, |_, _, _| 1.0);
    let error = detect(&reference, &white, &options).unwrap_err().to_string();
    assert!(error.contains("100.0 % is saturated"), "{error}");
    let black = changed(&reference, |x, _, _| x as f32 * 1e-6);
    assert!(matches!(
        detect(&black, &reference, &options),
        Err(DetectionError::Exposure { usable_percent, .. }) if usable_percent < 2.0
    ));
}

fn png_of(
    width: u32,
    height: u32,
    color: png::ColorType,
    depth: png::BitDepth,
    data: &[u8],
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

#[test]
fn twelve_bits_in_sixteen_are_refused() {
    use png::{BitDepth, ColorType};
    // The largest value of 12 bits, and then one more.
    let file = |value: u16| {
        let data: Vec<u8> = std::iter::repeat_n(value.to_be_bytes(), 64 * 64).flatten().collect();
        GreyImage::read(&png_of(64, 64, ColorType::Grayscale, BitDepth::Sixteen, &data))
    };
    let refused = file(4095).unwrap_err();
    assert_eq!(refused, ImageError::NarrowRange { largest: 4095, range: 65535 });
    assert!(refused.to_string().contains("multiply 12 bits in 16 by 16"), "{refused}");
    assert!(file(4096).is_ok() && file(0).is_ok());
}

#[test]
fn grey_and_colour_of_8_and_16_bits_are_read() {
    use png::{BitDepth, ColorType};
    let n = 64 * 64;
    let grey =
        GreyImage::read(&png_of(64, 64, ColorType::Grayscale, BitDepth::Eight, &vec![51; n]));
    assert!((grey.unwrap().at(3, 5) - 0.2).abs() < 1e-6);
    let deep = png_of(64, 64, ColorType::Grayscale, BitDepth::Sixteen, &[0x40, 0x00].repeat(n));
    assert!((GreyImage::read(&deep).unwrap().at(0, 0) - 16384.0 / 65535.0).abs() < 1e-6);
    let rgb = png_of(64, 64, ColorType::Rgb, BitDepth::Eight, &[255, 0, 0].repeat(n));
    assert!((GreyImage::read(&rgb).unwrap().at(63, 63) - 0.2126).abs() < 1e-6);
    let clear = png_of(64, 64, ColorType::Rgba, BitDepth::Eight, &[0, 255, 0, 7].repeat(n));
    assert!((GreyImage::read(&clear).unwrap().at(63, 63) - 0.7152).abs() < 1e-6);
}

#[test]
fn broken_and_absurd_images_are_refused() {
    use png::{BitDepth, ColorType};
    let whole = png_of(64, 64, ColorType::Grayscale, BitDepth::Eight, &[51; 64 * 64]);
    for broken in [&b""[..], b"not a png", &whole[..40], &whole[..whole.len() / 2]] {
        assert!(matches!(GreyImage::read(broken), Err(ImageError::Unreadable(_))));
    }
    let tiny = png_of(8, 64, ColorType::Grayscale, BitDepth::Eight, &[51; 8 * 64]);
    let error = GreyImage::read(&tiny).unwrap_err().to_string();
    assert!(error.starts_with("8 x 64 px; sides are 64 px to 16384 px"), "{error}");
    // A header that promises 60000 x 60000 px is refused before memory is asked for.
    let mut huge = whole.clone();
    huge[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
    assert!(GreyImage::read(&huge).is_err());
}

#[test]
fn a_mark_in_a_part_of_an_image_is_the_mark_in_the_whole() {
    let mut random = SplitMix64::new(5);
    for [width, height] in [[640, 480], [320, 400]] {
        let cell = background_cell_px(width.min(height));
        let at = [0.4 + 0.2 * random.unit(), 0.4 + 0.2 * random.unit()];
        let at = [at[0] * width as f64, at[1] * height as f64];
        let wide_px = 0.012 * width.min(height) as f64;
        let picture = |first: [usize; 2], size: [usize; 2], depth: f64| {
            let value = |i: usize| {
                let place = [first[0] + i % size[0], first[1] + i / size[0]];
                let off = [0, 1].map(|axis| place[axis] as f64 - at[axis]);
                let mark = (-(off[0] * off[0] + off[1] * off[1]) / (2.0 * wide_px * wide_px)).exp();
                (0.5 * (1.0 - depth * mark)) as f32
            };
            let values = (0..size[0] * size[1]).map(value).collect();
            GreyImage::new(size[0] as u32, size[1] as u32, values).unwrap()
        };
        let found = |first, size, part_of_px| {
            let options = DetectionOptions { part_of_px, ..DetectionOptions::default() };
            let [rest, pressed] = [0.0, 0.4].map(|depth| picture(first, size, depth));
            let marks = detect(&rest, &pressed, &options).unwrap().marks;
            assert_eq!(marks.kept().len(), 1, "{width} x {height}");
            marks.kept()[0]
        };
        let whole = found([0, 0], [width, height], None);
        let first = at.map(|px| (px as usize - 80) / cell * cell);
        let part = found(first, [160, 160], Some(width.min(height) as u32));
        // The same numbers from the same pixels, but that cells at the part's end are cut.
        let off = [0, 1].map(|axis| part.pixel[axis] + first[axis] as f64 - whole.pixel[axis]);
        assert!(off[0].hypot(off[1]) < 1e-9, "{off:?}");
        assert_eq!([part.contrast, part.diameter_px], [whole.contrast, whole.diameter_px]);
    }
}

/// A fifth of the lit surface is white, whatever is dark around it.
#[test]
fn what_is_saturated_of_what_is_lit_is_told() {
    let picture = |depth: f64| {
        let value = |i: usize| {
            let (x, y) = ((i % 250) as f64, (i / 250) as f64);
            if x < 50.0 {
                return 0.0;
            }
            let lit = if x < 90.0 { 1.0 } else { 0.6 + 0.002 * ((7 * i) % 13) as f64 / 13.0 };
            let r2 = (x - 180.0).powi(2) + (y - 75.0).powi(2);
            (lit * (1.0 - depth * (-r2 / 18.0).exp())) as f32
        };
        GreyImage::new(250, 150, (0..250 * 150).map(value).collect()).unwrap()
    };
    let found = detect(&picture(0.0), &picture(0.4), &DetectionOptions::default()).unwrap();
    assert_eq!(found.marks.kept().len(), 1);
    assert!((found.saturated_fraction - 0.2).abs() < 1e-12, "{}", found.saturated_fraction);
}

/// Two images of a board of 9 x 7 dots, without and with contact, whose dots take these parts of the light. `rounding`
/// changes what is left after that.
fn board(
    dark: impl Fn(usize) -> f64,
    noise: f64,
    rounding: impl Fn(usize, usize) -> f64,
) -> [GreyImage; 2] {
    let mut random = SplitMix64::new(11);
    [0.0, 1.0].map(|pressed| {
        let value = |i: usize| {
            let (x, y) = ((i % 640) as f64, (i / 640) as f64);
            let light =
                0.65 - 0.1 * (((x - 320.0) / 420.0).powi(2) + ((y - 240.0) / 330.0).powi(2));
            let column = ((x - 120.0) / 50.0).round().clamp(0.0, 8.0);
            let row = ((y - 75.0) / 55.0).round().clamp(0.0, 6.0);
            let far = (x - 120.0 - 50.0 * column).powi(2) + (y - 75.0 - 55.0 * row).powi(2);
            let part = pressed * dark((9.0 * row + column) as usize) * (-far / 162.0).exp();
            let grey = light * (1.0 - part) + noise * random.normal();
            (grey + pressed * rounding(i % 640, i / 640)) as f32
        };
        GreyImage::new(640, 480, (0..640 * 480).map(value).collect()).unwrap()
    })
}

/// Dots that are 7 % darker fill the image, and none is dropped because it is faint.
#[test]
fn faint_dots_are_found_where_all_are_faint() {
    let [rest, pressed] = board(|_| 0.07, 0.003, |_, _| 0.0);
    let found = detect(&rest, &pressed, &DetectionOptions::default()).unwrap();
    assert_eq!((found.marks.kept().len(), found.marks.left_out().len()), (63, 0));
    let least = found.marks.kept().iter().map(|mark| mark.significance.sigmas());
    assert!(least.fold(f64::INFINITY, f64::min) > 10.0);
}

#[test]
fn dots_that_are_much_fainter_than_others_are_counted() {
    let [rest, pressed] = board(|dot| if dot % 5 == 3 { 0.04 } else { 0.3 }, 0.002, |_, _| 0.0);
    let found = detect(&rest, &pressed, &DetectionOptions::default()).unwrap();
    let left_out = found.marks.summary();
    assert_eq!((found.marks.kept().len(), left_out.count), (51, 12));
    // Smoothing and the floor against the dark take a part of the 4 %.
    assert!((0.03..0.04).contains(&left_out.max_contrast), "{left_out}");
}
