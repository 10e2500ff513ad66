//! Faces, features and shared surfaces after booleans, and refused solids.

use crate::oracle;
use std::collections::BTreeSet;

use fabkit_geometry::{Path, Point3, Pose, Solid, Vector3};
use fabkit_geometry_testing::{cases, trees};
use fabkit_mesh::{
    DEFAULT_TOLERANCE_MM, IntersectionCache, MeshError, TriMesh, intersection_volume_mm3, mesh,
};
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases(200))]

    /// The oracle has no distance from half spaces, so theirs is checked in the frame of the leaf.
    #[test]
    fn each_triangle_lies_on_the_face_that_it_names(solid in trees()) {
        let tolerance_mm = 0.02;
        let Ok(triangles) = mesh(&solid, tolerance_mm) else { return Ok(()) };
        let leaves = solid.leaves();
        for (triangle, id) in triangles.triangles.iter().zip(&triangles.faces) {
            let leaf = &leaves[id.leaf as usize];
            let leaf_from_root = leaf.root_from_leaf.inverse();
            for &v in triangle {
                let point = leaf_from_root.point(Point3::from(triangles.vertices[v as usize]));
                let distance = match leaf.primitive {
                    Solid::HalfSpace(_) => point.z.abs(),
                    primitive => oracle::distance_mm(primitive, id.face, point.into()),
                };
                // The kernel may merge vertices that are 1e-5 mm apart.
                prop_assert!(distance < tolerance_mm + 1e-4, "{id:?} is {distance} mm off");
            }
        }
    }
}

/// Returns a layer of gel as on a test tube: a hemisphere on a straight wall, from one radius to another.
fn dome_layer(inner_mm: f64, outer_mm: f64) -> Solid {
    Solid::revolution(
        Path::from([inner_mm, 0.0])
            .line([outer_mm, 0.0])
            .line([outer_mm, 6.0])
            .arc([0.0, 6.0 + outer_mm], [0.0, 6.0], true)
            .line([0.0, 6.0 + inner_mm])
            .arc([inner_mm, 6.0], [0.0, 6.0], false)
            .close(),
    )
}

#[test]
fn layers_that_share_a_face_share_its_triangles() {
    let (inner, outer) = (dome_layer(12.0, 13.5), dome_layer(13.5, 15.0));
    let points_of = |mesh: &TriMesh, faces: [u32; 2], reversed: bool| {
        let on_face =
            mesh.triangles.iter().zip(&mesh.faces).filter(|(_, f)| faces.contains(&f.face));
        let corners = on_face.map(|(t, _)| {
            let mut corners = t.map(|v| mesh.vertices[v as usize].map(f64::to_bits));
            if reversed {
                corners.reverse();
            }
            let first = (0..3).min_by_key(|&i| corners[i]).unwrap();
            corners.rotate_left(first);
            corners
        });
        corners.collect::<BTreeSet<_>>()
    };
    let [a, b] = [&inner, &outer].map(|layer| mesh(layer, DEFAULT_TOLERANCE_MM).unwrap());
    // Faces 1 and 2 of the inner layer are its outside, 4 and 5 of the outer one its inside.
    let (outside, inside) = (points_of(&a, [1, 2], false), points_of(&b, [4, 5], true));
    assert!(outside.len() > 1000);
    assert_eq!(outside, inside);
    assert!(intersection_volume_mm3(&inner, &outer, DEFAULT_TOLERANCE_MM).unwrap() < 1e-6);
}

#[test]
fn layers_cut_from_solids_do_not_overlap_either() {
    let ball = |r: f64| Solid::sphere(r).and(Solid::behind(Point3::origin(), -Vector3::z()));
    let layer = |inner: f64, outer: f64| ball(outer).minus(Solid::sphere(inner));
    let [a, b] = [layer(12.0, 13.5), layer(13.5, 15.0)];
    assert!(intersection_volume_mm3(&a, &b, DEFAULT_TOLERANCE_MM).unwrap() < 1e-6);
    // The same test sees an overlap of a tenth of a millimetre.
    let overlap_mm3 = intersection_volume_mm3(&a, &layer(13.4, 15.0), DEFAULT_TOLERANCE_MM);
    let exact_mm3 = std::f64::consts::TAU / 3.0 * (13.5f64.powi(3) - 13.4f64.powi(3));
    assert!((overlap_mm3.unwrap() / exact_mm3 - 1.0).abs() < 0.01);
}

#[test]
fn cached_intersections_equal_single_ones() {
    let ball = Solid::sphere(5.0).minus(Solid::cylinder(1.0, 12.0).at_z(-6.0));
    let block = Solid::cuboid(6.0, 6.0, 6.0).minus(Solid::cylinder(2.0, 8.0).at_z(-1.0));
    let half = Solid::sphere(4.0).and(Solid::behind(Point3::origin(), Vector3::z()));
    let turned = block.clone().placed(Pose::translation(1.0, 2.0, -3.0));
    let solids = [ball, block, half, turned];
    let mut all = IntersectionCache::new(DEFAULT_TOLERANCE_MM);
    let mut overlaps = 0;
    for (i, a) in solids.iter().enumerate() {
        for b in &solids[i + 1..] {
            let alone_mm3 = intersection_volume_mm3(a, b, DEFAULT_TOLERANCE_MM).unwrap();
            let mm3 = all.volume_mm3(a, b).unwrap();
            assert_eq!(mm3.to_bits(), alone_mm3.to_bits(), "{mm3}, {alone_mm3}");
            overlaps += u32::from(mm3 > 1.0);
        }
    }
    assert!(overlaps >= 4, "{overlaps}");
}

