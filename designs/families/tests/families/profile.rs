//! Profiles and coupons from files, and all the ways in which they are refused.

use fabkit_designs::parameters::{FileSafeName, Problem, Scalar};
use fabkit_designs::profile::{MeasuredProfile, ProcessProfile};
use fabkit_geometry::{Path, Pose, Profile, Solid};

const COUPON: &str = "\
format: 1
process: fdm
material: PLA
lengths_x:
  - {id: X1, nominal: 40 mm, measured: 39.84 mm}
  - {id: X2, nominal: 60 mm, measured: 59.76 mm}
  - {id: X3, nominal: 80 mm, measured: 79.68 mm}
lengths_y:
  - {id: Y1, nominal: 40 mm, measured: 40 mm}
  - {id: Y2, nominal: 60 mm, measured: 60 mm}
  - {id: Y3, nominal: 80 mm, measured: 80 mm}
lengths_z:
  - {id: Z1, nominal: 20 mm, measured: 20.1 mm}
  - {id: Z2, nominal: 30 mm, measured: 30.1 mm}
  - {id: Z3, nominal: 40 mm, measured: 40.1 mm}
holes:
  - {id: H1, nominal: 2 mm, measured: 1.8 mm}
  - {id: H2, nominal: 4 mm, measured: 3.8 mm}
  - {id: H3, nominal: 6 mm, measured: 5.8 mm}
  - {id: H4, nominal: 8 mm, measured: null}
pins:
  - {id: P1, nominal: 2 mm, measured: 2.05 mm}
  - {id: P2, nominal: 4 mm, measured: 4.05 mm}
  - {id: P3, nominal: 6 mm, measured: 6.05 mm}
";

fn read(yaml: &str) -> Result<MeasuredProfile, Vec<Problem>> {
    let name = FileSafeName::parse("my-printer").unwrap();
    MeasuredProfile::read("coupon.yaml", yaml, &name).map_err(|invalid| invalid.problems)
}

#[test]
fn a_profile_survives_its_file() {
    let measured = read(COUPON).unwrap();
    let yaml = measured.profile.to_yaml(&["a comment".into()]);
    assert!(yaml.starts_with("# a comment\nformat: 1\nname: my-printer\n"), "{yaml}");
    let back = ProcessProfile::read("my-printer.yaml", &yaml).unwrap();
    assert!((back.shrinkage_percent.x - 0.4).abs() < 1e-4, "{back:?}");
    assert!((back.holes.offset.mm() + 0.2).abs() < 1e-4);
    assert_eq!(back.holes.largest.mm(), 6.0);
    assert_eq!(back.elephant_foot.mm(), 0.0);
    assert_eq!(back.material, "PLA");
    assert_eq!(ProcessProfile::read("my-printer.yaml", &back.to_yaml(&[])).unwrap(), back);
}

#[test]
fn each_slip_is_named_with_line_value_and_limit() {
    for (from, to, line, says) in [
        ("3.8 mm", "3.8", 18, "holes[1].measured is `3.8`, which has no unit; it must be between"),
        ("3.8 mm", ".nan mm", 18, "holes[1].measured is `.nan mm`, which is not finite"),
        ("3.8 mm", "inf mm", 18, "which is not finite"),
        ("3.8 mm", "-3.8 mm", 18, "holes[1].measured is -3.8 mm; it must be between 0.05 mm"),
        ("3.8 mm", "38 mm", 18, "for 4 mm it must be between 2.80 mm and 5.20 mm"),
        ("3.8 mm", "[3, 4]", 18, "holes[1].measured is not a single value"),
        ("3.8 mm", "null", 16, "holes has 2 measured sizes; a profile needs at least 3"),
        ("nominal: 4 mm, measured: 3.8 mm", "measured: 3.8 mm", 18, "holes[1] has no nominal size"),
        (
            "59.76 mm",
            "60.76 mm",
            6,
            "mm off the line through all lengths_x; it must be within 0.25",
        ),
        ("process: fdm", "process: laser", 2, "process is `laser`"),
        ("process: fdm\n", "", 0, "the process is missing"),
        ("pins:", "pin:", 21, "`pin` is not a key of a coupon"),
        ("format: 1", "format: 2", 1, "format is `2`"),
    ] {
        let yaml = COUPON.replacen(from, to, 1);
        assert_ne!(yaml, COUPON, "{from}");
        let problems = read(&yaml).unwrap_err();
        let problem = problems.iter().find(|problem| problem.message.contains(says));
        let problem = problem.unwrap_or_else(|| panic!("{to}: {problems:?}"));
        assert_eq!(problem.file, "coupon.yaml");
        if line > 0 {
            assert_eq!(problem.line, Some(line), "{to}: {problem}");
        }
    }
    // All at once.
    let yaml = COUPON.replacen("3.8 mm", "3.8", 1).replacen("4.05 mm", "nan mm", 1);
    assert!(read(&yaml).unwrap_err().len() >= 2);
}

