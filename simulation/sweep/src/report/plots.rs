//! Plots of the report.

use std::fmt::Write as _;

use fabkit_report::{Plot, escape};

use crate::plan::{Plan, PlanAxis, Sampling};
use crate::row::{Row, Status, Value};
use crate::table::Table;

/// Largest number of dots in a plot: more make it slow without showing more.
const MAX_DOTS: usize = 1500;
/// Largest number of axes that are drawn.
const MAX_AXES: usize = 8;
/// Number of bins of a sampled axis.
const BINS: usize = 10;

const OK_COLOUR: &str = "#1f4e79";
const FRONT_COLOUR: &str = "#c0392b";
const EXCLUDED_COLOUR: &str = "#bbbbbb";
const CURVE: &str = r##"stroke="#1f4e79" stroke-width="1.6""##;

/// Returns a row's position on an axis: its number, or the index of its word.
fn axis_position(axis: &PlanAxis, index: usize, row: &Row) -> Option<f64> {
    match (row.parameters.get(index)?, axis.words()) {
        (Value::Number(number), None) => Some(*number),
        (Value::Number(number), Some(words)) => {
            let text = number.to_string();
            words.iter().position(|word| *word == text).map(|i| i as f64)
        }
        (Value::Text(text), Some(words)) => {
            words.iter().position(|word| word == text).map(|i| i as f64)
        }
        (Value::Text(_), None) => None,
    }
}

/// Returns the label of an axis, with its words by index if it has words.
fn axis_label(axis: &PlanAxis) -> String {
    match axis.words() {
        None => axis.column(),
        Some(words) => {
            let words = words.iter().enumerate().map(|(i, word)| format!("{i} {word}"));
            format!("{} ({})", axis.column(), words.collect::<Vec<_>>().join(", "))
        }
    }
}

/// Returns the smallest and the largest value.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range, value| match range {
        None => Some([value, value]),
        Some([low, high]) => Some([low.min(value), high.max(value)]),
    })
}

/// Draws dots, in an order in which the important ones cover the others.
fn scatter(
    table: &Table,
    names: [&str; 2],
    point: impl Fn(&Row) -> Option<[f64; 2]>,
) -> Option<String> {
    let mut dots: Vec<(u8, usize, [f64; 2])> = Vec::new();
    for (i, row) in table.rows().iter().enumerate() {
        let Some(at) = point(row) else { continue };
        let rank = match row.status {
            _ if table.is_on_front(i) => 2,
            Status::Ok => 1,
            _ => 0,
        };
        dots.push((rank, i, at));
    }
    let ranges = [range(dots.iter().map(|dot| dot.2[0]))?, range(dots.iter().map(|dot| dot.2[1]))?];
    // Dots of the front are never thinned out.
    let others = dots.iter().filter(|dot| dot.0 < 2).count();
    // Evenly spaced rows are kept.
    let every = others.div_ceil(MAX_DOTS).max(1);
    dots.retain(|dot| dot.0 == 2 || dot.1.is_multiple_of(every));
    dots.sort_by_key(|dot| (dot.0, dot.1));
    let mut plot = Plot::between(ranges, names);
    for (rank, i, at) in dots {
        let fill = [EXCLUDED_COLOUR, OK_COLOUR, FRONT_COLOUR][usize::from(rank)];
        plot.dot(at, fill, &format!("variant {}", table.rows()[i].variant));
    }
    Some(plot.finish(&format!("{} against {}", names[1], names[0])))
}

/// Plots the first two objectives against each other.
pub(super) fn front(plan: &Plan, table: &Table) -> String {
    let [a, b, ..] = plan.objectives() else { return String::new() };
    let point = |row: &Row| Some([*row.metrics.get(&a.metric)?, *row.metrics.get(&b.metric)?]);
    let Some(plot) = scatter(table, [&a.metric, &b.metric], point) else { return String::new() };
    format!(
        "<figure>{plot}<figcaption>Red: the front. Blue: other variants. Grey: excluded by a \
         constraint.</figcaption></figure>\n"
    )
}

