//! Options of `fabkit guide`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Design;

/// `fabkit guide`.
#[derive(Debug, Args)]
pub struct Guide {
    #[command(flatten)]
    pub design: Design,
    /// Output folder for index.html, guide.json, bom.csv and parts.csv
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Number of sensors to build: parts and mixes count per sensor, molds and tools once
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000), value_name = "N")]
    pub units: u32,
    /// Slice FDM parts with PrusaSlicer for print times and masses; takes minutes. Without it they are estimates
    #[arg(long)]
    pub slice: bool,
    /// Language of the page
    #[arg(long, default_value = "en", value_enum)]
    pub language: Language,
}

/// A language that pages are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// English
    En,
}
