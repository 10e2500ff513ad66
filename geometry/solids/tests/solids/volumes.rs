//! Comparison of volumes by line integration with closed forms.

use std::f64::consts::PI;

use fabkit_geometry::measure::{MeasureError, VolumeEstimate, overlap_volume, ray_volume};
use fabkit_geometry::{Angle, CompiledSolid, Path, Point3, Pose, Profile, Solid, Vector3};
use fabkit_geometry_testing::{cases, dimpled_mold, perforated_dome, poses, trees};
use proptest::prelude::*;

fn volume(solid: &Solid, lines: u32) -> VolumeEstimate {
    ray_volume(&CompiledSolid::new(solid).unwrap(), lines).unwrap()
}

/// Asserts that a volume is right within its stated error, and that this error is small.
///
/// The error is stated for 99 % confidence with eight samples; over the hundred checks here one is
/// expected beyond it, and none (t = 7: 0.02 %) beyond twice that.
fn assert_volume(solid: &Solid, exact_mm3: f64) {
    let pose = Pose::z_to(Vector3::new(0.3, -0.5, 0.7), Point3::new(1.0, 2.0, 3.0));
    for solid in [solid.clone(), solid.clone().placed(pose)] {
        let VolumeEstimate { value_mm3, error_mm3 } = volume(&solid, 200_000);
        let off = (value_mm3 - exact_mm3).abs();
        assert!(off <= 2.0 * error_mm3, "{solid:?}: {value_mm3} +- {error_mm3}, not {exact_mm3}");
        assert!(error_mm3 < 5e-4 * exact_mm3, "{solid:?}: {value_mm3} +- {error_mm3}");
        assert!(off < 1e-4 * exact_mm3, "{solid:?}: {value_mm3} is not {exact_mm3}");
    }
}

#[test]
fn round_and_flat_primitives_have_the_volume_of_their_closed_form() {
    assert_volume(&Solid::sphere(3.0), 36.0 * PI);
    assert_volume(&Solid::ellipsoid([1.0, 2.0, 4.0]), 4.0 / 3.0 * PI * 8.0);
    assert_volume(&Solid::cylinder(2.0, 3.0), 12.0 * PI);
    assert_volume(&Solid::cone(2.0, 1.0, 3.0), PI * (4.0 + 2.0 + 1.0));
    assert_volume(&Solid::cone(0.0, 2.0, 3.0), 4.0 * PI);
    assert_volume(&Solid::cuboid(2.0, 3.0, 4.0), 24.0);
    assert_volume(&Solid::torus(5.0, 2.0), 2.0 * PI * PI * 5.0 * 4.0);
    assert_volume(&Solid::torus(5.0, 0.5), 2.0 * PI * PI * 5.0 * 0.25);
    let octant = Solid::sphere(2.0)
        .and(Solid::below(0.0))
        .and(Solid::behind(Point3::origin(), Vector3::x()))
        .and(Solid::behind(Point3::origin(), -Vector3::y()));
    assert_volume(&octant, 4.0 / 3.0 * PI);
}

#[test]
fn extrusions_have_the_volume_of_their_closed_form() {
    let plate = Profile::new(Path::rectangle([1.0, 2.0], [10.0, 6.0], 1.5))
        .with_hole(Path::circle([1.0, 2.0], 2.0));
    let area = 60.0 - (4.0 - PI) * 1.5 * 1.5 - 4.0 * PI;
    assert_volume(&Solid::extrusion(plate, 2.5), 2.5 * area);
    assert_volume(&Solid::extrusion(Path::slot([-3.0, 0.0], [2.0, 0.0], 1.0), 1.0), 10.0 + PI);
    let angle = |rad| Angle::from_rad(rad).unwrap();
    let sector = Path::ring_sector(2.0, 5.0, angle(0.3), angle(5.3));
    assert_volume(&Solid::extrusion(sector, 2.0), 5.0 * (25.0 - 4.0));
    // Clockwise paths are allowed, too.
    let clockwise = Path::polygon(&[[0.0, 0.0], [0.0, 4.0], [3.0, 0.0]]);
    assert_volume(&Solid::extrusion(clockwise, 2.0), 12.0);
}

