//! Options of `fabkit bench`.

use std::path::PathBuf;

use clap::Args;

use super::Design;

/// `fabkit bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// Which sensor.
    #[command(flatten)]
    pub design: Design,
    /// Minutes instead of hours: fewer presses, no PyTorch; what is done without --full
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Counts nearer to the paper's: up to hours
    #[arg(long)]
    pub full: bool,
    /// Of places, noise and models: the same gives the same figures
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u32,
    /// Only this experiment; may be repeated
    #[arg(long = "rows", value_name = "EXPERIMENT")]
    pub rows: Vec<String>,
    /// The folder to write bench.json, bench.html and networks/ into
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}
