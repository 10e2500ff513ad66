//! Comparison of conforming features with booleans and with the exact surfaces.

use std::cell::Cell;

use fabkit_geometry::{Angle, CompiledSolid, Path, Point3, Pose, Ray, Solid, Vector3};
use fabkit_geometry_testing::{cases, directions, poses, primitives};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use crate::evaluate::{evaluate_with_deferred_features, evaluate_without_fusion};
use crate::facets::Facets;
use crate::oracle;
use crate::{DEFAULT_TOLERANCE_MM, MeshError, TriMesh, to_mesh};

const TOLERANCE_MM: f64 = 0.02;

/// Draws a feature about its own z: the tool, and the depth below the surface at which it starts, mm.
fn tools() -> impl Strategy<Value = (Solid, f64)> {
    let radius = || 0.1f64..0.5;
    prop_oneof![
        (radius(), 0.1f64..1.0).prop_map(|(r, deep)| (Solid::cylinder(r, deep + 0.7), deep)),
        (radius(), 0.4f64..1.0).prop_map(|(r, deep)| (Solid::cone(r, 0.6 * r, deep + 0.4), deep)),
        (radius(), 0.4f64..1.0).prop_map(|(r, deep)| (Solid::cone(0.0, r, deep + 0.4), deep)),
        (radius(), 0.2f64..1.0).prop_map(|(r, shaft)| {
            let dimple = Path::from([0.0, -r])
                .arc([r, 0.0], [0.0, 0.0], true)
                .line([r, shaft + 0.3])
                .line([0.0, shaft + 0.3])
                .close();
            (Solid::revolution(dimple).at(0.0, 0.0, r), shaft + r)
        }),
        // Long enough to pass through most bases.
        radius().prop_map(|r| (Solid::cylinder(r, 60.0), 30.0)),
    ]
}

/// Draws one tool and its placement: a line that meets the base, a tilt of the axis, a rotation about it.
fn features() -> impl Strategy<Value = (Solid, f64, Ray, f64, f64)> {
    let near = || -2.0f64..2.0;
    (tools(), directions(), [near(), near(), near()], 0.0f64..0.6, 0.0f64..6.0).prop_map(
        |((tool, deep_mm), direction, near, tilt_rad, turn_rad)| {
            let ray = Ray { origin: Point3::from(near), direction };
            (tool, deep_mm, ray, tilt_rad, turn_rad)
        },
    )
}

fn bases() -> impl Strategy<Value = Solid> {
    prop_oneof![
        4 => primitives(),
        1 => Just(Solid::sphere(9.0).minus(Solid::sphere(8.0))),
        1 => Just(Solid::cuboid(12.0, 12.0, 2.0).plus(Solid::cylinder(3.0, 5.0))),
        1 => Just(Solid::sphere(12.0).and(Solid::below(3.0))),
    ]
}

fn placed(base: &CompiledSolid, drawn: Vec<(Solid, f64, Ray, f64, f64)>) -> Vec<Solid> {
    let place = |(tool, deep_mm, ray, tilt_rad, turn_rad): (Solid, f64, Ray, f64, f64)| {
        let outermost = *base.crossings(&ray).last()?;
        let radians = |a: f64| Angle::from_rad(a).unwrap();
        let surface = Pose::z_to(outermost.normal, ray.at(outermost.t));
        let pose = surface
            .then_in(Pose::rotation_z(radians(turn_rad)))
            .then_in(Pose::rotation_x(radians(tilt_rad)));
        Some(tool.at(0.0, 0.0, -deep_mm).placed(pose))
    };
    drawn.into_iter().filter_map(place).collect()
}

/// Returns the largest distance of centroids and edge midpoints of triangles from the face each belongs to, mm.
fn stray_mm(solid: &Solid, mesh: &TriMesh) -> f64 {
    let leaves = solid.leaves();
    let mut farthest = 0.0f64;
    for (t, id) in mesh.triangles.iter().zip(&mesh.faces) {
        let leaf = &leaves[id.leaf as usize];
        let leaf_from_root = leaf.root_from_leaf.inverse();
        let corners = t.map(|v| leaf_from_root.point(Point3::from(mesh.vertices[v as usize])));
        let third = 1.0 / 3.0;
        for weights in [[third; 3], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]] {
            let point = (0..3).map(|i| weights[i] * corners[i].coords).sum::<Vector3<f64>>();
            let distance = match leaf.primitive {
                Solid::HalfSpace(_) => point.z.abs(),
                primitive => oracle::distance_mm(primitive, id.face, point.into()),
            };
            farthest = farthest.max(distance);
        }
    }
    farthest
}

fn by(solid: &Solid, conforming: bool) -> Result<TriMesh, MeshError> {
    evaluate_without_fusion(solid, TOLERANCE_MM, conforming)
        .map(|facets: Facets| to_mesh(solid, facets))
}

