//! Soft layers as tetrahedra: exact where they touch, even inside, closed.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use fabkit_application::designs::builtin_yaml;
use fabkit_application::fixtures::{Project, load};
use fabkit_elastic::{MeridianCurve, SoftStack};
use fabkit_geometry::{Point3, TouchSurface};
use fabkit_tests::{fabkit, tested_sensors};
use fabkit_tetra::{TetraError, Tetrahedra};

/// No solver takes flatter ones gladly; the bound.
const LEAST_DIHEDRAL_DEG: f64 = 15.0;
/// The same where a dome is filled down to a flat floor: columns lean where it meets the rim.
const LEAST_ON_FLOOR_DEG: f64 = 12.0;

fn project(sensor: &str, settings: &[&str]) -> Project {
    let settings: Vec<String> = settings.iter().map(ToString::to_string).collect();
    load(&format!("{sensor}.yaml"), builtin_yaml(sensor).unwrap(), &settings).unwrap()
}

fn mesh(project: &Project, edge_mm: f64) -> (SoftStack, TouchSurface, Tetrahedra) {
    let sensor = &project.design.sensor;
    let (soft, touch) = (SoftStack::at_tip(sensor).unwrap(), sensor.touch.clone().unwrap());
    let mesh = Tetrahedra::new(&soft, &touch, edge_mm).unwrap();
    (soft, touch, mesh)
}

/// Of what lies between two curves when they are turned around the axis, mm3: by Pappus, of thin quadrilaterals.
fn between_mm3(outer: &MeridianCurve, inner: &MeridianCurve) -> f64 {
    const STEPS: usize = 20_000;
    let corner = |curve: &MeridianCurve, i: usize| curve.at(i as f64 / STEPS as f64);
    let triangle = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        2.0 * PI * area * (a[0] + b[0] + c[0]) / 3.0
    };
    let part = |i: usize| {
        let (a, b) = (corner(outer, i), corner(outer, i + 1));
        let (c, d) = (corner(inner, i), corner(inner, i + 1));
        triangle(a, c, b) + triangle(b, c, d)
    };
    (0..STEPS).map(part).sum::<f64>().abs()
}

