//! fabkit's side of `cargo xtask bench-peers`: builds, meshes and writes one part in a process of its own.
//!
//! ```text
//! peer scenes FOLDER                 the trees of two parts that stand for the hard ones
//! peer mesh TREE TOLERANCE_MM STL    a tree document's solid, as binary STL
//! ```

mod scenes;

use std::error::Error;
use std::path::Path;
use std::{env, fs};

use fabkit_geometry::Solid;
use fabkit_mesh::{PrintMesh, mesh};
use serde::Deserialize;

/// Part of a tree document that is needed here.
#[derive(Deserialize)]
struct Tree {
    solid: Solid,
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = env::args().skip(1).collect();
    match &words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["scenes", folder] => write_scenes(Path::new(folder)),
        ["mesh", tree, tolerance_mm, stl] => {
            let tree: Tree = serde_json::from_slice(&fs::read(tree)?)?;
            let start_s = cpu_s();
            let print = mesh(&tree.solid, tolerance_mm.parse()?)?.to_print()?;
            fs::write(stl, binary_stl(&print))?;
            if let (Some(start_s), Some(end_s)) = (start_s, cpu_s()) {
                println!("{}", serde_json::json!({ "cpu_s": end_s - start_s }));
            }
            Ok(())
        }
        _ => Err("peer scenes FOLDER | peer mesh TREE TOLERANCE_MM STL".into()),
    }
}

/// Returns the CPU time of the only thread, s; `None` if the system does not tell.
fn cpu_s() -> Option<f64> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}

fn write_scenes(folder: &Path) -> Result<(), Box<dyn Error>> {
    for scene in scenes::all() {
        let document = serde_json::json!({
            "name": scene.name,
            "exact_mm3": scene.exact_mm3,
            "solid": scene.solid,
        });
        fs::write(folder.join(format!("{}.tree.json", scene.name)), document.to_string())?;
    }
    Ok(())
}

fn binary_stl(mesh: &PrintMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles().len() as u32).to_le_bytes());
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|v| mesh.vertices()[v as usize]);
        let (u, v): ([f32; 3], [f32; 3]) =
            (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt().max(f32::MIN_POSITIVE);
        for value in normal.map(|n| n / length).iter().chain(&a).chain(&b).chain(&c) {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}
