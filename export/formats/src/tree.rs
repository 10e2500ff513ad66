//! Exact geometry as JSON, for rebuilding a part without fabkit.

mod figures;
mod samples;

pub use self::figures::{ExactFigures, moments};
pub use self::samples::{SamplesDocument, samples};

use fabkit_geometry::{Color, Landmark, Placement, Pose, Solid};
use serde::{Deserialize, Serialize};

use crate::{ExportError, VERSION, json_bytes};

/// Figures of a written mesh, for comparison with a rebuilt part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshFigures {
    /// Largest distance between triangles and the exact surface, mm.
    pub chord_tolerance_mm: f64,
    /// Number of triangles.
    pub triangles: usize,
    /// Enclosed volume, mm^3.
    pub volume_mm3: f64,
    /// Surface area, mm^2.
    pub area_mm2: f64,
    /// Genus: number of through holes and handles.
    pub genus: i32,
}

/// Content of a tree file.
#[derive(Clone, Copy, Debug)]
pub struct TreeDocument<'a> {
    /// Hash of the design and the fabkit version.
    pub design_hash: &'a str,
    /// Name of the sensor.
    pub sensor: &'a str,
    /// Name of the body.
    pub name: &'a str,
    /// Kind of body: `part`, `layer` or `component`.
    pub kind: &'a str,
    /// Summary in one line for people.
    pub summary: &'a str,
    /// Process, for example `fdm`; empty for bought components.
    pub process: &'a str,
    /// Material; empty for bought components.
    pub material: &'a str,
    /// Number of copies that a lab needs.
    pub quantity: u32,
    /// Colour for images and STEP.
    pub color: Color,
    /// Opacity, 0 to 1.
    pub opacity: f64,
    /// Exact shape, mm, in the body's own frame.
    pub solid: &'a Solid,
    /// Points that other parts rely on, in the body's own frame.
    pub landmarks: &'a [Landmark],
    /// Placements in assemblies.
    pub placements: &'a [Placement],
    /// Figures of the mesh at the export's tolerance.
    pub mesh: MeshFigures,
}

/// A primitive of the tree, numbered as faces and ray hits refer to it.
#[derive(Clone, Debug, Serialize)]
pub struct LeafEntry<'a> {
    /// Index in the list.
    pub leaf: usize,
    /// Name of the innermost feature around it; empty if there is none.
    pub feature: &'a str,
    /// Transform from the primitive's frame to the body's.
    pub body_from_leaf: Pose,
}

#[derive(Serialize)]
struct Form<'a> {
    format: &'static str,
    version: u32,
    fabkit: &'static str,
    units: Units,
    design_hash: &'a str,
    sensor: &'a str,
    name: &'a str,
    kind: &'a str,
    summary: &'a str,
    process: &'a str,
    material: &'a str,
    quantity: u32,
    color: Color,
    opacity: f64,
    mesh: MeshFigures,
    landmarks: Vec<LandmarkForm<'a>>,
    placements: Vec<PlacementForm<'a>>,
    leaves: Vec<LeafEntry<'a>>,
    solid: &'a Solid,
}

/// Units of numbers whose names do not state one.
#[derive(Serialize)]
pub(crate) struct Units {
    length: &'static str,
    angle: &'static str,
}

impl Units {
    /// Units of all documents.
    pub(crate) const USUAL: Self = Self { length: "mm", angle: "rad" };
}

#[derive(Serialize)]
struct LandmarkForm<'a> {
    name: &'a str,
    point_mm: [f64; 3],
    axis: [f64; 3],
}

#[derive(Serialize)]
struct PlacementForm<'a> {
    assembly: &'a str,
    assembly_from_body: Pose,
}

/// Writes a body's solid tree with its data, as JSON (`fabkit-tree` version 1).
///
/// # Errors
/// [`ExportError::Json`] if the encoder fails.
///
/// ```
/// use fabkit_export::{MeshFigures, TreeDocument, tree};
/// use fabkit_geometry::Solid;
/// use serde_json::Value;
///
/// let solid = Solid::cuboid(10.0, 10.0, 4.0).minus(Solid::rod(2.0, [-1.0, 5.0]).named("hole 1"));
/// let mesh = MeshFigures {
///     chord_tolerance_mm: 0.01,
///     triangles: 400,
///     volume_mm3: 350.0,
///     area_mm2: 385.0,
///     genus: 1,
/// };
/// let document = TreeDocument {
///     design_hash: "0123",
///     sensor: "demo",
///     name: "plate",
///     kind: "part",
///     summary: "A plate with a hole.",
///     process: "fdm",
///     material: "pla",
///     quantity: 1,
///     color: [200; 3],
///     opacity: 1.0,
///     solid: &solid,
///     landmarks: &[],
///     placements: &[],
///     mesh,
/// };
/// let json: Value = serde_json::from_slice(&tree(&document)?)?;
/// // Ray hits refer to primitives by these numbers.
/// assert_eq!(json["leaves"][1]["leaf"], 1);
/// assert_eq!(json["leaves"][1]["feature"], "hole 1");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn tree(document: &TreeDocument) -> Result<Vec<u8>, ExportError> {
    let leaves = document.solid.leaves().into_iter().enumerate();
    let landmarks = document.landmarks.iter().map(|landmark| LandmarkForm {
        name: &landmark.name,
        point_mm: landmark.point.coords.into(),
        axis: landmark.axis.into(),
    });
    let placements = document.placements.iter().map(|placement| PlacementForm {
        assembly: &placement.assembly.0,
        assembly_from_body: placement.assembly_from_body,
    });
    json_bytes(&Form {
        format: "fabkit-tree",
        version: 1,
        fabkit: VERSION,
        units: Units::USUAL,
        design_hash: document.design_hash,
        sensor: document.sensor,
        name: document.name,
        kind: document.kind,
        summary: document.summary,
        process: document.process,
        material: document.material,
        quantity: document.quantity,
        color: document.color,
        opacity: document.opacity,
        mesh: document.mesh,
        landmarks: landmarks.collect(),
        placements: placements.collect(),
        leaves: leaves
            .map(|(leaf, found)| LeafEntry {
                leaf,
                feature: found.feature,
                body_from_leaf: found.root_from_leaf,
            })
            .collect(),
        solid: document.solid,
    })
}
