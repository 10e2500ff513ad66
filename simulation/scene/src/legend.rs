//! Text and legends drawn on images.

use fabkit_depth::RenderedImage;

const INK: [u8; 3] = [30, 30, 36];
const PAPER: [u8; 3] = [255, 255, 255];

/// An entry of a legend: a colour, its meaning and its number of occurrences.
pub struct LegendEntry {
    /// Label of the entry.
    pub name: String,
    /// Colour as red, green and blue.
    pub color: [u8; 3],
    /// Number of occurrences.
    pub count: usize,
}

/// Draws one line of text with capitals `height_px` high. `[left, top]` is the top left corner of the text.
pub fn write(image: &mut RenderedImage, text: &str, [left, top]: [f64; 2], height_px: f64) {
    for stroke in fabkit_export::lettering(text, height_px) {
        let points: Vec<[f64; 2]> =
            stroke.iter().map(|[x, y]| [left + x, top + height_px - y]).collect();
        image.draw_line(&points, (height_px / 8.0).max(1.0), INK);
    }
}

/// Returns the width of a line of text, px.
///
/// ```
/// use fabkit_scene::legend::width_px;
/// assert_eq!(width_px("", 7.0), 0.0);
/// // Letters scale with the height of capitals.
/// assert!((width_px("gel", 14.0) - 2.0 * width_px("gel", 7.0)).abs() < 1e-9);
/// ```
pub fn width_px(text: &str, height_px: f64) -> f64 {
    let ends = fabkit_export::lettering(text, height_px);
    ends.iter().flatten().fold(0.0, |most: f64, [x, _]| most.max(*x))
}

/// Draws a legend of colours and labels in the top left corner, sized to the image.
pub fn draw(image: &mut RenderedImage, entries: &[([u8; 3], String)]) {
    let height_px = (f64::from(image.height_px) / 66.0).max(7.0);
    draw_at(image, entries, [height_px, height_px], height_px);
}

/// Draws a legend with its top left corner at `[left, top]` and capitals `height_px` high.
pub fn draw_at(
    image: &mut RenderedImage,
    entries: &[([u8; 3], String)],
    [left, top]: [f64; 2],
    height_px: f64,
) {
    // Distances below are multiples of the height of capitals.
    let pitch_px = 1.9 * height_px;
    let widest = entries.iter().map(|(_, text)| width_px(text, height_px)).fold(0.0, f64::max);
    let right_bottom =
        [left + 4.0 * height_px + widest, top + pitch_px * entries.len() as f64 + 0.9 * height_px];
    let px = |place: [f64; 2]| place.map(|value| value.round() as i64);
    image.fill(px([left, top]), px(right_bottom), PAPER);
    for (row, (color, text)) in entries.iter().enumerate() {
        let y = top + 0.9 * height_px + pitch_px * row as f64;
        let swatch = [left + height_px, y];
        let end = [left + 2.4 * height_px, y + height_px];
        image.fill(px([swatch[0] - 1.0, swatch[1] - 1.0]), px([end[0] + 1.0, end[1] + 1.0]), INK);
        image.fill(px(swatch), px(end), *color);
        write(image, text, [left + 3.2 * height_px, y], height_px);
    }
}
