//! Outlines of parts cut from sheets, and their nesting on stock sheets.

use std::collections::BTreeMap;

use fabkit_designs::Design;
use fabkit_export::{
    Compensation, DocumentInfo, Drawing, NestedSheet, Piece, SheetFigures, nest, sheet_preview,
    widen_for_kerf,
};
use fabkit_files::staging::OutputFile;
use fabkit_geometry::{Body, Process, Profile};
use fabkit_guide::{SheetPiece, SheetPlan};

use super::compensation::compute_compensation;
use super::formats::FormatWriter;
use super::{ExportOptions, ExportRunError, MadeFile, MeshedPart, stock};

/// Outlines of a part as they are cut, kerf included.
pub(super) struct CutSheet {
    profile: Profile,
    thickness_mm: f64,
}

/// Returns whether parts of this process have outlines.
fn is_flat(process: Process) -> bool {
    matches!(process, Process::Laser | Process::Pcb)
}

/// Returns the outlines of a part cut from a sheet; `None` for other parts.
///
/// # Errors
/// [`ExportRunError::NotASheet`] if the solid is not flat, [`ExportRunError::Outline`] if the kerf closes an outline.
pub(super) fn cut_sheet(
    body: &Body,
    compensation: &Compensation,
) -> Result<Option<CutSheet>, ExportRunError> {
    if !body.process().is_some_and(is_flat) {
        return Ok(None);
    }
    let sheet = body.solid.as_sheet().map_err(|source| ExportRunError::NotASheet {
        part: body.name.clone(),
        process: body.process_word(),
        source,
    })?;
    // Only the outlines are scaled against the shrinkage of what is cast between sheets. Their thickness is the
    // stock's.
    let scaled = match compensation.scale {
        1.0 => sheet.profile,
        scale => sheet.profile.scaled(scale),
    };
    let profile = widen_for_kerf(&scaled, compensation.kerf_mm)
        .map_err(|source| ExportRunError::Outline { part: body.name.clone(), source })?;
    Ok(Some(CutSheet { profile, thickness_mm: sheet.thickness_mm }))
}

impl CutSheet {
    /// Returns the manifest's figures.
    pub(super) fn figures(&self) -> SheetFigures {
        let [min, max] = self.profile.bounds_mm();
        SheetFigures {
            thickness_mm: self.thickness_mm,
            size_mm: [max[0] - min[0], max[1] - min[1]],
            area_mm2: self.profile.area_mm2(),
            cut_mm: self.profile.boundary_mm(),
        }
    }

    /// Returns the drawing of this part alone.
    pub(super) fn drawing(&self) -> Drawing {
        Drawing::from_piece(&self.profile)
    }
}

/// Makes one drawing for each stock sheet: `sheet-acrylic-3mm-1.dxf` and so on, each with as many pieces of one
/// material and thickness as fit. Circuit boards are ordered singly and are not nested.
///
/// # Errors
/// [`ExportRunError::Stock`] for a piece larger than the stock.
pub(super) fn nested_files(
    design: &Design,
    hash: &str,
    options: &ExportOptions,
    meshed: &[MeshedPart],
) -> Result<Vec<MadeFile>, ExportRunError> {
    let cut = meshed.iter().filter(|m| m.body.process() == Some(Process::Laser));
    let cut = cut.filter_map(|m| Some((m.body, m.sheet.as_ref()?))).collect::<Vec<_>>();
    let mut made = Vec::new();
    for StockSheets { name, material, sheets, .. } in nest_stock(&cut, 1, options)? {
        for (i, sheet) in sheets.into_iter().enumerate() {
            let title = format!("{name}-{}", i + 1);
            let heading = format!("{}: {title}", design.sensor.title);
            let document = DocumentInfo { title: &heading, design_hash: hash };
            for format in &options.formats {
                let FormatWriter::Outlines(write) = format.making() else { continue };
                let name = format.file_name(&title);
                let bytes = write(document, &sheet.drawing)
                    .map_err(|source| ExportRunError::Write { file: name.clone(), source })?;
                let file = OutputFile { name, bytes };
                made.push(MadeFile {
                    file,
                    format: format.word(),
                    parts: sheet.pieces.clone(),
                    stock: Some((Process::Laser, material.clone())),
                });
            }
        }
    }
    Ok(made)
}

/// Stock sheets of one material and thickness, with all pieces cut from them.
struct StockSheets {
    /// Name, for example `sheet-acrylic-3mm`.
    name: String,
    material: String,
    thickness_mm: f64,
    cut_mm: f64,
    area_mm2: f64,
    sheets: Vec<NestedSheet>,
}

