//! Comparison of fused trees with the original trees and with the exact faces.

use std::cell::Cell;

use fabkit_geometry::{Path, Point3, Pose, Solid};
use fabkit_geometry_testing::cases;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::fuse_coaxial;
use crate::evaluate::evaluate_without_fusion;
use crate::oracle;
use crate::{FaceId, MeshError, TriMesh, mesh, to_mesh};

const TOLERANCE_MM: f64 = 0.02;

/// Draws solids of revolution about z that start at z = 0.
fn round() -> impl Strategy<Value = Solid> {
    // Discrete sizes, so that no rim is as thin as the tolerance, where triangles and exact faces differ.
    let size = || (3u8..22).prop_map(|k| 0.37 * f64::from(k));
    prop_oneof![
        (size(), size()).prop_map(|(r, h)| Solid::cylinder(r, h)),
        (size(), size(), size()).prop_map(|(r, s, h)| Solid::cone(r, s, h)),
        size().prop_map(|r| Solid::sphere(r).at(0.0, 0.0, r)),
        (size(), size(), any::<bool>()).prop_map(|(r, h, long)| {
            let dome = Path::from([0.0, 0.0]).line([r, 0.0]).line([r, h]);
            Solid::revolution(if long {
                dome.elliptic_arc([0.0, 1.5 * r + h], [0.0, h], [r, 1.5 * r], true).close()
            } else {
                dome.arc([0.0, r + h], [0.0, h], true).close()
            })
        }),
        (size(), size(), size()).prop_map(|(r, wide, h)| {
            let ring = [[r, 0.0], [r + wide, 0.0], [r + wide, h], [r, h]];
            Solid::revolution(Path::polygon(&ring))
        }),
    ]
}

/// Draws stacks about one axis: some solids united, some cut away, and a box at one side.
fn stacks() -> impl Strategy<Value = Solid> {
    let placed = || (round(), -4.0f64..4.0).prop_map(|(one, z)| one.at(0.0, 0.0, z));
    let several = || prop::collection::vec(placed(), 1..4);
    (
        several(),
        prop::collection::vec(placed(), 0..4),
        any::<bool>(),
        fabkit_geometry_testing::poses(10.0),
    )
        .prop_map(|(of, minus, boxed, pose)| {
            let mut of = of;
            if boxed {
                of.push(Solid::cuboid(3.0, 2.3, 2.9).at(6.0, 0.3, 0.7));
            }
            Solid::union(of).minus_all(minus).placed(pose)
        })
}

fn unfused(solid: &Solid) -> Result<TriMesh, MeshError> {
    Ok(to_mesh(solid, evaluate_without_fusion(solid, TOLERANCE_MM, true)?))
}

fn distance_mm(solid: &Solid, id: FaceId, at: [f64; 3]) -> f64 {
    let leaves = solid.leaves();
    let leaf = &leaves[id.leaf as usize];
    let point = leaf.root_from_leaf.inverse().point(Point3::from(at));
    oracle::distance_mm(leaf.primitive, id.face, point.into())
}

