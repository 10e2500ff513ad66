//! What an export consists of, as JSON.

use fabkit_geometry::{Aabb, Pose};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::{ExportError, MeshFigures, VERSION, json_bytes};

/// Everything an export wrote (`fabkit-manifest` version 1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The sensor's name.
    pub sensor: String,
    /// For people.
    pub title: String,
    /// The paper.
    pub reference: String,
    /// Identifies the parameters and the maker's version.
    pub design_hash: String,
    /// How it was exported; unknown in the manifests of old versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub options: Option<OptionsEntry>,
    /// Every parameter as it was used, in the order of the schema.
    pub parameters: Vec<SettingEntry>,
    /// The printer's profile that was given, and which parts it is for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<ProfileEntry>,
    /// What was exported, in the order of the design.
    pub parts: Vec<PartEntry>,
    /// The files, sorted by name.
    pub files: Vec<FileEntry>,
    /// What else lies in the folder, sorted by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<OtherFile>,
}

/// What files depend on besides the design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptionsEntry {
    /// Largest distance between triangles and the exact surface, mm.
    pub tolerance_mm: f64,
    /// Length of the edges of tetrahedra, mm; where it was said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_mm: Option<f64>,
    /// Printer bed of the plates, mm.
    pub bed_mm: [f64; 2],
    /// Stock sheets of flat parts, mm.
    pub stock_mm: [f64; 2],
    /// Width of the laser's cut, mm; by material where nothing was said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kerf_mm: Option<f64>,
    /// The printer's profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<GivenProfile>,
    /// Whether the profile is for all materials of its process.
    #[serde(default, skip_serializing_if = "is_false")]
    pub any_material: bool,
    /// As designed, without making up for anything.
    pub nominal: bool,
}

/// A printer's profile among the options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GivenProfile {
    /// Its name.
    pub name: String,
    /// BLAKE3 of its values, in hex.
    pub blake3: String,
}

/// A file in an export's folder that the export does not stand for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherFile {
    /// Name within the folder.
    pub name: String,
    /// Why it is not among the files.
    pub why: Otherness,
    /// BLAKE3 of the content, in hex, of what an earlier export wrote.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blake3: Option<String>,
}

/// Why a file in an export's folder is not among its files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Otherness {
    /// An earlier export wrote it, of another version of the design or with other options.
    Stale,
    /// An earlier export wrote it, and somebody has changed it since.
    Changed,
    /// No export wrote it.
    Foreign,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SettingEntry {
    /// Dotted path.
    pub path: String,
    /// Value with unit.
    pub value: String,
}

/// A printer's profile, and what it was applied to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProfileEntry {
    /// Name of the printer.
    pub name: String,
    /// How the coupon was printed that it was measured on, for example `fdm`.
    pub process: String,
    /// From what.
    pub material: String,
    /// Whether it was to be applied to all materials of its process.
    pub for_any_material: bool,
    /// Parts whose STL and 3MF files make up for it.
    pub applied: Vec<String>,
    /// Those of them that are of another material than the coupon.
    pub applied_to_other_material: Vec<String>,
    /// What is as designed, in the order of the design.
    pub not_applied: Vec<NotApplied>,
}

/// A body that a printer's profile says nothing of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NotApplied {
    /// Its name.
    pub part: String,
    /// How it is made; empty for what is bought.
    pub process: String,
    /// From what; empty for what is bought.
    pub material: String,
    /// `other-process` or `other-material`.
    pub because: String,
}

/// One body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartEntry {
    /// Its name, and that of its files.
    pub name: String,
    /// `part`, `layer` or `component`.
    pub kind: String,
    /// One line for people.
    pub summary: String,
    /// How it is made, for example `fdm`; empty for what is bought.
    pub process: String,
    /// From what; empty for what is bought.
    pub material: String,
    /// How many a lab needs.
    pub quantity: u32,
    /// What its STL, 3MF, DXF and SVG files differ in from the nominal geometry.
    pub compensation: Compensation,
    /// Maps the part's own frame, after scaling about its origin, to that of its STL and 3MF
    /// files, mm. Where `compensation.print` stretches the files, everything moves away from the
    /// place of the part's origin, along the files' axes.
    pub file_from_part: Pose,
    /// Bounds in the files, mm.
    #[serde(serialize_with = "corners", deserialize_with = "from_corners")]
    pub bounds_in_file_mm: Aabb,
    /// The mesh in its STL and 3MF files.
    pub mesh: MeshFigures,
    /// The outlines in its DXF and SVG files, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sheet: Option<SheetFigures>,
    /// What it is made on, where a file says so, and what differs by that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineEntry>,
}

