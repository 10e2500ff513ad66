//! Plans of parts cut from stock sheets.

use serde::Serialize;

use crate::Guide;

/// Stock sheets of one material and thickness, for all units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetPlan {
    /// Name of the sheets' files, for example `sheet-acrylic-3mm`.
    pub name: String,
    /// Material of the sheets.
    pub material: String,
    /// Thickness, mm.
    pub thickness_mm: f64,
    /// Width and height of one sheet, mm.
    pub stock_mm: [f64; 2],
    /// Number of sheets.
    pub sheets: usize,
    /// For each sheet, width and height of the corner that holds all pieces, mm: a remnant of this size is enough.
    pub needs_mm: Vec<[f64; 2]>,
    /// Pieces to cut.
    pub pieces: Vec<SheetPiece>,
    /// Length of all cuts, mm.
    pub cut_mm: f64,
    /// Fraction of the sheets that the pieces cover, 0 to 1.
    pub used: f64,
}

/// Piece cut from a sheet.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SheetPiece {
    /// Name of the part.
    pub name: String,
    /// Number of copies on all sheets.
    pub count: usize,
}

impl Guide {
    /// Sets the plans of sheets. They depend on kerfs and stock sizes, which the guide does not know.
    pub fn set_sheets(&mut self, plans: Vec<SheetPlan>) {
        self.sheets = plans;
    }
}