/// Nests all pieces for `units` units, by material and thickness.
fn nest_stock(
    cut: &[(&Body, &CutSheet)],
    units: u32,
    options: &ExportOptions,
) -> Result<Vec<StockSheets>, ExportRunError> {
    let words = stock::material_words(cut.iter().map(|(body, _)| body.material.as_str()));
    let mut stocks: BTreeMap<String, Vec<(&Body, &CutSheet)>> = BTreeMap::new();
    for &(body, sheet) in cut {
        let name = format!(
            "sheet-{}-{}",
            words[body.material.as_str()],
            format_thickness(sheet.thickness_mm)
        );
        stocks.entry(name).or_default().push((body, sheet));
    }
    let stock = |(name, cut): (String, Vec<(&Body, &CutSheet)>)| {
        let piece = |(body, sheet): &(&Body, &CutSheet)| (body.quantity * units, sheet.figures());
        let pieces: Vec<Piece> = cut
            .iter()
            .map(|(body, sheet)| Piece {
                name: &body.name,
                profile: &sheet.profile,
                quantity: body.quantity * units,
            })
            .collect();
        let sum = |of: &dyn Fn(&SheetFigures) -> f64| {
            cut.iter()
                .map(piece)
                .map(|(count, figures)| f64::from(count) * of(&figures))
                .sum::<f64>()
        };
        Ok(StockSheets {
            // All pieces here share material and thickness, which the name contains.
            material: cut[0].0.material.clone(),
            thickness_mm: cut[0].1.thickness_mm,
            cut_mm: sum(&|figures| figures.cut_mm),
            area_mm2: sum(&|figures| figures.area_mm2),
            sheets: nest(&pieces, options.stock).map_err(ExportRunError::Stock)?,
            name,
        })
    };
    stocks.into_iter().map(stock).collect()
}

/// Sheet plans, and an SVG drawing of each sheet by its title.
pub(crate) type PlannedSheets = (Vec<SheetPlan>, BTreeMap<String, Vec<u8>>);

/// Nests the pieces of `units` units as `export` does, and draws each sheet.
///
/// # Errors
/// Errors of the export itself.
pub(crate) fn plan(design: &Design, units: u32) -> Result<PlannedSheets, ExportRunError> {
    let options = ExportOptions::default();
    let mut cut = Vec::new();
    for body in design.sensor.parts().filter(|body| body.process() == Some(Process::Laser)) {
        if let Some(sheet) = cut_sheet(body, &compute_compensation(body, &options, true))? {
            cut.push((body, sheet));
        }
    }
    let cut: Vec<(&Body, &CutSheet)> = cut.iter().map(|(body, sheet)| (*body, sheet)).collect();
    let (mut plans, mut drawings) = (Vec::new(), BTreeMap::new());
    let stock_mm = options.stock.size_mm;
    for stocked in nest_stock(&cut, units, &options)? {
        let mut pieces = BTreeMap::<String, usize>::new();
        for (i, sheet) in stocked.sheets.iter().enumerate() {
            sheet.pieces.iter().for_each(|name| *pieces.entry(name.clone()).or_default() += 1);
            let title = format!("{}-{}", stocked.name, i + 1);
            let bytes = sheet_preview(sheet)
                .map_err(|source| ExportRunError::Write { file: title.clone(), source })?;
            drawings.insert(title, bytes);
        }
        let sheets = stocked.sheets.len();
        plans.push(SheetPlan {
            used: stocked.area_mm2 / (sheets as f64 * stock_mm[0] * stock_mm[1]),
            name: stocked.name,
            material: stocked.material,
            thickness_mm: stocked.thickness_mm,
            stock_mm,
            sheets,
            needs_mm: stocked
                .sheets
                .iter()
                .map(|sheet| sheet.used_size_mm.map(f64::ceil))
                .collect(),
            pieces: pieces.into_iter().map(|(name, count)| SheetPiece { name, count }).collect(),
            cut_mm: stocked.cut_mm,
        });
    }
    Ok((plans, drawings))
}

/// Formats a thickness rounded to a micrometre, which is finer than any sheet's tolerance.
fn format_thickness(mm: f64) -> String {
    format!("{}mm", (mm * 1000.0).round() / 1000.0)
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::Solid;

    use super::*;

    #[test]
    fn outlines_of_molds_are_scaled_before_they_are_widened() {
        let solid = Solid::cuboid(40.0, 20.0, 3.0);
        let mut frame = Body::made("mold-frame", "", Process::Laser, solid).for_shrinkage(0.02);
        frame.substance.laser_kerf_mm = Some(0.25);
        let options = ExportOptions::default();
        let sheet =
            cut_sheet(&frame, &compute_compensation(&frame, &options, true)).unwrap().unwrap();
        let SheetFigures { size_mm, thickness_mm, .. } = sheet.figures();
        for (size, nominal) in size_mm.into_iter().zip([40.0, 20.0]) {
            assert!((size - nominal / 0.98 - 0.25).abs() < 1e-9, "{size_mm:?}");
        }
        assert_eq!(thickness_mm, 3.0);
    }

    #[test]
    fn stock_is_named_by_its_thickness_to_a_micrometre() {
        assert_eq!(format_thickness(0.1 + 0.2), "0.3mm");
        assert_eq!(format_thickness(3.0), "3mm");
    }
}
