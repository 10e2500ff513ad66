//! Small drawings as inline SVG.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

// Styles are attributes instead of style sheets, which some programs that print HTML do not apply to drawings.

/// Style of an image's border.
pub const BORDER_STYLE: &str = r##"fill="#fafafa" stroke="#999""##;
/// Style of a part of an image without data.
pub const NO_DATA_STYLE: &str = r##"fill="#fbe9d0""##;
/// Style of a residual vector.
pub const RESIDUAL_STYLE: &str = r##"stroke="#c0392b" stroke-width="1.4""##;
/// Style of a line at the lower bound that no model can undercut.
pub const LOWER_BOUND_STYLE: &str = r##"stroke="#d89b00" stroke-dasharray="5 4""##;

/// A drawing under construction.
///
/// ```
/// use fabkit_report::Svg;
/// let mut drawing = Svg::new(40.0, 20.0);
/// drawing.line([0.0, 0.0], [40.0, 20.0], "stroke=\"#222\"");
/// let element = drawing.finish("a line from the upper left to the lower right");
/// assert!(element.starts_with("<svg viewBox=\"0 0 40 20\" role=\"img\""));
/// assert!(element.contains("x2=\"40.0\" y2=\"20.0\""));
/// ```
#[derive(Clone, Debug)]
pub struct Svg {
    /// Coordinates of the upper left corner.
    corner: [f64; 2],
    width: f64,
    height: f64,
    body: String,
}

impl Svg {
    /// Creates an empty drawing of a size in px.
    pub fn new(width: f64, height: f64) -> Self {
        Self { corner: [0.0; 2], width, height, body: String::new() }
    }

    /// Creates a drawing over a camera's image, with its border. Coordinates are those of its pixels, whose centres are
    /// whole numbers: the drawing reaches from -0.5 to half a pixel beyond the last centre.
    ///
    /// ```
    /// use fabkit_report::Svg;
    /// let mut drawing = Svg::over_image([640, 480]);
    /// drawing.dot([0.0, 0.0], 0.5, "#1f4e79", "the first pixel");
    /// let element = drawing.finish("an image");
    /// assert!(element.starts_with("<svg viewBox=\"-0.5 -0.5 640 480\""));
    /// assert!(element.contains("x=\"-0.5\" y=\"-0.5\" width=\"640.0\"") && element.contains("cx=\"0.0\""));
    /// ```
    pub fn over_image(size_px: [u32; 2]) -> Self {
        let [width, height] = size_px.map(f64::from);
        let mut drawing = Self { corner: [-0.5; 2], ..Self::new(width, height) };
        drawing.rect(drawing.corner, [width, height], BORDER_STYLE);
        drawing
    }

    /// Returns the corner of a cell and its size, of an image divided evenly into columns and rows of cells; cells are
    /// counted row by row.
    ///
    /// ```
    /// // Two by two cells over 4 x 4 pixels: the last begins between pixels 1 and 2.
    /// let drawing = fabkit_report::Svg::over_image([4, 4]);
    /// assert_eq!(drawing.grid_cell(3, [2, 2]), ([1.5, 1.5], [2.0, 2.0]));
    /// ```
    pub fn grid_cell(&self, number: usize, [columns, rows]: [usize; 2]) -> ([f64; 2], [f64; 2]) {
        let size = [self.width / columns as f64, self.height / rows as f64];
        let at = [number % columns, number / columns];
        ([0, 1].map(|axis| self.corner[axis] + at[axis] as f64 * size[axis]), size)
    }

