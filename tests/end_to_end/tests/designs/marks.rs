//! Marks that are listed one by one, by the real binary and as meshes.

use fabkit_designs::{builtin_yaml, load};
use fabkit_mesh::mesh;
use fabkit_tests::fabkit;

/// Coarse enough to be quick; every mesh is proven closed, with the pieces and holes of its design.
const TOLERANCE_MM: f64 = 0.1;

/// Sensors with a list each that can be built.
const LISTED: [(&str, [&str; 3]); 4] = [
    (
        "shadowtac",
        [
            "dimples.pattern=list",
            "dimples.polar=[0deg,12.5deg,20deg]",
            "dimples.azimuth=[0deg,90deg,-135deg]",
        ],
    ),
    (
        "uvdtact",
        [
            "markers.pattern=list",
            "markers.polar=[0deg,50deg,82deg]",
            "markers.azimuth=[0deg,90deg,-135deg]",
        ],
    ),
    (
        "tactip",
        [
            "pins.pattern=list",
            "pins.polar=[0deg,12.5deg,20deg]",
            "pins.azimuth=[0deg,90deg,-135deg]",
        ],
    ),
    (
        "fluidic",
        ["markers.pattern=list", "markers.x=[-5.5mm,7.25mm,0mm]", "markers.y=[0mm,3mm,-11mm]"],
    ),
];

#[test]
fn listed_marks_are_checked_and_exported() {
    let root = tempfile::tempdir().unwrap();
    for (sensor, sets) in LISTED {
        let sets: Vec<String> = sets.iter().map(|set| format!("--set={set}")).collect();
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let checked = fabkit(root.path(), &[&["check", sensor][..], &sets].concat());
        assert_eq!(checked.code, Some(0), "{sensor}: {checked:?}");
        // An export counts pieces and holes of each mesh.
        let export = ["export", sensor, "--format=stl,tree", "--tolerance=0.05mm", "-o", sensor];
        fabkit(root.path(), &[&export[..], &sets].concat()).ok();
    }
}

#[test]
fn fixing_leaves_a_list_as_it_was_written() {
    let root = tempfile::tempdir().unwrap();
    // 2.8 mm apart: holes of 2 mm need 3 mm, those that are chosen smaller less.
    let listed =
        ["--set=markers.pattern=list", "--set=markers.x=[0mm,2.8mm]", "--set=markers.y=[0mm,0mm]"];
    let refused = fabkit(root.path(), &[&["show", "fluidic"][..], &listed].concat());
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("(markers.x[0] and markers.x[1])"), "{refused:?}");
    let fix = [&["show", "fluidic", "--fix", "--json"][..], &listed].concat();
    let json = fabkit(root.path(), &fix).ok().json();
    let changes = json["changes"].as_array().unwrap();
    let paths: Vec<_> = changes.iter().map(|change| change["path"].as_str().unwrap()).collect();
    assert!(paths.contains(&"markers.diameter"), "{paths:?}");
    let is_list = |path: &str| ["markers.x", "markers.y", "markers.pattern"].contains(&path);
    assert!(!paths.iter().any(|path| is_list(path)), "{paths:?}");
}

/// Numbers from 0 to 1, the same every time.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        // Knuth's linear congruential generator; its upper bits are the random ones.
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn list(&mut self, count: usize, [low, high]: [f64; 2], unit: &str) -> String {
        let items: Vec<String> =
            (0..count).map(|_| format!("{:.2} {unit}", low + (high - low) * self.roll())).collect();
        format!("[{}]", items.join(", "))
    }
}

/// Refused with problems of its own, or meshes that are closed: how many of each.
fn random_lists(sensor: &str, keys: [&str; 2], unit: &str, ranges: [[f64; 2]; 2], rounds: u32) {
    let section = keys[0].split('.').next().unwrap();
    let (mut dice, mut made, mut refused) = (Dice(7), 0, 0);
    for round in 0..rounds {
        let count = 1 + (dice.roll() * 7.0) as usize;
        let lists = [0, 1].map(|i| dice.list(count, ranges[i], unit));
        let sets = [
            format!("{section}.pattern=list"),
            format!("{}={}", keys[0], lists[0]),
            format!("{}={}", keys[1], lists[1]),
        ];
        let design = match load(sensor, builtin_yaml(sensor).unwrap(), &sets, &["fixtures"]) {
            Ok(design) => design,
            Err(invalid) => {
                refused += 1;
                assert!(!invalid.problems.is_empty());
                for problem in invalid.problems {
                    let hint = problem.hint.as_deref().unwrap_or_default();
                    assert!(
                        !problem.message.is_empty() && !hint.is_empty(),
                        "{sets:?} {problem:?}"
                    );
                }
                continue;
            }
        };
        made += 1;
        for body in &design.sensor.bodies {
            let has_marks = body.solid.leaves().iter().any(|leaf| {
                let word = leaf.feature.split(' ').next().unwrap_or_default();
                ["dimple", "marker", "pin", "dot"].contains(&word) && leaf.feature.contains(' ')
            });
            if has_marks {
                let tell = |e: &dyn std::fmt::Display| {
                    format!("{sensor} {round} {sets:?} {}: {e}", body.name)
                };
                let meshed =
                    mesh(&body.solid, TOLERANCE_MM).unwrap_or_else(|e| panic!("{}", tell(&e)));
                let print = meshed.to_print().unwrap_or_else(|e| panic!("{}", tell(&e)));
                if ["dots", "marker-paint"].contains(&body.name.as_str()) {
                    assert_eq!(body.shells.unwrap().pieces, count, "{sensor} {}", body.name);
                }
                assert!(print.volume_mm3() > 0.0, "{sensor} {}", body.name);
            }
        }
    }
    println!("{sensor}: {made} made, {refused} refused");
    assert!(made >= rounds / 4 && refused >= 1, "{sensor}: {made} made, {refused} refused");
}

#[test]
fn random_dimples_are_refused_or_closed() {
    let keys = ["dimples.polar", "dimples.azimuth"];
    random_lists("shadowtac", keys, "deg", [[0.0, 50.0], [-180.0, 180.0]], 12);
}

#[test]
fn random_markers_are_refused_or_closed() {
    let keys = ["markers.polar", "markers.azimuth"];
    random_lists("uvdtact", keys, "deg", [[0.0, 90.0], [-180.0, 180.0]], 12);
    let keys = ["markers.x", "markers.y"];
    random_lists("fluidic", keys, "mm", [[-31.0, 31.0]; 2], 12);
}

#[test]
fn random_pins_are_refused_or_closed() {
    let keys = ["pins.polar", "pins.azimuth"];
    random_lists("tactip", keys, "deg", [[0.0, 62.0], [-180.0, 180.0]], 12);
}
