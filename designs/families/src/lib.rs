//! The sensors: their parameters with sources, and the parametric parts made from them.

use fabkit_geometry::Sensor;

pub mod assembling;
pub mod blocks;
pub mod built;
pub mod buying;
mod companion;
mod families;
mod fits;
pub mod fixing;
pub mod hardware;
mod identity;
mod kerf;
mod labeling;
mod loads;
pub mod materials;
mod own;
pub mod processes;
pub mod profile;
mod registry;

pub use companion::Companion;
pub use fabkit_text as parameters;
pub use fabkit_text::{choices, parameters};
pub use fits::{Fit, gap_mm};
pub use hardware::{
    Dowel, Head, HeatSetNut, HexNut, HexSpacer, ORing, SQUEEZED_PLAY_MM, Screw, SocketScrew,
};
pub use identity::design_hash;
pub use kerf::kerf_mm;
pub use own::UserFile;
pub use registry::{
    BaseFile, Built, Extended, Extends, Extension, FORMAT, Family, FamilyEntry, Header, Registry,
    SensorText, Start, camera_modules, extended_file,
};

/// Sections of parameters, one after the other: [`parameters!`] for each.
macro_rules! sections {
    ($($(#[doc = $doc:literal])+ pub struct $name:ident { $($fields:tt)+ })+) => {$(
        $crate::parameters! { $(#[doc = $doc])+ pub struct $name { $($fields)+ } }
    )+};
}
pub(crate) use sections;

/// Where things are, each stated once: what it is called, what it means, what it follows from. `let` for
/// what nobody else needs.
macro_rules! layout {
    ($(#[$doc:meta])+ pub struct $name:ident from $p:ident: &$params:ty { $($rest:tt)+ }) => {
        $crate::layout!(@ $p: $params, [$(#[$doc])+ $name] [] [] [] $($rest)+);
    };
    (@ $p:ident: $params:ty, $head:tt [$($field:tt)*] [$($made:ident)*] [$($lets:tt)*]
        let $local:pat = $value:expr; $($rest:tt)*) => {
        $crate::layout!(
            @ $p: $params, $head [$($field)*] [$($made)*] [$($lets)* let $local = $value;] $($rest)*
        );
    };
    (@ $p:ident: $params:ty, $head:tt [$($field:tt)*] [$($made:ident)*] [$($lets:tt)*]
        $(#[$doc:meta])+ $at:ident = $value:expr; $($rest:tt)*) => {
        $crate::layout!(
            @ $p: $params, $head [$($field)*] [$($made)*] [$($lets)*]
            $(#[$doc])+ $at: f64 = $value; $($rest)*
        );
    };
    (@ $p:ident: $params:ty, $head:tt [$($field:tt)*] [$($made:ident)*] [$($lets:tt)*]
        $(#[$doc:meta])+ $at:ident: $type:ty = $value:expr; $($rest:tt)*) => {
        $crate::layout!(
            @ $p: $params, $head [$($field)* $(#[$doc])+ pub $at: $type,] [$($made)* $at]
            [$($lets)* let $at = $value;] $($rest)*
        );
    };
    (@ $p:ident: $params:ty, [$(#[$doc:meta])+ $name:ident] [$($field:tt)*] [$($made:ident)*]
        [$($lets:tt)*]) => {
        $(#[$doc])+
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $($field)*
        }

        impl $name {
            /// Derives it; meaningful only for parameters that satisfy the family's constraints.
            pub fn new($p: &$params) -> Self {
                $($lets)*
                Self { $($made),* }
            }
        }
    };
}
pub(crate) use layout;

/// A sensor built from validated parameters.
#[derive(Clone, Debug)]
pub struct Design {
    /// The family that read the files.
    pub family: &'static str,
    /// The parts, layers and components.
    pub sensor: Sensor,
    /// Every parameter in the order of the schema, with value and source.
    pub parameters: Vec<parameters::Setting>,
    /// What follows from the parameters: name, value with unit; for `fabkit show`.
    pub derived: Vec<(String, String)>,
    /// The materials that are cast, in the order of the parameters that name them.
    pub materials: Vec<materials::Castable>,
    /// Files that belong to the design besides those of its parts.
    pub companions: Vec<Companion>,
    /// What may be bought, as fabkit and the user's files list it.
    pub articles: buying::Articles,
}

/// The families and sensors that fabkit comes with.
pub static REGISTRY: Registry = Registry::new(families::FAMILIES, families::SENSORS);

/// Names of the built-in sensors, sorted.
pub fn builtin_names() -> Vec<&'static str> {
    REGISTRY.builtin_names()
}

/// The YAML text of a built-in sensor.
pub fn builtin_yaml(name: &str) -> Option<&'static str> {
    REGISTRY.builtin_yaml(name)
}

/// Builds a design from YAML text and overrides.
///
/// `file` names the text in messages. Each override is `path=value` as on the command line. Keys at
/// the top that are among `others` are not read: other crates keep sections in the same files.
///
/// # Errors
/// Everything that is wrong, each with place, value, limit and a hint.
pub fn load(
    file: &str,
    yaml: &str,
    overrides: &[String],
    others: &[&str],
) -> Result<Design, parameters::InvalidDesign> {
    REGISTRY.load(file, yaml, overrides, others)
}

/// The JSON Schema (draft-07) of sensor files, without extensions.
pub fn json_schema() -> serde_json::Value {
    REGISTRY.json_schema(&[])
}
