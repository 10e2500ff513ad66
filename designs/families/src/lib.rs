//! Sensors: their parameters with sources, and the parametric parts made from them.

pub mod articles;
pub mod blocks;
pub mod chain_builder;
mod design;
mod families;
mod fits;
pub mod fixing;
pub mod hardware;
mod identity;
mod kerf;
mod labels;
mod loads;
mod macros;
pub mod materials;
pub mod processes;
pub mod profile;
mod registry;
pub mod unit_dimensions;
mod user_catalogue;

pub use design::{Companion, Design};
pub use fabkit_text as parameters;
pub use fabkit_text::{choices, parameters};
pub use fits::{Fit, gap_mm};
pub use hardware::{
    Dowel, Head, HeatSetNut, HexNut, HexSpacer, ORing, SQUEEZED_PLAY_MM, Screw, SocketScrew,
};
pub use identity::design_hash;
pub use kerf::kerf_mm;
pub(crate) use macros::{layout, sections};
pub use registry::{
    BaseFile, BaseReference, Extension, ExtensionValues, FORMAT, Family, FamilyEntry, FamilyOutput,
    Header, Registry, SensorText, TemplateBase, camera_modules, extended_file,
};
pub use user_catalogue::UserFile;

/// Families and built-in sensors that fabkit comes with.
pub static REGISTRY: Registry = Registry::new(families::FAMILIES, families::SENSORS);

/// Returns the names of the built-in sensors, sorted.
pub fn builtin_names() -> Vec<&'static str> {
    REGISTRY.builtin_names()
}

/// Returns the YAML text of a built-in sensor.
pub fn builtin_yaml(name: &str) -> Option<&'static str> {
    REGISTRY.builtin_yaml(name)
}

/// Builds a design from YAML text and overrides.
///
/// `file` names the text in messages. Each override is `path=value` as on the command line. Top-level keys among
/// `others` are skipped: other crates keep sections in the same files.
///
/// # Errors
/// Every problem, each with place, value, limit and a hint.
pub fn load(
    file: &str,
    yaml: &str,
    overrides: &[String],
    others: &[&str],
) -> Result<Design, parameters::InvalidDesign> {
    REGISTRY.load(file, yaml, overrides, others)
}

/// Returns the JSON Schema (draft-07) of sensor files, without extensions.
pub fn json_schema() -> serde_json::Value {
    REGISTRY.json_schema(&[])
}
