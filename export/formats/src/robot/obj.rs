//! Wavefront OBJ files in metres.

use std::fmt::Write as _;

use super::RobotMesh;
use super::numbers::{MM_PER_M, number};

/// Writes a mesh, mm, counter-clockwise seen from outside. The file is in metres, with the vertices in the same order.
pub fn obj(comment: &str, mesh: &RobotMesh) -> Vec<u8> {
    let mut text = format!("# {}\n", comment.replace('\n', " "));
    // Writing to a string cannot fail.
    for vertex in &mesh.vertices_mm {
        let [x, y, z] = vertex.map(|mm| number(mm / MM_PER_M));
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| i + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text.into_bytes()
}
