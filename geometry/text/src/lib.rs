//! Files that people write: read with every error at once, each with place, value, limit and hint.
//!
//! [`parse()`] reads YAML to values that know where they stand, for all kinds of file ([`Dialect`]).
//! Above it are two ways to read. What is declared with [`parameters!`] needs no more: from that one
//! declaration come the typed struct that code reads, the limits that are checked, the JSON Schema,
//! the rows of `fabkit show`, and the paths that `--set` knows. Other files are read key by key, with
//! a [`Reading`] that collects what is wrong. What programs write, as JSON, says what it is
//! ([`JsonFormat`]).
//!
//! Reading goes on after an error. For parameters the steps are: text to a tree, trees to one table
//! of values by path ([`Document`]: what a file `extends`, the file itself, then `--set`), table to
//! typed values within their limits ([`Reader`]), and last what is required of several values
//! together ([`Report`]).
//!
//! Why not serde: it stops at the first error, and forgets where values stood.

mod declare;
mod document;
mod expression;
mod facts;
mod json;
mod layer;
mod numbers;
mod overrides;
mod parse;
mod place;
mod problem;
mod reader;
mod reading;
mod report;
mod schema;
mod setting;
mod shown;
mod source;
mod suggest;
mod tree;
mod unknown;
mod value;

pub use declare::{Field, Inline, Look, Parameter, Section, Shape, join, summary};
pub use document::Document;
pub use expression::Formula;
pub use facts::{Facts, Suggestion, UNKNOWN_PARAMETER, number_and_unit};
pub use json::{InvalidDocument, JsonFormat};
pub use layer::TextLayer;
pub use numbers::Number;
pub use overrides::{OVERRIDES, apply_overrides};
pub use parse::{MAX_BYTES, MAX_DEPTH, MAX_NODES, Parsed, parse};
pub use place::{Found, Place, Written, WrittenText};
pub use problem::{InvalidDesign, Problem};
pub use reader::{Example, Reader};
pub use reading::{Reading, check_format, mapping_of, read_section, take_word};
pub use report::{Broken, Quantity, Report, Rule};
pub use schema::{FamilySchema, root_schema, section_schema};
pub use serde_json::Value as Json;
pub use setting::Setting;
pub use shown::shown;
pub use source::{Source, SourceKind};
pub use suggest::{did_you_mean, hint as suggestion, list_names, similar};
pub use tree::{Content, Dialect, Entry, Fault, Node, Position};
pub use value::{Kind, Name, Refusal, Scalar};
