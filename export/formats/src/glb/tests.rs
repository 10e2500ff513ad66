use fabkit_geometry::{Angle, Point3, Solid};
use fabkit_mesh::mesh;
use serde_json::json;

use super::*;

fn ball() -> ShadedMesh {
    let solid = Solid::sphere(2.0);
    mesh(&solid, 0.1).unwrap().to_print().unwrap().with_exact_normals(&solid)
}

fn body<'a>(name: &'a str, mesh: &'a ShadedMesh, places: Vec<GlbPlacement>) -> GlbBody<'a> {
    GlbBody {
        name,
        material: "PLA",
        color: [255, 128, 0],
        opacity: 1.0,
        refractive_index: None,
        mesh,
        placements: places,
        extras: json!({ "kind": "part" }),
    }
}

fn place(x_mm: f64, apart_mm: f64) -> GlbPlacement {
    GlbPlacement {
        assembly_from_body: Pose::translation(x_mm, 0.0, 0.0),
        exploded_offset_mm: Vector3::z() * apart_mm,
    }
}

fn written(bodies: Vec<GlbBody>) -> Vec<u8> {
    let upright_from_assembly = Pose::identity();
    let scene =
        GlbScene { name: "test", label: "test", upright_from_assembly, bodies, extras: json!({}) };
    glb(&[scene]).unwrap()
}

/// Returns the JSON and the binary chunk of a file, after checking its lengths.
fn read(file: &[u8]) -> (Value, &[u8]) {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    assert_eq!([number(0), number(4), number(8)], [GLTF, 2, file.len() as u32]);
    let json = number(12) as usize;
    assert_eq!((number(16), json % 4), (JSON, 0));
    let length = number(20 + json) as usize;
    assert_eq!((number(24 + json), length % 4, 28 + json + length), (BIN, 0, file.len()));
    (serde_json::from_slice(&file[20..20 + json]).unwrap(), &file[28 + json..])
}

