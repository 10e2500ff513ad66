//! Errors of writing files.

/// Errors of writing a file format.
///
/// ```
/// use fabkit_export::{Bed, ExportError, pack, png};
///
/// let slab = pack(&[("slab", [10.0, 201.0])], Bed::default()).unwrap_err();
/// let says = "slab needs 10.0 x 201.0 mm of the bed; 240 x 200 mm are usable";
/// assert_eq!(slab.to_string(), says);
/// let short = png(2, 2, &[0; 11]).unwrap_err();
/// assert!(matches!(short, ExportError::ImageSize { needed: 12, found: 11, .. }));
/// ```
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Size above the format's counters.
    #[error("{what} needs {needed}, but the format holds {limit}")]
    TooLarge {
        /// Name of the quantity.
        what: &'static str,
        /// Required size.
        needed: u64,
        /// Largest size of the format.
        limit: u64,
    },
    /// Archive or plate without a single object.
    #[error("there is nothing to write")]
    Nothing,
    /// Object that does not fit on the printer's bed.
    #[error(
        "{name} needs {:.1} x {:.1} mm of the bed; {:.0} x {:.0} mm are usable",
        .size_mm[0], .size_mm[1], .usable_mm[0], .usable_mm[1]
    )]
    LargerThanBed {
        /// Name of the object.
        name: String,
        /// Footprint of the object, mm.
        size_mm: [f64; 2],
        /// Bed without its margin, mm.
        usable_mm: [f64; 2],
    },
    /// Piece that does not fit on a stock sheet.
    #[error(
        "{name} needs {:.1} x {:.1} mm; a stock sheet of {:.0} x {:.0} mm has {:.1} x {:.1} mm",
        .size_mm[0], .size_mm[1], .stock_mm[0], .stock_mm[1], .usable_mm[0], .usable_mm[1]
    )]
    LargerThanStock {
        /// Name of the piece.
        name: String,
        /// Bounding box of the piece, turned along the stock, mm.
        size_mm: [f64; 2],
        /// Size of the stock sheet, mm.
        stock_mm: [f64; 2],
        /// Stock without its margin, mm.
        usable_mm: [f64; 2],
    },
    /// Outline that the beam closes or divides.
    #[error("a kerf of {kerf_mm} mm closes or divides {outline}")]
    KerfTooWide {
        /// Description of the outline.
        outline: String,
        /// Width of the beam, mm.
        kerf_mm: f64,
    },
    /// Outline that contains elliptic arcs.
    #[error("an arc of an ellipse cannot be drawn; outlines are lines and circular arcs")]
    NotCuttable,
    /// Array whose shape does not match its number of values.
    #[error("array {name}: shape {shape:?} does not hold {values} values")]
    Shape {
        /// Name of the array.
        name: String,
        /// Given shape.
        shape: Vec<usize>,
        /// Number of values.
        values: usize,
    },
    /// Pixel data that does not match the image size.
    #[error("{width_px} x {height_px} pixels need {needed} values, there are {found}")]
    ImageSize {
        /// Width, px.
        width_px: u32,
        /// Height, px.
        height_px: u32,
        /// Number of values that the size requires: one a pixel of a grey image, three of a colour image.
        needed: u64,
        /// Number of values given.
        found: usize,
    },
    /// Error of the PNG encoder.
    #[error("PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// Error of the deflate encoder.
    #[error("deflate: {0}")]
    Deflate(#[from] std::io::Error),
    /// Solid that cannot be sampled.
    #[error("{name} cannot be sampled: {reason}")]
    Samples {
        /// Name of the body.
        name: String,
        /// Reason.
        reason: String,
    },
    /// Error of the JSON encoder.
    #[error("JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Table that cannot be written as Parquet.
    #[error("the table cannot be written: {0}")]
    Table(String),
}
