//! GLB files against the designs that they are of: bodies, places, colours, masses, and the animation against
//! the exploded image. Outside readers judge the same files: `tests/oracles/check_glb.py`.

use std::collections::BTreeMap;

use fabkit_application::exports::{self, ExportOptions, Format};
use fabkit_designs::Design;
use fabkit_geometry::{Assembly, Body, Placement};
use fabkit_tests::{fabkit, read_folder};
use serde_json::Value;

/// The JSON and the bytes of a file.
fn parts(file: &[u8]) -> (Value, &[u8]) {
    assert_eq!(&file[..4], b"glTF");
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&file[20..20 + length]).unwrap(), &file[28 + length..])
}

fn exported(design: &Design) -> Vec<u8> {
    // One part alone, for the sake of time: the file holds all of them.
    let part = design.sensor.bodies.iter().find(|body| body.is_made()).unwrap();
    let options = ExportOptions {
        parts: vec![part.name.clone()],
        formats: vec![Format::Glb],
        tolerance_mm: 0.1,
        ..ExportOptions::default()
    };
    let exported = exports::export(design, &options, &|_| ()).unwrap();
    let name = format!("{}.glb", design.sensor.name);
    exported.files.into_iter().find(|file| file.name == name).unwrap().bytes
}

fn index(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap()).unwrap()
}

/// How far the animation moves each node, mm.
fn moves(json: &Value, bytes: &[u8]) -> BTreeMap<usize, [f64; 3]> {
    let mut moves = BTreeMap::new();
    let animation = &json["animations"][0];
    assert_eq!(animation["name"], "explode");
    for channel in animation["channels"].as_array().unwrap() {
        let sampler = &animation["samplers"][index(&channel["sampler"])];
        let accessor = &json["accessors"][index(&sampler["output"])];
        let view = &json["bufferViews"][index(&accessor["bufferView"])];
        let start =
            view["byteOffset"].as_u64().unwrap_or(0) + accessor["byteOffset"].as_u64().unwrap_or(0);
        let floats = bytes[start as usize..][..24].chunks(4);
        let at: Vec<f64> =
            floats.map(|f| f64::from(f32::from_le_bytes(f.try_into().unwrap()))).collect();
        let moved = std::array::from_fn(|axis| at[3 + axis] - at[axis]);
        moves.insert(index(&channel["target"]["node"]), moved);
    }
    moves
}

fn places(body: &Body) -> Vec<&Placement> {
    body.placements.iter().filter(|place| place.assembly == Assembly::sensor()).collect()
}

/// From a factor of light to sRGB.
fn srgb(light: f64) -> f64 {
    255.0 * if light <= 0.0031308 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn every_sensor_is_its_bodies_and_comes_apart_as_its_exploded_image() {
    let (mut moved, mut several, mut clear) = (0, 0, 0);
    for design in fabkit_tests::builtin_designs() {
        let file = exported(&design);
        let (json, bytes) = parts(&file);
        let mut moves = moves(&json, bytes);
        let bodies: Vec<&Body> =
            design.sensor.bodies.iter().filter(|body| !places(body).is_empty()).collect();
        let tops = json["nodes"][0]["children"].as_array().unwrap();
        assert_eq!(tops.len(), bodies.len(), "{}", design.sensor.name);
        for (top, body) in tops.iter().zip(bodies) {
            let name = format!("{}/{}", design.sensor.name, body.name);
            let node = &json["nodes"][index(top)];
            assert_eq!(node["name"], body.name.as_str(), "{name}");
            let places = places(body);
            let nodes = match node["children"].as_array() {
                Some(children) => children.iter().map(index).collect(),
                None => vec![index(top)],
            };
            assert_eq!(nodes.len(), places.len(), "{name}");
            several += usize::from(nodes.len() > 1);
            let mut meshes: Vec<&Value> =
                nodes.iter().map(|&n| &json["nodes"][n]["mesh"]).collect();
            meshes.dedup();
            let [mesh] = meshes[..] else { panic!("{name} has {} meshes", meshes.len()) };
            let primitive = &json["meshes"][index(mesh)]["primitives"][0];
            let material = &json["materials"][index(&primitive["material"])];
            let factor = &material["pbrMetallicRoughness"]["baseColorFactor"];
            for axis in 0..3 {
                let found = srgb(factor[axis].as_f64().unwrap());
                assert!((found - f64::from(body.color[axis])).abs() < 0.5, "{name}: {found}");
            }
            assert_eq!(factor[3].as_f64(), Some(body.opacity), "{name}");
            assert_eq!(material["alphaMode"] == "BLEND", body.opacity < 1.0, "{name}");
            clear += usize::from(material["extensions"]["KHR_materials_ior"].is_object());
            for (node, place) in nodes.iter().zip(places) {
                let by = moves.remove(node).unwrap_or_default();
                for axis in 0..3 {
                    let off = (by[axis] - place.explode_mm[axis]).abs();
                    assert!(off < 1e-4, "{name}: moves by {by:?}, not {}", place.explode_mm);
                }
                moved += usize::from(place.explode_mm.norm() > 0.0);
            }
        }
        assert!(moves.is_empty(), "{}: {moves:?}", design.sensor.name);
    }
    assert!(moved > 150 && several > 30 && clear > 15, "{moved}, {several}, {clear}");
}

/// Materials of all built-in sensors are known, so that everything that a lab makes has a mass.
#[test]
fn what_a_lab_makes_has_a_mass() {
    for design in fabkit_tests::builtin_designs() {
        let file = exported(&design);
        let (json, _) = parts(&file);
        let extras = |name: &str| {
            let nodes = json["nodes"].as_array().unwrap();
            let node = nodes.iter().find(|node| node["name"] == name).unwrap();
            node["extras"].clone()
        };
        for body in design.sensor.bodies.iter().filter(|body| !places(body).is_empty()) {
            let extras = extras(&body.name);
            let name = format!("{}/{}", design.sensor.name, body.name);
            if body.process().is_none() {
                continue;
            }
            let volume_cm3 = extras["volume_mm3"].as_f64().unwrap() / 1e3;
            let mass_g = extras["mass_g"].as_f64().unwrap_or_else(|| panic!("{name}: no mass"));
            let density = mass_g / volume_cm3;
            assert!((0.5..2.5).contains(&density), "{name}: {density} g/cm3");
        }
    }
}

#[test]
fn the_command_writes_one_file_of_the_whole() {
    let root = tempfile::tempdir().unwrap();
    let export = |target: &str, more: &[&str]| {
        let all = [&["export", target, "--format=glb", "--tolerance=0.1mm"], more].concat();
        fabkit(root.path(), &all).ok();
    };
    export("rtac0", &["--part=shell"]);
    let whole = read_folder(&root.path().join("out/rtac0"));
    assert_eq!(whole.keys().collect::<Vec<_>>(), ["manifest.json", "rtac0.glb"]);
    for threads in ["1", "8"] {
        export("rtac0", &["--part=shell", "-o", threads, "--threads", threads]);
        assert_eq!(read_folder(&root.path().join(threads))["rtac0.glb"], whole["rtac0.glb"]);
    }
    export("rtac0/pin-dome", &["--part=dome"]);
    let fixture = read_folder(&root.path().join("out/rtac0/pin-dome"));
    let (json, _) = parts(&fixture["rtac0-pin-dome.glb"]);
    let names =
        json["meshes"].as_array().unwrap().iter().map(|mesh| mesh["name"].as_str().unwrap());
    assert!(names.clone().any(|name| name == "pin-short"), "{:?}", names.collect::<Vec<_>>());
}
