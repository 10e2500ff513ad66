//! Options of `fabkit bench`.

use std::path::PathBuf;

use clap::Args;

use super::Design;

/// `fabkit bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// The sensor.
    #[command(flatten)]
    pub design: Design,
    /// Fewer presses, no PyTorch: minutes instead of hours (the default)
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Sample counts close to the paper's: up to hours
    #[arg(long)]
    pub full: bool,
    /// Seed of positions, noise and models
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u32,
    /// Only this experiment; may be repeated
    #[arg(long = "rows", value_name = "EXPERIMENT")]
    pub rows: Vec<String>,
    /// Output folder for bench.json, bench.html and networks/
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}
