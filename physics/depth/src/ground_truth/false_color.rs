//! False-colour images of maps, with a scale in millimetres.

use crate::RenderedImage;

/// Anchors of the colour scale, sRGB. Lightness rises evenly from dark violet to yellow, so that it also reads in grey
/// and with any colour vision.
const SCALE: [[u8; 3]; 6] =
    [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]];

/// Colour of pixels without a value.
const NOTHING: [u8; 3] = [236, 236, 240];
const PAPER: [u8; 3] = [255, 255, 255];
const INK: [u8; 3] = [30, 30, 36];

/// Width of the margin that holds the scale, and of the scale's bar in it, px.
const MARGIN_PX: u32 = 84;
const BAR_PX: u32 = 14;
const TICKS: u32 = 5;

/// Glyphs of 3 x 5 dots, one bit each, the first row in the highest bits; drawn at twice their size.
const GLYPHS: [(char, u16); 13] = [
    ('0', 0b111_101_101_101_111),
    ('1', 0b010_110_010_010_111),
    ('2', 0b111_001_111_100_111),
    ('3', 0b111_001_111_001_111),
    ('4', 0b101_101_111_001_001),
    ('5', 0b111_100_111_001_111),
    ('6', 0b111_100_111_101_111),
    ('7', 0b111_001_010_010_010),
    ('8', 0b111_101_111_101_111),
    ('9', 0b111_101_111_001_111),
    ('.', 0b000_000_000_000_010),
    ('-', 0b000_000_111_000_000),
    ('m', 0b000_000_111_111_101),
];
const DOT_PX: u32 = 2;

/// Returns the colour of a value between `low` and `high`.
///
/// ```
/// use fabkit_depth::ground_truth::scale_color;
///
/// // Dark violet at the lower end, yellow at the upper one and beyond; what has no value is light grey.
/// let color = |depth_mm| scale_color(depth_mm, [0.0, 1.5]);
/// assert_eq!((color(0.0), color(1.5), color(9.0)), ([68, 1, 84], [253, 231, 37], [253, 231, 37]));
/// assert_eq!(color(f64::NAN), [236, 236, 240]);
/// ```
pub fn scale_color(value: f64, [low, high]: [f64; 2]) -> [u8; 3] {
    if !value.is_finite() {
        return NOTHING;
    }
    let last = (SCALE.len() - 1) as f64;
    let at = if high > low { (value - low) / (high - low) } else { 0.0 };
    let at = at.clamp(0.0, 1.0) * last;
    let below = (at.floor() as usize).min(SCALE.len() - 2);
    let share = at - below as f64;
    std::array::from_fn(|i| {
        let [a, b] = [SCALE[below][i], SCALE[below + 1][i]].map(f64::from);
        (a + share * (b - a)).round() as u8
    })
}

