//! Table of all rows, as CSV and Parquet.

use std::collections::BTreeSet;

use fabkit_export::{ExportError, ParquetColumn, parquet};
use fabkit_geometry::csv::{CsvCell, CsvTable};

use crate::pareto::pareto_front;
use crate::plan::Plan;
use crate::row::{Row, Status, Value};

/// Rows of a plan, in order, with their columns.
///
/// ```
/// use fabkit_sweep::{Plan, PlanSource, Table};
///
/// let text = "
/// format: 1
/// sensor: rtac0
/// axes: {camera.depth: [6 mm, 7 mm]}
/// metrics: [coverage]
/// objectives: {coverage: max}
/// ";
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let plan = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml))?;
/// let table = Table::new(&plan, [1, 0, 1].map(|number| plan.evaluate(number)).to_vec());
/// // The best row alone is on the front: the camera further back sees more.
/// assert_eq!((table.rows().len(), table.is_on_front(0), table.is_on_front(1)), (2, false, true));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Table {
    rows: Vec<Row>,
    /// Names of the columns of the axes.
    axes: Vec<String>,
    /// Names of the columns of the metrics.
    metrics: Vec<String>,
    /// True for each row on the Pareto front.
    pareto: Vec<bool>,
    has_objectives: bool,
    /// True if the plan allows additional changes, so that there is a column for them.
    has_changes: bool,
}

impl Table {
    /// Creates a table of rows, which are sorted. The metrics' columns are the plan's in the order of their table,
    /// those of materials sorted by name, then the custom metrics.
    pub fn new(plan: &Plan, mut rows: Vec<Row>) -> Self {
        rows.sort_by_key(|row| row.variant);
        // A row that was computed twice is the same both times.
        rows.dedup_by_key(|row| row.variant);
        let found: BTreeSet<&str> =
            rows.iter().flat_map(|row| row.metrics.keys().map(String::as_str)).collect();
        let mut metrics: Vec<String> = Vec::new();
        for metric in plan.metrics() {
            if metric.per_material {
                metrics.extend(
                    found.iter().filter(|name| metric.covers(name)).map(|name| (*name).to_owned()),
                )
            } else {
                metrics.push(metric.name.to_owned())
            }
        }
        metrics.extend(plan.source().custom_metrics.iter().cloned());
        let directions: Vec<_> = plan.objectives().iter().map(|o| o.direction).collect();
        let costs: Vec<Vec<Option<f64>>> = rows
            .iter()
            .map(|row| {
                let value = |name: &str| row.metrics.get(name).copied();
                let is_ok = row.status == Status::Ok;
                plan.objectives().iter().map(|o| value(&o.metric).filter(|_| is_ok)).collect()
            })
            .collect();
        let pareto = pareto_front(&costs, &directions);
        let axes = plan.axes().iter().map(|axis| axis.column()).collect();
        let (has_objectives, has_changes) = (!directions.is_empty(), plan.adapts_chosen_values());
        Self { rows, axes, metrics, pareto, has_objectives, has_changes }
    }

    /// Rows, in order.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Names of the columns of the metrics.
    pub fn metrics(&self) -> &[String] {
        &self.metrics
    }

    /// Returns whether a row, by its index, is on the Pareto front.
    pub fn is_on_front(&self, row: usize) -> bool {
        self.pareto.get(row).copied().unwrap_or(false)
    }

    /// Lists the metrics of the plan that no row has.
    pub fn empty_metrics(&self) -> Vec<&str> {
        let is_empty =
            |name: &&String| !self.rows.iter().any(|row| row.metrics.contains_key(*name));
        self.metrics.iter().filter(is_empty).map(String::as_str).collect()
    }

    /// Writes comma-separated values (RFC 4180, but with Unix line ends); numbers have all their digits.
    pub fn to_csv(&self) -> String {
        let columns = self.columns();
        let mut table = CsvTable::with_heads(columns.iter().map(|(name, _)| &**name));
        for i in 0..self.rows.len() {
            table.row(columns.iter().map(|(_, column)| match column {
                ParquetColumn::Integers(values) => CsvCell::count(values[i]),
                ParquetColumn::Numbers(values) => values[i].into(),
                ParquetColumn::Texts(values) => values[i].as_deref().into(),
                ParquetColumn::Flags(values) => {
                    values[i].map(|flag| if flag { "true" } else { "false" }).into()
                }
            }));
        }
        table.finish()
    }

    /// Writes a Parquet file; empty cells are null.
    ///
    /// # Errors
    /// Does not fail for rows of one plan.
    pub fn to_parquet(&self) -> Result<Vec<u8>, ExportError> {
        parquet("sweep", &self.columns())
    }

    /// Lists names and values of all columns.
    fn columns(&self) -> Vec<(String, ParquetColumn)> {
        let texts = |text: &dyn Fn(&Row) -> Option<String>| {
            ParquetColumn::Texts(self.rows.iter().map(text).collect())
        };
        let notes = |row: &Row| (!row.notes.is_empty()).then(|| row.notes.join("; "));
        let flag = |on: &bool| self.has_objectives.then_some(*on);
        let mut columns = vec![
            (
                "variant".to_owned(),
                ParquetColumn::Integers(self.rows.iter().map(|r| r.variant as i64).collect()),
            ),
            ("status".to_owned(), texts(&|row| Some(row.status.word().to_owned()))),
            ("error_code".to_owned(), texts(&|row| row.error_code.clone())),
            ("reason".to_owned(), texts(&|row| row.reason.clone())),
            ("notes".to_owned(), texts(&notes)),
            ("pareto".to_owned(), ParquetColumn::Flags(self.pareto.iter().map(flag).collect())),
        ];
        if self.has_changes {
            let changes = |row: &Row| (!row.changes.is_empty()).then(|| row.changes.join("; "));
            columns.push(("changes".to_owned(), texts(&changes)));
        }
        for (i, name) in self.axes.iter().enumerate() {
            let values = || self.rows.iter().map(|row| row.parameters.get(i));
            // A column has one type: a single word makes it a column of texts.
            let is_number = values().all(|value| matches!(value, None | Some(Value::Number(_))));
            let column = if is_number {
                ParquetColumn::Numbers(values().map(|v| v.and_then(Value::number)).collect())
            } else {
                ParquetColumn::Texts(values().map(|v| v.map(format_value)).collect())
            };
            columns.push((name.clone(), column));
        }
        for name in &self.metrics {
            let values = self.rows.iter().map(|row| row.metrics.get(name).copied());
            columns.push((name.clone(), ParquetColumn::Numbers(values.collect())));
        }
        columns
    }
}

fn format_value(value: &Value) -> String {
    match value {
        Value::Number(number) => number.to_string(),
        Value::Text(text) => text.clone(),
    }
}
