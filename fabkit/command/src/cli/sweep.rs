//! Options of `fabkit sweep`.

use std::path::PathBuf;

use clap::Args;

/// `fabkit sweep`.
#[derive(Debug, Args)]
pub struct Sweep {
    /// Plan with the sensor, parameters to vary, constraints and metrics; see `schema --sweep`
    #[arg(value_name = "FILE.yaml")]
    pub plan: PathBuf,
    /// Output folder for sweep.csv, sweep.parquet and report.html
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Continue an interrupted run of the same plan
    #[arg(long)]
    pub resume: bool,
}
