//! Manifest of an export, as JSON.

use fabkit_geometry::{Aabb, Pose};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::{ExportError, MeshFigures, VERSION, json_bytes};

/// Record of everything that an export wrote (`fabkit-manifest` version 1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name of the sensor.
    pub sensor: String,
    /// Title for people.
    pub title: String,
    /// Paper that describes the sensor.
    pub reference: String,
    /// Hash of the parameters and the fabkit version.
    pub design_hash: String,
    /// Options of the export; missing in manifests of old versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub options: Option<OptionsEntry>,
    /// Every parameter as used, in the order of the schema.
    pub parameters: Vec<SettingEntry>,
    /// Printer profile, if given, and the parts it applies to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<ProfileEntry>,
    /// Exported bodies, in the order of the design.
    pub parts: Vec<PartEntry>,
    /// Files, sorted by name.
    pub files: Vec<FileEntry>,
    /// Other files in the folder, sorted by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<UnlistedFile>,
}

/// Options of an export, on which files depend besides the design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptionsEntry {
    /// Largest distance between triangles and the exact surface, mm.
    pub tolerance_mm: f64,
    /// Edge length of tetrahedra, mm; `None` if not specified.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_mm: Option<f64>,
    /// Printer bed of the plates, mm.
    pub bed_mm: [f64; 2],
    /// Stock sheets of flat parts, mm.
    pub stock_mm: [f64; 2],
    /// Width of the laser's cut, mm; `None` for the materials' own values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kerf_mm: Option<f64>,
    /// Printer profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<ProfileReference>,
    /// True if the profile applies to all materials of its process.
    #[serde(default, skip_serializing_if = "is_false")]
    pub any_material: bool,
    /// True if files are nominal, without any compensation.
    pub nominal: bool,
}

/// Reference to a printer profile among the options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProfileReference {
    /// Name of the profile.
    pub name: String,
    /// BLAKE3 of the profile's values, in hex.
    pub blake3: String,
}

/// A file in an export's folder that is not part of the export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnlistedFile {
    /// Name within the folder.
    pub name: String,
    /// Reason why the file is not part of the export.
    pub why: UnlistedReason,
    /// BLAKE3 of the content, in hex, if an earlier export wrote it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blake3: Option<String>,
}

/// Reason why a file in an export's folder is not among the export's files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnlistedReason {
    /// Written by an earlier export of another version of the design or with other options.
    Stale,
    /// Written by an earlier export, and changed since.
    Changed,
    /// Not written by any export.
    Foreign,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SettingEntry {
    /// Dotted path of the parameter.
    pub path: String,
    /// Value with its unit.
    pub value: String,
}

/// A printer profile and the parts it was applied to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProfileEntry {
    /// Name of the printer.
    pub name: String,
    /// Process that printed the measured coupon, for example `fdm`.
    pub process: String,
    /// Material of the coupon.
    pub material: String,
    /// True if the profile was to be applied to all materials of its process.
    pub for_any_material: bool,
    /// Parts whose STL and 3MF files are compensated.
    pub applied: Vec<String>,
    /// Compensated parts of another material than the coupon.
    pub applied_to_other_material: Vec<String>,
    /// Bodies that stay as designed, in the order of the design.
    pub not_applied: Vec<UncompensatedBody>,
}

/// A body to which a printer profile does not apply.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UncompensatedBody {
    /// Name of the body.
    pub part: String,
    /// Process of the body; empty for bought components.
    pub process: String,
    /// Material of the body; empty for bought components.
    pub material: String,
    /// Reason: `other-process` or `other-material`.
    pub because: String,
}

/// A body of the export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartEntry {
    /// Name of the body and of its files.
    pub name: String,
    /// Kind of body: `part`, `layer` or `component`.
    pub kind: String,
    /// Summary in one line for people.
    pub summary: String,
    /// Process, for example `fdm`; empty for bought components.
    pub process: String,
    /// Material; empty for bought components.
    pub material: String,
    /// Number of copies that a lab needs.
    pub quantity: u32,
    /// Differences of its STL, 3MF, DXF and SVG files from the nominal geometry.
    pub compensation: Compensation,
    /// Transform from the part's own frame, after scaling about its origin, to that of its STL and 3MF files, mm. Where
    /// `compensation.print` stretches the files, everything moves away from the position of the part's origin, along
    /// the files' axes.
    pub file_from_part: Pose,
    /// Bounds in the files, mm.
    #[serde(serialize_with = "corners", deserialize_with = "from_corners")]
    pub bounds_in_file_mm: Aabb,
    /// Figures of the mesh in its STL and 3MF files.
    pub mesh: MeshFigures,
    /// Figures of the outlines in its DXF and SVG files, if there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sheet: Option<SheetFigures>,
    /// Machine for this part, if a user's file names one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineEntry>,
}

