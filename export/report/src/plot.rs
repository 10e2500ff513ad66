//! Scatter plots.

use crate::Svg;

const GRID: &str = r##"stroke="#e3e3e3""##;
const SIZE: [f64; 2] = [640.0, 272.0];
/// Margins left, top, right and bottom: ticks and axis name fit below each other, also in the larger letters of a
/// narrow page.
const MARGIN: [f64; 4] = [46.0, 10.0, 12.0, 46.0];

/// A plot of points over two axes.
///
/// ```
/// use fabkit_report::Plot;
/// let mut plot = Plot::new([4.0, 1.0], [1.0, 0.5], ["force, N", "depth, mm"]);
/// plot.dot([4.0, 1.0], "#1f4e79", "at the end of both axes");
/// plot.dot([4.0, 9.0], "#1f4e79", "far above, drawn at the upper edge");
/// let element = plot.finish("depth against force");
/// assert_eq!(element.matches("cx=\"628.0\" cy=\"10.0\"").count(), 2);
/// ```
#[derive(Clone, Debug)]
pub struct Plot {
    svg: Svg,
    /// Ranges of the horizontal and the vertical axis.
    ranges: [[f64; 2]; 2],
}

impl Plot {
    /// Creates axes that begin at 0; `limits` are their ends, `ticks` their steps.
    pub fn new(limits: [f64; 2], ticks: [f64; 2], names: [&str; 2]) -> Self {
        Self::with_ticks(limits.map(|limit| [0.0, limit.max(1e-9)]), ticks, names)
    }

    /// Creates axes that cover a range each, horizontal and vertical, a little wider, with round ticks.
    ///
    /// ```
    /// use fabkit_report::Plot;
    /// let plot = Plot::between([[100.0, 200.0], [0.0, 0.4]], ["frame", "error, px"]);
    /// let element = plot.finish("axes alone");
    /// assert!(element.contains(">100<") && element.contains(">200<") && element.contains(">0.4<"));
    /// assert!(!element.contains(">0.45<"));
    /// ```
    pub fn between(ranges: [[f64; 2]; 2], names: [&str; 2]) -> Self {
        let ranges = ranges.map(|[low, high]| {
            // A range of no width still needs an axis.
            let half = (0.54 * (high - low)).max(1e-3 * low.abs().max(high.abs())).max(1e-9);
            let middle = 0.5 * (low + high);
            [middle - half, middle + half]
        });
        // About eight ticks across and five up.
        let ticks = [
            round_tick_step(ranges[0][1] - ranges[0][0], 8.0),
            round_tick_step(ranges[1][1] - ranges[1][0], 5.0),
        ];
        Self::with_ticks(ranges, ticks, names)
    }

    /// Draws grid, tick labels and axis names.
    fn with_ticks(ranges: [[f64; 2]; 2], ticks: [f64; 2], names: [&str; 2]) -> Self {
        let mut plot = Self { svg: Svg::new(SIZE[0], SIZE[1]), ranges };
        let bottom = SIZE[1] - MARGIN[3];
        let [[x_low, _], [y_low, _]] = ranges;
        for value in marks(ranges[0], ticks[0]) {
            let x = plot.at([value, y_low])[0];
            plot.svg.line([x, MARGIN[1]], [x, bottom], GRID);
            plot.svg.text([x, bottom + 16.0], "middle", &format_tick(value, ticks[0]));
        }
        for value in marks(ranges[1], ticks[1]) {
            let y = plot.at([x_low, value])[1];
            plot.svg.line([MARGIN[0], y], [SIZE[0] - MARGIN[2], y], GRID);
            plot.svg.text([MARGIN[0] - 5.0, y + 4.0], "end", &format_tick(value, ticks[1]));
        }
        plot.svg.text([(MARGIN[0] + SIZE[0]) / 2.0, SIZE[1] - 6.0], "middle", names[0]);
        plot.svg.text([MARGIN[0] + 4.0, MARGIN[1] + 8.0], "start", names[1]);
        plot
    }

