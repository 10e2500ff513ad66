//! Edges made by booleans lie where the exact surfaces meet.

use crate::oracle;
use std::collections::BTreeMap;

use fabkit_geometry::{Angle, Path, Point3, Profile, Solid};
use fabkit_mesh::{FaceId, TriMesh, mesh};

/// Tolerance for points on a surface, mm: Newton's method ends at 1e-9 mm from each surface.
const ON_MM: f64 = 2e-9;

fn distance_mm(solid: &Solid, id: FaceId, point: [f64; 3]) -> f64 {
    let leaf = &solid.leaves()[id.leaf as usize];
    let local = leaf.root_from_leaf.inverse().point(Point3::from(point));
    oracle::distance_mm(leaf.primitive, id.face, local.into())
}

/// Returns each vertex with the faces around it.
fn faces_at(mesh: &TriMesh) -> BTreeMap<u32, Vec<FaceId>> {
    let mut faces: BTreeMap<u32, Vec<FaceId>> = BTreeMap::new();
    for (triangle, &face) in mesh.triangles.iter().zip(&mesh.faces) {
        for &v in triangle {
            faces.entry(v).or_default().push(face);
        }
    }
    faces
}

/// Returns bodies with faces that the kernel intersects at large and at small angles.
fn met() -> Vec<Solid> {
    let ears = Profile::new(Path::rectangle([0.0, 0.0], [60.0, 9.0], 0.0));
    let tilt = Angle::from_deg(35.0).unwrap();
    let cone = Solid::cone(24.0, 8.0, 16.0);
    vec![
        Solid::cylinder(10.0, 20.0).plus(Solid::cuboid(40.0, 19.0, 5.0).at(0.0, 0.0, 7.0)),
        Solid::cylinder(20.0, 10.0).plus(Solid::extrusion(ears, 4.0).at(0.0, 15.0, 3.0)),
        Solid::sphere(12.0).minus(Solid::cuboid(30.0, 30.0, 4.0).turned_x(tilt).at(1.0, 2.0, 3.0)),
        cone.minus(Solid::cylinder(9.0, 40.0).turned_y(tilt).at(5.0, 1.0, -9.0)),
    ]
}

#[test]
fn vertices_between_faces_lie_on_all_of_them() {
    for solid in met() {
        for tolerance_mm in [0.01, 0.2] {
            let mesh = mesh(&solid, tolerance_mm).unwrap();
            for (vertex, faces) in faces_at(&mesh) {
                let at = mesh.vertices[vertex as usize];
                for face in faces {
                    let off_mm = distance_mm(&solid, face, at);
                    assert!(off_mm < ON_MM, "{off_mm} mm off {face:?} at {at:?}: {solid:?}");
                }
            }
            mesh.to_print().unwrap();
        }
    }
}

#[test]
fn seam_correction_folds_no_triangle() {
    for solid in met() {
        let mesh = mesh(&solid, 0.05).unwrap();
        // Folded triangles would increase the area.
        let fine = fabkit_mesh::mesh(&solid, 0.001).unwrap();
        assert!(mesh.area_mm2() < fine.area_mm2() * 1.0001, "{solid:?}");
        assert_eq!((mesh.genus(), mesh.shells()), (fine.genus(), fine.shells()), "{solid:?}");
    }
}
