//! Report of a sweep as one HTML file: results of the variants, the Pareto front, and dependencies.

mod plots;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use fabkit_report::{escape, page};

use crate::metrics::METRICS;
use crate::plan::{Plan, Sampling};
use crate::row::{Status, Value};
use crate::table::Table;

/// Largest number of listed rows of the front.
const MAX_LISTED_ROWS: usize = 50;
/// Largest number of listed reasons.
const MAX_LISTED_REASONS: usize = 12;
/// Number of metrics that are drawn if the plan has no objectives.
const MAX_DRAWN_METRICS: usize = 4;

/// Writes the report of a table.
///
/// ```
/// use fabkit_sweep::{Plan, PlanSource, Table, report};
///
/// let text = "format: 1\nsensor: rtac0\naxes: {camera.depth: [6 mm, 7 mm]}\nmetrics: [coverage]\n";
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let plan = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml))?;
/// let rows = (0..plan.len()).map(|number| plan.evaluate(number)).collect();
/// let html = report(&plan, &Table::new(&plan, rows));
/// assert!(html.contains("Sweep of rtac0") && html.contains("coverage"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn report(plan: &Plan, table: &Table) -> String {
    let drawn = metrics_to_draw(plan, table);
    let mut body = summary(plan, table);
    body += &reasons(table);
    body += &empty(table);
    body += &front(plan, table);
    body += &plots::front(plan, table);
    body += &plots::sensitivity(plan, table, &drawn);
    body += &plots::pairs(plan, table, &drawn);
    body += &legend(table);
    page(&format!("Sweep of {}", plan.sensor()), &body)
}

/// Returns the metrics to draw: the objectives, or else the first metrics that vary.
fn metrics_to_draw(plan: &Plan, table: &Table) -> Vec<String> {
    if !plan.objectives().is_empty() {
        return plan.objectives().iter().map(|objective| objective.metric.clone()).collect();
    }
    let changes = |name: &&String| {
        let mut values = table.rows().iter().filter_map(|row| row.metrics.get(*name));
        let first = values.next();
        values.any(|value| Some(value) != first)
    };
    table.metrics().iter().filter(changes).take(MAX_DRAWN_METRICS).cloned().collect()
}

fn row(cells: &[String]) -> String {
    let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
    format!("<tr>{cells}</tr>\n")
}

fn heading(cells: &[&str]) -> String {
    let cells: String = cells.iter().map(|cell| format!("<th>{}</th>", escape(cell))).collect();
    format!("<tr>{cells}</tr>\n")
}

/// Writes the plan's main figures.
fn summary(plan: &Plan, table: &Table) -> String {
    let chosen = match plan.sampling {
        Sampling::Grid => "all combinations of the axes' values".to_owned(),
        Sampling::Sample(count) => {
            format!("{count} points of a scrambled Halton sequence, seed {}", plan.seed)
        }
    };
    let mut rows = vec![
        ["sensor".to_owned(), plan.sensor().to_owned()],
        ["variants".to_owned(), format!("{}: {chosen}", table.rows().len())],
    ];
    for status in Status::ALL {
        let count = table.rows().iter().filter(|row| row.status == status).count();
        rows.push([status.word().to_owned(), count.to_string()]);
    }
    let axes: Vec<String> = plan.axes().iter().map(|axis| axis.column()).collect();
    rows.push(["axes".to_owned(), axes.join(", ")]);
    let constraints: Vec<&str> = plan.constraints.iter().map(|c| c.text.as_str()).collect();
    if !constraints.is_empty() {
        rows.push(["constraints".to_owned(), constraints.join("; ")]);
    }
    rows.push(["plan".to_owned(), plan.hash()[..16].to_owned()]);
    format!("<table>{}</table>\n", rows.iter().map(|cells| row(cells)).collect::<String>())
}

