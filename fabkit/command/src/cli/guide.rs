//! `fabkit guide`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::Design;

/// `fabkit guide`.
#[derive(Debug, Args)]
pub struct Guide {
    #[command(flatten)]
    pub design: Design,
    /// The folder to write index.html, guide.json, bom.csv and parts.csv into
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// How many to build: what is in each sensor is counted that often, molds and tools once
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000), value_name = "N")]
    pub units: u32,
    /// Slice parts of filament with PrusaSlicer for their times and masses; takes minutes. Without, they are
    /// fabkit's own estimates
    #[arg(long)]
    pub slice: bool,
    /// The language of the page
    #[arg(long, default_value = "en", value_enum)]
    pub language: Language,
}

/// A language that pages are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// English
    En,
}
