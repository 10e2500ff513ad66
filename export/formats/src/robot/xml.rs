//! Helpers of XML formats.

use fabkit_geometry::{Pose, Vector3};

use super::numbers::{MM_PER_M, numbers};

/// Formats the translation of a pose, metres.
pub(super) fn translation_m(pose: &Pose) -> String {
    numbers(pose.translation_mm().iter().map(|mm| mm / MM_PER_M))
}

pub(super) fn vector(vector: &Vector3<f64>) -> String {
    numbers(vector.iter().copied())
}

/// Escapes text for an attribute or between tags.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            other => escaped.push(other),
        }
    }
    escaped
}

/// Formats a comment, which must not contain two hyphens in a row.
pub(super) fn comment(text: &str) -> String {
    format!("<!-- {} -->", text.replace("--", "- -"))
}
