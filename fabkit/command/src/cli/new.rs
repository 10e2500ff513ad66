//! Options of `fabkit new`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use fabkit_application::designs::REGISTRY;

/// `fabkit new`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("start").required(true))]
pub struct New {
    /// Name of the sensor: lower-case letters, digits and hyphens, at most 64 characters
    pub name: String,
    /// Write every parameter of this family, with the values of its example sensor
    #[arg(long, group = "start", value_name = "FAMILY")]
    pub family: Option<String>,
    /// Extend this built-in sensor; its parameters are listed as comments
    #[arg(long, group = "start", value_name = "SENSOR")]
    pub extends: Option<String>,
    /// File to write [default: NAME.yaml]
    #[arg(short, long, value_name = "FILE.yaml")]
    pub output: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long)]
    pub force: bool,
}

/// Lists the families and an example, for the end of `--help`.
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
