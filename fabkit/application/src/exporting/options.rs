//! What to export.

use fabkit_designs::profile::ProcessProfile;
use fabkit_export::{Bed, GivenProfile, OptionsEntry};
use fabkit_geometry::Sensor;

use super::Format;

/// What to export.
#[derive(Clone, Debug)]
pub struct ExportOptions {
    /// Bodies by name, layers and components too; empty for all parts.
    pub parts: Vec<String>,
    /// Which files; sorted, each once.
    pub formats: Vec<Format>,
    /// Largest distance between triangles and the exact surface, mm.
    pub tolerance_mm: f64,
    /// Length of the edges of tetrahedra, mm; [`DEFAULT_EDGE_MM`](super::DEFAULT_EDGE_MM) where nothing is said.
    pub edge_mm: Option<f64>,
    /// Where plates are laid out.
    pub bed: Bed,
    /// Sheets from which flat parts are cut.
    pub stock: Bed,
    /// Width of the laser's cut, mm; by material where nothing is said.
    pub kerf_mm: Option<f64>,
    /// What the printer does to sizes; files of parts of its process and material make up for it.
    pub profile: Option<ProcessProfile>,
    /// Apply the profile to parts of its process that are of another material too.
    pub profile_for_any_material: bool,
    /// Write the geometry as designed: no scaling against shrinkage, no room for the kerf, and no
    /// profile.
    pub nominal: bool,
}

impl ExportOptions {
    /// The same without boards for a sensor that has none of its own: a package of many designs holds what each
    /// of them has, while boards that are asked for by name and are not there are an error.
    pub fn for_sensor(&self, sensor: &Sensor) -> Self {
        let has_boards = sensor.circuits.iter().any(|circuit| circuit.board.is_some());
        let mut options = self.clone();
        options.formats.retain(|format| has_boards || *format != Format::Gerber);
        options
    }

    /// What the manifest says of them: all that the content of files depends on.
    pub(super) fn entry(&self) -> OptionsEntry {
        let profile = self.profile.as_ref().map(|profile| GivenProfile {
            name: profile.name.as_str().to_owned(),
            blake3: blake3::hash(profile.to_yaml(&[]).as_bytes()).to_hex().to_string(),
        });
        OptionsEntry {
            tolerance_mm: self.tolerance_mm,
            edge_mm: self.edge_mm,
            bed_mm: self.bed.size_mm,
            stock_mm: self.stock.size_mm,
            kerf_mm: self.kerf_mm,
            profile,
            any_material: self.profile_for_any_material,
            nominal: self.nominal,
        }
    }

    /// Whether any file may differ from the design.
    pub(super) fn compensates(&self) -> bool {
        !self.nominal && self.formats.iter().any(|format| format.is_compensated())
    }

    /// Whether any file may make up for what a printer does.
    pub(super) fn prints(&self) -> bool {
        !self.nominal
            && self.formats.iter().any(|format| format.is_compensated() && !format.is_drawing())
    }
}

/// The 600 x 300 mm of a common desktop laser, pieces 3 mm apart.
pub const DEFAULT_STOCK: Bed = Bed { size_mm: [600.0, 300.0], spacing_mm: 3.0 };

impl Default for ExportOptions {
    fn default() -> Self {
        Self {
            parts: Vec::new(),
            formats: vec![Format::Stl, Format::ThreeMf, Format::Dxf],
            tolerance_mm: fabkit_mesh::DEFAULT_TOLERANCE_MM,
            edge_mm: None,
            bed: Bed::default(),
            stock: DEFAULT_STOCK,
            kerf_mm: None,
            profile: None,
            profile_for_any_material: false,
            nominal: false,
        }
    }
}
