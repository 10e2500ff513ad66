//! `fabkit sweep`.

use std::path::PathBuf;

use clap::Args;

/// `fabkit sweep`.
#[derive(Debug, Args)]
pub struct Sweep {
    /// The plan: a sensor, the parameters to vary, constraints, metrics; `schema --sweep` has it all
    #[arg(value_name = "FILE.yaml")]
    pub plan: PathBuf,
    /// Folder for sweep.csv, sweep.parquet and report.html
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Go on where an earlier run of the same plan was stopped
    #[arg(long)]
    pub resume: bool,
}
