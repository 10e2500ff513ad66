//! Proofs must never exclude an overlap that lines or points would find.

use fabkit_geometry::proofs::{find_obstacle_boxes, find_overlap_boxes};
use fabkit_geometry::{Aabb, CompiledSolid, Point3, Pose, Ray, Solid, Vector3};
use fabkit_geometry_testing::{cases, poses, primitives, trees};
use proptest::prelude::*;

/// Returns points that fill a box evenly (steps from the generalised golden ratio).
fn points(bounds: &Aabb, count: u32) -> impl Iterator<Item = Point3<f64>> + use<> {
    let (min, size) = (bounds.min, bounds.max - bounds.min);
    (1..=count).map(move |k| {
        let share = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|g| (f64::from(k) * g).fract());
        min + size.component_mul(&Vector3::from(share))
    })
}

/// Returns the mold of a solid: a tool that touches it all around, or one that is shifted a little.
fn molds(solid: Solid, shift: Vector3<f64>) -> Solid {
    let bounds = CompiledSolid::new(&solid).unwrap().bounds().grown(2.0);
    let block = Solid::cuboid_between(bounds.min.into(), bounds.max.into());
    block.minus(solid.at(shift.x, shift.y, shift.z))
}

fn assert_meetings_hold(a: &Solid, b: &Solid) -> Result<(), TestCaseError> {
    let (a, b) = (CompiledSolid::new(a).unwrap(), CompiledSolid::new(b).unwrap());
    let Some(boxes) = find_overlap_boxes(&a, &b) else { return Ok(()) };
    for point in points(&a.bounds().common(&b.bounds()), 2_000) {
        if a.contains(&point) && b.contains(&point) {
            prop_assert!(boxes.iter().any(|b| b.contains(&point)), "{point} of {a:?} and {b:?}");
        }
    }
    Ok(())
}

/// Asserts that each line along an axis on which the other solid lies behind the end of the tool passes a box.
fn assert_obstacles_hold(tool: &Solid, other: &Solid) -> Result<(), TestCaseError> {
    let (tool, other) = (CompiledSolid::new(tool).unwrap(), CompiledSolid::new(other).unwrap());
    let bounds = tool.bounds().common(&other.bounds());
    if bounds.is_empty() || !bounds.is_finite() {
        return Ok(());
    }
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut direction = Vector3::zeros();
            direction[axis] = sign;
            let Some(boxes) = find_obstacle_boxes(&tool, &[&other], &direction) else { continue };
            for origin in points(&bounds, 500) {
                let ray = Ray { origin, direction };
                let ends = tool.crossings(&ray);
                let Some(end) = ends.iter().find(|c| !c.entering) else { continue };
                let last = other.crossings(&ray);
                // A smaller overhang is contact, measured across the faces, so that grazed ones do not count either.
                let steep = |c: &fabkit_geometry::Crossing| c.normal.dot(&direction).abs();
                let is_held = last
                    .chunks_exact(2)
                    .any(|s| (s[1].t - s[0].t.max(end.t)) * steep(&s[1]).min(steep(end)) > 1e-6);
                let passes = |b: &Aabb| {
                    (0..3).all(|i| i == axis || (b.min[i] <= origin[i] && origin[i] <= b.max[i]))
                };
                prop_assert!(
                    !is_held || boxes.iter().any(passes),
                    "{origin} along {direction:?} through {tool:?} and {other:?}"
                );
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn overlaps_of_random_solids_lie_in_the_boxes(
        a in trees(), b in trees(), pose in poses(4.0),
    ) {
        let b = b.placed(pose);
        assert_meetings_hold(&a, &b)?;
        assert_obstacles_hold(&a, &b)?;
    }

    #[test]
    fn a_mold_is_proven_not_to_overlap_its_cast(
        solid in primitives(), upright in any::<bool>(), pose in poses(3.0), shift in -0.2f64..0.2,
    ) {
        let solid = if upright { solid } else { solid.placed(pose) };
        let mold = molds(solid.clone(), Vector3::zeros());
        let [a, b] = [&solid, &mold].map(|s| CompiledSolid::new(s).unwrap());
        prop_assert_eq!(find_overlap_boxes(&a, &b), Some(vec![]));
        let off = molds(solid.clone(), Vector3::new(0.0, shift, 0.5 * shift));
        assert_meetings_hold(&solid, &off)?;
        // Half of the mold, pulled any way.
        let below = mold.and(Solid::below(shift));
        assert_obstacles_hold(&below, &solid)?;
        assert_obstacles_hold(&solid, &below)?;
    }

    #[test]
    fn overlaps_with_a_shifted_mold_lie_in_the_boxes(solid in trees(), shift in -0.2f64..0.2) {
        prop_assume!(!CompiledSolid::new(&solid).unwrap().bounds().is_empty());
        let off = molds(solid.clone(), Vector3::new(shift, 0.0, 0.0));
        assert_meetings_hold(&solid, &off)?;
        assert_obstacles_hold(&off, &solid)?;
    }
}

#[test]
fn nested_shells_and_clearances_are_apart() {
    let shell = |inner: f64, outer: f64| Solid::sphere(outer).minus(Solid::sphere(inner));
    let screw = |radius: f64| Solid::cylinder(radius, 8.0).plus(Solid::cylinder(2.0 * radius, 2.0));
    let plate = Solid::cuboid(12.0, 12.0, 6.0).minus(Solid::cylinder(1.7, 6.0).at(0.0, 0.0, 0.0));
    let countersunk = plate.minus(Solid::cylinder(3.4, 2.0));
    let turned = Pose::z_to(Vector3::new(0.3, 0.2, 0.9), Point3::new(3.0, -2.0, 1.0));
    for (a, b) in [
        (shell(4.0, 5.0), shell(5.0, 6.0)),
        (screw(1.5), countersunk),
        (Solid::torus(8.0, 2.0), Solid::cuboid(30.0, 30.0, 2.0).minus(Solid::torus(8.0, 2.05))),
    ] {
        let [a, b] = [a, b].map(|s| CompiledSolid::new(&s.placed(turned)).unwrap());
        assert_eq!(find_overlap_boxes(&a, &b), Some(vec![]), "{a:?} {b:?}");
    }
}
