//! What is cut from stock sheets, and how many of them.

use serde::Serialize;

use crate::Guide;

/// The stock sheets of one material and thickness, for all units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetPlan {
    /// What the files of its sheets are called, for example `sheet-acrylic-3mm`.
    pub name: String,
    /// What it is of.
    pub material: String,
    /// How thick it is, mm.
    pub thickness_mm: f64,
    /// Width and height of one sheet, mm.
    pub stock_mm: [f64; 2],
    /// How many sheets.
    pub sheets: usize,
    /// For each sheet, the corner of it that holds everything, mm: a remnant of this size will do.
    pub needs_mm: Vec<[f64; 2]>,
    /// What is cut.
    pub pieces: Vec<SheetPiece>,
    /// Length of all cuts, mm.
    pub cut_mm: f64,
    /// Share of the sheets that the pieces take, 0 to 1.
    pub used: f64,
}

/// A piece of a sheet.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SheetPiece {
    /// The part's name.
    pub name: String,
    /// How often it lies on all sheets.
    pub count: usize,
}

impl Guide {
    /// Takes the plan of what is cut, which asks for kerfs and stock sizes that the guide does not know.
    pub fn take_sheets(&mut self, plans: Vec<SheetPlan>) {
        self.sheets = plans;
    }
}
