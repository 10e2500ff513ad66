//! PDF files, written without a library: one page of filled polygons and lines takes five objects, and PDF crates stamp
//! files with the clock.

use std::fmt::Write as _;

use super::{Artwork, STROKE_MM, corners};
use crate::{ExportError, VERSION};

/// Number of points of 1/72 inch, the unit of PDF's page boxes, per millimetre.
const POINTS_PER_MM: f64 = 72.0 / 25.4;

/// Writes the file: five objects, the cross-reference table and the trailer.
pub(super) fn write(artwork: &Artwork, title: &str) -> Result<Vec<u8>, ExportError> {
    if artwork.dark.is_empty() {
        return Err(ExportError::Nothing);
    }
    let content = content(artwork)?;
    let [width, height] = artwork.page_mm.map(|mm| number(mm * POINTS_PER_MM));
    let objects = [
        "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>".to_owned(),
        "<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_owned(),
        format!(
            "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width} {height}] /Resources << >> \
             /Contents 4 0 R >>"
        ),
        format!("<< /Length {} >>\nstream\n{content}endstream", content.len()),
        format!("<< /Title ({}) /Producer (fabkit {VERSION}) >>", string(title)),
    ];

    let mut file = String::from("%PDF-1.4\n");
    let mut offsets = Vec::new();
    for (i, object) in objects.iter().enumerate() {
        offsets.push(file.len());
        // Writing to a String cannot fail.
        let _ = write!(file, "{} 0 obj\n{object}\nendobj\n", i + 1);
    }
    let start = file.len();
    let count = objects.len() + 1;
    // Entries of the cross-reference table are exactly 20 bytes, line end included.
    let _ = write!(file, "xref\n0 {count}\n0000000000 65535 f \n");
    for offset in offsets {
        let _ = writeln!(file, "{offset:010} 00000 n ");
    }
    let _ = write!(
        file,
        "trailer\n<< /Size {count} /Root 1 0 R /Info {} 0 R >>\nstartxref\n{start}\n%%EOF\n",
        objects.len()
    );
    Ok(file.into_bytes())
}

/// Writes the page's operators, in millimetres after one scaling.
fn content(artwork: &Artwork) -> Result<String, ExportError> {
    let scale = POINTS_PER_MM;
    let mut text = format!("{scale:.9} 0 0 {scale:.9} 0 0 cm\n0 g 0 G {STROKE_MM} w\n");
    for path in &artwork.dark {
        for (i, point) in corners(path)?.into_iter().enumerate() {
            push(&mut text, point, if i == 0 { "m" } else { "l" });
        }
        text.push_str("h\n");
    }
    // Fills all paths at once by the even-odd rule.
    text.push_str("f*\n");
    for stroke in &artwork.strokes {
        for (i, &point) in stroke.iter().enumerate() {
            push(&mut text, point, if i == 0 { "m" } else { "l" });
        }
        text.push_str("S\n");
    }
    Ok(text)
}

fn push(text: &mut String, [x, y]: [f64; 2], operator: &str) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{} {} {operator}", number(x), number(y));
}

/// Formats a number without exponent, which PDF does not allow; a tenth of a nanometre is far below any printer's
/// resolution.
fn number(value: f64) -> String {
    let text = format!("{:.7}", value + 0.0);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Escapes a literal string: printable ASCII, with its delimiters escaped.
fn string(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '(' | ')' | '\\' => out.extend(['\\', c]),
            ' '..='~' => out.push(c),
            _ => out.push('?'),
        }
    }
    out
}
