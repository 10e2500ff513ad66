//! 3MF files: named, coloured objects with units (3MF Core Specification 1.4), a thumbnail, and slicer settings for
//! each object.

mod slicers;

use std::fmt::Write as _;

use fabkit_mesh::PrintMesh;

use crate::{ExportError, VERSION, opc};

pub use slicers::SlicerSettings;

/// Namespace of fabkit's own metadata, which section 3.4.1 of the specification requires.
const METADATA_NAMESPACE: &str = "urn:fabkit:metadata:1";

const CONTENT_TYPES: &str = concat!(
    r#"<?xml version="1.0" encoding="UTF-8"?>"#,
    r#"<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">"#,
    r#"<Default Extension="rels" "#,
    r#"ContentType="application/vnd.openxmlformats-package.relationships+xml"/>"#,
    r#"<Default Extension="model" "#,
    r#"ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>"#,
    r#"<Default Extension="png" ContentType="image/png"/>"#,
    r#"<Default Extension="config" ContentType="application/xml"/>"#,
    "</Types>\n",
);

const RELATIONSHIPS: &str = concat!(
    r#"<?xml version="1.0" encoding="UTF-8"?>"#,
    r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">"#,
    r#"<Relationship Id="rel0" Target="/3D/3dmodel.model" "#,
    r#"Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>"#,
    r#"<Relationship Id="rel1" Target="/Metadata/thumbnail.png" "#,
    r#"Type="http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail"/>"#,
    "</Relationships>\n",
);

/// Width and height of the thumbnail, px, as PrusaSlicer writes it.
const THUMBNAIL_PX: u32 = 256;

/// Title and origin of a file.
#[derive(Clone, Copy, Debug)]
pub struct DocumentInfo<'a> {
    /// Title for people, for example `R-Tac0: shell`.
    pub title: &'a str,
    /// Hash of the design and the fabkit version.
    pub design_hash: &'a str,
}

/// An object to print.
#[derive(Clone, Copy, Debug)]
pub struct PrintObject<'a> {
    /// Name in the slicer's list.
    pub name: &'a str,
    /// Name of the material.
    pub material: &'a str,
    /// Colour, sRGB.
    pub color: [u8; 3],
    /// Mesh in its place, mm; the specification requires coordinates that are not negative.
    pub mesh: &'a PrintMesh,
    /// Slicer settings; `None` for objects that take their settings from elsewhere.
    pub settings: Option<SlicerSettings>,
    /// Explanation of these settings for people.
    pub settings_note: &'a str,
}

/// Writes a 3MF file with one build item per object, mm, without transforms.
///
/// Coordinates are the shortest decimals that parse to the same `f32`.
///
/// # Errors
/// [`ExportError::Nothing`] without objects, [`ExportError::TooLarge`] beyond 4 GiB.
///
/// ```
/// use fabkit_export::{DocumentInfo, ExportError, PrintObject, three_mf};
/// use fabkit_geometry::Solid;
///
/// let mesh =
///     fabkit_mesh::mesh(&Solid::cuboid(10.0, 10.0, 5.0).at(5.0, 5.0, 0.0), 0.01)?.to_print()?;
/// let block = PrintObject {
///     name: "block",
///     material: "PLA",
///     color: [230, 120, 20],
///     mesh: &mesh,
///     settings: None,
///     settings_note: "",
/// };
/// let document = DocumentInfo { title: "a block", design_hash: "0123" };
/// let file = three_mf(document, &[block])?;
/// assert!(file.starts_with(b"PK"));
/// assert_eq!(file, three_mf(document, &[block])?);
/// assert!(matches!(three_mf(document, &[]), Err(ExportError::Nothing)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn three_mf(document: DocumentInfo, objects: &[PrintObject]) -> Result<Vec<u8>, ExportError> {
    package(document, objects, None)
}

/// Writes a 3MF file with one build item that consists of all objects: one print of several materials. Slicers load it
/// as one piece and keep its parts together.
///
/// # Errors
/// See [`three_mf`].
pub fn three_mf_single_item(
    document: DocumentInfo,
    name: &str,
    objects: &[PrintObject],
) -> Result<Vec<u8>, ExportError> {
    package(document, objects, Some(name))
}

/// Writes the archive: model, thumbnail and slicer configurations.
fn package(
    document: DocumentInfo,
    objects: &[PrintObject],
    piece: Option<&str>,
) -> Result<Vec<u8>, ExportError> {
    if objects.is_empty() {
        return Err(ExportError::Nothing);
    }
    let model = model_xml(document, objects, piece);
    let meshes: Vec<_> = objects.iter().map(|object| (object.mesh, object.color)).collect();
    let image = fabkit_mesh::snapshot(&meshes, THUMBNAIL_PX as usize);
    let thumbnail = crate::png(THUMBNAIL_PX, THUMBNAIL_PX, &image)?;
    let configs = slicers::configs(objects, piece);
    let mut parts = vec![
        ("[Content_Types].xml", CONTENT_TYPES.as_bytes()),
        ("_rels/.rels", RELATIONSHIPS.as_bytes()),
        ("3D/3dmodel.model", model.as_bytes()),
        ("Metadata/thumbnail.png", &thumbnail),
    ];
    parts.extend(configs.iter().map(|(name, text)| (*name, text.as_bytes())));
    opc::archive(&parts)
}