#[test]
fn half_spaces_cut_and_are_cut() {
    let half_ball_mm3 = std::f64::consts::TAU / 3.0 * 125.0;
    let ball = || Solid::sphere(5.0);
    let tilted = || Solid::behind(Point3::origin(), Vector3::new(1.0, 2.0, -0.5));
    let both = [ball().and(tilted()), tilted().and(ball()), ball().minus(tilted())];
    let within = Solid::intersection([ball(), tilted().minus(Solid::sphere(1.0))]);
    for solid in both {
        let volume_mm3 = mesh(&solid, 0.01).unwrap().volume_mm3();
        assert!((volume_mm3 - half_ball_mm3).abs() < 0.01 * 236.0, "{volume_mm3}");
    }
    let hollow_mm3 = half_ball_mm3 - std::f64::consts::TAU / 3.0;
    assert!((mesh(&within, 0.01).unwrap().volume_mm3() - hollow_mm3).abs() < 0.01 * 245.0);
}

#[test]
fn features_name_their_triangles() {
    let hole = |x: f64| Solid::cylinder(1.0, 4.0).at(x, 0.0, -1.0).named(format!("hole at {x}"));
    let plate = Solid::cuboid(20.0, 6.0, 2.0).minus_all([hole(-5.0), hole(5.0)]);
    let mesh = mesh(&plate, 0.05).unwrap();
    assert_eq!(mesh.genus(), 2);
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        let middle_mm = triangle.iter().map(|&v| mesh.vertices[v as usize][0]).sum::<f64>() / 3.0;
        let feature = mesh.feature(i, &plate);
        match feature {
            "" => assert_eq!(mesh.faces[i].leaf, 0),
            "hole at -5" => assert!((-6.0..-4.0).contains(&middle_mm)),
            "hole at 5" => assert!((4.0..6.0).contains(&middle_mm)),
            other => panic!("{other}"),
        }
    }
    let named = (0..mesh.triangles.len()).filter(|&i| !mesh.feature(i, &plate).is_empty());
    // Two walls, two triangles per chord.
    assert!(named.count() >= 2 * 2 * 12);
}

#[test]
fn unbounded_empty_and_invalid_solids_are_refused() {
    let ball = || Solid::sphere(1.0);
    let error = |solid: Solid| mesh(&solid, 0.1).unwrap_err();
    assert_eq!(error(Solid::below(0.0)), MeshError::Unbounded);
    assert_eq!(error(Solid::below(0.0).plus(ball())), MeshError::Unbounded);
    assert_eq!(error(Solid::below(0.0).minus(ball())), MeshError::Unbounded);
    assert_eq!(error(ball().and(ball().at(3.0, 0.0, 0.0))), MeshError::Empty);
    assert_eq!(
        error(ball().minus(Solid::cuboid(4.0, 4.0, 4.0).at(0.0, 0.0, -2.0))),
        MeshError::Empty
    );
    assert_eq!(error(ball().and(Solid::below(-2.0))), MeshError::Empty);
    assert!(matches!(error(Solid::union([])), MeshError::Invalid(_)));
    assert!(matches!(error(Solid::sphere(f64::NAN)), MeshError::Invalid(_)));
    assert_eq!(error(Solid::sphere(1e6)), MeshError::TooFine { tolerance_mm: 0.1 });
    for tolerance_mm in [0.0, -1.0, 1e-9, 1e3, f64::NAN, f64::INFINITY] {
        assert!(matches!(mesh(&ball(), tolerance_mm), Err(MeshError::Tolerance { .. })));
    }
}

#[test]
fn solids_that_touch_along_an_edge_or_in_a_point_can_be_written() {
    let cube = || Solid::cuboid(1.0, 1.0, 1.0);
    for (x, y, z) in [(1.0, 1.0, 0.0), (1.0, 1.0, 1.0), (1.0, 0.0, 0.0), (3.0, 0.0, 0.0)] {
        let file = mesh(&cube().plus(cube().at(x, y, z)), 0.1).unwrap().to_print().unwrap();
        assert!((file.volume_mm3() - 2.0).abs() < 1e-5, "({x}, {y}, {z}): {}", file.volume_mm3());
    }
}

#[test]
fn a_cavity_is_a_shell_of_its_own() {
    let hollow = mesh(&Solid::sphere(5.0).minus(Solid::sphere(3.0)), 0.05).unwrap();
    assert_eq!((hollow.shells(), hollow.genus()), (2, 0));
    hollow.to_print().unwrap();
}
