//! Quantities: conversion of parameters between numbers, in one unit for each kind, and text.

use fabkit_geometry::{Angle, Length};
use fabkit_text::ValueKind;

/// Returns the suffix of a column's name for parameters of this kind.
pub fn suffix(kind: ValueKind) -> &'static str {
    match kind {
        ValueKind::Length => "_mm",
        ValueKind::Angle => "_deg",
        _ => "",
    }
}

/// Returns whether values of the kind are numbers.
pub fn is_numeric(kind: ValueKind) -> bool {
    matches!(kind, ValueKind::Length | ValueKind::Angle | ValueKind::Count | ValueKind::Number)
}

/// Parses a text as a number: mm, degrees, or without unit; `None` for other texts.
pub fn parse(kind: ValueKind, text: &str) -> Option<f64> {
    let text = text.trim();
    match kind {
        ValueKind::Length => text.parse::<Length>().ok().map(Length::mm),
        ValueKind::Angle => text.parse::<Angle>().ok().map(|angle| round_digits(angle.deg())),
        ValueKind::Count => text.parse::<u32>().ok().map(f64::from),
        ValueKind::Number => text.parse::<f64>().ok().filter(|number| number.is_finite()),
        ValueKind::Switch | ValueKind::Text | ValueKind::List => None,
    }
}

/// Formats a number as in a sensor's file.
pub fn format_quantity(kind: ValueKind, value: f64) -> String {
    match kind {
        ValueKind::Length => format!("{value} mm"),
        ValueKind::Angle => format!("{value} deg"),
        _ => format!("{value}"),
    }
}

/// Describes the notation of such a value, for messages.
pub fn example(kind: ValueKind) -> &'static str {
    match kind {
        ValueKind::Length => "a length such as `12 mm`",
        ValueKind::Angle => "an angle such as `120 deg`",
        ValueKind::Count => "a whole number",
        ValueKind::Number => "a number",
        ValueKind::Switch => "`true` or `false`",
        ValueKind::Text => "a word",
        ValueKind::List => "a list",
    }
}

/// Rounds to twelve significant digits, so that rounding errors are not written.
pub fn round_digits(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
