//! Quantities: conversion of parameters between numbers, in one unit for each kind, and text.

use fabkit_geometry::{Angle, Length};
use fabkit_text::Kind;

/// Returns the suffix of a column's name for parameters of this kind.
pub fn suffix(kind: Kind) -> &'static str {
    match kind {
        Kind::Length => "_mm",
        Kind::Angle => "_deg",
        _ => "",
    }
}

/// Returns whether values of the kind are numbers.
pub fn is_numeric(kind: Kind) -> bool {
    matches!(kind, Kind::Length | Kind::Angle | Kind::Count | Kind::Number)
}

/// Parses a text as a number: mm, degrees, or without unit; `None` for other texts.
pub fn parse(kind: Kind, text: &str) -> Option<f64> {
    let text = text.trim();
    match kind {
        Kind::Length => text.parse::<Length>().ok().map(Length::mm),
        Kind::Angle => text.parse::<Angle>().ok().map(|angle| tidy(angle.deg())),
        Kind::Count => text.parse::<u32>().ok().map(f64::from),
        Kind::Number => text.parse::<f64>().ok().filter(|number| number.is_finite()),
        Kind::Switch | Kind::Text | Kind::List => None,
    }
}

/// Formats a number as in a sensor's file.
pub fn show(kind: Kind, value: f64) -> String {
    match kind {
        Kind::Length => format!("{value} mm"),
        Kind::Angle => format!("{value} deg"),
        _ => format!("{value}"),
    }
}

/// Describes the notation of such a value, for messages.
pub fn example(kind: Kind) -> &'static str {
    match kind {
        Kind::Length => "a length such as `12 mm`",
        Kind::Angle => "an angle such as `120 deg`",
        Kind::Count => "a whole number",
        Kind::Number => "a number",
        Kind::Switch => "`true` or `false`",
        Kind::Text => "a word",
        Kind::List => "a list",
    }
}

/// Rounds to twelve significant digits, so that rounding errors are not written.
pub fn tidy(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