#[test]
fn fused_stacks_equal_booleans() {
    let (count, differ, solids) = (Cell::new(0), Cell::new(0), stacks());
    let check = |solid: Solid| {
        let Some(fused) = fuse_coaxial(&solid) else { return Ok(()) };
        count.set(count.get() + 1);
        // Vertices made by the kernel lie on its triangles, not on the exact faces.
        let whole = fused.solid.leaves().len() == 1;
        let [vertex_mm, most_mm] =
            if whole { [1e-9, TOLERANCE_MM] } else { [TOLERANCE_MM + 1e-4; 2] };
        let (one, other) = match (mesh(&solid, TOLERANCE_MM), unfused(&solid)) {
            (Ok(one), Ok(other)) => (one, other),
            (one, other) => {
                prop_assert_eq!(one.err(), other.err());
                return Ok(());
            }
        };
        // Rims thinner than the tolerance are right if fused to one solid; by booleans they may break or vanish.
        if whole {
            let Solid::Revolution(one_profile) = fused.solid.leaves()[0].primitive else {
                return Err(TestCaseError::fail("no profile"));
            };
            let path = &one_profile.profile.outer;
            let on_axis = path.segments.iter().any(|segment| segment.to()[0] < 1e-9);
            prop_assert_eq!((one.genus(), one.shells()), (i32::from(!on_axis), 1));
        } else if (one.genus(), one.shells()) != (other.genus(), other.shells()) {
            differ.set(differ.get() + 1);
        }
        let bound_mm3 = 2.0 * TOLERANCE_MM * one.area_mm2();
        prop_assert!((one.volume_mm3() - other.volume_mm3()).abs() < bound_mm3);
        for (triangle, &id) in one.triangles.iter().zip(&one.faces) {
            for &v in triangle {
                let off_mm = distance_mm(&solid, id, one.vertices[v as usize]);
                prop_assert!(off_mm < vertex_mm, "{:?} is {} mm off", id, off_mm);
            }
            let middle: [f64; 3] = std::array::from_fn(|i| {
                triangle.iter().map(|&v| one.vertices[v as usize][i]).sum::<f64>() / 3.0
            });
            let off_mm = distance_mm(&solid, id, middle);
            prop_assert!(off_mm < most_mm * (1.0 + 1e-6), "{:?} is {} mm off", id, off_mm);
        }
        prop_assert!(one.to_print().is_ok());
        Ok(())
    };
    TestRunner::new(cases(150)).run(&solids, check).unwrap();
    assert!(differ.get() < count.get() / 20, "{} of {} differ", differ.get(), count.get());
    assert!(count.get() > 50, "only {} of 150 had anything to fuse", count.get());
}

/// Tests a hollow dome on a flange with a counterbored hole: one profile and one stepped tool.
#[test]
fn a_dome_on_a_flange_needs_no_boolean_for_its_round_parts() {
    let dome = |r: f64, low: f64| {
        let path = Path::from([0.0, low]).line([r, low]).line([r, 0.0]);
        Solid::revolution(path.arc([0.0, r], [0.0, 0.0], true).close())
    };
    let side = Pose::z_to(fabkit_geometry::Vector3::x(), Point3::origin());
    let hole = Solid::cylinder(1.0, 30.0).placed(side);
    let seat = Solid::cylinder(2.0, 30.0).at(0.0, 0.0, 17.0).placed(side);
    let outside = Solid::cylinder(25.0, 2.0).at(0.0, 0.0, -1.0).plus(dome(18.0, -0.9));
    let solid = outside.minus_all([dome(15.0, -2.0), hole, seat]);
    let one = fuse_coaxial(&solid).unwrap().solid;
    assert_eq!(one.leaves().len(), 2, "{one:?}");
    let [volume_mm3, before_mm3] =
        [mesh(&solid, TOLERANCE_MM), unfused(&solid)].map(|m| m.unwrap().volume_mm3());
    assert!((volume_mm3 / before_mm3 - 1.0).abs() < 1e-3, "{volume_mm3} and {before_mm3} mm3");
}

/// Touching layers have the same triangles on their common face, so a curved face must not be divided in only one.
#[test]
fn faces_that_other_leaves_share_are_not_divided() {
    let ball = || Solid::sphere(10.0);
    let flange = || Solid::cylinder(14.0, 2.0).at(0.0, 0.0, -1.0);
    assert!(fuse_coaxial(&ball().plus(flange())).is_some());
    let block = Solid::cuboid(40.0, 40.0, 40.0).at(0.0, 0.0, -20.0);
    let around = block.minus(ball());
    let both = Solid::union([ball().plus(flange()), around]);
    assert!(fuse_coaxial(&both).is_none());
}

/// Contacts, overlapping faces, voids and solids that would fall apart are left to the kernel.
#[test]
fn undecidable_pairs_are_not_fused() {
    let post = || Solid::cylinder(5.0, 10.0);
    let cases = [
        post().plus(post().at(0.0, 0.0, 10.0)),
        post().plus(Solid::cylinder(7.0, 10.0)),
        post().minus(Solid::cylinder(3.0, 4.0).at(0.0, 0.0, 2.0)),
        post().minus(Solid::cylinder(7.0, 4.0).at(0.0, 0.0, 2.0)),
        post().plus(post().at(0.1, 0.0, 5.0)),
        post().plus(post().at(0.0, 0.0, 20.0)),
    ];
    for (i, case) in cases.iter().enumerate() {
        assert!(fuse_coaxial(case).is_none(), "{i}");
    }
}
