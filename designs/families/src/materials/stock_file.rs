//! The built-in file of what parts are printed, cut or milled from.

use fabkit_text::{Dialect, LocatedProblem, TextLayer, TextPlace, read_mapping, take_format};

use crate::user_catalogue::named_sections::{RawSection, SectionKind, read_sections};

/// Name of the file in messages.
pub(super) const BUILTIN_FILE: &str = "stock.yaml (built-in)";

/// Dialect of the file, which gives messages their nouns.
pub(super) static DIALECT: Dialect = Dialect::new("file of stock", 1, "");

/// Reads the sections below one of the file's keys.
pub(super) fn read_builtin(kind: SectionKind, found: &mut Vec<LocatedProblem>) -> Vec<RawSection> {
    let place = TextPlace::new(TextLayer::Base, BUILTIN_FILE, &DIALECT);
    let mut entries =
        read_mapping(include_str!("../../stock.yaml"), &place, found).unwrap_or_default();
    take_format(&mut entries, &place, found);
    match entries.iter().position(|entry| entry.key == kind.key) {
        Some(at) => read_sections(kind, entries.remove(at), &place, found),
        None => Vec::new(),
    }
}