#[test]
fn revolutions_by_pappus() {
    let disc = Solid::revolution(Path::circle([5.0, 1.0], 2.0));
    assert_volume(&disc, 2.0 * PI * 5.0 * PI * 4.0);
    let (a, b) = (1.5, 3.0);
    let ellipse = Path::from([6.5, 0.0])
        .elliptic_arc([3.5, 0.0], [5.0, 0.0], [a, b], true)
        .elliptic_arc([6.5, 0.0], [5.0, 0.0], [a, b], true);
    assert_volume(&Solid::revolution(ellipse.clone()), 2.0 * PI * 5.0 * PI * a * b);
    let square = Path::rectangle([5.0, 0.0], [1.0, 1.0], 0.0);
    let hollow = Profile::new(ellipse).with_hole(square);
    assert_volume(&Solid::revolution(hollow), 2.0 * PI * 5.0 * (PI * a * b - 1.0));
    let bullet = Path::from([0.0, 0.0])
        .line([15.0, 0.0])
        .line([15.0, 6.0])
        .arc([0.0, 21.0], [0.0, 6.0], true)
        .close();
    assert_volume(&Solid::revolution(bullet), PI * 225.0 * (6.0 + 10.0));
    // Half a spheroid stands on a cone's tip.
    let drop = Path::from([0.0, -3.0])
        .line([4.0, 0.0])
        .elliptic_arc([0.0, 2.0], [0.0, 0.0], [4.0, 2.0], true)
        .close();
    assert_volume(&Solid::revolution(drop), PI * 16.0 + 2.0 / 3.0 * PI * 32.0);
    // A lemon: an arc whose circle reaches beyond the axis (Weisstein, "Lemon Surface").
    let (c, r): (f64, f64) = (-3.0, 5.0);
    let h = (r * r - c * c).sqrt();
    let lemon = Path::from([0.0, -h]).arc([0.0, h], [c, 0.0], true).close();
    let exact = 2.0 * PI * (h * (r * r - h * h / 3.0) + c * (0.0 + r * r * (h / r).asin()));
    assert_volume(&Solid::revolution(lemon), exact);
}

/// Steiner's formula: V(r) = V + S r + M r^2 + 4/3 pi r^3, M the integral of the mean curvature.
fn offset_volume(equatorial: f64, polar: f64, offset: f64) -> f64 {
    let (a, c) = (equatorial, polar);
    let (surface, mean) = if a > c {
        let e = (1.0 - c * c / (a * a)).sqrt();
        let surface = 2.0 * PI * a * a * (1.0 + (1.0 - e * e) / e * e.atanh());
        (surface, 2.0 * PI * (c + a * a / (a * e) * e.asin()))
    } else {
        let e = (1.0 - a * a / (c * c)).sqrt();
        let surface = 2.0 * PI * a * a * (1.0 + c / (a * e) * e.asin());
        (surface, 2.0 * PI * (c + a * a / (c * e) * e.atanh()))
    };
    let r = offset;
    4.0 / 3.0 * PI * a * a * c + surface * r + mean * r * r + 4.0 / 3.0 * PI * r * r * r
}

#[test]
fn parallel_surfaces_by_steiner() {
    for (equatorial, polar) in [(5.0, 3.0), (3.0, 5.0), (4.0, 1.0)] {
        let (long, short) = (f64::max(equatorial, polar), f64::min(equatorial, polar));
        for offset in [-0.9 * short * short / long, 0.2, 1.5] {
            let solid = Solid::ellipsoid_offset(equatorial, polar, offset);
            assert_volume(&solid, offset_volume(equatorial, polar, offset));
        }
    }
    assert_volume(&Solid::ellipsoid_offset(3.0, 3.0, 1.0), 4.0 / 3.0 * PI * 64.0);
}

#[test]
fn perforated_dome_and_dimpled_mold_have_their_exact_volumes() {
    for ((solid, exact), stated) in
        [(perforated_dome(), 4910.254750), (dimpled_mold(), 24219.930363)]
    {
        assert!((exact - stated).abs() < 5e-7, "{exact}");
        let VolumeEstimate { value_mm3, error_mm3 } = volume(&solid, 400_000);
        let off = (value_mm3 - exact).abs();
        println!("{value_mm3} +- {error_mm3}, exact {exact}");
        assert!(off <= 2.0 * error_mm3 && error_mm3 < 1e-4 * exact, "{value_mm3} +- {error_mm3}");
        assert!(off < 2e-5 * exact, "{value_mm3} is not {exact}");
    }
}

#[test]
fn holes_and_dimples_keep_apart() {
    for ((solid, _), word, count, diameter) in
        [(perforated_dome(), "hole", 100, 1.0), (dimpled_mold(), "dimple", 200, 0.45)]
    {
        let body = CompiledSolid::new(&solid).unwrap();
        let is_shaft = |s: &Solid| matches!(s, Solid::Cylinder(_));
        let starts: Vec<_> = body
            .leaves()
            .iter()
            .filter(|leaf| leaf.feature.starts_with(word) && is_shaft(&leaf.primitive))
            .map(|leaf| leaf.body_from_leaf.point(Point3::origin()))
            .collect();
        assert_eq!(starts.len(), count);
        for (i, a) in starts.iter().enumerate() {
            // Shafts of the dome begin where they are closest, those of the mold just before.
            assert!(starts[..i].iter().all(|b| (a - b).norm() > 1.5 * diameter));
        }
    }
}

