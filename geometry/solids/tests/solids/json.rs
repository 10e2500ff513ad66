//! The JSON form of solids.

use fabkit_geometry::{Angle, Path, Point3, Profile, Solid, Vector3};
use fabkit_geometry_testing::{cases, trees};
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn json_roundtrip_is_exact(solid in trees(), outward in 0.1f64..1.0) {
        let direction = Vector3::new(outward, 0.2, 0.3);
        let solid = solid.and(Solid::behind(Point3::new(0.0, 0.0, outward), direction)).named("x");
        let text = serde_json::to_string(&solid).unwrap();
        let back: Solid = serde_json::from_str(&text).unwrap();
        prop_assert_eq!(&back, &solid);
        prop_assert_eq!(serde_json::to_string(&back).unwrap(), text);
        prop_assert_eq!(back.validate(), Ok(()));
    }
}

#[test]
fn the_form_is_as_documented() {
    let half_turn = Angle::from_deg(180.0).unwrap();
    for (solid, text) in [
        (Solid::sphere(1.5), r#"{"sphere":{"radius_mm":1.5}}"#),
        (Solid::ellipsoid([1.0, 2.0, 3.0]), r#"{"ellipsoid":{"semi_axes_mm":[1.0,2.0,3.0]}}"#),
        (Solid::cylinder(1.0, 2.0), r#"{"cylinder":{"radius_mm":1.0,"height_mm":2.0}}"#),
        (
            Solid::cone(1.0, 0.0, 2.0),
            r#"{"cone":{"bottom_radius_mm":1.0,"top_radius_mm":0.0,"height_mm":2.0}}"#,
        ),
        (Solid::cuboid(1.0, 2.0, 3.0), r#"{"cuboid":{"size_mm":[1.0,2.0,3.0]}}"#),
        (Solid::torus(2.0, 1.0), r#"{"torus":{"ring_radius_mm":2.0,"tube_radius_mm":1.0}}"#),
        (
            Solid::ellipsoid_offset(3.0, 2.0, 0.5),
            r#"{"ellipsoid-offset":{"equatorial_mm":3.0,"polar_mm":2.0,"offset_mm":0.5}}"#,
        ),
        (
            Solid::below(0.0).turned_z(half_turn),
            concat!(
                r#"{"placed":{"pose":{"rotation":[[-1.0,0.0,0.0],[0.0,-1.0,0.0],[0.0,0.0,1.0]],"#,
                r#""translation_mm":[0.0,0.0,0.0]},"of":{"half-space":{}}}}"#
            ),
        ),
        (
            Solid::revolution(Path::from([0.0, 0.0]).line([1.0, 0.0]).line([0.0, 1.0]).close()),
            concat!(
                r#"{"revolution":{"profile":{"outer":{"start":[0.0,0.0],"segments":["#,
                r#"{"line":{"to":[1.0,0.0]}},{"line":{"to":[0.0,1.0]}},{"line":{"to":[0.0,0.0]}}]}}}}"#
            ),
        ),
        (
            Solid::extrusion(
                Path::from([1.0, 0.0]).arc([-1.0, 0.0], [0.0, 0.0], true).close(),
                2.0,
            ),
            concat!(
                r#"{"extrusion":{"profile":{"outer":{"start":[1.0,0.0],"segments":["#,
                r#"{"arc":{"to":[-1.0,0.0],"centre":[0.0,0.0],"ccw":true}},"#,
                r#"{"line":{"to":[1.0,0.0]}}]}},"height_mm":2.0}}"#
            ),
        ),
        (
            Solid::sphere(2.0).minus(Solid::sphere(1.0).named("core")),
            concat!(
                r#"{"difference":{"of":{"sphere":{"radius_mm":2.0}},"#,
                r#""minus":[{"feature":{"name":"core","of":{"sphere":{"radius_mm":1.0}}}}]}}"#
            ),
        ),
        (
            Solid::union([Solid::sphere(2.0), Solid::sphere(1.0).and(Solid::sphere(3.0))]),
            concat!(
                r#"{"union":[{"sphere":{"radius_mm":2.0}},"#,
                r#"{"intersection":[{"sphere":{"radius_mm":1.0}},{"sphere":{"radius_mm":3.0}}]}]}"#
            ),
        ),
    ] {
        // JSON keeps the sign of zeros that a rotation computed; here minus zero counts as zero.
        let written = serde_json::to_string(&solid).unwrap().replace("-0.0", "0.0");
        assert_eq!(written, text);
        assert_eq!(serde_json::from_str::<Solid>(text).unwrap(), solid);
    }
}

#[test]
fn refuses_what_is_not_a_solid() {
    let parse = |text: &str| serde_json::from_str::<Solid>(text).map_err(|e| e.to_string());
    assert!(
        parse(r#"{"sphere":{"radius_mm":1.0,"colour":"red"}}"#).unwrap_err().contains("colour")
    );
    assert!(parse(r#"{"blob":{}}"#).unwrap_err().contains("blob"));
    assert!(parse(r#"{"sphere":{"radius_mm":NaN}}"#).is_err());
    assert!(parse(r#"{"sphere":{"radius_mm":1e999}}"#).is_err());
    let mirrored = concat!(
        r#"{"placed":{"pose":{"rotation":[[-1.0,0.0,0.0],[0.0,1.0,0.0],[0.0,0.0,1.0]],"#,
        r#""translation_mm":[0.0,0.0,0.0]},"of":{"half-space":{}}}}"#
    );
    assert!(parse(mirrored).unwrap_err().contains("mirror"));
    let deep = r#"{"union":["#.repeat(100_000);
    assert!(parse(&deep).unwrap_err().contains("recursion limit"));
}

/// Returns the messages of validating an extruded profile.
fn complaints(profile: Profile) -> String {
    Solid::extrusion(profile, 1.0).validate().unwrap_err().to_string()
}

#[test]
fn validation_names_what_is_wrong_with_a_profile() {
    let bow_tie = Path::polygon(&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]);
    assert!(complaints(bow_tie.into()).contains("cross"));
    let plate = || Path::rectangle([0.0, 0.0], [10.0, 10.0], 1.0);
    let across = Profile::new(plate()).with_hole(Path::circle([5.0, 0.0], 1.0));
    assert!(complaints(across).contains("cross"));
    let outside = Profile::new(plate()).with_hole(Path::circle([8.0, 0.0], 1.0));
    assert!(complaints(outside).contains("outside"));
    let nested = Profile::new(plate())
        .with_hole(Path::circle([0.0, 0.0], 3.0))
        .with_hole(Path::circle([0.0, 0.0], 1.0));
    assert!(complaints(nested).contains("within"));
    let flat = Path::polygon(&[[0.0, 0.0], [4.0, 0.0], [8.0, 0.0]]);
    assert!(complaints(flat.into()).contains("area"));
    let nan = Path::polygon(&[[0.0, 0.0], [4.0, f64::NAN], [8.0, 1.0]]);
    assert!(complaints(nan.into()).contains("finite"));
    // An arc that dips below the line it should stay above.
    let dips = Path::from([0.0, 0.0])
        .line([10.0, 0.0])
        .line([10.0, 1.0])
        .arc([0.0, 1.0], [5.0, 5.0], false)
        .close();
    assert!(complaints(dips.into()).contains("cross"));
}

#[test]
fn validation_accepts_walls_of_a_micrometre() {
    // Two concentric arcs, closer than any polyline approximation could tell apart.
    let angle = |rad| Angle::from_rad(rad).unwrap();
    let ring = Path::ring_sector(14.999, 15.0, angle(0.1), angle(6.0));
    assert_eq!(Solid::extrusion(ring, 1.0).validate(), Ok(()));
    let disc = Profile::new(Path::circle([0.0, 0.0], 15.0));
    let hole = Path::circle([0.0, 0.0], 14.9999);
    assert_eq!(Solid::extrusion(disc.with_hole(hole), 1.0).validate(), Ok(()));
}

#[test]
fn validation_refuses_absurd_sizes() {
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1e9] {
        assert!(Solid::sphere(radius).validate().is_err(), "{radius}");
    }
    assert!(Solid::sphere(1.0).at(1e9, 0.0, 0.0).validate().is_err());
    assert!(Solid::union([]).validate().is_err());
}

#[test]
fn the_deepest_valid_tree_survives_json() {
    let plate = Profile::new(Path::rectangle([0.0, 0.0], [9.0, 9.0], 1.0))
        .with_hole(Path::circle([0.0, 0.0], 2.0));
    let mut deep = Solid::extrusion(plate, 1.0);
    loop {
        let deeper =
            Solid::Difference { of: Box::new(Solid::sphere(9.0)), minus: vec![deep.clone()] };
        if deeper.validate().is_err() {
            break;
        }
        deep = deeper;
    }
    let text = serde_json::to_string(&deep).unwrap();
    assert_eq!(serde_json::from_str::<Solid>(&text).unwrap(), deep);
    for _ in 0..1000 {
        deep = Solid::union([deep]);
    }
    assert!(deep.validate().unwrap_err().to_string().contains("deeper"));
}