/// Lists the reasons why variants are not ok, the most frequent first. Reasons that differ only in their numbers are
/// counted together; the first serves as an example.
fn reasons(table: &Table) -> String {
    let mut counts: BTreeMap<(Status, String), (usize, &str)> = BTreeMap::new();
    for row in table.rows() {
        if let Some(reason) = &row.reason {
            let kind: String = reason.chars().filter(|c| !c.is_ascii_digit()).collect();
            counts.entry((row.status, kind.replace('.', ""))).or_insert((0, reason)).0 += 1;
        }
    }
    if counts.is_empty() {
        return String::new();
    }
    let kinds = counts.len();
    let mut counts: Vec<_> =
        counts.into_iter().map(|((status, _), count)| (status, count)).collect();
    // The sort is stable: equal counts stay in the order of statuses.
    counts.sort_by_key(|(_, (count, _))| std::cmp::Reverse(*count));
    let mut html = String::from("<h2>Why variants are not ok</h2>\n<table>");
    html += &heading(&["for example", "status", "variants"]);
    for (status, (count, example)) in counts.iter().take(MAX_LISTED_REASONS) {
        html += &row(&[(*example).to_owned(), status.word().to_owned(), count.to_string()]);
    }
    html += "</table>\n";
    if kinds > MAX_LISTED_REASONS {
        let _ =
            writeln!(html, "<p>And {} more; all are in the table.</p>", kinds - MAX_LISTED_REASONS);
    }
    html
}

/// Writes the metrics that no row has, with the notes.
fn empty(table: &Table) -> String {
    let empty = table.empty_metrics();
    if empty.is_empty() || table.rows().iter().all(|row| row.status != Status::Ok) {
        return String::new();
    }
    let names: Vec<String> = empty.iter().map(|name| escape(name)).collect();
    let notes: BTreeSet<&str> =
        table.rows().iter().flat_map(|row| row.notes.iter().map(String::as_str)).collect();
    let notes: String = notes
        .iter()
        .take(MAX_LISTED_REASONS)
        .map(|n| format!("<li>{}</li>\n", escape(n)))
        .collect();
    format!(
        "<h2>What does not apply</h2>\n<p>No variant has {}.</p>\n<ul>{notes}</ul>\n",
        names.join(", ")
    )
}

/// Writes the rows on the Pareto front.
fn front(plan: &Plan, table: &Table) -> String {
    if plan.objectives().is_empty() {
        return String::new();
    }
    let on_front: Vec<_> =
        table.rows().iter().enumerate().filter(|(i, _)| table.is_on_front(*i)).collect();
    let objectives: Vec<String> =
        plan.objectives().iter().map(|o| format!("{}, {}", o.metric, o.direction.word())).collect();
    let axes: Vec<String> = plan.axes().iter().map(|axis| axis.column()).collect();
    let names: Vec<&str> =
        ["variant"].into_iter().chain(axes.iter().chain(&objectives).map(String::as_str)).collect();
    let mut html = format!(
        "<h2>Pareto front</h2>\n<p>{} of {} variants: no other one is at least as good in every \
         objective and better in one.</p>\n<table>",
        on_front.len(),
        table.rows().len()
    );
    html += &heading(&names);
    for (_, found) in on_front.iter().take(MAX_LISTED_ROWS) {
        let mut cells = vec![found.variant.to_string()];
        cells.extend(found.parameters.iter().map(|value| match value {
            Value::Number(number) => round_to_digits(*number),
            Value::Text(text) => text.clone(),
        }));
        let value =
            |name: &str| found.metrics.get(name).map_or(String::new(), |v| round_to_digits(*v));
        cells.extend(plan.objectives().iter().map(|o| value(&o.metric)));
        html += &row(&cells);
    }
    html += "</table>\n";
    if on_front.len() > MAX_LISTED_ROWS {
        let _ = writeln!(html, "<p>And {} more.</p>", on_front.len() - MAX_LISTED_ROWS);
    }
    html
}

/// Lists the metrics with their descriptions.
fn legend(table: &Table) -> String {
    let mut html = String::from("<h2>Metrics</h2>\n<table>");
    for metric in METRICS {
        if table.metrics().iter().any(|name| metric.covers(name)) {
            html += &row(&[metric.name.to_owned(), metric.summary.to_owned()]);
        }
    }
    html + "</table>\n"
}

/// Rounds to five significant digits.
fn round_to_digits(value: f64) -> String {
    let text = format!("{value:.4e}");
    text.parse::<f64>().map_or(text, |rounded| rounded.to_string())
}
