//! Wavefront OBJ files in metres.

use std::fmt::Write as _;

use super::RobotMesh;
use super::numbers::{MM_PER_M, number};

/// Writes a mesh, mm, counter-clockwise seen from outside. The file is in metres, with the vertices in the same order.
///
/// ```
/// use fabkit_export::{RobotMesh, obj};
///
/// let triangle = RobotMesh {
///     file: "triangle.obj".into(),
///     vertices_mm: vec![[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 2.5, 0.0]],
///     triangles: vec![[0, 1, 2]],
/// };
/// let text = String::from_utf8(obj("a triangle", &triangle))?;
/// assert_eq!(text, "# a triangle\nv 0 0 0\nv 0.01 0 0\nv 0 0.0025 0\nf 1 2 3\n");
/// # Ok::<(), std::string::FromUtf8Error>(())
/// ```
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
