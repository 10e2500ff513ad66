//! Files read back by the rules of their formats.

use std::io::Write;

use fabkit_export::{
    DocumentInfo, MeshFigures, PrintObject, TreeDocument, stl, three_mf, three_mf_single_item, tree,
};
use fabkit_geometry::{Assembly, Landmark, Placement, Point3, Pose, Solid, Vector3};
use fabkit_mesh::{PrintMesh, mesh};

fn washer() -> Solid {
    let hole = Solid::cylinder(2.0, 3.0).at(0.0, 0.0, -1.0).named("hole 1");
    Solid::cylinder(5.0, 1.0).minus(hole)
}

fn print(solid: &Solid) -> PrintMesh {
    mesh(solid, 0.01).and_then(|mesh| mesh.to_print()).expect("a washer can be meshed")
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

#[test]
fn an_stl_file_holds_the_mesh_bit_for_bit() {
    let mesh = print(&washer());
    let bytes = stl("washer", &mesh).unwrap();
    assert!(bytes.starts_with(b"fabkit "), "a header that starts with `solid` means text");
    assert_eq!(
        u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize,
        mesh.triangles().len()
    );
    assert_eq!(bytes.len(), 84 + 50 * mesh.triangles().len());
    for (triangle, record) in mesh.triangles().iter().zip(bytes[84..].chunks_exact(50)) {
        let [normal, corners @ ..]: [[f32; 3]; 4] =
            std::array::from_fn(|row| std::array::from_fn(|i| f32_at(record, 12 * row + 4 * i)));
        assert_eq!(corners, triangle.map(|i| mesh.vertices()[i as usize]));
        let [a, b, c] = corners.map(|corner| Vector3::from(corner.map(f64::from)));
        let exact = (b - a).cross(&(c - a)).normalize();
        // Each component is rounded to f32 once: half a step below 1, three of them.
        let difference = (Vector3::from(normal.map(f64::from)) - exact).norm();
        assert!(difference < 3.0 * f64::from(f32::EPSILON) / 2.0, "{difference}");
    }
}

#[test]
fn an_stl_header_fits_whatever_the_name_is() {
    let mesh = print(&washer());
    let bytes = stl(&"µ-long ".repeat(40), &mesh).unwrap();
    assert_eq!(bytes.len(), 84 + 50 * mesh.triangles().len());
    assert!(bytes[..80].is_ascii());
}

/// The model part of a 3MF file, which is the archive's last.
fn model(archive: &[u8]) -> String {
    let name = b"3D/3dmodel.model";
    let at = archive.windows(name.len()).position(|w| w == name).unwrap();
    let header = &archive[at - 30..at];
    let packed = u32::from_le_bytes(header[18..22].try_into().unwrap()) as usize;
    let mut text = Vec::new();
    let mut decoder = flate2::write::DeflateDecoder::new(&mut text);
    decoder.write_all(&archive[at + name.len()..][..packed]).unwrap();
    decoder.finish().unwrap();
    String::from_utf8(text).unwrap()
}

fn attributes<'a>(xml: &'a str, element: &str, name: &str) -> Vec<&'a str> {
    let key = format!(" {name}=\"");
    xml.split(&format!("<{element} "))
        .skip(1)
        .map(|rest| {
            let tag = &rest[..rest.find('>').unwrap()];
            let from = format!(" {tag}").find(&key).unwrap() + key.len() - 1;
            &tag[from..from + tag[from..].find('"').unwrap()]
        })
        .collect()
}

