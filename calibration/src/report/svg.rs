//! Small drawings as inline SVG.

use std::fmt::Write;

// Looks are attributes and not style sheets, which not every program that prints HTML applies to
// drawings.

/// The border of an image.
pub(super) const FRAME: &str = r##"fill="#fafafa" stroke="#999""##;
/// A part of an image where nothing was seen.
pub(super) const EMPTY: &str = r##"fill="#fbe9d0""##;
/// A residual.
pub(super) const VECTOR: &str = r##"stroke="#c0392b" stroke-width="1.4""##;
/// What no model can go below.
pub(super) const FLOOR: &str = r##"stroke="#d89b00" stroke-dasharray="5 4""##;
const GRID: &str = r##"stroke="#e3e3e3""##;

/// A drawing that grows.
pub(super) struct Svg {
    width: f64,
    height: f64,
    body: String,
}

impl Svg {
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], style: &str) {
        let _ = write!(
            self.body,
            r#"<line {style} x1="{:.1}" y1="{:.1}" x2="{:.1}" y2="{:.1}"/>"#,
            from[0], from[1], to[0], to[1]
        );
    }

    /// A dot in a colour of its own, with what it says when pointed at.
    pub fn dot(&mut self, centre: [f64; 2], radius: f64, fill: &str, title: &str) {
        let _ = write!(
            self.body,
            r#"<circle cx="{:.1}" cy="{:.1}" r="{radius:.1}" fill="{fill}"><title>{}</title></circle>"#,
            centre[0],
            centre[1],
            escape(title)
        );
    }

    pub fn rect(&mut self, corner: [f64; 2], size: [f64; 2], style: &str) {
        let _ = write!(
            self.body,
            r#"<rect {style} x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}"/>"#,
            corner[0], corner[1], size[0], size[1]
        );
    }

    /// Anchored at `start`, `middle` or `end`.
    pub fn text(&mut self, at: [f64; 2], anchor: &str, text: &str) {
        let _ = write!(
            self.body,
            r##"<text x="{:.1}" y="{:.1}" text-anchor="{anchor}" font-size="12" fill="#444">{}</text>"##,
            at[0],
            at[1],
            escape(text)
        );
    }

    pub fn finish(self, label: &str) -> String {
        format!(
            "<svg viewBox=\"0 0 {:.0} {:.0}\" role=\"img\" aria-label=\"{}\">{}</svg>\n",
            self.width,
            self.height,
            escape(label),
            self.body
        )
    }
}

/// A plot of points over two axes that begin at 0.
pub(super) struct Plot {
    svg: Svg,
    limits: [f64; 2],
}

const SIZE: [f64; 2] = [640.0, 260.0];
/// Left, top, right, bottom.
const MARGIN: [f64; 4] = [46.0, 10.0, 12.0, 34.0];

impl Plot {
    /// `limits` are the ends of the axes, `ticks` their steps.
    pub fn new(limits: [f64; 2], ticks: [f64; 2], names: [&str; 2]) -> Self {
        let limits = limits.map(|limit| limit.max(1e-9));
        let mut plot = Self { svg: Svg::new(SIZE[0], SIZE[1]), limits };
        let bottom = SIZE[1] - MARGIN[3];
        let mut value = 0.0;
        while value <= limits[0] * 1.001 {
            let x = plot.at([value, 0.0])[0];
            plot.svg.line([x, MARGIN[1]], [x, bottom], GRID);
            plot.svg.text([x, bottom + 14.0], "middle", &tidy(value));
            value += ticks[0];
        }
        value = 0.0;
        while value <= limits[1] * 1.001 {
            let y = plot.at([0.0, value])[1];
            plot.svg.line([MARGIN[0], y], [SIZE[0] - MARGIN[2], y], GRID);
            plot.svg.text([MARGIN[0] - 5.0, y + 4.0], "end", &tidy(value));
            value += ticks[1];
        }
        plot.svg.text([(MARGIN[0] + SIZE[0]) / 2.0, SIZE[1] - 4.0], "middle", names[0]);
        plot.svg.text([4.0, MARGIN[1] + 8.0], "start", names[1]);
        plot
    }

    fn at(&self, point: [f64; 2]) -> [f64; 2] {
        let width = SIZE[0] - MARGIN[0] - MARGIN[2];
        let height = SIZE[1] - MARGIN[1] - MARGIN[3];
        [
            MARGIN[0] + width * point[0] / self.limits[0],
            MARGIN[1] + height * (1.0 - (point[1] / self.limits[1]).min(1.0)),
        ]
    }

    pub fn dot(&mut self, point: [f64; 2], fill: &str, title: &str) {
        let at = self.at(point);
        self.svg.dot(at, 3.0, fill, title);
    }

    pub fn level(&mut self, value: f64, style: &str) {
        let (left, right) = (self.at([0.0, value]), self.at([self.limits[0], value]));
        self.svg.line(left, right, style);
    }

    pub fn finish(self, label: &str) -> String {
        self.svg.finish(label)
    }
}

/// A step for an axis: 1, 2 or 5 times a power of ten, about `count` of them up to `limit`.
pub(super) fn step(limit: f64, count: f64) -> f64 {
    let rough = (limit / count).max(1e-9);
    let power = 10f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    steps.into_iter().find(|step| *step >= rough).unwrap_or(rough)
}

/// From pale to dark for 0 to 1, readable in grey as well.
pub(super) fn shade(part: f64) -> String {
    let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 1.0 };
    let mix = |from: f64, to: f64| (from + (to - from) * part).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(255.0, 122.0), mix(237.0, 4.0), mix(160.0, 3.0))
}

fn tidy(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Text that is safe inside HTML.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
