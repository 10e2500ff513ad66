//! Comparison of every primitive's mesh with its exact surface.

use crate::oracle::distance_mm;
use fabkit_geometry::{Path, Profile, Solid};
use fabkit_geometry_testing::{cases, primitives};
use fabkit_mesh::{TriMesh, mesh};
use proptest::prelude::*;

/// Number of steps along each edge of a triangle at which it is compared with the surface.
const STEPS: usize = 8;

/// Approximate largest number of triangles of a mesh that are compared, evenly spread over it.
const SAMPLED: usize = 500;

/// Returns the largest distance of vertices, and of samples of triangles, from the face each belongs to.
fn deviations(primitive: &Solid, mesh: &TriMesh) -> (f64, f64) {
    let (mut vertices, mut samples) = (0.0f64, 0.0f64);
    let stride = 1.max(mesh.triangles.len() / SAMPLED);
    for (triangle, id) in mesh.triangles.iter().zip(&mesh.faces).step_by(stride) {
        let corners = triangle.map(|v| mesh.vertices[v as usize]);
        for i in 0..=STEPS {
            for j in 0..=STEPS - i {
                let weights = [i, j, STEPS - i - j].map(|w| w as f64 / STEPS as f64);
                let point =
                    std::array::from_fn(|k| (0..3).map(|c| weights[c] * corners[c][k]).sum());
                let distance = distance_mm(primitive, id.face, point);
                samples = samples.max(distance);
                if weights.contains(&1.0) {
                    vertices = vertices.max(distance);
                }
            }
        }
    }
    (vertices, samples)
}

fn check(solid: &Solid, tolerance_mm: f64) -> TriMesh {
    let mesh = mesh(solid, tolerance_mm).unwrap_or_else(|e| panic!("{solid:?}: {e}"));
    let (vertices, samples) = deviations(solid, &mesh);
    assert!(vertices < 1e-9, "{solid:?} at {tolerance_mm}: vertices {vertices} mm off");
    assert!(samples <= tolerance_mm, "{solid:?} at {tolerance_mm}: {samples} mm off");
    mesh.to_print().unwrap_or_else(|e| panic!("{solid:?} at {tolerance_mm}: {e}"));
    mesh
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn triangles_of_random_primitives_keep_to_the_surface(
        solid in primitives(),
        log_tolerance in -3.0f64..-0.3,
    ) {
        check(&solid, 10f64.powf(log_tolerance));
    }
}

/// Returns solids with their volume and genus.
fn known() -> Vec<(Solid, f64, i32)> {
    use std::f64::consts::PI;
    let mut known = Vec::new();
    for r in [0.2, 1.0, 15.0, 60.0] {
        known.extend([
            (Solid::sphere(r), 4.0 / 3.0 * PI * r * r * r, 0),
            (Solid::ellipsoid([r, 0.6 * r, 0.3 * r]), 4.0 / 3.0 * PI * 0.18 * r * r * r, 0),
            (Solid::ellipsoid([0.3 * r, r, 2.0 * r]), 4.0 / 3.0 * PI * 0.6 * r * r * r, 0),
            (Solid::cylinder(r, 2.0), PI * r * r * 2.0, 0),
            (Solid::cone(r, 0.4 * r, 3.0), PI * r * r * (1.0 + 0.4 + 0.16), 0),
            (Solid::cone(r, 0.0, 3.0), PI * r * r, 0),
            (Solid::cuboid(r, 2.0, 3.0), 6.0 * r, 0),
            (Solid::torus(r, 0.3 * r), 2.0 * PI * PI * r * (0.3 * r).powi(2), 1),
            (Solid::torus(r, 0.9 * r), 2.0 * PI * PI * r * (0.9 * r).powi(2), 1),
            (Solid::ellipsoid_offset(r, r, 0.5 * r), 4.5 * PI * r * r * r, 0),
            (Solid::ellipsoid_offset(r, r, -0.5 * r), PI * r * r * r / 6.0, 0),
            (washer(r), PI * r * r * 0.75, 1),
            (
                Solid::revolution(Path::circle([3.0 * r, 0.0], r)),
                2.0 * PI * 3.0 * r * PI * r * r,
                1,
            ),
        ]);
    }
    known
}

/// Returns a disc of height 1 with a hole of half its radius, as an extrusion.
fn washer(radius_mm: f64) -> Solid {
    let outer = Profile::new(Path::circle([1.0, 2.0], radius_mm));
    Solid::extrusion(outer.with_hole(Path::circle([1.0, 2.0], radius_mm / 2.0)), 1.0)
}

#[test]
fn volumes_lie_within_area_times_tolerance_of_the_closed_form() {
    for (solid, exact_mm3, genus) in known() {
        for tolerance_mm in [0.1, 0.01] {
            let mesh = check(&solid, tolerance_mm);
            let off = (mesh.volume_mm3() - exact_mm3).abs();
            // The mesh's area falls short of the surface's: allow for it where it is coarse.
            let bound = 1.3 * mesh.area_mm2() * tolerance_mm + 1e-9 * exact_mm3;
            assert!(off <= bound, "{solid:?} at {tolerance_mm}: {off} mm3 off, bound {bound}");
            assert_eq!(mesh.genus(), genus, "{solid:?}");
        }
    }
}

#[test]
fn extreme_points_are_vertices() {
    for (solid, half) in [
        (Solid::sphere(7.3), [7.3, 7.3, 7.3]),
        (Solid::torus(5.0, 1.7), [6.7, 6.7, 1.7]),
        (Solid::ellipsoid([3.0, 4.0, 5.0]), [3.0, 4.0, 5.0]),
        (Solid::ellipsoid_offset(3.0, 5.0, 0.5), [3.5, 3.5, 5.5]),
    ] {
        let bounds = mesh(&solid, 0.05).unwrap().bounds();
        for (i, half_mm) in half.into_iter().enumerate() {
            assert!((bounds.max[i] - half_mm).abs() < 1e-12, "{solid:?}");
            assert!((bounds.min[i] + half_mm).abs() < 1e-12, "{solid:?}");
        }
    }
}