#[test]
fn a_3mf_file_holds_the_mesh_bit_for_bit() {
    let mesh = print(&washer().at(0.1, 1.0 / 3.0, 1e-7));
    let object = PrintObject {
        name: "washer",
        material: "PLA",
        color: [1, 171, 255],
        mesh: &mesh,
        settings: None,
        settings_note: "",
    };
    let document = DocumentInfo { title: "Test: washer", design_hash: "0123abcd" };
    let bytes = three_mf(document, &[object]).unwrap();
    assert_eq!(bytes, three_mf(document, &[object]).unwrap());

    let xml = model(&bytes);
    let axis =
        |axis| attributes(&xml, "vertex", axis).into_iter().map(|v| v.parse::<f32>().unwrap());
    let vertices: Vec<[f32; 3]> =
        axis("x").zip(axis("y")).zip(axis("z")).map(|((x, y), z)| [x, y, z]).collect();
    assert_eq!(vertices, mesh.vertices());
    let corner = |v| attributes(&xml, "triangle", v).into_iter().map(|v| v.parse::<u32>().unwrap());
    let triangles: Vec<[u32; 3]> =
        corner("v1").zip(corner("v2")).zip(corner("v3")).map(|((a, b), c)| [a, b, c]).collect();
    assert_eq!(triangles, mesh.triangles());
    assert_eq!(attributes(&xml, "model", "unit"), ["millimeter"]);
    assert_eq!(attributes(&xml, "base", "displaycolor"), ["#01ABFF"]);
    assert!(xml.contains(r#"<metadata name="fabkit:DesignHash">0123abcd</metadata>"#));
    assert!(!xml.contains("transform"));
}

#[test]
fn a_3mf_file_names_its_objects_and_shares_their_materials() {
    let mesh = print(&washer());
    let object = |name, material| PrintObject {
        name,
        material,
        color: [0, 0, 0],
        mesh: &mesh,
        settings: None,
        settings_note: "",
    };
    let document = DocumentInfo { title: "<\"&>", design_hash: "" };
    let objects = [object("a", "PLA"), object("b", "PETG \u{7}&\u{FFFF}co"), object("c", "PLA")];
    let xml = model(&three_mf(document, &objects).unwrap());
    assert_eq!(attributes(&xml, "object", "name"), ["a", "b", "c"]);
    assert_eq!(attributes(&xml, "object", "pindex"), ["0", "1", "0"]);
    assert_eq!(attributes(&xml, "base", "name"), ["PLA", "PETG  &amp; co"]);
    assert_eq!(attributes(&xml, "item", "objectid"), attributes(&xml, "object", "id"));
    assert!(xml.contains("&lt;&quot;&amp;&gt;</metadata>"));
    assert!(three_mf(document, &[]).is_err());
}

#[test]
fn a_3mf_file_of_one_piece_has_one_item_made_of_all_objects() {
    let mesh = print(&washer());
    let object = |name, material| PrintObject {
        name,
        material,
        color: [0, 0, 0],
        mesh: &mesh,
        settings: None,
        settings_note: "",
    };
    let document = DocumentInfo { title: "Test", design_hash: "" };
    let objects = [object("soft", "Tango"), object("hard", "Vero")];
    let xml = model(&three_mf_single_item(document, "tip & all", &objects).unwrap());
    assert_eq!(attributes(&xml, "object", "name"), ["soft", "hard", "tip &amp; all"]);
    let ids = attributes(&xml, "object", "id");
    // The parts keep their materials; the item is the object that refers to them.
    assert_eq!(attributes(&xml, "component", "objectid"), ids[..2]);
    assert_eq!(attributes(&xml, "item", "objectid"), ids[2..]);
    assert_eq!(attributes(&xml, "base", "name"), ["Tango", "Vero"]);
    assert!(three_mf_single_item(document, "nothing", &[]).is_err());
}

#[test]
fn a_tree_reads_back_as_the_same_solid() {
    let solid = washer().at(1.0 / 3.0, 0.0, 0.0);
    let landmarks =
        [Landmark { name: "hole 1".into(), point: Point3::new(1.0, 2.0, 3.0), axis: Vector3::z() }];
    let placements = [Placement::in_place(Assembly::sensor())];
    let figures = MeshFigures {
        chord_tolerance_mm: 0.01,
        triangles: 12,
        volume_mm3: 0.1,
        area_mm2: 6.0,
        genus: 1,
    };
    let bytes = tree(&TreeDocument {
        design_hash: "0123abcd",
        sensor: "test",
        name: "washer",
        kind: "part",
        summary: "A washer",
        process: "fdm",
        material: "PLA",
        quantity: 2,
        color: [1, 2, 3],
        opacity: 1.0,
        solid: &solid,
        landmarks: &landmarks,
        placements: &placements,
        mesh: figures,
    })
    .unwrap();
    let json: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    assert_eq!(serde_json::from_value::<Solid>(json["solid"].clone()).unwrap(), solid);
    assert_eq!((&json["format"], &json["version"]), (&"fabkit-tree".into(), &1.into()));
    assert_eq!(json["landmarks"][0]["point_mm"], serde_json::json!([1.0, 2.0, 3.0]));
    let features: Vec<&str> =
        json["leaves"].as_array().unwrap().iter().map(|l| l["feature"].as_str().unwrap()).collect();
    assert_eq!(features, ["", "hole 1"]);
    let pose: Pose = serde_json::from_value(json["leaves"][1]["body_from_leaf"].clone()).unwrap();
    assert_eq!(pose, solid.leaves()[1].root_from_leaf);
}
