//! GLB files: a whole assembly as binary glTF 2.0, for viewers.

mod binary_chunk;
mod json;

use fabkit_geometry::{Pose, Vector3};
use fabkit_mesh::ShadedMesh;
use serde_json::Value;

use self::binary_chunk::BinaryChunk;
use self::json::{Document, Extension, Material, Mesh, Node, Primitive, Scene, Surface};
use crate::ExportError;

/// A body of a scene: one mesh at one or more places.
#[derive(Clone, Debug)]
pub struct GlbBody<'a> {
    /// Name of the body's node and mesh.
    pub name: &'a str,
    /// Name of the material.
    pub material: &'a str,
    /// Colour, sRGB.
    pub color: [u8; 3],
    /// Opacity, 0 to 1.
    pub opacity: f64,
    /// Refractive index of a clear body, if known.
    pub refractive_index: Option<f64>,
    /// Mesh in the body's own frame, mm.
    pub mesh: &'a ShadedMesh,
    /// Placements, at least one.
    pub placements: Vec<GlbPlacement>,
    /// Further data for the node: a JSON object.
    pub extras: Value,
}

/// A placement of a body.
#[derive(Clone, Copy, Debug)]
pub struct GlbPlacement {
    /// Transform from the body's frame to the assembly's, mm.
    pub assembly_from_body: Pose,
    /// Displacement in the exploded view, in the assembly's frame, mm.
    pub exploded_offset_mm: Vector3<f64>,
}

/// A scene of a GLB file.
#[derive(Clone, Debug)]
pub struct GlbScene<'a> {
    /// Name of the root node.
    pub name: &'a str,
    /// Name of the scene.
    pub label: &'a str,
    /// Rotation of the assembly that makes z point up.
    pub upright_from_assembly: Pose,
    /// Bodies in file order; at least one.
    pub bodies: Vec<GlbBody<'a>>,
    /// Further data for the root node: a JSON object.
    pub extras: Value,
}

/// Duration of the `explode` animation, s.
pub const GLB_EXPLODE_S: f32 = 2.0;

const METRES_PER_MM: f64 = 1e-3;
const GLTF: u32 = 0x4654_6C67;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// Roughness of clear bodies, which are smooth, and of all others, which look like prints and rubber.
const CLEAR_ROUGHNESS: f64 = 0.15;
const ROUGHNESS: f64 = 0.6;

/// Writes a binary glTF 2.0 file of one or more scenes, of which the first is shown.
///
/// Meshes and the nodes of bodies are in mm, z up; the root node of a scene turns y up and scales to metres, as the
/// standard demands. The animation `explode` moves each node from its place to its place in the exploded view. A mesh
/// that occurs in several scenes is written once.
///
/// # Errors
/// [`ExportError::Nothing`] without scenes, or for a scene without bodies; [`ExportError::TooLarge`] beyond 4 GiB.
///
/// ```
/// use fabkit_export::{GlbBody, GlbPlacement, GlbScene, glb};
/// use fabkit_geometry::{Pose, Solid, Vector3};
/// use serde_json::{Value, json};
///
/// let solid = Solid::sphere(2.0);
/// let mesh = fabkit_mesh::mesh(&solid, 0.1)?.to_print()?.with_exact_normals(&solid);
/// let placement = |x_mm| GlbPlacement {
///     assembly_from_body: Pose::translation(x_mm, 0.0, 0.0),
///     exploded_offset_mm: Vector3::zeros(),
/// };
/// let ball = GlbBody {
///     name: "ball",
///     material: "steel",
///     color: [180; 3],
///     opacity: 1.0,
///     refractive_index: None,
///     mesh: &mesh,
///     placements: vec![placement(0.0), placement(9.0)],
///     extras: json!({}),
/// };
/// let scene = GlbScene {
///     name: "balls",
///     label: "two balls",
///     upright_from_assembly: Pose::identity(),
///     bodies: vec![ball],
///     extras: json!({}),
/// };
/// let file = glb(&[scene])?;
/// let length = u32::from_le_bytes([file[12], file[13], file[14], file[15]]) as usize;
/// let json: Value = serde_json::from_slice(&file[20..20 + length])?;
/// // The mesh is there once; the root scales millimetres to metres; one node moves 9 mm.
/// assert_eq!(json["meshes"].as_array().map(Vec::len), Some(1));
/// assert_eq!(json["nodes"][0]["scale"], json!([0.001, 0.001, 0.001]));
/// assert_eq!(json["nodes"][3]["translation"], json!([9.0, 0.0, 0.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn glb(scenes: &[GlbScene]) -> Result<Vec<u8>, ExportError> {
    if scenes.is_empty() || scenes.iter().any(|scene| scene.bodies.is_empty()) {
        return Err(ExportError::Nothing);
    }
    let mut writer = Writer::default();
    for scene in scenes {
        writer.scene(scene);
    }
    let Writer { mut document, mut content, moves, .. } = writer;
    // The standard demands that used extensions are listed, and that the list is not empty.
    document.extensions_used =
        document.materials.iter().any(|m| m.extensions.is_some()).then(|| vec![json::IOR]);
    if !moves.is_empty() {
        document.animations = vec![content.animation("explode", GLB_EXPLODE_S, &moves)];
    }
    let bytes = content.finish(&mut document);
    container(&serde_json::to_vec(&document)?, &bytes)
}