    /// Draws a straight line; `style` holds SVG attributes.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], style: &str) {
        let _ = write!(
            self.body,
            r#"<line {style} x1="{:.1}" y1="{:.1}" x2="{:.1}" y2="{:.1}"/>"#,
            from[0], from[1], to[0], to[1]
        );
    }

    /// Draws a filled circle with a tooltip.
    ///
    /// ```
    /// let mut drawing = fabkit_report::Svg::new(10.0, 10.0);
    /// drawing.dot([5.0, 5.0], 2.0, "#1f4e79", "residual < 0.1 px");
    /// let element = drawing.finish("one point");
    /// assert!(element.contains("<title>residual &lt; 0.1 px</title>"));
    /// ```
    pub fn dot(&mut self, centre: [f64; 2], radius: f64, fill: &str, title: &str) {
        let _ = write!(
            self.body,
            r#"<circle cx="{:.1}" cy="{:.1}" r="{radius:.1}" fill="{fill}"><title>{}</title></circle>"#,
            centre[0],
            centre[1],
            escape(title)
        );
    }

    /// Draws a rectangle from its upper left corner; `style` holds SVG attributes.
    ///
    /// ```
    /// use fabkit_report::{BORDER_STYLE, Svg};
    /// let mut drawing = Svg::new(64.0, 48.0);
    /// drawing.rect([2.0, 2.0], [60.0, 44.0], BORDER_STYLE);
    /// assert!(drawing.finish("an image's border").contains("x=\"2.0\" y=\"2.0\" width=\"60.0\""));
    /// ```
    pub fn rect(&mut self, corner: [f64; 2], size: [f64; 2], style: &str) {
        let _ = write!(
            self.body,
            r#"<rect {style} x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}"/>"#,
            corner[0], corner[1], size[0], size[1]
        );
    }

    /// Draws a filled rectangle from its upper left corner, with a tooltip.
    ///
    /// ```
    /// use fabkit_report::{Svg, heat_color};
    /// let mut map = Svg::new(20.0, 10.0);
    /// for (column, part) in [0.0, 1.0].into_iter().enumerate() {
    ///     map.cell([10.0 * column as f64, 0.0], [10.0, 10.0], &heat_color(part), &format!("{part} mm"));
    /// }
    /// assert_eq!(map.finish("a map of two cells").matches("<rect").count(), 2);
    /// ```
    pub fn cell(&mut self, corner: [f64; 2], size: [f64; 2], fill: &str, title: &str) {
        let _ = write!(
            self.body,
            r#"<rect fill="{fill}" x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}"><title>{}</title></rect>"#,
            corner[0],
            corner[1],
            size[0],
            size[1],
            escape(title)
        );
    }

    /// Draws an image from its upper left corner, its pixels as squares; `png` is the file's content.
    ///
    /// ```
    /// let mut drawing = fabkit_report::Svg::new(8.0, 8.0);
    /// drawing.image([0.0, 0.0], [8.0, 8.0], b"abc");
    /// assert!(drawing.finish("pixels").contains("href=\"data:image/png;base64,YWJj\""));
    /// ```
    pub fn image(&mut self, corner: [f64; 2], size: [f64; 2], png: &[u8]) {
        let _ = write!(
            self.body,
            r#"<image x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" style="image-rendering: pixelated" href="data:image/png;base64,{}"/>"#,
            corner[0],
            corner[1],
            size[0],
            size[1],
            STANDARD.encode(png)
        );
    }

    /// Draws text anchored at its `start`, `middle` or `end`.
    pub fn text(&mut self, at: [f64; 2], anchor: &str, text: &str) {
        let _ = write!(
            self.body,
            r##"<text x="{:.1}" y="{:.1}" text-anchor="{anchor}" font-size="12" fill="#444">{}</text>"##,
            at[0],
            at[1],
            escape(text)
        );
    }

    /// Returns the drawing as an SVG element; `label` describes it in words.
    pub fn finish(self, label: &str) -> String {
        format!(
            "<svg viewBox=\"{} {} {:.0} {:.0}\" role=\"img\" aria-label=\"{}\">{}</svg>\n",
            self.corner[0],
            self.corner[1],
            self.width,
            self.height,
            escape(label),
            self.body
        )
    }
}

/// Returns a colour from pale to dark for 0 to 1, readable in grey as well. Values that are not finite are darkest.
///
/// ```
/// use fabkit_report::heat_color;
/// assert_eq!(heat_color(0.0), "#ffeda0");
/// assert_eq!(heat_color(1.0), "#7a0403");
/// assert_eq!(heat_color(-3.0), heat_color(0.0));
/// assert_eq!(heat_color(f64::NAN), heat_color(1.0));
/// ```
pub fn heat_color(part: f64) -> String {
    let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 1.0 };
    // From #ffeda0 to #7a0403.
    let mix = |from: f64, to: f64| (from + (to - from) * part).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(255.0, 122.0), mix(237.0, 4.0), mix(160.0, 3.0))
}

/// Escapes text for HTML.
///
/// ```
/// assert_eq!(fabkit_report::escape("a < b & \"c\""), "a &lt; b &amp; &quot;c&quot;");
/// ```
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
