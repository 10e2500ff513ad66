//! What holds for all of the repository and the command: its crates, lists, documents and messages.

mod bad_input;
mod contracts;
mod crate_graph;
mod documents;
mod papers;
mod problems;
mod registry;
