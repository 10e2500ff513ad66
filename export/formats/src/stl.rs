//! Binary STL files: triangles without units, names or connectivity.

use fabkit_mesh::PrintMesh;

use crate::{ExportError, VERSION};

const HEADER_BYTES: usize = 80;
const TRIANGLE_BYTES: usize = 50;

/// Writes a binary STL file, mm.
///
/// The header names fabkit, the part and the unit for people, since STL has no fields for them. It does not begin with
/// `solid`, which readers would take for the text format. Facet normals are computed in `f64` from the vertices as
/// written.
///
/// # Errors
/// [`ExportError::TooLarge`] beyond 2^32 - 1 triangles.
///
/// ```
/// use fabkit_geometry::Solid;
///
/// let block = fabkit_mesh::mesh(&Solid::cuboid(10.0, 20.0, 30.0), 0.01)?.to_print()?;
/// let file = fabkit_export::stl("block", &block)?;
/// // Two triangles on each of six faces.
/// assert_eq!(file[80..84], 12u32.to_le_bytes());
/// assert_eq!(file.len(), 84 + 12 * 50);
/// assert!(file.starts_with(b"fabkit "));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn stl(name: &str, mesh: &PrintMesh) -> Result<Vec<u8>, ExportError> {
    let triangles = mesh.triangles();
    let count = u32::try_from(triangles.len()).map_err(|_| ExportError::TooLarge {
        what: "the number of triangles",
        needed: triangles.len() as u64,
        limit: u32::MAX.into(),
    })?;

    let mut bytes = Vec::with_capacity(HEADER_BYTES + 4 + TRIANGLE_BYTES * triangles.len());
    let ascii: String = name.chars().filter(char::is_ascii_graphic).collect();
    bytes.extend(format!("fabkit {VERSION}; unit mm; {ascii}").bytes().take(HEADER_BYTES));
    bytes.resize(HEADER_BYTES, b' ');
    bytes.extend(count.to_le_bytes());

    let vertices = mesh.vertices();
    for triangle in triangles {
        let corners = triangle.map(|i| vertices[i as usize]);
        for value in [normal(corners)].iter().chain(&corners).flatten() {
            // No negative zero: equal numbers are equal bytes.
            bytes.extend((value + 0.0).to_le_bytes());
        }
        bytes.extend([0, 0]); // attribute byte count, unused
    }
    Ok(bytes)
}

/// Computes the unit normal by the right-hand rule. In `f64`, differences and products of `f32` coordinates lose only a
/// few bits; in `f32`, thin triangles would flip.
fn normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let u: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
    let v: [f64; 3] = std::array::from_fn(|i| c[i] - a[i]);
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n[0].hypot(n[1]).hypot(n[2]);
    n.map(|x| (x / length) as f32)
}