/// What a part is made on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MachineEntry {
    /// As its owner calls it.
    pub name: String,
    /// What differs from how the part is usually made.
    pub note: String,
}

/// How exported copies differ from the nominal geometry, which pictures, trees and ground truth
/// show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compensation {
    /// Factor about the part's origin; 1 for none. Outlines grow in their plane only: a sheet is as
    /// thick as its stock.
    pub scale: f64,
    /// Width of the cut that the outlines in DXF and SVG files make room for, mm; 0 for none.
    pub kerf_mm: f64,
    /// What the copy makes up for of the printer's own deviations, where there is a profile of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub print: Option<PrintCompensation>,
    /// For people; `none` for nominal geometry.
    pub note: String,
}

/// What STL and 3MF files make up for of one printer's deviations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrintCompensation {
    /// Name of the printer's profile.
    pub profile: String,
    /// Factors along x, y and z of the files.
    pub scale: [f64; 3],
    /// The printer makes an upright round hole of diameter d as `hole_gain * d + hole_offset_mm`;
    /// fitted holes have the diameter that comes out as designed.
    pub hole_gain: f64,
    /// See `hole_gain`, mm.
    pub hole_offset_mm: f64,
    /// How many holes are fitted.
    pub holes_fitted: usize,
    /// How many round holes are not: they are not upright, or far from what was measured.
    pub holes_left: usize,
    /// How far the printer's first layer spreads, mm. Files do not make up for it: slicers do.
    pub elephant_foot_left_mm: f64,
}

/// What is cut, as written to DXF and SVG files.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SheetFigures {
    /// Thickness of the stock, mm.
    pub thickness_mm: f64,
    /// Width and height of the outline, mm.
    pub size_mm: [f64; 2],
    /// Area between the outlines, mm^2.
    pub area_mm2: f64,
    /// Length of all cuts, mm.
    pub cut_mm: f64,
}

/// One file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Name within the export's folder.
    pub name: String,
    /// Which bodies it holds; each as often as it lies in there.
    pub parts: Vec<String>,
    /// How all of it is made, for plates and stock sheets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub process: Option<String>,
    /// From what all of it is made, for plates and stock sheets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// In a word, `stl` or `3mf`: one of those that `export` knows, or what the name ends in.
    pub format: String,
    /// Size.
    pub bytes: u64,
    /// BLAKE3 of the content, in hex.
    pub blake3: String,
}

fn is_false(value: &bool) -> bool {
    !value
}

const FORMAT: (&str, u32) = ("fabkit-manifest", Manifest::VERSION);

#[derive(Serialize)]
struct Form<'a> {
    format: &'static str,
    version: u32,
    fabkit: &'static str,
    #[serde(flatten)]
    manifest: &'a Manifest,
}

#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
}

impl Manifest {
    /// Of the document.
    pub const VERSION: u32 = 1;

    /// The document as JSON.
    ///
    /// # Errors
    /// [`ExportError::Json`] if the encoder refuses.
    pub fn to_json(&self) -> Result<Vec<u8>, ExportError> {
        let (format, version) = FORMAT;
        json_bytes(&Form { format, version, fabkit: VERSION, manifest: self })
    }

    /// Reads the document; nothing if it is none, or one of a version that is not known.
    pub fn from_json(bytes: &[u8]) -> Option<Self> {
        let Head { format, version } = serde_json::from_slice(bytes).ok()?;
        ((format.as_str(), version) == FORMAT).then(|| serde_json::from_slice(bytes).ok())?
    }
}

fn from_corners<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Aabb, D::Error> {
    let [min, max] = <[[f64; 3]; 2]>::deserialize(deserializer)?;
    Ok(Aabb { min: min.into(), max: max.into() })
}

fn corners<S: Serializer>(bounds: &Aabb, serializer: S) -> Result<S::Ok, S::Error> {
    let corners: [[f64; 3]; 2] = [bounds.min.coords.into(), bounds.max.coords.into()];
    corners.serialize(serializer)
}
