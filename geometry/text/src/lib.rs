//! Reading of files that people write. Every error is reported at once, each with place, value, limit and hint.
//!
//! [`parse()`] reads YAML into a tree whose values carry their positions, for every kind of file ([`Dialect`]). There
//! are two ways to read such a tree. Parameters declared with [`parameters!`] are read automatically: that one
//! declaration yields the typed struct, the limits that are checked, the JSON Schema, the rows of `fabkit show`, and
//! the paths that `--set` accepts. Other files are read key by key with a [`NodeReader`], which collects the errors. Files
//! that programs write are JSON with a format name and a version ([`JsonFormat`]).
//!
//! Reading goes on after an error. For parameters the steps are: text to a tree; trees to one table of values by path
//! ([`ParameterTable`]: the file named by `extends`, the file itself, then `--set`); table to typed values within their
//! limits ([`Reader`]); and last the rules that relate several values ([`RuleReport`]).
//!
//! serde is not used for these files because it stops at the first error and loses the positions of values.
//!
//! ```
//! use fabkit_geometry::Length;
//! use fabkit_text::{Dialect, TextLayer, TextPlace, parameters, read_section};
//!
//! parameters! {
//!     /// A washer.
//!     pub struct Washer {
//!         /// Outer radius.
//!         radius: Length = 1.0..=20.0,
//!         /// Number of holes.
//!         holes: u32 = 1..=4,
//!     }
//! }
//! const WASHER: &Dialect = &Dialect::new("washer", 1, "");
//! let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
//! let washer: Washer = read_section("format: 1\nradius: 1.2 cm\nholes: 2\n", &place)?;
//! assert_eq!((washer.radius.mm(), washer.holes), (12.0, 2));
//! let invalid = read_section::<Washer>("format: 1\nradius: 12\nholes: 9\n", &place).unwrap_err();
//! let says = "radius is `12`, which has no unit; it must be between 1 mm and 20 mm";
//! assert_eq!(invalid.problems[0].to_string(), format!("washer.yaml:2:9: {says}"));
//! assert_eq!(invalid.problems[1].hint.as_deref(), Some("the nearest allowed value is 4"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod declare;
mod expression;
mod facts;
mod json;
mod layer;
mod limited_quantity;
mod node_reader;
mod numbers;
mod overrides;
mod parameter_table;
mod parse;
mod place;
mod printable;
mod problem;
mod reader;
mod report;
mod schema;
mod setting;
mod source;
mod suggest;
mod tree;
mod trial;
mod unknown_path;
mod value;

pub use declare::{
    FieldDeclaration, FieldShape, Inline, NeighbourCallback, Parameter, Section, join, summary,
};
pub use expression::Formula;
pub use facts::{ProblemFacts, Suggestion, UNKNOWN_PARAMETER, number_and_unit};
pub use json::{InvalidDocument, JsonFormat};
pub use layer::TextLayer;
pub use limited_quantity::LimitedQuantity;
pub use node_reader::{NodeReader, read_mapping, read_section, take_format, take_word};
pub use numbers::NumericParameter;
pub use overrides::{OVERRIDE_FILE_NAME, apply_overrides};
pub use parameter_table::ParameterTable;
pub use parse::{MAX_BYTES, MAX_DEPTH, MAX_NODES, Parsed, parse};
pub use place::{LocatedProblem, TextPlace, WrittenText, WrittenValue, WrittenValues};
pub use printable::{escape_steering, is_steering, to_printable};
pub use problem::{InvalidDesign, MAX_PROBLEMS, Problem, list_problems};
pub use reader::{Example, Reader};
pub use report::{BrokenRule, RuleId, RuleReport};
pub use schema::{FamilySchema, root_schema, section_schema};
pub use serde_json::Value as Json;
pub use setting::Setting;
pub use source::{SourceKind, ValueSource};
pub use suggest::{did_you_mean, find_similar, list_names, suggest_or_list as suggestion};
pub use tree::{Dialect, Position, YamlContent, YamlEntry, YamlFault, YamlNode};
pub use trial::TrialTable;
pub use value::{FileSafeName, Refusal, Scalar, ValueKind};
