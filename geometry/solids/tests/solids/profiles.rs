//! Areas, lengths, bounds and motions of plane regions.

use std::f64::consts::PI;

use fabkit_geometry::{Angle, Path, Profile, Segment};

/// Returns a sector of a ring with a round hole: lines, arcs in both directions, extreme points within arcs.
fn sector() -> Profile {
    let degrees = |d| Angle::from_deg(d).unwrap();
    Profile::new(Path::ring_sector(4.0, 10.0, degrees(30.0), degrees(150.0)))
        .with_hole(Path::circle([0.0, 7.0], 1.5))
}

#[test]
fn area_boundary_and_bounds_are_those_of_the_formulas() {
    let profile = sector();
    let third_of_ring = PI * (100.0 - 16.0) / 3.0;
    assert!((profile.area_mm2() - third_of_ring + PI * 2.25).abs() < 1e-12);
    let boundary = 2.0 * 6.0 + 2.0 * PI * (10.0 + 4.0) / 3.0 + 3.0 * PI;
    assert!((profile.boundary_mm() - boundary).abs() < 1e-12);
    let [min, max] = profile.bounds_mm();
    let half_width = 10.0 * 30.0f64.to_radians().cos();
    let expected = [-half_width, 4.0 * 0.5, half_width, 10.0];
    for (found, expected) in min.into_iter().chain(max).zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{min:?} {max:?}");
    }
}

#[test]
fn quarter_turns_are_exact_and_four_of_them_are_none() {
    let profile = sector();
    let turned = profile.quarter_turned();
    let ([min, max], [turned_min, turned_max]) = (profile.bounds_mm(), turned.bounds_mm());
    assert_eq!((turned_min, turned_max), ([-max[1], min[0]], [-min[1], max[0]]));
    assert_eq!(turned.area_mm2(), profile.area_mm2());
    assert_eq!(turned.quarter_turned().quarter_turned().quarter_turned(), profile);

    let oval = Path::from([3.0, 0.0]).elliptic_arc([0.0, 2.0], [0.0; 2], [3.0, 2.0], true);
    let Segment::EllipticArc { semi_axes_mm, .. } = oval.quarter_turned().segments[0] else {
        panic!("an arc stays an arc");
    };
    assert_eq!(semi_axes_mm, [2.0, 3.0]);
}

#[test]
fn shifts_move_holes_too() {
    let shifted = sector().shifted([5.0, -2.0]);
    assert_eq!(shifted.bounds_mm()[1], [sector().bounds_mm()[1][0] + 5.0, 8.0]);
    assert_eq!(shifted.holes[0], Path::circle([5.0, 5.0], 1.5));
    assert_eq!(shifted.holes[0].segments.len(), 2);
}

#[test]
fn scaling_goes_for_centres_and_half_axes_too() {
    let scaled = sector().scaled(1.5);
    assert!((scaled.area_mm2() - 2.25 * sector().area_mm2()).abs() < 1e-12);
    assert!((scaled.boundary_mm() - 1.5 * sector().boundary_mm()).abs() < 1e-12);
    let oval = Path::from([-3.0, 0.0]).elliptic_arc([3.0, 0.0], [0.0; 2], [3.0, 2.0], true).close();
    assert!((oval.scaled(2.0).signed_area_mm2() - 12.0 * PI).abs() < 1e-12);
}
