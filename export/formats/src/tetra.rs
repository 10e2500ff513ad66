//! Tetrahedral meshes with materials and face sets: Gmsh's MSH 4.1 and 2.2, and VTK's legacy format, all as text.

use std::fmt::Write as _;

/// A tetrahedral mesh.
///
/// ```
/// use fabkit_export::{TetraMesh, msh2, vtk};
///
/// let mesh = TetraMesh {
///     title: "one tetrahedron",
///     notes: &[],
///     points_mm: &[[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]],
///     unit_mm: 1000.0,
///     cells: &[[0, 1, 2, 3]],
///     cell_materials: &[0],
///     materials: &["gel".into()],
///     faces: &[("bottom", &[[0, 2, 1]])],
/// };
/// // Nodes in metres, and a 1 for each node of the bottom.
/// let text = String::from_utf8(vtk(&mesh))?;
/// assert!(text.contains("POINTS 4 double\n0 0 0\n0.01 0 0\n"));
/// assert!(text.ends_with("SCALARS bottom int 1\nLOOKUP_TABLE default\n1\n1\n1\n0\n"));
/// // Gmsh counts from 1: a triangle (type 2) of group 1, then a tetrahedron (type 4).
/// let text = String::from_utf8(msh2(&mesh))?;
/// assert!(text.contains("$Elements\n2\n1 2 2 1 1 1 3 2\n2 4 2 1 1 1 2 3 4\n"));
/// # Ok::<(), std::string::FromUtf8Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TetraMesh<'a> {
    /// Title in one line for people.
    pub title: &'a str,
    /// Further notes, line by line.
    pub notes: &'a [String],
    /// Nodes, mm.
    pub points_mm: &'a [[f64; 3]],
    /// Unit of the file's lengths, mm: 1000 for a file in metres.
    pub unit_mm: f64,
    /// Corners of the tetrahedra, of positive volume.
    pub cells: &'a [[u32; 4]],
    /// Material of each tetrahedron, as an index into `materials`.
    pub cell_materials: &'a [u32],
    /// Names of materials.
    pub materials: &'a [String],
    /// Named sets of surface triangles.
    pub faces: &'a [(&'a str, &'a [[u32; 3]])],
}

/// Element types of Gmsh.
const TRIANGLE: u32 = 2;
const TETRAHEDRON: u32 = 4;
/// Cell type of VTK.
const VTK_TETRA: u32 = 10;
/// Maximum length of a VTK title line, in characters.
const MOST_TITLE: usize = 255;

/// Writes Gmsh's MSH 4.1 in ASCII: a volume for each material and a surface for each face set, each a physical group of
/// its name.
///
/// Gmsh reference manual, section "MSH file format".
pub fn msh(mesh: &TetraMesh) -> Vec<u8> {
    let mut text = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Comments\n");
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(text, "{}", mesh.title);
    mesh.notes.iter().for_each(|note| {
        let _ = writeln!(text, "{note}");
    });
    text += "$EndComments\n";
    names(mesh, &mut text);
    text += "$Entities\n";
    // Numbers of points, curves, surfaces and volumes.
    let _ = writeln!(text, "0 0 {} {}", mesh.faces.len(), mesh.materials.len());
    let [low, high] = bounds(mesh.points_mm).map(|end| end.map(|mm| mm / mesh.unit_mm));
    let bounds = [low, high].concat().iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    // Tag, bounds, one physical group of the same number, no bounding entities.
    for i in 1..=mesh.faces.len() {
        let _ = writeln!(text, "{i} {bounds} 1 {i} 0");
    }
    for i in 1..=mesh.materials.len() {
        let _ = writeln!(text, "{i} {bounds} 1 {i} 0");
    }
    let count = mesh.points_mm.len();
    // A single block lists all nodes under volume 1.
    let _ = writeln!(text, "$EndEntities\n$Nodes\n1 {count} 1 {count}\n3 1 0 {count}");
    for node in 1..=count {
        let _ = writeln!(text, "{node}");
    }
    points(mesh, &mut text);
    text += "$EndNodes\n$Elements\n";
    let triangles: usize = mesh.faces.iter().map(|(_, faces)| faces.len()).sum();
    let all = triangles + mesh.cells.len();
    let blocks = mesh.faces.len() + mesh.materials.len();
    let _ = writeln!(text, "{blocks} {all} 1 {all}");
    let mut tag = 0;
    for (i, (_, faces)) in mesh.faces.iter().enumerate() {
        let _ = writeln!(text, "2 {} {TRIANGLE} {}", i + 1, faces.len());
        for [a, b, c] in *faces {
            tag += 1;
            let _ = writeln!(text, "{tag} {} {} {}", a + 1, b + 1, c + 1);
        }
    }
    for i in 0..mesh.materials.len() {
        let of_it = || {
            let all = mesh.cells.iter().zip(mesh.cell_materials);
            all.filter(move |(_, material)| **material as usize == i).map(|(cell, _)| cell)
        };
        let _ = writeln!(text, "3 {} {TETRAHEDRON} {}", i + 1, of_it().count());
        for [a, b, c, d] in of_it() {
            tag += 1;
            let _ = writeln!(text, "{tag} {} {} {} {}", a + 1, b + 1, c + 1, d + 1);
        }
    }
    text += "$EndElements\n";
    text.into_bytes()
}