/// Draws a map, in millimetres, row by row, with a scale on its right; `NaN` pixels stay blank.
///
/// `range_mm` sets the ends of the scale; without it they are the smallest and the largest value.
///
/// ```
/// use fabkit_depth::ground_truth::{false_color, scale_color};
///
/// // A map of 40 x 30 pixels that rises from 0 to 1 mm; the scale is drawn on its right.
/// let depths_mm: Vec<f64> = (0..1200).map(|pixel| f64::from(pixel % 40) / 39.0).collect();
/// let image = false_color(40, &depths_mm, None);
/// assert!(image.width_px > 40 && image.height_px == 30);
/// assert_eq!(image.pixel(39, 12), scale_color(1.0, [0.0, 1.0]));
/// ```
pub fn false_color(width_px: u32, values_mm: &[f64], range_mm: Option<[f64; 2]>) -> RenderedImage {
    let height_px = values_mm.len() as u32 / width_px.max(1);
    let finite = values_mm.iter().copied().filter(|value| value.is_finite());
    let found = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    });
    let range = range_mm.unwrap_or(if found[0] <= found[1] { found } else { [0.0, 1.0] });
    let mut canvas = Canvas::new(width_px + MARGIN_PX, height_px);
    for (pixel, &value) in values_mm.iter().enumerate() {
        let (column, row) = (pixel as u32 % width_px, pixel as u32 / width_px);
        canvas.set(column, row, scale_color(value, range));
    }
    let glyph_px = 5 * DOT_PX;
    let (top, bottom) = (glyph_px, height_px.saturating_sub(2 * glyph_px).max(glyph_px + 1));
    let left = width_px + 8;
    for row in top..bottom {
        // The largest value is at the top.
        let share = f64::from(bottom - 1 - row) / f64::from((bottom - 1 - top).max(1));
        let color = scale_color(range[0] + share * (range[1] - range[0]), range);
        (left..left + BAR_PX).for_each(|column| canvas.set(column, row, color));
    }
    for tick in 0..TICKS {
        let share = f64::from(tick) / f64::from(TICKS - 1);
        let row = f64::from(bottom - 1) - share * f64::from(bottom - 1 - top);
        let row = row.round() as u32;
        canvas.set(left + BAR_PX, row, INK);
        canvas.set(left + BAR_PX + 1, row, INK);
        let text = format!("{:.3}", range[0] + share * (range[1] - range[0]));
        canvas.write(&text, left + BAR_PX + 5, row.saturating_sub(glyph_px / 2));
    }
    canvas.write("mm", left, height_px.saturating_sub(glyph_px + 3));
    canvas.image
}

struct Canvas {
    image: RenderedImage,
}

impl Canvas {
    fn new(width_px: u32, height_px: u32) -> Self {
        let rgb = PAPER.repeat(width_px as usize * height_px as usize);
        Self { image: RenderedImage { width_px, height_px, rgb } }
    }

    /// Sets a pixel; pixels outside the image are ignored.
    fn set(&mut self, column: u32, row: u32, color: [u8; 3]) {
        let RenderedImage { width_px, height_px, rgb } = &mut self.image;
        if column < *width_px && row < *height_px {
            let at = 3 * (row as usize * *width_px as usize + column as usize);
            rgb[at..at + 3].copy_from_slice(&color);
        }
    }

    /// Writes a text with its top left corner at a pixel.
    fn write(&mut self, text: &str, left: u32, top: u32) {
        for (i, c) in text.chars().enumerate() {
            let Some((_, dots)) = GLYPHS.iter().find(|(glyph, _)| *glyph == c) else { continue };
            for place in 0..15u32 {
                if dots >> (14 - place) & 1 == 1 {
                    let column = left + (4 * i as u32 + place % 3) * DOT_PX;
                    let row = top + (place / 3) * DOT_PX;
                    for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        self.set(column + x, row + y, INK);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_runs_from_end_to_end_and_grows_lighter() {
        assert_eq!(scale_color(0.0, [0.0, 2.0]), SCALE[0]);
        assert_eq!(scale_color(2.0, [0.0, 2.0]), SCALE[5]);
        assert_eq!(scale_color(9.0, [0.0, 2.0]), SCALE[5]);
        assert_eq!(scale_color(f64::NAN, [0.0, 2.0]), NOTHING);
        let luma = |[r, g, b]: [u8; 3]| {
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        let steps: Vec<f64> =
            (0..=20).map(|i| luma(scale_color(f64::from(i), [0.0, 20.0]))).collect();
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn a_map_keeps_its_pixels_and_gains_a_scale() {
        let values: Vec<f64> = (0..40 * 60).map(|i| f64::from(i % 40)).collect();
        let image = false_color(40, &values, None);
        assert_eq!((image.width_px, image.height_px), (40 + MARGIN_PX, 60));
        assert_eq!(image.pixel(0, 7), SCALE[0]);
        assert_eq!(image.pixel(39, 7), SCALE[5]);
        let inked = (40..40 + MARGIN_PX).flat_map(|x| (0..60).map(move |y| (x, y)));
        assert!(inked.filter(|(x, y)| image.pixel(*x, *y) == INK).count() > 100);
    }
}