#[test]
fn unbounded_volume_is_an_error_and_empty_volume_is_zero() {
    let ground = CompiledSolid::new(&Solid::below(0.0)).unwrap();
    assert_eq!(ray_volume(&ground, 1000), Err(MeasureError::Unbounded));
    let apart = Solid::sphere(1.0).and(Solid::sphere(1.0).at(5.0, 0.0, 0.0));
    assert_eq!(volume(&apart, 1000).value_mm3, 0.0);
}

#[test]
fn contact_is_no_overlap() {
    let body = |solid: &Solid| CompiledSolid::new(solid).unwrap();
    let block = Solid::cuboid(10.0, 10.0, 1.0 / 3.0);
    let shaft = Solid::cylinder(2.0, 8.0);
    let bushing = Solid::cylinder(3.0, 6.0).minus(Solid::cylinder(2.0, 8.0).at(0.0, 0.0, -1.0));
    let ball = Solid::sphere(3.0);
    let socket = Solid::cuboid(9.0, 9.0, 4.0).minus(ball.clone());
    let contacts = [
        (block.clone().at(0.0, 0.0, 2.0), block.clone().at(1.0, 0.0, 2.0 + 1.0 / 3.0)),
        (shaft.clone(), bushing),
        (ball, socket),
        (block.clone(), block.at(0.0, 0.0, 5.0)),
    ];
    let tilt = Pose::z_to(Vector3::new(0.1, 0.2, 0.3), Point3::new(7.0, 8.0, 9.0));
    for (a, b) in contacts {
        for (a, b) in [(a.clone(), b.clone()), (a.placed(tilt), b.placed(tilt))] {
            let overlap = overlap_volume(&body(&a), &body(&b), 50_000).unwrap();
            assert_eq!(overlap.volume.value_mm3, 0.0, "{a:?} {b:?} at {:?}", overlap.witness);
            assert!(overlap.witness.is_none());
        }
    }
}

#[test]
fn overlap_is_measured_and_witnessed() {
    // Two balls: the lens between them in closed form.
    let (r, d) = (2.0, 3.0);
    let lens = PI * (4.0 * r + d) * f64::powi(2.0 * r - d, 2) / 12.0;
    let a = CompiledSolid::new(&Solid::sphere(r)).unwrap();
    let b = CompiledSolid::new(&Solid::sphere(r).at(0.0, 0.0, d)).unwrap();
    let overlap = overlap_volume(&a, &b, 100_000).unwrap();
    assert!((overlap.volume.value_mm3 - lens).abs() < 1e-4 * lens);
    let witness = overlap.witness.unwrap();
    assert!(a.contains(&witness) && b.contains(&witness));
    // A press fit of a tenth of a micrometre is found.
    let pin = CompiledSolid::new(&Solid::cylinder(1.0001, 5.0)).unwrap();
    let hole = Solid::cuboid(6.0, 6.0, 4.0).minus(Solid::cylinder(1.0, 6.0).at(0.0, 0.0, -1.0));
    let overlap = overlap_volume(&pin, &CompiledSolid::new(&hole).unwrap(), 200_000).unwrap();
    let ring = PI * (1.0001f64.powi(2) - 1.0) * 4.0;
    assert!((overlap.volume.value_mm3 - ring).abs() < 0.05 * ring, "{overlap:?} {ring}");
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn volumes_keep_inclusion_and_exclusion(a in trees(), b in trees(), pose in poses(3.0)) {
        // |A u B| + |A n B| = |A| + |B|, and |A - B| + |A n B| = |A|; A n B also as an overlap.
        let b = b.placed(pose);
        let both = volume(&a.clone().and(b.clone()), 8_000);
        let (union, rest) = (volume(&Solid::union([a.clone(), b.clone()]), 8_000),
            volume(&a.clone().minus(b.clone()), 8_000));
        let overlap = overlap_volume(&CompiledSolid::new(&a).unwrap(), &CompiledSolid::new(&b).unwrap(), 8_000)
            .unwrap().volume;
        let (a, b) = (volume(&a, 8_000), volume(&b, 8_000));
        let near = |x: f64, errors: [VolumeEstimate; 4]| {
            let error: f64 = errors.iter().map(|e| e.error_mm3).sum();
            x.abs() <= 2.0 * error + 1e-9
        };
        let inclusion = union.value_mm3 + both.value_mm3 - a.value_mm3 - b.value_mm3;
        prop_assert!(near(inclusion, [union, both, a, b]), "{}", inclusion);
        let exclusion = rest.value_mm3 + both.value_mm3 - a.value_mm3;
        prop_assert!(near(exclusion, [rest, both, a, a]), "{}", exclusion);
        prop_assert!(near(overlap.value_mm3 - both.value_mm3, [overlap, both, both, both]));
    }
}