/// State of a file while it is written.
#[derive(Default)]
struct Writer<'a> {
    document: Document,
    content: BinaryChunk,
    /// Meshes written so far, with the name and material index of their bodies, by mesh index.
    meshes: Vec<(&'a ShadedMesh, &'a str, usize)>,
    /// Nodes that move, with their positions before and after.
    moves: Vec<(usize, [[f64; 3]; 2])>,
}

/// Creates the root node, which maps the upright assembly (mm, z up) to metres with y up.
fn root(scene: &GlbScene) -> Node {
    let y_up = Pose::with_axes([Vector3::x(), -Vector3::z(), Vector3::y()], Default::default());
    let turned =
        y_up.expect("the axes are a right-handed frame").then_in(scene.upright_from_assembly);
    let [x, y, z] = (*turned.translation_mm() * METRES_PER_MM).into();
    Node {
        scale: Some([METRES_PER_MM; 3]),
        translation: nonzero_translation([x, y, z]),
        extras: Some(scene.extras.clone()),
        ..Node::named(scene.name, &turned)
    }
}

impl Node {
    fn named(name: &str, pose: &Pose) -> Self {
        let rotation = quaternion(pose);
        Self {
            name: name.to_owned(),
            translation: nonzero_translation((*pose.translation_mm()).into()),
            rotation: (rotation != [0.0, 0.0, 0.0, 1.0]).then_some(rotation),
            ..Self::default()
        }
    }
}

fn nonzero_translation(by: [f64; 3]) -> Option<[f64; 3]> {
    (by != [0.0; 3]).then_some(by.map(|x| x + 0.0))
}

impl<'a> Writer<'a> {
    fn scene(&mut self, scene: &GlbScene<'a>) {
        let root = self.document.nodes.len();
        self.document.scenes.push(Scene { name: scene.label.to_owned(), nodes: vec![root] });
        self.document.nodes.push(self::root(scene));
        for body in &scene.bodies {
            self.body(root, body);
        }
    }

    /// Adds a body's mesh and material once, and a node for each place; a body with several places gets a parent node.
    fn body(&mut self, root: usize, body: &GlbBody<'a>) {
        let mesh = self.mesh(body);
        let nodes = &mut self.document.nodes;
        let top = nodes.len();
        nodes[root].children.push(top);
        // A body with one place needs no parent node.
        let is_one = body.placements.len() == 1;
        if !is_one {
            nodes.push(Node::named(body.name, &Pose::identity()));
        }
        for (number, place) in (1..).zip(&body.placements) {
            let node = nodes.len();
            let name =
                if is_one { body.name.to_owned() } else { format!("{} {number}", body.name) };
            let pose = &place.assembly_from_body;
            nodes.push(Node { mesh: Some(mesh), ..Node::named(&name, pose) });
            if !is_one {
                nodes[top].children.push(node);
            }
            if place.exploded_offset_mm != Vector3::zeros() {
                let from = *pose.translation_mm();
                self.moves.push((node, [from.into(), (from + place.exploded_offset_mm).into()]));
            }
        }
        nodes[top].extras = Some(body.extras.clone());
    }