fn check(project: &Project, edge_mm: f64) {
    let (soft, touch, mesh) = mesh(project, edge_mm);
    let name = &project.design.sensor.name;
    let quality = mesh.quality();
    assert!(quality.least_volume_mm3 > 0.0, "{name}: inverted");
    let least_deg = if name == "tactip" { LEAST_ON_FLOOR_DEG } else { LEAST_DIHEDRAL_DEG };
    assert!(
        quality.least_dihedral_deg > least_deg,
        "{name}, {edge_mm} mm: {} deg",
        quality.least_dihedral_deg
    );
    // The touched surface, to rounding.
    for node in Tetrahedra::collect_nodes(&mesh.touched_faces) {
        let (depth_mm, _) = touch.depth_mm(&Point3::from(mesh.points_mm[node as usize]));
        assert!(depth_mm.abs() < 1e-9, "{name}: {depth_mm} mm off the surface");
    }
    // All layers together: chords of an edge sag by its square over eight radii.
    let interfaces = &soft.body.interfaces;
    let (first, last) = (&interfaces[0], &interfaces[interfaces.len() - 1]);
    let exact_mm3 = match &touch {
        // Layer by layer: the rim is a line with a corner where they meet.
        TouchSurface::Dome(_) => {
            interfaces.windows(2).map(|pair| between_mm3(&pair[0], &pair[1])).sum()
        }
        TouchSurface::Plane(plane) => {
            plane.outline.signed_area_mm2().abs() * (first.at(0.0)[1] - last.at(0.0)[1])
        }
    };
    let found_mm3: f64 = quality.volume_mm3.iter().sum();
    let part = (0.001f64).max(0.004 * edge_mm * edge_mm);
    assert!(
        (found_mm3 / exact_mm3 - 1.0).abs() < part,
        "{name}, {edge_mm} mm: {found_mm3} {exact_mm3}"
    );
    // Each face belongs to two tetrahedra, or to the surface; the named sets are parts of it.
    let mut faces = BTreeMap::<[u32; 3], usize>::new();
    for cell in &mesh.cells {
        for skip in 0..4 {
            let mut face: Vec<u32> = (0..4).filter(|i| *i != skip).map(|i| cell[i]).collect();
            face.sort_unstable();
            *faces.entry([face[0], face[1], face[2]]).or_default() += 1;
        }
    }
    assert!(faces.values().all(|count| *count <= 2), "{name}");
    for face in mesh.touched_faces.iter().chain(&mesh.bonded_faces) {
        let mut sorted = *face;
        sorted.sort_unstable();
        assert_eq!(faces.get(&sorted), Some(&1), "{name}: a face of a set is not on the surface");
    }
    // What is left of the surface is a rim or a free inner face; edges of a closed surface belong to two triangles.
    let mut edges = BTreeMap::<[u32; 2], usize>::new();
    for face in faces.iter().filter(|(_, count)| **count == 1).map(|(face, _)| face) {
        for [a, b] in [[face[0], face[1]], [face[0], face[2]], [face[1], face[2]]] {
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    assert!(edges.values().all(|count| *count == 2), "{name}: the surface is not closed");
}

#[test]
fn layers_of_every_sensor_are_even_closed_and_exact() {
    let mut seen = 0;
    for sensor in tested_sensors() {
        let project = project(sensor, &[]);
        if project.design.sensor.touch.is_none() {
            continue;
        }
        seen += 1;
        check(&project, 0.9);
    }
    assert!(seen >= 5, "{seen}");
    check(&project("rtac0", &[]), 0.5);
    check(&project("digit-like", &[]), 0.5);
}

#[test]
fn edges_and_thicknesses_may_be_any() {
    let mut random = fabkit_geometry::sequences::SplitMix64::new(11);
    let mut checked = 0;
    for _ in 0..8 {
        let thickness_mm = 1.2 + random.unit();
        let edge_mm = 0.5 + 2.0 * random.unit();
        let settings = [format!("translucent_gel.thickness={thickness_mm:.2}mm")];
        // What the rest of the design does not follow is no variant.
        let yaml = builtin_yaml("rtac0").unwrap();
        let Ok(project) = load("rtac0.yaml", yaml, &settings) else { continue };
        check(&project, edge_mm);
        check(&self::project("gelsight-like", &[]), edge_mm);
        checked += 1;
    }
    assert!(checked >= 4, "{checked}");
}

#[test]
fn what_cannot_be_meshed_is_refused_with_numbers() {
    let project = project("rtac0", &[]);
    let sensor = &project.design.sensor;
    let (soft, touch) = (SoftStack::at_tip(sensor).unwrap(), sensor.touch.as_ref().unwrap());
    for edge_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Tetrahedra::new(&soft, touch, edge_mm).unwrap_err();
        assert!(matches!(error, TetraError::Edge { .. }), "{error}");
    }
    let error = Tetrahedra::new(&soft, touch, 0.06).unwrap_err();
    assert!(error.to_string().contains("at most 5000000"), "{error}");
}

#[test]
fn files_are_whole_and_the_same_each_time() {
    let root = tempfile::tempdir().unwrap();
    let made = |folder: &str, threads: &str| {
        let arguments =
            ["export", "digit-like", "--format", "msh,vtk", "--edge", "1mm", "--threads", threads];
        fabkit(root.path(), &[&arguments[..], &["-o", folder]].concat()).ok();
        ["msh", "vtk", "tetrahedra.json"].map(|end| {
            std::fs::read(root.path().join(folder).join(format!("digit-like.{end}"))).unwrap()
        })
    };
    let one = made("one", "1");
    assert!(one == made("two", "2") && one == made("eight", "8"));
    let about: serde_json::Value = serde_json::from_slice(&one[2]).unwrap();
    assert_eq!((&about["unit"], &about["frame"]), (&"mm".into(), &"sensor".into()));
    let run = fabkit(root.path(), &["export", "fluidic", "--format", "msh", "-o", "none"]);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("nothing of known elasticity"), "{}", run.stderr);
    assert!(!root.path().join("none").exists());
    let run = fabkit(
        root.path(),
        &["export", "rtac0", "--format", "msh", "--edge", "0.06mm", "-o", "none"],
    );
    assert_eq!(run.code, Some(3), "{run:?}");
    assert!(run.stderr.contains("tetrahedra") && run.stderr.contains("longer edges"));
}
