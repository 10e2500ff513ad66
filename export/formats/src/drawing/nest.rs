//! Layout of pieces on stock sheets.

use fabkit_geometry::Profile;

use super::{Drawing, lettering};
use crate::{Bed, ExportError, pack};

/// Gap between a piece and its label below it, mm.
const LABEL_GAP_MM: f64 = 1.0;

/// A piece to cut, with its number of copies.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'a> {
    /// Text of the label.
    pub name: &'a str,
    /// Outlines to cut, with kerf compensation, mm.
    pub profile: &'a Profile,
    /// Number of copies.
    pub quantity: u32,
}

/// One stock sheet with pieces on it.
#[derive(Clone, Debug, PartialEq)]
pub struct NestedSheet {
    /// Drawing of the size of the stock.
    pub drawing: Drawing,
    /// Size of the stock's corner that holds everything with the spacing around it, mm; a remnant of this size
    /// suffices.
    pub used_size_mm: [f64; 2],
    /// Names of the pieces in the order of cutting, repeated for each copy.
    pub pieces: Vec<String>,
}

/// A copy of a piece with the room that it takes.
struct Cell<'a> {
    name: &'a str,
    /// Outlines, with the bounding box's lower left corner at the origin.
    profile: Profile,
    size_mm: [f64; 2],
    /// Height of the label's strip below the piece, mm; 0 without a label.
    strip_mm: f64,
}

/// Lays all pieces out in rows on few stock sheets, each with its label.
///
/// Pieces lie along the stock: those that are longer the other way are turned by 90 degrees. `stock.spacing_mm` stays
/// free around every piece and its label. A piece that would only fit without its label goes without one.
///
/// # Errors
/// [`ExportError::LargerThanStock`] for the first piece that does not fit on a sheet.
///
/// ```
/// use fabkit_export::{Bed, Piece, nest};
/// use fabkit_geometry::{Path, Profile};
///
/// let strip = Profile::new(Path::rectangle([0.0, 0.0], [10.0, 30.0], 0.0));
/// let piece = Piece { name: "pad", profile: &strip, quantity: 3 };
/// let stock = Bed { size_mm: [100.0, 60.0], spacing_mm: 2.0 };
/// let sheets = nest(&[piece], stock)?;
/// assert_eq!((sheets.len(), sheets[0].pieces.len()), (1, 3));
/// // Turned along the stock, three strips of 30 mm and four gaps fill a row.
/// assert!((sheets[0].used_size_mm[0] - 98.0).abs() < 1e-9);
/// // A sheet of 33 mm has 29 mm between its margins.
/// assert!(nest(&[piece], Bed { size_mm: [33.0, 33.0], ..stock }).is_err());
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn nest(pieces: &[Piece], stock: Bed) -> Result<Vec<NestedSheet>, ExportError> {
    let cells: Vec<Cell> =
        pieces.iter().flat_map(|piece| (0..piece.quantity).map(|_| cell(piece, stock))).collect();
    let footprints: Vec<(&str, [f64; 2])> = cells
        .iter()
        .map(|cell| {
            let label_mm = if cell.strip_mm > 0.0 { lettering::width_mm(cell.name) } else { 0.0 };
            let [width_mm, depth_mm] = cell.size_mm;
            (cell.name, [width_mm.max(label_mm), depth_mm + cell.strip_mm])
        })
        .collect();
    // The same packing as for printer beds, with an error that names the stock.
    let spots = pack(&footprints, stock).map_err(|error| match error {
        ExportError::LargerThanBed { name, size_mm, usable_mm } => {
            ExportError::LargerThanStock { name, size_mm, stock_mm: stock.size_mm, usable_mm }
        }
        other => other,
    })?;
    let count = spots.iter().map(|spot| spot.plate + 1).max().unwrap_or(0);
    let empty = Drawing { size_mm: stock.size_mm, ..Drawing::default() };
    let mut sheets =
        vec![NestedSheet { drawing: empty, used_size_mm: [0.0; 2], pieces: Vec::new() }; count];
    for ((cell, (_, size_mm)), spot) in cells.iter().zip(&footprints).zip(&spots) {
        let [left_mm, front_mm] = spot.corner_mm;
        let sheet = &mut sheets[spot.plate];
        sheet.drawing.add(&cell.profile.shifted([left_mm, front_mm + cell.strip_mm]));
        let ends_mm = [left_mm + size_mm[0], front_mm + size_mm[1]];
        for (needs_mm, end_mm) in sheet.used_size_mm.iter_mut().zip(ends_mm) {
            *needs_mm = needs_mm.max(end_mm + stock.spacing_mm);
        }
        if cell.strip_mm > 0.0 {
            sheet.drawing.strokes.extend(lettering::strokes(cell.name, [left_mm, front_mm]));
        }
        sheet.pieces.push(cell.name.to_owned());
    }
    Ok(sheets)
}

/// Turns a piece along the stock and decides whether its label fits.
fn cell<'a>(piece: &Piece<'a>, stock: Bed) -> Cell<'a> {
    let size = |profile: &Profile| {
        let [min, max] = profile.bounds_mm();
        ([max[0] - min[0], max[1] - min[1]], min)
    };
    // The longer side of a piece goes along the longer side of the stock.
    let is_wide = |[x, y]: [f64; 2]| x >= y;
    let mut profile = piece.profile.clone();
    let (mut size_mm, mut min) = size(&profile);
    let lies_across = is_wide(size_mm) != is_wide(stock.size_mm);
    if lies_across && size_mm[0] != size_mm[1] {
        profile = profile.quarter_turned();
        (size_mm, min) = size(&profile);
    }
    let strip_mm = LABEL_GAP_MM + lettering::HEIGHT_MM;
    let usable_mm = stock.size_mm.map(|side| side - 2.0 * stock.spacing_mm);
    let has_room =
        lettering::width_mm(piece.name) <= usable_mm[0] && size_mm[1] + strip_mm <= usable_mm[1];
    Cell {
        name: piece.name,
        profile: profile.shifted([-min[0], -min[1]]),
        size_mm,
        strip_mm: if has_room { strip_mm } else { 0.0 },
    }
}
