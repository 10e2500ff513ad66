//! SVG files for laser cutters: millimetres, true arcs, hairlines (SVG 1.1).

use std::fmt::Write as _;

use fabkit_geometry::{Path, Segment};

use crate::drawing::{Drawing, NestedSheet, Operation, sweep};
use crate::{DocumentInfo, ExportError, VERSION};

/// Width of lines to cut, mm. Cutters treat lines thinner than 0.001 inch as cuts, wider ones as images.
const HAIRLINE_MM: f64 = 0.02;

/// Longer side of a large sheet's preview, px, and the largest scale of a small sheet's.
const IMAGE_PX: f64 = 640.0;
const MOST_PX_PER_MM: f64 = 4.0;

/// Writes a drawing as SVG: user units are millimetres, one group per operation in its own colour, every outline one
/// closed path of lines and circular arcs.
///
/// SVG's y axis points down: the drawing's top edge is y = 0.
///
/// # Errors
/// [`ExportError::Nothing`] without outlines, [`ExportError::NotCuttable`] for elliptic arcs.
///
/// ```
/// use fabkit_export::{DocumentInfo, Drawing, svg};
/// use fabkit_geometry::{Path, Profile};
///
/// let triangle = Profile::new(Path::polygon(&[[0.0, 0.0], [8.0, 0.0], [0.0, 6.0]]));
/// let document = DocumentInfo { title: "wedge", design_hash: "0123" };
/// let file = String::from_utf8(svg(document, &Drawing::from_piece(&triangle))?)?;
/// assert!(file.contains("width=\"8mm\" height=\"6mm\" viewBox=\"0 0 8 6\""));
/// // The corner at the drawing's lower left is at the bottom of the image: y = 6.
/// assert!(file.contains("M 0 6 L 8 6 L 0 0"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn svg(document: DocumentInfo, drawing: &Drawing) -> Result<Vec<u8>, ExportError> {
    if drawing.contours.is_empty() {
        return Err(ExportError::Nothing);
    }
    let [width, height] = drawing.size_mm;
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    // Writing to a String cannot fail.
    let _ = writeln!(
        xml,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{width}mm\" \
         height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">"
    );
    let _ = writeln!(xml, "<title>{}</title>", escaped(document.title));
    let _ = writeln!(
        xml,
        "<desc>fabkit {VERSION}; unit mm; design {}</desc>",
        escaped(document.design_hash)
    );
    write_groups(&mut xml, drawing, |operation| {
        let (layer, color) = (operation.layer(), operation.color_css());
        format!("id=\"{layer}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{HAIRLINE_MM}\"")
    })?;
    xml.push_str("</svg>\n");
    Ok(xml.into_bytes())
}

/// Draws a preview of a sheet's used corner for people: the stock in grey, cuts as clearly visible lines.
///
/// # Errors
/// See [`svg`].
///
/// ```
/// use fabkit_export::{Bed, Piece, nest, sheet_preview};
/// use fabkit_geometry::{Path, Profile};
///
/// let pad = Profile::new(Path::rectangle([0.0, 0.0], [96.0, 30.0], 0.0));
/// let piece = Piece { name: "pad", profile: &pad, quantity: 1 };
/// let sheets = nest(&[piece], Bed { size_mm: [600.0, 300.0], spacing_mm: 2.0 })?;
/// // 100 mm of the stock are used, shown with 4 px per mm.
/// let preview = String::from_utf8(sheet_preview(&sheets[0])?)?;
/// assert!(preview.contains("width=\"400\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sheet_preview(sheet: &NestedSheet) -> Result<Vec<u8>, ExportError> {
    let [stock_width, stock_height] = sheet.drawing.size_mm;
    let [width, height] = sheet.used_size_mm;
    // Lines are 1.2 px wide at any scale; the view box selects the used corner, which is at the bottom.
    let px_per_mm = (IMAGE_PX / width.max(height)).min(MOST_PX_PER_MM);
    let (stroke, top) = (1.2 / px_per_mm, stock_height - height);
    let mut xml = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0}\" height=\"{:.0}\" \
         viewBox=\"0 {top} {width} {height}\">\n\
         <rect width=\"{stock_width}\" height=\"{stock_height}\" fill=\"#f2efe8\"/>\n",
        width * px_per_mm,
        height * px_per_mm,
    );
    write_groups(&mut xml, &sheet.drawing, |operation| {
        let color = if operation == Operation::Label { "#666" } else { "#1f4e79" };
        format!("fill=\"none\" stroke=\"{color}\" stroke-width=\"{stroke}\"")
    })?;
    xml.push_str("</svg>\n");
    Ok(xml.into_bytes())
}

/// Writes one group of lines for each operation, with the attributes that `look` returns.
fn write_groups(
    xml: &mut String,
    drawing: &Drawing,
    look: impl Fn(Operation) -> String,
) -> Result<(), ExportError> {
    let height = drawing.size_mm[1];
    for operation in Operation::ALL {
        let mut paths = Vec::new();
        if operation == Operation::Label {
            // Lettering has no outline of its own and belongs to the label layer.
            paths.extend(drawing.strokes.iter().map(|stroke| polyline(stroke, height)));
        }
        for (_, path) in drawing.contours.iter().filter(|(o, _)| *o == operation) {
            paths.push(outline(path, height)?);
        }
        if paths.is_empty() {
            continue;
        }
        let _ = writeln!(xml, "<g {}>", look(operation));
        for path in paths {
            let _ = writeln!(xml, "<path d=\"{path}\"/>");
        }
        xml.push_str("</g>\n");
    }
    Ok(())
}

/// Returns the path data of a closed outline, with y turned downwards.
pub(crate) fn outline(path: &Path, height_mm: f64) -> Result<String, ExportError> {
    let mut from = path.start;
    let mut data = format!("M {}", point(from, height_mm));
    for segment in &path.segments {
        let end = point(segment.to(), height_mm);
        // Writing to a String cannot fail.
        let _ = match segment {
            Segment::Line { .. } => write!(data, " L {end}"),
            Segment::Arc { to, centre, ccw } => {
                let radius = (from[0] - centre[0]).hypot(from[1] - centre[1]);
                let turned = sweep(from, *to, *centre, *ccw).abs();
                let large = u8::from(turned > std::f64::consts::PI);
                // Sweep flag 1 turns from +x to +y, which is clockwise on the screen.
                write!(data, " A {radius} {radius} 0 {large} {} {end}", u8::from(!ccw))
            }
            Segment::EllipticArc { .. } => return Err(ExportError::NotCuttable),
        };
        from = segment.to();
    }
    data.push_str(" Z");
    Ok(data)
}

/// Returns the path data of an open polyline, with y turned downwards.
pub(crate) fn polyline(points: &[[f64; 2]], height_mm: f64) -> String {
    let points: Vec<String> = points.iter().map(|&p| point(p, height_mm)).collect();
    format!("M {}", points.join(" L "))
}

fn point([x, y]: [f64; 2], height_mm: f64) -> String {
    format!("{} {}", x + 0.0, height_mm - y)
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
