//! Why there are no bytes.

/// What cannot be written in the format asked for.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// More than the format's counters hold.
    #[error("{what} needs {needed}, but the format holds {limit}")]
    TooLarge {
        /// What does not fit.
        what: &'static str,
        /// How much it is.
        needed: u64,
        /// How much fits.
        limit: u64,
    },
    /// An archive or plate without a single object.
    #[error("there is nothing to write")]
    Nothing,
    /// An object that does not fit on the printer's bed.
    #[error(
        "{name} needs {:.1} x {:.1} mm of the bed; {:.0} x {:.0} mm are usable",
        .size_mm[0], .size_mm[1], .usable_mm[0], .usable_mm[1]
    )]
    LargerThanBed {
        /// Which object.
        name: String,
        /// Its footprint, mm.
        size_mm: [f64; 2],
        /// The bed without its margin, mm.
        usable_mm: [f64; 2],
    },
    /// A piece that does not fit on a stock sheet.
    #[error(
        "{name} needs {:.1} x {:.1} mm; a stock sheet of {:.0} x {:.0} mm has {:.1} x {:.1} mm",
        .size_mm[0], .size_mm[1], .stock_mm[0], .stock_mm[1], .usable_mm[0], .usable_mm[1]
    )]
    LargerThanStock {
        /// Which piece.
        name: String,
        /// Its box, turned along the stock, mm.
        size_mm: [f64; 2],
        /// The whole stock sheet, mm.
        stock_mm: [f64; 2],
        /// The stock without its margin, mm.
        usable_mm: [f64; 2],
    },
    /// An outline that the beam closes or divides.
    #[error("a kerf of {kerf_mm} mm closes or divides {outline}")]
    KerfTooWide {
        /// Which outline.
        outline: String,
        /// Width of the beam, mm.
        kerf_mm: f64,
    },
    /// An outline that is not made of lines and circular arcs.
    #[error("an arc of an ellipse cannot be drawn; outlines are lines and circular arcs")]
    NotCuttable,
    /// An array whose shape does not hold its values.
    #[error("array {name}: shape {shape:?} does not hold {values} values")]
    Shape {
        /// Which array.
        name: String,
        /// As given.
        shape: Vec<usize>,
        /// How many there are.
        values: usize,
    },
    /// Pixels and picture size disagree.
    #[error("{width_px} x {height_px} pixels need {needed} bytes of RGB, there are {found}")]
    PictureSize {
        /// Width, px.
        width_px: u32,
        /// Height, px.
        height_px: u32,
        /// Bytes that the size asks for.
        needed: u64,
        /// Bytes that are there.
        found: usize,
    },
    /// The PNG encoder refused.
    #[error("PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// The deflate encoder refused.
    #[error("deflate: {0}")]
    Deflate(#[from] std::io::Error),
    /// A solid that cannot be sampled.
    #[error("{name} cannot be sampled: {reason}")]
    Samples {
        /// Which body.
        name: String,
        /// Why.
        reason: String,
    },
    /// The JSON encoder refused.
    #[error("JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A table that no file can hold.
    #[error("the table cannot be written: {0}")]
    Table(String),
}