/// Machine that makes a part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MachineEntry {
    /// Name that its owner gave it.
    pub name: String,
    /// Difference from how the part is usually made.
    pub note: String,
}

/// Differences of exported files from the nominal geometry, which images, trees and ground truth show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compensation {
    /// Scale about the part's origin; 1 for none. Outlines grow in their plane only: a sheet is as thick as its stock.
    pub scale: f64,
    /// Width of the cut for which outlines in DXF and SVG files are widened, mm; 0 for none.
    pub kerf_mm: f64,
    /// Compensation of the printer's own deviations, if a profile is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub print: Option<PrintCompensation>,
    /// Description for people; `none` for nominal geometry.
    pub note: String,
}

/// Compensation of one printer's deviations in STL and 3MF files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrintCompensation {
    /// Name of the printer's profile.
    pub profile: String,
    /// Scale factors along x, y and z of the files.
    pub scale: [f64; 3],
    /// Gain of the printer's hole diameters: an upright round hole of diameter d comes out as `hole_gain * d +
    /// hole_offset_mm`. Fitted holes are drawn so that they come out as designed.
    pub hole_gain: f64,
    /// Offset of the printer's hole diameters, mm; see `hole_gain`.
    pub hole_offset_mm: f64,
    /// Number of fitted holes.
    pub holes_fitted: usize,
    /// Number of round holes that are not fitted: they are not upright, or their diameters are far from those measured.
    pub holes_left: usize,
    /// Spread of the printer's first layer, mm. Slicers compensate it, files do not.
    pub elephant_foot_left_mm: f64,
}

/// Figures of the cut outlines in DXF and SVG files.
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

/// A file of the export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Name within the export's folder.
    pub name: String,
    /// Names of the bodies in the file, repeated for each copy.
    pub parts: Vec<String>,
    /// Process of the whole file, for plates and stock sheets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub process: Option<String>,
    /// Material of the whole file, for plates and stock sheets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Format as one word, such as `stl` or `3mf`: a name that `export` accepts, or the file's extension.
    pub format: String,
    /// `compensated` or `nominal`, for files of parts whose geometry differs between formats: `compensation` of the part
    /// says by what.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry: Option<String>,
    /// Size in bytes.
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
    /// Version of the document.
    pub const VERSION: u32 = 1;

    /// Writes the document as JSON.
    ///
    /// # Errors
    /// [`ExportError::Json`] if the encoder fails.
    pub fn to_json(&self) -> Result<Vec<u8>, ExportError> {
        let (format, version) = FORMAT;
        json_bytes(&Form { format, version, fabkit: VERSION, manifest: self })
    }

    /// Reads the document; `None` if it is not a manifest, or one of an unknown version.
    ///
    /// ```
    /// use fabkit_export::Manifest;
    ///
    /// let manifest = Manifest {
    ///     sensor: "rtac0".into(),
    ///     title: "R-Tac0".into(),
    ///     reference: String::new(),
    ///     design_hash: "0123".into(),
    ///     options: None,
    ///     parameters: Vec::new(),
    ///     profile: None,
    ///     parts: Vec::new(),
    ///     files: Vec::new(),
    ///     others: Vec::new(),
    /// };
    /// let bytes = manifest.to_json()?;
    /// assert_eq!(Manifest::from_json(&bytes), Some(manifest));
    /// let newer = String::from_utf8(bytes)?.replace("\"version\": 1", "\"version\": 2");
    /// assert_eq!(Manifest::from_json(newer.as_bytes()), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_json(bytes: &[u8]) -> Option<Self> {
        // Format and version first: the rest of another version would fail to parse for the wrong reason.
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