/// Returns the id of an object; the single material group has id 1.
fn object_id(index: usize) -> usize {
    index + 2
}

/// Writes the model part.
fn model_xml(document: DocumentInfo, objects: &[PrintObject], piece: Option<&str>) -> String {
    let mut materials: Vec<(&str, [u8; 3])> = Vec::new();
    let mut xml = Xml(String::new());
    xml.line(r#"<?xml version="1.0" encoding="UTF-8"?>"#);
    xml.put(r#"<model unit="millimeter" xml:lang="en-US" "#);
    xml.put(r#"xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" "#);
    xml.line(&format!(r#"xmlns:fabkit="{METADATA_NAMESPACE}">"#));
    xml.metadata("Title", document.title);
    let mut about: Vec<&str> = objects.iter().map(|object| object.settings_note).collect();
    about.retain(|text| !text.is_empty());
    about.dedup();
    if !about.is_empty() {
        xml.metadata("Description", &about.join(" "));
    }
    xml.metadata("Application", &format!("fabkit {VERSION}"));
    xml.metadata("fabkit:DesignHash", document.design_hash);
    xml.line("<resources>");

    xml.line(r#"<basematerials id="1">"#);
    for object in objects {
        let material = (object.material, object.color);
        if !materials.contains(&material) {
            materials.push(material);
            let [r, g, b] = object.color;
            xml.put(r#"<base name=""#);
            xml.escaped(object.material);
            xml.line(&format!(r##"" displaycolor="#{r:02X}{g:02X}{b:02X}"/>"##));
        }
    }
    xml.line("</basematerials>");
    for (index, object) in objects.iter().enumerate() {
        let material = (object.material, object.color);
        let pindex = materials.iter().position(|m| *m == material).unwrap_or_default();
        xml.object(object_id(index), pindex, object);
    }
    // A component must refer to an object before it in the file (section 4.2).
    let items = match piece {
        None => 0..objects.len(),
        Some(name) => {
            xml.components(object_id(objects.len()), name, objects.len());
            objects.len()..objects.len() + 1
        }
    };
    xml.line("</resources>");
    xml.line("<build>");
    for index in items {
        xml.line(&format!(r#"<item objectid="{}"/>"#, object_id(index)));
    }
    xml.line("</build>");
    xml.line("</model>");
    xml.0
}

struct Xml(String);

impl Xml {
    fn put(&mut self, text: &str) {
        self.0.push_str(text);
    }

    fn line(&mut self, text: &str) {
        self.0.push_str(text);
        self.0.push('\n');
    }

    /// Writes text or attribute content. Characters that XML 1.0 does not allow (section 2.2) become spaces.
    fn escaped(&mut self, text: &str) {
        for c in text.chars() {
            match c {
                '&' => self.put("&amp;"),
                '<' => self.put("&lt;"),
                '>' => self.put("&gt;"),
                '"' => self.put("&quot;"),
                '\u{FFFE}' | '\u{FFFF}' => self.0.push(' '),
                c if c.is_control() => self.0.push(' '),
                c => self.0.push(c),
            }
        }
    }

    fn metadata(&mut self, name: &str, value: &str) {
        self.put(&format!(r#"<metadata name="{name}">"#));
        self.escaped(value);
        self.line("</metadata>");
    }

    /// Writes an object made of the first `count` objects in their places.
    fn components(&mut self, id: usize, name: &str, count: usize) {
        self.put(&format!(r#"<object id="{id}" type="model" name=""#));
        self.escaped(name);
        self.line("\">\n<components>");
        for index in 0..count {
            self.line(&format!(r#"<component objectid="{}"/>"#, object_id(index)));
        }
        self.line("</components>\n</object>");
    }

    fn object(&mut self, id: usize, pindex: usize, object: &PrintObject) {
        let (vertices, triangles) = (object.mesh.vertices(), object.mesh.triangles());
        self.0.reserve(48 * vertices.len() + 40 * triangles.len());
        self.put(&format!(r#"<object id="{id}" type="model" pid="1" pindex="{pindex}" name=""#));
        self.escaped(object.name);
        self.line("\">\n<mesh>\n<vertices>");
        for vertex in vertices {
            // Display of f32 is the shortest decimal that parses to the same number; adding 0.0 drops the sign of -0.
            let [x, y, z] = vertex.map(|value| value + 0.0);
            // Writing to a String cannot fail.
            let _ = writeln!(self.0, r#"<vertex x="{x}" y="{y}" z="{z}"/>"#);
        }
        self.line("</vertices>\n<triangles>");
        for [a, b, c] in triangles {
            let _ = writeln!(self.0, r#"<triangle v1="{a}" v2="{b}" v3="{c}"/>"#);
        }
        self.line("</triangles>\n</mesh>\n</object>");
    }
}
