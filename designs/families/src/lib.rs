//! Sensors: their parameters with sources, and the parametric parts made from them.
//!
//! ```
//! let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
//! let overrides = ["shell.wall=1.6 mm".to_owned()];
//! let design = fabkit_designs::load("rtac0.yaml", yaml, &overrides, &["fixtures"])?;
//! assert_eq!(design.family, "dome");
//! assert!(design.sensor.body("shell").is_some());
//! let wall = design.parameters.iter().find(|one| one.path == "shell.wall").ok_or("no wall")?;
//! assert_eq!(wall.value, "1.6 mm");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod articles;
pub mod blocks;
pub mod chain_builder;
mod conditions;
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

pub use conditions::{Condition, condition, conditions};
pub use design::{Companion, Design};
pub use fabkit_text as parameters;
pub use fabkit_text::{choices, parameters};
pub use fits::{Fit, gap_mm};
pub use hardware::{
    Dowel, Head, HeatSetNut, HexNut, HexSpacer, ORing, SQUEEZED_PLAY_MM, Screw, SocketScrew,
};
pub use identity::{built_hash, debug_hash, design_hash};
pub use kerf::kerf_mm;
pub(crate) use macros::{layout, sections};
pub use registry::{
    BaseFile, BaseReference, Extension, ExtensionValues, FORMAT, Family, FamilyEntry, FamilyOutput,
    Header, Registry, SensorText, TemplateBase, UserValue, camera_modules, extended_file,
};
pub use user_catalogue::UserFile;

/// Families and built-in sensors that fabkit comes with.
pub static REGISTRY: Registry = Registry::new(families::FAMILIES, families::SENSORS);

/// Returns the names of the built-in sensors, sorted.
pub fn builtin_names() -> Vec<&'static str> {
    REGISTRY.builtin_names()
}

/// Returns the YAML text of a built-in sensor.
///
/// ```
/// let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// assert!(yaml.contains("family: dome"));
/// assert!(fabkit_designs::builtin_yaml("no-such-sensor").is_none());
/// # Ok::<(), &str>(())
/// ```
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
///
/// ```
/// // All problems are reported at once: a radius without its unit, and a key that no sensor has.
/// let yaml = "format: 1\nextends: rtac0\nsurface: {radius: 15}\nshell: {wal: 2 mm}\n";
/// let invalid = fabkit_designs::load("mine.yaml", yaml, &[], &[]).unwrap_err();
/// let places: Vec<_> = invalid.problems.iter().map(|one| (one.line, &*one.path)).collect();
/// assert_eq!(places, [(Some(3), "surface.radius"), (Some(4), "shell.wal")]);
/// ```
pub fn load(
    file: &str,
    yaml: &str,
    overrides: &[String],
    others: &[&str],
) -> Result<Design, parameters::InvalidDesign> {
    REGISTRY.load(file, yaml, overrides, others)
}

/// Returns the JSON Schema (draft-07) of sensor files, without extensions.
///
/// ```
/// let schema = fabkit_designs::json_schema();
/// assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
/// ```
pub fn json_schema() -> serde_json::Value {
    REGISTRY.json_schema(&[])
}
