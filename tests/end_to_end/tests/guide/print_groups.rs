//! Parts that are printed as one piece: their files share coordinates, they touch without overlap,
//! and where they touch their meshes have the same vertices.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use fabkit_geometry::measure::overlap_volume;
use fabkit_geometry::{CompiledSolid, Solid};
use fabkit_mesh::{DEFAULT_TOLERANCE_MM, intersection_volume_mm3};
use fabkit_tests::{builtin_designs, fabkit};

/// Lines through the box that two bodies share.
const LINES: u32 = 20_000;

/// Largest common volume of two meshes that only touch, mm3.
const TOUCHING_MM3: f64 = 1e-6;

/// A vertex, bit for bit.
type Vertex = [u32; 3];

type Triangle = [[f32; 3]; 3];

fn read_stl(path: &Path) -> Vec<Triangle> {
    let bytes = fs::read(path).unwrap();
    let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let corner = |at: usize| std::array::from_fn(|axis| number(at + 4 * axis));
    (84..bytes.len()).step_by(50).map(|at| [12, 24, 36].map(|skip| corner(at + skip))).collect()
}

/// Negative zero is zero.
fn bits(vertex: &[f32; 3]) -> Vertex {
    vertex.map(|v| (v + 0.0).to_bits())
}

fn vertices(triangles: &[Triangle]) -> BTreeSet<Vertex> {
    triangles.iter().flatten().map(bits).collect()
}

/// Area of the triangles all of whose corners are shared, mm2.
fn area_within(triangles: &[Triangle], shared: &BTreeSet<Vertex>) -> f64 {
    let within = |triangle: &&Triangle| triangle.iter().all(|v| shared.contains(&bits(v)));
    let area = |triangle: &Triangle| {
        let [a, b, c] = triangle.map(|v| v.map(f64::from));
        let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        let cross =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        cross.iter().map(|x| x * x).sum::<f64>().sqrt() / 2.0
    };
    triangles.iter().filter(within).map(area).sum()
}

#[test]
fn parts_of_one_piece_touch_and_never_overlap() {
    for design in builtin_designs() {
        let sensor = &design.sensor;
        let solid = |name: &String| -> &Solid { &sensor.body(name).unwrap().solid };
        for group in &sensor.print_groups {
            for (i, a) in group.parts.iter().enumerate() {
                for b in &group.parts[i + 1..] {
                    let bodies = [a, b].map(|name| CompiledSolid::new(solid(name)).unwrap());
                    let overlap = overlap_volume(&bodies[0], &bodies[1], LINES).unwrap();
                    assert_eq!(overlap.volume.value_mm3, 0.0, "{a}, {b}: {:?}", overlap.witness);
                    let meshes =
                        intersection_volume_mm3(solid(a), solid(b), DEFAULT_TOLERANCE_MM).unwrap();
                    assert!(meshes < TOUCHING_MM3, "{a}, {b}: meshes share {meshes} mm3");
                }
            }
        }
    }
}

#[test]
fn the_tactips_bodies_share_the_vertices_of_their_common_faces() {
    let folder = tempfile::tempdir().unwrap();
    // One part brings the others of its group with it.
    fabkit(folder.path(), &["export", "tactip", "-o", "out", "--part=skin"]).ok();
    let out = folder.path().join("out");
    let mut files: Vec<String> = fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, ["dots.stl", "manifest.json", "ring.stl", "skin.stl", "tip.3mf"]);

    let [skin, dots, ring] =
        ["skin", "dots", "ring"].map(|name| read_stl(&out.join(format!("{name}.stl"))));
    let shared = |a: &[Triangle], b: &[Triangle]| -> BTreeSet<Vertex> {
        vertices(a).intersection(&vertices(b)).copied().collect()
    };
    assert!(shared(&dots, &ring).is_empty(), "dots and ring are apart");

    // Each pin ends in a disc of 1 mm diameter; the ring bears the skin on a step: an annulus from
    // 12.5 to 12.9 mm, a cylinder 1.5 mm high, an annulus from 12.9 to 13.5 mm.
    let discs_mm2 = 57.0 * PI * 0.25;
    let annuli_mm2 = PI * (13.5f64.powi(2) - 12.5f64.powi(2));
    let step_mm2 = annuli_mm2 + 2.0 * PI * 12.9 * 1.5;
    for (name, other, exact_mm2, smallest_radius_mm) in
        [("dots", &dots, discs_mm2, 0.5), ("ring", &ring, step_mm2, 12.5)]
    {
        let common = shared(&skin, other);
        let (on_skin, on_other) = (area_within(&skin, &common), area_within(other, &common));
        println!("{name}: {} shared vertices, {on_skin} mm2 of {exact_mm2} mm2", common.len());
        assert!((on_skin - on_other).abs() < 1e-6 * exact_mm2, "{name}: {on_skin}, {on_other}");
        // Chords within the tolerance of a circle of radius r lose at most 2 t / r of its disc.
        let bound = 2.0 * DEFAULT_TOLERANCE_MM / smallest_radius_mm * exact_mm2;
        let lost = exact_mm2 - on_skin;
        assert!((0.0..bound).contains(&lost), "{name}: {on_skin} of {exact_mm2} mm2 are shared");
    }
}