/// Writes Gmsh's MSH 2.2 in ASCII, which libigl and thereby UIPC read, with the same groups as element tags.
///
/// Gmsh reference manual, section "MSH file format version 2 (Legacy)".
pub fn msh2(mesh: &TetraMesh) -> Vec<u8> {
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    names(mesh, &mut text);
    // Writing to a string cannot fail, here and below.
    let _ = writeln!(text, "$Nodes\n{}", mesh.points_mm.len());
    for (i, point) in mesh.points_mm.iter().enumerate() {
        let [x, y, z] = point.map(|mm| mm / mesh.unit_mm);
        let _ = writeln!(text, "{} {x} {y} {z}", i + 1);
    }
    let triangles: usize = mesh.faces.iter().map(|(_, faces)| faces.len()).sum();
    let _ = writeln!(text, "$EndNodes\n$Elements\n{}", triangles + mesh.cells.len());
    let mut tag = 0;
    for (i, (_, faces)) in mesh.faces.iter().enumerate() {
        for [a, b, c] in *faces {
            tag += 1;
            let _ = writeln!(
                text,
                "{tag} {TRIANGLE} 2 {0} {0} {1} {2} {3}",
                i + 1,
                a + 1,
                b + 1,
                c + 1
            );
        }
    }
    for ([a, b, c, d], material) in mesh.cells.iter().zip(mesh.cell_materials) {
        tag += 1;
        let _ = writeln!(
            text,
            "{tag} {TETRAHEDRON} 2 {0} {0} {1} {2} {3} {4}",
            material + 1,
            a + 1,
            b + 1,
            c + 1,
            d + 1
        );
    }
    text += "$EndElements\n";
    text.into_bytes()
}

fn names(mesh: &TetraMesh, text: &mut String) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "$PhysicalNames\n{}", mesh.faces.len() + mesh.materials.len());
    for (i, (name, _)) in mesh.faces.iter().enumerate() {
        let _ = writeln!(text, "2 {} \"{name}\"", i + 1);
    }
    for (i, name) in mesh.materials.iter().enumerate() {
        let _ = writeln!(text, "3 {} \"{name}\"", i + 1);
    }
    *text += "$EndPhysicalNames\n";
}

/// Writes VTK's legacy format, version 3.0, as an unstructured grid of tetrahedra only: cells have `material`, nodes
/// one array of 0 and 1 for each face set.
///
/// VTK file formats, "Simple legacy formats".
pub fn vtk(mesh: &TetraMesh) -> Vec<u8> {
    let title: String = mesh.title.chars().filter(|c| *c != '\n').take(MOST_TITLE).collect();
    let count = mesh.points_mm.len();
    let mut text = format!(
        "# vtk DataFile Version 3.0\n{title}\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {count} double\n"
    );
    points(mesh, &mut text);
    let cells = mesh.cells.len();
    // Each cell takes five numbers: the count and four nodes.
    let _ = writeln!(text, "CELLS {cells} {}", 5 * cells);
    for [a, b, c, d] in mesh.cells {
        let _ = writeln!(text, "4 {a} {b} {c} {d}");
    }
    let _ = writeln!(text, "CELL_TYPES {cells}");
    for _ in 0..cells {
        let _ = writeln!(text, "{VTK_TETRA}");
    }
    let _ = writeln!(text, "CELL_DATA {cells}\nSCALARS material int 1\nLOOKUP_TABLE default");
    for material in mesh.cell_materials {
        let _ = writeln!(text, "{}", material + 1);
    }
    let _ = writeln!(text, "POINT_DATA {count}");
    for (name, faces) in mesh.faces {
        let _ = writeln!(text, "SCALARS {name} int 1\nLOOKUP_TABLE default");
        let mut is_in = vec![0; count];
        faces.iter().flatten().for_each(|node| is_in[*node as usize] = 1);
        for is_in in is_in {
            let _ = writeln!(text, "{is_in}");
        }
    }
    text.into_bytes()
}

/// Writes the nodes with the shortest digits that parse to the same numbers.
fn points(mesh: &TetraMesh, text: &mut String) {
    for point in mesh.points_mm {
        let [x, y, z] = point.map(|mm| mm / mesh.unit_mm);
        let _ = writeln!(text, "{x} {y} {z}");
    }
}

fn bounds(points_mm: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let ends = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    points_mm.iter().fold(ends, |[low, high], point| {
        [0, 1].map(|end| {
            std::array::from_fn(|axis| match end {
                0 => low[axis].min(point[axis]),
                _ => high[axis].max(point[axis]),
            })
        })
    })
}