    /// Returns the index of a body's mesh, which is shared by scenes if mesh, name and material are the same.
    fn mesh(&mut self, body: &GlbBody<'a>) -> usize {
        let material = material(&mut self.document, body);
        let is_it = |(mesh, name, look): &(&ShadedMesh, &str, usize)| {
            std::ptr::eq(*mesh, body.mesh) && *name == body.name && *look == material
        };
        self.meshes.iter().position(is_it).unwrap_or_else(|| {
            let primitive = Primitive { material, ..self.content.mesh(body.mesh) };
            self.meshes.push((body.mesh, body.name, material));
            let mesh = Mesh { name: body.name.to_owned(), primitives: vec![primitive] };
            self.document.meshes.push(mesh);
            self.meshes.len() - 1
        })
    }
}

/// Returns the index of a body's material, which is shared by bodies of the same look.
fn material(document: &mut Document, body: &GlbBody) -> usize {
    let is_clear = body.opacity < 1.0;
    let [r, g, b] = body.color.map(linear);
    // Opaque materials do not need the extension.
    let ior = body.refractive_index.filter(|_| is_clear);
    let material = Material {
        name: body.material.to_owned(),
        surface: Surface {
            base_color_factor: [r, g, b, body.opacity],
            metallic_factor: 0.0,
            roughness_factor: if is_clear { CLEAR_ROUGHNESS } else { ROUGHNESS },
        },
        alpha_mode: is_clear.then_some("BLEND"),
        extensions: ior.map(Extension::ior),
    };
    let known = document.materials.iter().position(|known| *known == material);
    known.unwrap_or_else(|| {
        document.materials.push(material);
        document.materials.len() - 1
    })
}

/// Converts sRGB (IEC 61966-2-1) to linear light, as glTF's colour factors require. Rounded, since powers differ in
/// their last digit between machines.
fn linear(value: u8) -> f64 {
    let value = f64::from(value) / 255.0;
    let light = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    (light * 1e6).round() / 1e6
}

/// Returns a rotation as quaternion x, y, z, w. It divides by the largest component, which rounding cannot spoil.
fn quaternion(pose: &Pose) -> [f64; 4] {
    let m = |row: usize, column: usize| pose.rotation()[(row, column)];
    // Four times the squares of x, y, z and w.
    let trace = m(0, 0) + m(1, 1) + m(2, 2);
    let squares = [m(0, 0), m(1, 1), m(2, 2), trace].map(|d| 1.0 + 2.0 * d - trace);
    let largest = (0..4).fold(3, |best, i| if squares[i] > squares[best] { i } else { best });
    let four = 2.0 * squares[largest].sqrt();
    let difference = |i: usize| m((i + 2) % 3, (i + 1) % 3) - m((i + 1) % 3, (i + 2) % 3);
    let q: [f64; 4] = std::array::from_fn(|i| match (i == largest, largest, i) {
        (true, ..) => four / 4.0,
        (_, 3, _) => difference(i) / four,
        (_, _, 3) => difference(largest) / four,
        _ => (m(i, largest) + m(largest, i)) / four,
    });
    // A quaternion and its negative are the same rotation; the one with non-negative w is written.
    let sign = if q[3] < 0.0 { -1.0 } else { 1.0 };
    q.map(|x| sign * x + 0.0)
}

/// Assembles the file: the 12 bytes of the header and two chunks, each padded to a multiple of four.
fn container(json: &[u8], bytes: &[u8]) -> Result<Vec<u8>, ExportError> {
    let padded = |length: usize| length.next_multiple_of(4);
    let length = 28 + padded(json.len()) + padded(bytes.len());
    let total = u32::try_from(length).map_err(|_| ExportError::TooLarge {
        what: "the length of the GLB file",
        needed: length as u64,
        limit: u32::MAX.into(),
    })?;
    let mut file = Vec::with_capacity(length);
    file.extend([GLTF, 2, total].into_iter().flat_map(u32::to_le_bytes));
    for (kind, chunk, filler) in [(JSON, json, b' '), (BIN, bytes, 0)] {
        // Smaller than the whole, which fits.
        let size = padded(chunk.len()) as u32;
        file.extend([size, kind].into_iter().flat_map(u32::to_le_bytes));
        file.extend(chunk);
        file.resize(padded(file.len()), filler);
    }
    Ok(file)
}

#[cfg(test)]
mod tests;