    /// Maps a data point to the drawing, px. Vertical values are clamped to the axis.
    fn at(&self, point: [f64; 2]) -> [f64; 2] {
        let width = SIZE[0] - MARGIN[0] - MARGIN[2];
        let height = SIZE[1] - MARGIN[1] - MARGIN[3];
        let share = |axis: usize| {
            let [low, high] = self.ranges[axis];
            (point[axis] - low) / (high - low)
        };
        [MARGIN[0] + width * share(0), MARGIN[1] + height * (1.0 - share(1).clamp(0.0, 1.0))]
    }

    /// Draws a point in a colour, with a tooltip.
    pub fn dot(&mut self, point: [f64; 2], fill: &str, title: &str) {
        let at = self.at(point);
        self.svg.dot(at, 3.0, fill, title);
    }

    /// Draws a straight line between two points; `style` holds SVG attributes.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], style: &str) {
        let (from, to) = (self.at(from), self.at(to));
        self.svg.line(from, to, style);
    }

    /// Draws a horizontal line across the plot; `style` holds SVG attributes.
    ///
    /// ```
    /// use fabkit_report::{LOWER_BOUND_STYLE, Plot};
    /// let mut plot = Plot::new([10.0, 1.0], [2.0, 0.5], ["frame", "error, px"]);
    /// plot.horizontal_line(1.0, LOWER_BOUND_STYLE);
    /// let across = "x1=\"46.0\" y1=\"10.0\" x2=\"628.0\" y2=\"10.0\"";
    /// assert!(plot.finish("a bound").contains(&format!("{LOWER_BOUND_STYLE} {across}")));
    /// ```
    pub fn horizontal_line(&mut self, value: f64, style: &str) {
        let [low, high] = self.ranges[0];
        self.line([low, value], [high, value], style);
    }

    /// Returns the plot as an SVG element; `label` describes it in words.
    pub fn finish(self, label: &str) -> String {
        self.svg.finish(label)
    }
}

/// Returns a round step of an axis: 1, 2 or 5 times a power of ten, so that about `count` steps reach `limit`.
///
/// ```
/// use fabkit_report::round_tick_step;
/// assert_eq!(round_tick_step(40.0, 8.0), 5.0);
/// assert_eq!(round_tick_step(41.0, 8.0), 10.0);
/// assert_eq!(round_tick_step(0.07, 5.0), 0.02);
/// ```
pub fn round_tick_step(limit: f64, count: f64) -> f64 {
    let rough = (limit / count).max(1e-12);
    let power = 10f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    steps.into_iter().find(|step| *step >= rough).unwrap_or(rough)
}

/// Iterates over the multiples of a step within a range.
fn marks([low, high]: [f64; 2], tick: f64) -> impl Iterator<Item = f64> {
    let first = (low / tick - 1e-3).ceil();
    let last = (high / tick + 1e-3).floor();
    // A step from `round_tick_step` yields a few; the limit guards against any other.
    (0..1000)
        .map(move |i| first + f64::from(i))
        .take_while(move |i| *i <= last)
        .map(move |i| i * tick)
}

/// Formats a value with as many decimals as the step has.
fn format_tick(value: f64, tick: f64) -> String {
    let digits = (-tick.log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{:.digits$}", value + 0.0);
    // Rounded values of zero, with a sign or decimals, become a plain 0.
    if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) {
        "0".into()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_lie_within() {
        assert_eq!(marks([0.0, 1.0], 0.25).collect::<Vec<_>>(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(marks([11.9, 15.2], 1.0).collect::<Vec<_>>(), [12.0, 13.0, 14.0, 15.0]);
        assert_eq!((round_tick_step(3.3, 8.0), round_tick_step(0.07, 5.0)), (0.5, 0.02));
        assert_eq!(
            (format_tick(-0.0, 0.5), format_tick(1.5, 0.5), format_tick(200.0, 50.0)),
            ("0".into(), "1.5".into(), "200".into())
        );
    }

    #[test]
    fn a_range_without_width_has_an_axis() {
        let plot = Plot::between([[3.0, 3.0], [0.0, 0.0]], ["x", "y"]);
        let [x, y] = plot.at([3.0, 0.0]);
        assert!((x - 337.0).abs() < 0.5 && y.is_finite(), "{x} {y}");
    }
}
