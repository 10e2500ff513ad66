//! Triangles as PLY (Turk, "The PLY Polygon File Format", Stanford 1994), binary.

use fabkit_mesh::PrintMesh;

use crate::{ExportError, VERSION};

/// Writes a binary little-endian PLY file, mm, whose triangles share their vertices.
///
/// A comment names the maker, the unit and the part, for people: PLY has no field for them.
///
/// # Errors
/// [`ExportError::TooLarge`] beyond 2^31 - 1 vertices: indices are the format's `int`.
pub fn mesh_ply(name: &str, mesh: &PrintMesh) -> Result<Vec<u8>, ExportError> {
    let (vertices, triangles) = (mesh.vertices(), mesh.triangles());
    if i32::try_from(vertices.len()).is_err() {
        let (what, needed) = ("the number of vertices", vertices.len() as u64);
        return Err(ExportError::TooLarge { what, needed, limit: i32::MAX as u64 });
    }
    // A line break would end the comment and begin something else.
    let name: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment fabkit {VERSION}; unit mm; {name}\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    );
    let mut bytes = header.into_bytes();
    bytes.reserve(12 * vertices.len() + 13 * triangles.len());
    // No negative zero: equal numbers are equal bytes.
    vertices.iter().flatten().for_each(|mm| bytes.extend((mm + 0.0).to_le_bytes()));
    for triangle in triangles {
        bytes.push(3);
        triangle.iter().for_each(|index| bytes.extend(index.to_le_bytes()));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use fabkit_geometry::Solid;

    use super::*;

    /// The header, all vertices and all triangles of a file.
    type Read = (String, Vec<[f32; 3]>, Vec<[u32; 3]>);

    fn read(bytes: &[u8]) -> Read {
        let end = b"end_header\n";
        let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let header = String::from_utf8(bytes[..at].to_vec()).unwrap();
        let count = |element: &str| -> usize {
            let line = header.lines().find_map(|line| line.strip_prefix(element)).unwrap();
            line.trim().parse().unwrap()
        };
        let (vertices, faces) = bytes[at..].split_at(12 * count("element vertex"));
        assert_eq!(faces.len(), 13 * count("element face"));
        let word = |four: &[u8]| <[u8; 4]>::try_from(four).unwrap();
        let vertex = |row: &[u8]| [0, 4, 8].map(|i| f32::from_le_bytes(word(&row[i..i + 4])));
        let face = |row: &[u8]| {
            assert_eq!(row[0], 3);
            [1, 5, 9].map(|i| u32::from_le_bytes(word(&row[i..i + 4])))
        };
        let vertices = vertices.chunks_exact(12).map(vertex).collect();
        (header, vertices, faces.chunks_exact(13).map(face).collect())
    }

    #[test]
    fn a_ply_file_holds_the_closed_mesh_bit_for_bit() {
        let hole = Solid::cylinder(2.0, 3.0).at(0.0, 0.0, -1.0);
        let washer = Solid::cylinder(5.0, 1.0).minus(hole);
        let mesh = fabkit_mesh::mesh(&washer, 0.01).unwrap().to_print().unwrap();
        let (header, vertices, triangles) = read(&mesh_ply("big\nwasher", &mesh).unwrap());
        assert!(header.contains("; unit mm; big washer\n"), "{header}");
        assert_eq!(vertices, mesh.vertices());
        assert_eq!(triangles, mesh.triangles());
        // Each edge is passed once in each direction.
        let edges = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let edges: HashSet<(u32, u32)> = edges.collect();
        assert_eq!(edges.len(), 3 * triangles.len());
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
    }
}
