//! What an export consists of, as JSON.

use fabkit_geometry::{Aabb, Pose};
use serde::{Serialize, Serializer};

use crate::{ExportError, MeshFigures, VERSION, json_bytes};

/// Everything an export wrote (`fabkit-manifest` version 1).
#[derive(Clone, Debug, Serialize)]
pub struct Manifest {
    /// The sensor's name.
    pub sensor: String,
    /// For people.
    pub title: String,
    /// The paper.
    pub reference: String,
    /// Identifies the parameters and the maker's version.
    pub design_hash: String,
    /// Every parameter as it was used, in the order of the schema.
    pub parameters: Vec<SettingEntry>,
    /// What was exported, in the order of the design.
    pub parts: Vec<PartEntry>,
    /// The files, sorted by name.
    pub files: Vec<FileEntry>,
}

/// One parameter.
#[derive(Clone, Debug, Serialize)]
pub struct SettingEntry {
    /// Dotted path.
    pub path: String,
    /// Value with unit.
    pub value: String,
}

/// One body.
#[derive(Clone, Debug, Serialize)]
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
    /// Growth or shrinkage applied to the files for the process; `none` for nominal geometry.
    pub compensation: String,
    /// Maps the part's own frame to that of its STL and 3MF files, mm.
    pub file_from_part: Pose,
    /// Bounds in the files, mm.
    #[serde(serialize_with = "corners")]
    pub bounds_in_file_mm: Aabb,
    /// The mesh in its STL and 3MF files.
    pub mesh: MeshFigures,
}

/// One file.
#[derive(Clone, Debug, Serialize)]
pub struct FileEntry {
    /// Name within the export's folder.
    pub name: String,
    /// Which bodies it holds; each as often as it lies in there.
    pub parts: Vec<String>,
    /// `stl`, `3mf`, `png` or `tree`.
    pub format: String,
    /// Size.
    pub bytes: u64,
    /// BLAKE3 of the content, in hex.
    pub blake3: String,
}

#[derive(Serialize)]
struct Form<'a> {
    format: &'static str,
    version: u32,
    fabkit: &'static str,
    #[serde(flatten)]
    manifest: &'a Manifest,
}

impl Manifest {
    /// The document as JSON.
    ///
    /// # Errors
    /// [`ExportError::Json`] if the encoder refuses.
    pub fn to_json(&self) -> Result<Vec<u8>, ExportError> {
        let (format, version) = ("fabkit-manifest", 1);
        json_bytes(&Form { format, version, fabkit: VERSION, manifest: self })
    }
}

fn corners<S: Serializer>(bounds: &Aabb, serializer: S) -> Result<S::Ok, S::Error> {
    let corners: [[f64; 3]; 2] = [bounds.min.coords.into(), bounds.max.coords.into()];
    corners.serialize(serializer)
}