/// Plots each metric against each axis.
pub(super) fn pairs(plan: &Plan, table: &Table, metrics: &[String]) -> String {
    let mut html = String::new();
    for metric in metrics {
        let mut row_html = String::new();
        for (index, axis) in plan.axes().iter().enumerate().take(MAX_AXES) {
            let axis_name = axis_label(axis);
            let point =
                |row: &Row| Some([axis_position(axis, index, row)?, *row.metrics.get(metric)?]);
            if let Some(plot) = scatter(table, [&axis_name, metric], point) {
                let _ = write!(row_html, "<figure>{plot}</figure>");
            }
        }
        html += &in_pairs(&row_html);
    }
    if html.is_empty() { html } else { format!("<h2>Pairs</h2>\n{html}") }
}

/// Arranges figures in pairs.
fn in_pairs(figures: &str) -> String {
    let figures: Vec<&str> = figures.split_inclusive("</figure>").collect();
    figures.chunks(2).map(|pair| format!("<div class=\"pair\">{}</div>\n", pair.concat())).collect()
}

/// Plots the change of each metric with one axis while the others are fixed.
pub(super) fn sensitivity(plan: &Plan, table: &Table, metrics: &[String]) -> String {
    let mut html = String::new();
    for metric in metrics {
        let mut row_html = String::new();
        let axes = plan.axes().iter().enumerate().take(MAX_AXES);
        let curves: Vec<_> = axes.map(|(i, axis)| (axis, curve(plan, table, i, metric))).collect();
        // A common scale, so that unimportant axes look unimportant.
        let Some(y) = range(curves.iter().flat_map(|(_, c)| c.iter().map(|p| p[1]))) else {
            continue;
        };
        for (axis, curve) in &curves {
            let Some(x) = range(curve.iter().map(|p| p[0])) else { continue };
            let mut plot = Plot::between([x, y], [&axis_label(axis), metric]);
            for pair in curve.windows(2) {
                plot.line(pair[0], pair[1], CURVE);
            }
            for point in curve {
                plot.dot(*point, OK_COLOUR, &format!("{}", point[1]));
            }
            let label = format!("{metric} as {} changes alone", axis.column());
            let _ = write!(row_html, "<figure>{}</figure>", plot.finish(&label));
        }
        html += &in_pairs(&row_html);
    }
    if html.is_empty() {
        return html;
    }
    let how = match plan.sampling {
        Sampling::Grid => "One axis changes, the others stay at the middle of their values.",
        Sampling::Sample(_) => {
            "Means over tenths of one axis; the others, spread evenly over theirs, are averaged out."
        }
    };
    format!("<h2>One at a time</h2>\n<p>{}</p>\n{html}", escape(how))
}

/// Returns the points of a curve, in the order of the axis.
fn curve(plan: &Plan, table: &Table, index: usize, metric: &str) -> Vec<[f64; 2]> {
    let axis = &plan.axes()[index];
    let point = |row: &Row| Some([axis_position(axis, index, row)?, *row.metrics.get(metric)?]);
    let ok = table.rows().iter().filter(|row| row.status == Status::Ok);
    match plan.sampling {
        Sampling::Grid => {
            let middle: Vec<Option<Value>> = plan.axes().iter().map(PlanAxis::middle).collect();
            // Variants that differ from the middle one in this axis only.
            let on_cross = |row: &&Row| {
                let others = row.parameters.iter().zip(&middle).enumerate();
                others.filter(|(i, _)| *i != index).all(|(_, (v, m))| Some(v) == m.as_ref())
            };
            let mut points: Vec<[f64; 2]> = ok.filter(on_cross).filter_map(point).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            points
        }
        Sampling::Sample(_) => {
            let points: Vec<[f64; 2]> = ok.filter_map(point).collect();
            let Some([low, high]) = range(points.iter().map(|p| p[0])) else { return Vec::new() };
            let mut bins = [[0.0; 3]; BINS];
            for [x, y] in points {
                let share = (x - low) / (high - low).max(f64::MIN_POSITIVE);
                let bin = &mut bins[((share * BINS as f64) as usize).min(BINS - 1)];
                *bin = [bin[0] + x, bin[1] + y, bin[2] + 1.0];
            }
            let full = bins.iter().filter(|bin| bin[2] > 0.0);
            full.map(|[x, y, n]| [x / n, y / n]).collect()
        }
    }
}