/// Compares both methods. Returns whether the meshes differ at all, that is, whether any feature conformed.
fn compare(solid: &Solid) -> Result<bool, TestCaseError> {
    let (Ok(ours), Ok(theirs)) = (by(solid, true), by(solid, false)) else {
        return Err(TestCaseError::reject("nothing is left"));
    };
    if ours == theirs {
        return Ok(false);
    }
    prop_assert_eq!(ours.genus(), theirs.genus());
    prop_assert_eq!(ours.shells(), theirs.shells());
    // Each is within the tolerance of the exact surface.
    let off_mm3 = (ours.volume_mm3() - theirs.volume_mm3()).abs();
    prop_assert!(off_mm3 <= theirs.area_mm2() * TOLERANCE_MM, "{off_mm3} mm3 apart");
    let stray_mm = stray_mm(solid, &ours);
    prop_assert!(stray_mm <= TOLERANCE_MM, "{stray_mm} mm off the exact surface");
    let file = ours.to_print();
    prop_assert!(file.is_ok(), "{}", file.unwrap_err());
    Ok(true)
}

/// Runs cases and returns how many of them conformed.
fn run<S: Strategy>(count: u32, strategy: &S, solid: impl Fn(S::Value) -> Solid) -> u32 {
    let conformed = Cell::new(0);
    let mut runner = TestRunner::new(cases(count));
    let result = runner.run(strategy, |drawn| {
        conformed.set(conformed.get() + u32::from(compare(&solid(drawn))?));
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
    conformed.get()
}

#[test]
fn conforming_features_equal_booleans() {
    let strategy = (bases(), prop::collection::vec(features(), 1..5), any::<bool>());
    let conformed = run(200, &strategy, |(base, drawn, adding)| {
        let tools = placed(&CompiledSolid::new(&base).unwrap(), drawn);
        if adding {
            Solid::union(std::iter::once(base).chain(tools))
        } else {
            base.minus_all(tools)
        }
    });
    assert!(conformed > 100, "only {conformed} of 200 conformed");
}

/// Draws operands with a dozen features, in trees that add, cut, hide or truncate them.
fn nests() -> impl Strategy<Value = Solid> {
    let operand = prop_oneof![
        (4.0f64..8.0).prop_map(Solid::sphere),
        (4.0f64..8.0, 3.0f64..9.0).prop_map(|(a, b)| Solid::ellipsoid_offset(a, b, 0.4)),
        (4.0f64..8.0).prop_map(|r| Solid::cylinder(r, 6.0).at(0.0, 0.0, -3.0)),
    ];
    let lattice = (8usize..14, poses(0.0));
    (operand, tools(), lattice, any::<bool>(), 0usize..6, -0.3f64..2.0).prop_map(
        |(operand, (tool, deep_mm), (count, turned), cuts, form, thick_mm)| {
            let body = CompiledSolid::new(&operand).unwrap();
            let place = |i: usize| {
                let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
                let (s, c) = (2.4 * i as f64).sin_cos();
                let across = (1.0 - z * z).sqrt();
                let direction = turned.vector(Vector3::new(across * c, across * s, z));
                let ray = Ray { origin: Point3::origin(), direction };
                let hit = *body.crossings(&ray).last().unwrap();
                tool.clone().at(0.0, 0.0, -deep_mm).placed(Pose::z_to(hit.normal, ray.at(hit.t)))
            };
            let reach_mm = body.bounds().max.coords.max();
            let tools: Vec<Solid> = (0..count).map(place).collect();
            let operand = if cuts {
                operand.minus_all(tools)
            } else {
                Solid::union(std::iter::once(operand).chain(tools))
            };
            let side_mm = 2.0 * (reach_mm + thick_mm);
            let block = Solid::cuboid(side_mm, side_mm, 1.5 * side_mm).at(0.0, 0.0, -side_mm / 2.0);
            match form {
                0 | 1 => block.minus(operand),
                2 => operand.and(block),
                3 => operand.at(0.0, 0.0, reach_mm).plus(Solid::cuboid(30.0, 30.0, reach_mm)),
                4 => Solid::sphere(reach_mm + thick_mm.max(0.1)).minus(operand),
                _ => Solid::cuboid(30.0, 30.0, 4.0).minus(block.minus(operand)),
            }
        },
    )
}

#[test]
fn operand_features_equal_booleans() {
    let lifted = Cell::new(0);
    run(120, &nests(), |solid| {
        let facets = evaluate_with_deferred_features(&solid, TOLERANCE_MM);
        lifted.set(lifted.get() + u32::from(facets.is_ok_and(|f| f.is_some())));
        solid
    });
    assert!(lifted.get() > 25, "only {} of 120 were put in last", lifted.get());
}

#[test]
fn a_hundred_holes_through_a_shell_have_no_slivers() {
    let (dome, exact_mm3) = fabkit_geometry_testing::perforated_dome();
    let mesh = crate::mesh(&dome, DEFAULT_TOLERANCE_MM).unwrap();
    assert_eq!(mesh.genus(), 100);
    assert!((mesh.volume_mm3() / exact_mm3 - 1.0).abs() < 2e-4);
    assert!(mesh.lowest_altitude_mm() > 1e-3, "{}", mesh.lowest_altitude_mm());
}
