//! Design sweeps: many variants of one sensor, and their metrics.
//!
//! A [`Plan`] is read from YAML: a sensor, the parameters to vary, constraints, and the [metrics](METRICS) to compute.
//! It numbers its variants, and [`Plan::evaluate`] computes the row of one variant. A row depends only on the plan and
//! the variant's number, so that rows can be computed in any order, on any machine, even twice, and the table is the
//! same. A [`Table`] of all rows becomes CSV, Parquet and a report.
//!
//! # Conventions
//!
//! - Lengths are millimetres, angles degrees; every column's name ends in its unit.
//! - A metric that does not apply to a sensor is an empty cell. One that should be a number and is not finite fails its
//!   row. So does a panic, which is a bug; the other rows are not affected.
//! - This crate opens no files.
//!
//! ```
//! use fabkit_sweep::{Plan, PlanSource, Status, Table};
//!
//! let text = "
//! format: 1
//! sensor: rtac0
//! axes:
//!   camera.depth: {from: 6 mm, to: 7 mm, steps: 3}
//! metrics: [coverage]
//! objectives: {coverage: max}
//! ";
//! let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
//! let plan = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml))?;
//! let rows: Vec<_> = (0..plan.len()).map(|variant| plan.evaluate(variant)).collect();
//! assert!(rows.iter().all(|row| row.status == Status::Ok));
//! // The further back the camera stands, the more it sees.
//! assert!(rows[0].metrics["coverage"] < rows[2].metrics["coverage"]);
//! let csv = Table::new(&plan, rows).to_csv();
//! assert!(csv.starts_with("variant,status,error_code,reason,notes,pareto,camera.depth_mm,coverage\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod metrics;
pub mod panics;
mod pareto;
mod plan;
mod report;
mod row;
mod table;

pub use metrics::{GROUPS, METRICS, Metric, MetricGroup, densities};
pub use pareto::pareto_front;
pub use plan::{
    ComputeCustomMetrics, Constraint, CustomMetrics, Direction, InvalidSource, MAX_AXES,
    MAX_VARIANTS, Objective, Plan, PlanAxis, PlanSource, Sampling, Variant, json_schema,
};
pub use report::report;
pub use row::{InvalidRow, PANIC, Row, Status, Value};
pub use table::Table;