#[test]
fn a_body_with_several_places_is_one_mesh_below_one_node() {
    let mesh = ball();
    let two = body("led", &mesh, vec![place(5.0, 0.0), place(-5.0, 8.0)]);
    let file = written(vec![body("shell", &mesh, vec![place(0.0, 0.0)]), two]);
    let (json, _) = read(&file);
    let nodes = json["nodes"].as_array().unwrap();
    let names: Vec<&str> = nodes.iter().map(|node| node["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["test", "shell", "led", "led 1", "led 2"]);
    assert_eq!((&nodes[0]["children"], &nodes[2]["children"]), (&json!([1, 2]), &json!([3, 4])));
    assert_eq!((&nodes[3]["mesh"], &nodes[4]["mesh"]), (&json!(1), &json!(1)));
    assert_eq!(nodes[2]["extras"], json!({ "kind": "part" }));
    // Both have the same material.
    assert_eq!(json["materials"].as_array().unwrap().len(), 1);
}

#[test]
fn the_root_turns_z_up_to_y_up_and_millimetres_to_metres() {
    let mesh = ball();
    let file = written(vec![body("shell", &mesh, vec![place(0.0, 0.0)])]);
    let (json, _) = read(&file);
    let half = 0.5f64.sqrt();
    let rotation: Vec<f64> = serde_json::from_value(json["nodes"][0]["rotation"].clone()).unwrap();
    for (found, wanted) in rotation.iter().zip([-half, 0.0, 0.0, half]) {
        assert!((found - wanted).abs() < 1e-12, "{rotation:?}");
    }
    assert_eq!(json["nodes"][0]["scale"], json!([0.001, 0.001, 0.001]));
}

#[test]
fn what_moves_is_animated_from_its_place_to_where_it_is_taken() {
    let mesh = ball();
    let file = written(vec![
        body("stays", &mesh, vec![place(1.0, 0.0)]),
        body("lid", &mesh, vec![place(2.0, 30.0)]),
    ]);
    let (json, bytes) = read(&file);
    let animation = &json["animations"][0];
    assert_eq!(animation["name"], "explode");
    assert_eq!(animation["channels"].as_array().unwrap().len(), 1);
    assert_eq!(animation["channels"][0]["target"], json!({ "node": 2, "path": "translation" }));
    let output = &json["accessors"][animation["samplers"][0]["output"].as_u64().unwrap() as usize];
    let view = &json["bufferViews"][output["bufferView"].as_u64().unwrap() as usize];
    let from = view["byteOffset"].as_u64().unwrap() + output["byteOffset"].as_u64().unwrap();
    let floats = bytes[from as usize..][..24].as_chunks().0.iter();
    let floats: Vec<f32> = floats.map(|four| f32::from_le_bytes(*four)).collect();
    assert_eq!(floats, [2.0, 0.0, 0.0, 2.0, 0.0, 30.0]);
    // Without motion there is no animation: lists must not be empty.
    let (still, _) = (written(vec![body("stays", &mesh, vec![place(1.0, 0.0)])]), ());
    assert!(read(&still).0.get("animations").is_none());
}

#[test]
fn what_is_clear_blends_and_says_how_it_bends_light() {
    let mesh = ball();
    let gel = GlbBody {
        opacity: 0.35,
        refractive_index: Some(1.41),
        ..body("gel", &mesh, vec![place(0.0, 0.0)])
    };
    let file = written(vec![gel, body("shell", &mesh, vec![place(0.0, 0.0)])]);
    let (json, _) = read(&file);
    let gel = &json["materials"][0];
    assert_eq!(
        (&gel["alphaMode"], &gel["pbrMetallicRoughness"]["baseColorFactor"][3]),
        (&json!("BLEND"), &json!(0.35))
    );
    assert_eq!(gel["extensions"][json::IOR]["ior"], 1.41);
    assert_eq!(json["extensionsUsed"], json!([json::IOR]));
    let shell = &json["materials"][1];
    assert!(shell.get("alphaMode").is_none() && shell.get("extensions").is_none());
    // sRGB 255, 128, 0.
    assert_eq!(shell["pbrMetallicRoughness"]["baseColorFactor"], json!([1.0, 0.215861, 0.0, 1.0]));
}

#[test]
fn quaternions_rotate_as_their_poses() {
    let turn = |f: fn(Angle) -> Pose, deg| f(Angle::from_deg(deg).unwrap());
    let mut poses: Vec<Pose> = Vec::new();
    for deg in [0.0, 30.0, 90.0, 179.0, 180.0, 270.0] {
        poses.extend([Pose::rotation_x, Pose::rotation_y, Pose::rotation_z].map(|f| turn(f, deg)));
        let (x, y) = (turn(Pose::rotation_x, deg), turn(Pose::rotation_y, 2.0 * deg + 10.0));
        poses.push(x.then_in(y).then_in(turn(Pose::rotation_z, 40.0)));
        poses.push(Pose::z_to(Vector3::new(0.3, -0.2, -0.9), Point3::origin()).then_in(x));
    }
    for pose in poses {
        let [x, y, z, w] = quaternion(&pose);
        assert!((x * x + y * y + z * z + w * w - 1.0).abs() < 1e-12);
        let (axis, v) = (Vector3::new(x, y, z), Vector3::new(0.2, -0.7, 0.5));
        let turned = v + 2.0 * axis.cross(&(axis.cross(&v) + w * v));
        assert!((turned - pose.vector(v)).norm() < 1e-12, "{pose:?}: {x} {y} {z} {w}");
    }
}

#[test]
fn empty_scenes_are_refused() {
    let upright_from_assembly = Pose::identity();
    let bodies = Vec::new();
    let scene = GlbScene { name: "", label: "", upright_from_assembly, bodies, extras: json!({}) };
    assert!(matches!(glb(&[scene]), Err(ExportError::Nothing)));
    assert!(matches!(glb(&[]), Err(ExportError::Nothing)));
}
