//! What holds for all of the repository and the command: its crates, lists, documents and messages.

mod bad_input;
mod captures;
mod circles;
mod contracts;
mod crate_graph;
mod crates;
mod documents;
mod doors;
mod light;
mod limits;
mod material_names;
mod modules;
mod papers;
mod paths;
mod plan;
mod problems;
mod registry;
mod rules;
mod terminal;
mod tokens;
