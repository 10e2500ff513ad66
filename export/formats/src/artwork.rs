//! Printed pages with dark areas and thin lines at true size, such as calibration boards.
//!
//! A calibration board is only as good as its scale. These files therefore state their page size in millimetres and
//! hold vectors only: no raster image that a printer could resample, and no font that it could replace.

mod pdf;

use std::fmt::Write as _;

use fabkit_geometry::{Path, Segment};

use crate::drawing::{Drawing, Operation, lettering};
use crate::svg::{escaped, outline, polyline};
use crate::{DocumentInfo, ExportError, VERSION, dxf};

/// A printed page in mm, with its origin in the lower left corner, x to the right and y upwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Artwork {
    /// Width and height of the page, mm.
    pub page_mm: [f64; 2],
    /// Closed polygons that bound the dark areas, by the even-odd rule. Boundaries of dark areas run one way, those of
    /// light islands in them the other.
    pub dark: Vec<Path>,
    /// Open polylines, mm.
    pub strokes: Vec<Vec<[f64; 2]>>,
}

/// Width of thin lines, mm. Every printer shows it, and a ruler is read to better than half of it.
pub(crate) const STROKE_MM: f64 = 0.15;

impl Artwork {
    /// Height of a label's capitals, mm.
    pub const LABEL_MM: f64 = lettering::HEIGHT_MM;

    /// Adds a line of single-stroke capitals whose baseline starts at a point, mm.
    ///
    /// Letters, digits, spaces and `-.,%()` are supported; any other character becomes a box.
    pub fn label(&mut self, text: &str, start_mm: [f64; 2]) {
        self.strokes.extend(lettering::strokes(text, start_mm));
    }

    /// Width of a label, mm.
    ///
    /// ```
    /// use fabkit_export::Artwork;
    ///
    /// let width_mm = Artwork::label_width_mm("7 MM");
    /// let mut page = Artwork { page_mm: [40.0, 10.0], ..Artwork::default() };
    /// page.label("7 MM", [3.0, 2.0]);
    /// let points = page.strokes.concat();
    /// let right_mm = points.iter().fold(0.0f64, |most, [x, _]| most.max(*x));
    /// let top_mm = points.iter().fold(0.0f64, |most, [_, y]| most.max(*y));
    /// assert!((right_mm - (3.0 + width_mm)).abs() < 1e-12);
    /// assert!((top_mm - (2.0 + Artwork::LABEL_MM)).abs() < 1e-12);
    /// ```
    pub fn label_width_mm(text: &str) -> f64 {
        lettering::width_mm(text)
    }

    /// Writes SVG 1.1 with the page size in millimetres; user units are millimetres.
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
    /// [`ExportError::Nothing`] without dark areas, [`ExportError::NotCuttable`] for elliptic arcs.
    pub fn svg(&self, title: &str) -> Result<Vec<u8>, ExportError> {
        if self.dark.is_empty() {
            return Err(ExportError::Nothing);
        }
        let [width, height] = self.page_mm;
        let dark: Result<Vec<_>, _> = self.dark.iter().map(|path| outline(path, height)).collect();
        let strokes: Vec<_> = self.strokes.iter().map(|s| polyline(s, height)).collect();
        let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        // Writing to a String cannot fail. The white background covers a viewer's grey one.
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

    /// Writes one page of PDF 1.4 (ISO 32000-1), with its page box in points of 1/72 inch.
    ///
    /// # Errors
    /// [`ExportError::Nothing`] without dark areas, [`ExportError::NotCuttable`] for anything but straight lines.
    ///
    /// ```
    /// use fabkit_export::Artwork;
    /// use fabkit_geometry::Path;
    ///
    /// // A page of one inch: 72 points.
    /// let dark = vec![Path::rectangle([12.7, 12.7], [10.0, 10.0], 0.0)];
    /// let page = Artwork { page_mm: [25.4, 25.4], dark, strokes: Vec::new() };
    /// let text = String::from_utf8(page.pdf("one square")?)?;
    /// assert!(text.starts_with("%PDF-1.4") && text.contains("/MediaBox [0 0 72 72]"));
    /// let round = Artwork { dark: vec![Path::circle([12.7, 12.7], 5.0)], ..page };
    /// assert!(round.pdf("one disc").is_err() && round.svg("one disc").is_ok());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pdf(&self, title: &str) -> Result<Vec<u8>, ExportError> {
        pdf::write(self, title)
    }

    /// Writes DXF like [`dxf`](crate::dxf()), with the boundaries of dark areas on the engraving layer.
    ///
    /// # Errors
    /// See [`Artwork::svg`].
    pub fn dxf(&self, document: DocumentInfo) -> Result<Vec<u8>, ExportError> {
        let contours = self.dark.iter().map(|path| (Operation::Engrave, path.clone())).collect();
        let drawing = Drawing { size_mm: self.page_mm, contours, strokes: self.strokes.clone() };
        dxf(document, &drawing)
    }
}

/// Returns the corners of a polygon.
fn corners(path: &Path) -> Result<Vec<[f64; 2]>, ExportError> {
    let ends = path.segments.iter().map(|segment| match segment {
        Segment::Line { to } => Ok(*to),
        Segment::Arc { .. } | Segment::EllipticArc { .. } => Err(ExportError::NotCuttable),
    });
    ends.collect()
}