#[test]
fn hostile_files_are_refused_not_crashed_on() {
    for yaml in
        ["", "a", "[]", "format: 1", "holes: {", "holes: [[[[", "\u{0}", "format: 1\nholes: 3"]
    {
        assert!(!read(yaml).unwrap_err().is_empty(), "{yaml:?}");
        assert!(ProcessProfile::read("p.yaml", yaml).is_err(), "{yaml:?}");
    }
}

#[test]
fn a_profile_out_of_limits_is_refused() {
    let good = read(COUPON).unwrap().profile.to_yaml(&[]);
    for (from, to, says) in [
        ("process: fdm", "process: cnc", "process is `cnc`"),
        ("gain: 1,", "gain: .nan,", "holes.gain is `.nan`, which is not finite"),
        ("gain: 1,", "gain: 2,", "holes.gain is 2; it must be between 0.8 and 1.2"),
        ("elephant_foot: 0 mm", "elephant_foot: 3 mm", "elephant_foot is 3 mm"),
        ("elephant_foot: 0 mm\n", "", "the file lacks `elephant_foot`"),
        ("x: 0.4", "x: 40", "shrinkage_percent.x is 40; it must be between -5 and 5"),
    ] {
        let yaml = good.replacen(from, to, 1);
        assert_ne!(yaml, good, "{from} in {good}");
        let problems = ProcessProfile::read("my-printer.yaml", &yaml).unwrap_err().problems;
        assert!(problems[0].message.contains(says), "{problems:?}");
        assert_eq!(problems[0].file, "my-printer.yaml");
    }
}

/// Cylinders and circles that are cut away are holes; what stands is not.
#[test]
fn only_round_upright_holes_are_fitted() {
    let profile = read(COUPON).unwrap().profile;
    let scale = (profile.scale()[0] + profile.scale()[1]) / 2.0;
    let fitted = |radius: f64| (2.0 * radius + 0.2) / 2.0 / scale;
    let count = |solid: &Solid| profile.fit_holes(solid, &Pose::identity(), 1.0).1;

    let pin = Solid::cylinder(2.0, 5.0);
    assert_eq!(profile.fit_holes(&pin, &Pose::identity(), 1.0).0, pin);
    // A hole, a post in a pocket, a pocket in the post.
    let block = Solid::cuboid(40.0, 40.0, 9.0);
    let pocket =
        Solid::cuboid(20.0, 20.0, 20.0).minus(pin.clone().minus(Solid::cylinder(1.0, 9.0)));
    assert_eq!(count(&block.clone().minus(pocket)).fitted, 1);

    let plate = Profile::new(Path::rectangle([0.0, 0.0], [30.0, 30.0], 1.0))
        .with_hole(Path::circle([3.0, 4.0], 2.5))
        .with_hole(Path::slot([-8.0, 0.0], [-4.0, 0.0], 1.5));
    let (copy, found) = profile.fit_holes(&Solid::extrusion(plate, 3.0), &Pose::identity(), 1.0);
    assert_eq!((found.fitted, found.unchanged), (1, 0));
    let Solid::Extrusion(extrusion) = copy else { panic!("{copy:?}") };
    let [min, max] = Profile::new(extrusion.profile.holes[0].clone()).bounds_mm();
    assert!((max[0] - min[0] - 2.0 * fitted(2.5)).abs() < 1e-9);
    assert!((min[0] + max[0] - 6.0).abs() < 1e-12);

    // 20 mm is far beyond the 6 mm that were measured; a hole across is not upright.
    let wide = block.clone().minus(Solid::cylinder(10.0, 20.0));
    assert_eq!((count(&wide).fitted, count(&wide).unchanged), (0, 1));
    let quarter = fabkit_geometry::Angle::from_deg(90.0).unwrap();
    let across = block.minus(Solid::cylinder(1.0, 90.0).turned_x(quarter));
    assert_eq!((count(&across).fitted, count(&across).unchanged), (0, 1));
}
