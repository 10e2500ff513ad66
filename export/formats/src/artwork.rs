//! Sheets to look at rather than to cut: dark areas and thin lines at true size.
//!
//! A calibration board is as good as its scale. So these files name their page in millimetres and
//! hold vectors only: no picture that a printer could resample, and no font that it could replace.

mod pdf;

use std::fmt::Write as _;

use fabkit_geometry::{Path, Segment};

use crate::drawing::{Drawing, Operation, lettering};
use crate::svg::{escaped, outline, polyline};
use crate::{Document, ExportError, VERSION, dxf};

/// A printed page; origin in the lower left corner, x to the right and y upwards, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Artwork {
    /// Width and height of the page, mm.
    pub page_mm: [f64; 2],
    /// Closed polygons that together bound the dark areas: a point is dark if an odd number of
    /// them is around it. Those around dark run one way, those around light in dark the other.
    pub dark: Vec<Path>,
    /// Open polylines, mm.
    pub strokes: Vec<Vec<[f64; 2]>>,
}

/// Width of thin lines, mm: every printer shows it, and a ruler is read to better than half of it.
pub(crate) const STROKE_MM: f64 = 0.15;

impl Artwork {
    /// Height of a label's letters, mm.
    pub const LABEL_MM: f64 = lettering::HEIGHT_MM;

    /// Adds a line of single-stroke capitals whose baseline starts at a point, mm.
    ///
    /// Letters, digits, spaces, hyphens and full stops; anything else becomes a box.
    pub fn label(&mut self, text: &str, start_mm: [f64; 2]) {
        self.strokes.extend(lettering::strokes(text, start_mm));
    }

    /// How wide a label is, mm.
    pub fn label_width_mm(text: &str) -> f64 {
        lettering::width_mm(text)
    }

    /// SVG 1.1 with the page's size in millimetres; user units are millimetres.
    ///
    /// ```
    /// use fabkit_export::Artwork;
    /// use fabkit_geometry::Path;
    /// let square = Path::rectangle([5.0, 5.0], [4.0, 4.0], 0.0);
    /// let art = Artwork { page_mm: [10.0, 10.0], dark: vec![square], strokes: Vec::new() };
    /// let text = String::from_utf8(art.svg("one square")?)?;
    /// assert!(text.contains("width=\"10mm\""));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ExportError::Nothing`] without dark areas, [`ExportError::NotCuttable`] for arcs of
    /// ellipses.
    pub fn svg(&self, title: &str) -> Result<Vec<u8>, ExportError> {
        if self.dark.is_empty() {
            return Err(ExportError::Nothing);
        }
        let [width, height] = self.page_mm;
        let dark: Result<Vec<_>, _> = self.dark.iter().map(|path| outline(path, height)).collect();
        let strokes: Vec<_> = self.strokes.iter().map(|s| polyline(s, height)).collect();
        let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        // Writing to a String cannot fail. White below: a viewer may show pages on grey.
        let _ = writeln!(
            xml,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{width}mm\" \
             height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">\n\
             <title>{}</title>\n\
             <desc>fabkit {VERSION}; unit mm; print at 100 %</desc>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n\
             <path fill=\"#000000\" fill-rule=\"evenodd\" d=\"{}\"/>",
            escaped(title),
            dark?.join("\n"),
        );
        if !strokes.is_empty() {
            let _ = writeln!(
                xml,
                "<path fill=\"none\" stroke=\"#000000\" stroke-width=\"{STROKE_MM}\" d=\"{}\"/>",
                strokes.join("\n"),
            );
        }
        xml.push_str("</svg>\n");
        Ok(xml.into_bytes())
    }

    /// One page of PDF 1.4 (ISO 32000-1), its page box in points of 1/72 inch.
    ///
    /// # Errors
    /// [`ExportError::Nothing`] without dark areas, [`ExportError::NotCuttable`] for anything but
    /// straight lines.
    pub fn pdf(&self, title: &str) -> Result<Vec<u8>, ExportError> {
        pdf::write(self, title)
    }

    /// DXF as of [`dxf`](crate::dxf()): boundaries of dark areas on the layer of engravings.
    ///
    /// # Errors
    /// As [`Artwork::svg`].
    pub fn dxf(&self, document: Document) -> Result<Vec<u8>, ExportError> {
        let contours = self.dark.iter().map(|path| (Operation::Engrave, path.clone())).collect();
        let drawing = Drawing { size_mm: self.page_mm, contours, strokes: self.strokes.clone() };
        dxf(document, &drawing)
    }
}

/// Corners of a polygon.
fn corners(path: &Path) -> Result<Vec<[f64; 2]>, ExportError> {
    let ends = path.segments.iter().map(|segment| match segment {
        Segment::Line { to } => Ok(*to),
        Segment::Arc { .. } | Segment::EllipticArc { .. } => Err(ExportError::NotCuttable),
    });
    ends.collect()
}
