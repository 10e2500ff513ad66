//! Options of an export.

use fabkit_designs::profile::ProcessProfile;
use fabkit_export::{Bed, OptionsEntry, ProfileReference};
use fabkit_geometry::Sensor;

use super::Format;

/// Options of an export.
///
/// ```
/// use fabkit_application::exports::{ExportOptions, Format};
/// let options = ExportOptions::default();
/// assert_eq!(options.formats, [Format::Stl, Format::ThreeMf, Format::Dxf]);
/// // No names stand for all parts, and lengths are compensated where a profile or a kerf is known.
/// assert!(options.parts.is_empty() && !options.nominal);
/// ```
#[derive(Clone, Debug)]
pub struct ExportOptions {
    /// Names of bodies, layers and components included; empty for all parts.
    pub parts: Vec<String>,
    /// File formats, sorted, each once.
    pub formats: Vec<Format>,
    /// Chord tolerance: largest distance between triangles and the exact surface, mm.
    pub tolerance_mm: f64,
    /// Edge length of tetrahedra, mm; [`DEFAULT_EDGE_MM`](super::DEFAULT_EDGE_MM) if absent.
    pub edge_mm: Option<f64>,
    /// Printer bed on which plates are laid out.
    pub bed: Bed,
    /// Stock sheet from which flat parts are cut.
    pub stock: Bed,
    /// Kerf of the laser, mm; by material if absent.
    pub kerf_mm: Option<f64>,
    /// Printer profile; it is compensated in files of parts of its process and material.
    pub profile: Option<ProcessProfile>,
    /// Apply the profile also to parts of its process in another material.
    pub profile_for_any_material: bool,
    /// Write the nominal geometry: no compensation of shrinkage, kerf or printer errors.
    pub nominal: bool,
}

impl ExportOptions {
    /// Returns the options without boards for a sensor that has none. A package of many designs holds the boards that
    /// exist, while boards requested by name that do not exist are an error.
    ///
    /// ```
    /// use fabkit_application::exports::{ExportOptions, Format};
    /// use fabkit_application::source::Target;
    ///
    /// let wanted = ExportOptions { formats: vec![Format::Stl, Format::Gerber], ..ExportOptions::default() };
    /// // A pin dome has no circuit.
    /// let dome = Target::new("rtac0/pin-dome").design(&[])?;
    /// assert_eq!(wanted.for_sensor(&dome.sensor).formats, [Format::Stl]);
    /// # Ok::<(), fabkit_application::Error>(())
    /// ```
    pub fn for_sensor(&self, sensor: &Sensor) -> Self {
        let has_boards = sensor.circuits.iter().any(|circuit| circuit.board.is_some());
        let mut options = self.clone();
        options.formats.retain(|format| has_boards || *format != Format::Gerber);
        options
    }

    /// Returns the manifest's entry of the options: everything that the files' content depends on.
    pub(super) fn manifest_entry(&self) -> OptionsEntry {
        let profile = self.profile.as_ref().map(|profile| ProfileReference {
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

    /// Returns whether any requested file may differ from the nominal design.
    pub(super) fn has_compensation(&self) -> bool {
        !self.nominal && self.formats.iter().any(|format| format.is_compensated())
    }

    /// Returns whether any requested file may compensate a printer's errors.
    pub(super) fn has_printed_files(&self) -> bool {
        !self.nominal
            && self.formats.iter().any(|format| format.is_compensated() && !format.is_drawing())
    }
}

/// Default stock sheet: the 600 x 300 mm of a common desktop laser, pieces 3 mm apart.
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
