//! `fabkit new`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use fabkit_application::designs::REGISTRY;

/// `fabkit new`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("start").required(true))]
pub struct New {
    /// The sensor's name: small letters, digits and hyphens, at most 64
    pub name: String,
    /// Write every parameter of this family, with the values of its example
    #[arg(long, group = "start", value_name = "FAMILY")]
    pub family: Option<String>,
    /// Extend this built-in sensor: all of its parameters as comments, to change some of them
    #[arg(long, group = "start", value_name = "SENSOR")]
    pub extends: Option<String>,
    /// The file to write [default: NAME.yaml]
    #[arg(short, long, value_name = "FILE.yaml")]
    pub output: Option<PathBuf>,
    /// Replace the file if it is there already
    #[arg(long)]
    pub force: bool,
}

/// The families, and how to go on.
pub fn after_help() -> String {
    let families = REGISTRY.families().iter();
    let width = families.clone().map(|family| family.name().len()).max().unwrap_or_default();
    let families =
        families.map(|family| format!("  {:width$}  {}\n", family.name(), family.summary()));
    format!(
        "Families:\n{}\nExample:\n  fabkit new my-finger --family dome\n  fabkit check my-finger.yaml",
        families.collect::<String>()
    )
}
