//! What a press does to soft layers, by the real binary.

use std::collections::BTreeMap;
use std::path::Path;

use fabkit_tests::fabkit;
use serde_json::Value;

fn press(folder: &Path, sensor: &str, more: &[&str]) -> Value {
    let mut arguments = vec!["press", sensor, "--json"];
    arguments.extend(more);
    fabkit(folder, &arguments).ok().json()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn vector(value: &Value) -> [f64; 3] {
    std::array::from_fn(|i| number(&value[i]))
}

fn norm(vector: [f64; 3]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Nodes this far apart: coarse, so that a press takes a second.
const COARSE: [&str; 2] = ["--spacing", "0.6mm"];

#[test]
fn a_ball_on_a_dome_pushes_along_the_normal_wherever_it_is() {
    let root = tempfile::tempdir().unwrap();
    let at = |place: &str| {
        let indenter = format!("ball@{place}");
        let more = ["--indenter", &indenter, "--depth", "0.8mm", "--steps", "4"];
        press(root.path(), "rtac0", &[&more[..], &["--spacing", "0.3mm"]].concat())
    };
    let documents = ["0deg,0deg", "40deg,20deg", "40deg,110deg"].map(at);
    let mut forces = Vec::new();
    for (document, [polar, azimuth]) in
        documents.iter().zip([[0.0, 0.0], [40.0, 20.0], [40.0, 110.0f64]])
    {
        assert_eq!(
            (&document["contact_level"], &document["is_simulated"]),
            (&"linear".into(), &true.into())
        );
        let force = vector(&document["force_n"]);
        let (polar, azimuth): (f64, f64) = (f64::to_radians(polar), azimuth.to_radians());
        let outward = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
        // Onto the sensor, against the normal; nodes of a contact are not even about its middle.
        let along: f64 = force.iter().zip(outward).map(|(f, n)| -f * n).sum();
        assert!(along > 0.99 * norm(force), "{force:?} {outward:?}");
        // About the dome's centre, 12.5 mm below the tip, a push along the normal has no moment; about the
        // origin it has that of the centre's height.
        forces.push(norm(force));
        let curve: Vec<f64> = document["curve"]
            .as_array()
            .unwrap()
            .iter()
            .map(|step| norm(vector(&step["force_n"])))
            .collect();
        assert_eq!(curve.len(), 4);
        assert!(curve.windows(2).all(|pair| pair[1] > 1.3 * pair[0]), "{curve:?}");
        // Incompressible, so that what is pushed in comes out beside it.
        let (depth_mm, bulge_mm) = (number(&document["depth_mm"]), number(&document["bulge_mm"]));
        assert!((0.04..0.2).contains(&(bulge_mm / depth_mm)), "{bulge_mm}");
        let [low, high] = [0, 1].map(|i| number(&document["force_range_n"][i]));
        assert!(low < norm(force) && norm(force) < high);
    }
    // The dome is round: nodes of 0.3 mm under a contact of 1.7 mm tell forces to some percent.
    assert!((forces[1] / forces[2] - 1.0).abs() < 0.03, "{forces:?}");
    assert!((forces[0] / forces[1] - 1.0).abs() < 0.03, "{forces:?}");
}

#[test]
fn stiffer_layers_push_back_in_proportion() {
    let root = tempfile::tempdir().unwrap();
    let at = |sensor: &str, indenter: &str, settings: &[&str]| {
        let more = ["--indenter", indenter, "--depth", "0.4mm", "--steps", "1"];
        norm(vector(&press(root.path(), sensor, &[&more[..], settings].concat())["force_n"]))
    };
    std::fs::write(
        root.path().join("twice.yaml"),
        "format: 1\nextends: digit-like\nname: twice\nmaterials:\n  Smooth-On Solaris:\n    youngs_modulus: 340 kPa\n",
    )
    .unwrap();
    let once = at("digit-like", "ball@0mm,0mm", &[]);
    let twice = at("twice.yaml", "ball@0mm,0mm", &[]);
    assert!((twice / once - 2.0).abs() < 1e-6, "{once} {twice}");
    // Beside the middle of a pad nothing else is different.
    let beside = at("digit-like", "ball@1.5mm,-1mm", &[]);
    assert!((beside / once - 1.0).abs() < 1e-6, "{once} {beside}");
}

#[test]
fn friction_drags_along_until_it_slips() {
    let root = tempfile::tempdir().unwrap();
    let at = |shear: &str, friction: &str| {
        let more =
            ["--indenter", "ball@0mm,0mm", "--depth", "0.4mm", "--steps", "1", "--shear", shear];
        press(root.path(), "digit-like", &[&more[..], &["--friction", friction]].concat())
    };
    let force = |document: &Value| vector(&document["force_n"]);
    let little = force(&at("0.05mm,0mm", "0.5"));
    assert!(little[0] > 0.0 && little[0] < 0.5 * -little[2], "{little:?}");
    // Far enough, all slips: Coulomb's limit.
    let far = force(&at("1.5mm,0mm", "0.5"));
    assert!((far[0] / -far[2] - 0.5).abs() < 0.01, "{far:?}");
    let across = force(&at("0mm,1.5mm", "0.5"));
    assert!((across[1] / -across[2] - 0.5).abs() < 0.01, "{across:?}");
    let none = force(&at("1mm,0mm", "0"));
    assert!(none[0].abs() < 1e-3 * -none[2], "{none:?}");
}

#[test]
fn files_are_the_same_on_any_number_of_threads() {
    let root = tempfile::tempdir().unwrap();
    let made = |threads: &str| {
        let folder = root.path().join(threads);
        std::fs::create_dir(&folder).unwrap();
        let base = [
            "press",
            "rtac0",
            "--indenter",
            "ball@30deg,50deg",
            "--depth",
            "0.5mm",
            "--steps",
            "2",
        ];
        let files = [
            "--csv",
            "curve.csv",
            "--plot",
            "curve.svg",
            "--png",
            "field.png",
            "-o",
            "field.npz",
            "--threads",
            threads,
        ];
        fabkit(&folder, &[&base[..], &COARSE, &files].concat()).ok();
        ["curve.csv", "curve.svg", "field.npz", "field.png"]
            .map(|name| std::fs::read(folder.join(name)).unwrap())
    };
    let one = made("1");
    assert!(one == made("2") && one == made("8"));
    let table = String::from_utf8(one[0].clone()).unwrap();
    assert_eq!(table.lines().count(), 3);
    assert!(table.starts_with("depth_mm,shear_mm,force_n,"));
}

#[test]
fn what_cannot_be_pressed_is_refused_with_numbers() {
    let root = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], code: i32, words: &[&str]| {
        let run = fabkit(root.path(), &[&["press"], arguments].concat());
        assert_eq!(run.code, Some(code), "{arguments:?}: {run:?}");
        for word in words {
            assert!(run.stderr.contains(word), "{word} is not in {}", run.stderr);
        }
    };
    let tip = ["--indenter", "ball@0deg,0deg", "--depth"];
    refused(
        &[&["rtac0"], &tip[..], &["3mm"]].concat(),
        2,
        &["3 mm is out of range", "at most 1.5 mm"],
    );
    refused(&[&["rtac0"], &tip[..], &["-1mm"]].concat(), 2, &["--depth"]);
    refused(&[&["rtac0"], &tip[..], &["nan mm"]].concat(), 2, &["nan"]);
    refused(
        &["rtac0", "--indenter", "bal@0deg,0deg", "--depth", "1mm"],
        2,
        &["there is no press", "hemisphere@"],
    );
    refused(
        &["rtac0", "--indenter", "ball@170deg,0deg", "--depth", "1mm"],
        2,
        &["170 deg", "111.8 deg"],
    );
    let sheared = |friction| ["1mm", "--shear", "1mm,0mm", "--friction", friction];
    refused(&[&["rtac0"], &tip[..], &sheared("-1")].concat(), 2, &["-1 is not between 0 and 10"]);
    let skin =
        |more: &[&'static str]| [&["fluidic", "--spacing", "3mm", "--steps", "1"], more].concat();
    refused(
        &skin(&["--indenter", "ball@40mm,0mm", "--depth", "1mm"]),
        2,
        &["40 mm", "from -30 to 30 mm in x"],
    );
    refused(
        &skin(&["--indenter", "ball@0mm,0mm", "--depth", "9.1mm"]),
        2,
        &["9.1 mm", "at most 9 mm"],
    );
    refused(
        &skin(&["--indenter", "ball@0mm,0mm", "--depth", "1mm", "--shear", "1mm,0mm"]),
        2,
        &["straight down"],
    );
    for (key, value, word) in [
        ("poissons_ratio", "0.5", "0.4999"),
        ("poissons_ratio", ".nan", "nan"),
        ("youngs_modulus", "-70 kPa", "-70"),
        ("friction", "-1", "-1"),
    ] {
        let text = format!(
            "format: 1\nextends: rtac0\nname: own\nmaterials:\n  Smooth-On Ecoflex 00-30:\n    {key}: {value}\n"
        );
        std::fs::write(root.path().join("own.yaml"), text).unwrap();
        refused(&[&["own.yaml"], &tip[..], &["1mm"]].concat(), 2, &["own.yaml", key, word]);
    }
}

#[test]
fn a_press_that_tears_a_bond_is_found() {
    let root = tempfile::tempdir().unwrap();
    let own = |modulus: &str| {
        let text = format!(
            "format: 1\nextends: digit-like\nname: own\nmaterials:\n  Smooth-On Solaris:\n    youngs_modulus: {modulus}\n    \
             youngs_modulus_most: 5 MPa\n"
        );
        std::fs::write(root.path().join("own.yaml"), text).unwrap();
        fabkit(root.path(), &["check", "own.yaml", "--json"]).json()
    };
    let torn = |document: &Value| -> Vec<String> {
        let findings = document["findings"].as_array().unwrap().iter();
        let bonding = findings.filter(|finding| finding["rule"] == "bonding");
        bonding.map(|finding| finding["message"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(torn(&own("340 kPa")), Vec::<String>::new());
    let found = torn(&own("3 MPa"));
    assert_eq!(found.len(), 1);
    assert!(
        found[0].contains("shears gel on plate") && found[0].contains("withstands 200.0 kPa"),
        "{found:?}"
    );
}

#[test]
fn sweeps_know_what_a_press_says() {
    let root = tempfile::tempdir().unwrap();
    let plan = "format: 1\nsensor: rtac0\naxes:\n  translucent_gel.thickness: [1.5 mm, 2 mm]\nmetrics: [press]\n";
    std::fs::write(root.path().join("plan.yaml"), plan).unwrap();
    fabkit(root.path(), &["sweep", "plan.yaml", "-o", "swept"]).ok();
    let table = std::fs::read_to_string(root.path().join("swept/sweep.csv")).unwrap();
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().unwrap();
    let at = |name: &str| names.iter().position(|known| *known == name).unwrap();
    let rows: Vec<Vec<&str>> = lines.collect();
    let value = |row: usize, name: &str| rows[row][at(name)].parse::<f64>().unwrap();
    for (name, least, most) in [
        ("force_at_1mm_n", 0.5, 0.8),
        ("stiffness_n_mm", 0.5, 0.8),
        ("bulge_mm", 0.5, 0.9),
        ("bond_shear_strain", 0.5, 0.8),
    ] {
        // A thicker layer gives way more easily, bulges less and is sheared less.
        let share = value(1, name) / value(0, name);
        assert!((least..most).contains(&share), "{name}: {share}");
    }
    let place = ["--indenter", "ball@0deg,0deg", "--depth", "1mm"];
    let ball = ["fixtures.indenters.ball_diameter=8mm", "fixtures.indenters.shank_diameter=9mm"];
    let ball = ball.map(|setting| ["--set", setting]).concat();
    let pressed = press(root.path(), "rtac0", &[&place[..], &ball].concat());
    let force = norm(vector(&pressed["force_n"]));
    // Nodes of the whole dome are coarser than those around a tip alone.
    assert!((value(0, "force_at_1mm_n") / force - 1.0).abs() < 0.05, "{force}");
    assert!((value(0, "bulge_mm") / number(&pressed["bulge_mm"]) - 1.0).abs() < 0.1);
}

#[test]
fn large_strain_is_asked_for_at_the_tip() {
    let root = tempfile::tempdir().unwrap();
    let at = |level: &str| {
        let more = [
            "--indenter",
            "ball@0deg,0deg",
            "--depth",
            "0.9mm",
            "--steps",
            "3",
            "--contact",
            level,
        ];
        press(root.path(), "rtac0", &more)
    };
    let (linear, finite) = (at("linear"), at("finite"));
    assert!(
        linear["warning"].as_str().is_some_and(|text| text.contains("0.60 mm")),
        "{}",
        linear["warning"]
    );
    assert!(finite["warning"].is_null());
    assert_eq!(finite["contact_level"], "finite");
    let forces = |document: &Value| -> Vec<f64> {
        let steps = document["curve"].as_array().unwrap().iter();
        steps.map(|step| norm(vector(&step["force_n"]))).collect()
    };
    for (small, large) in forces(&linear).iter().zip(forces(&finite)) {
        // As in the table of the book, and by how much coarser the whole dome's nodes are.
        assert!((small / large - 1.0).abs() < 0.12, "{small} {large}");
    }
    let refused = |more: &[&str], word: &str| {
        let base = ["press", "rtac0", "--depth", "0.5mm", "--contact", "finite"];
        let run = fabkit(root.path(), &[&base[..], more].concat());
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains(word), "{}", run.stderr);
    };
    refused(&["--indenter", "ball@20deg,0deg"], "at the tip");
    refused(&["--indenter", "ball@0deg,0deg", "--shear", "0.1mm,0mm"], "cannot have shear");
}

/// How far apart nodes of a skin are here: a press takes seconds.
const SKIN: [&str; 4] = ["--spacing", "1.5mm", "--steps", "3"];

#[test]
fn a_press_on_the_fluidic_sensor_moves_the_columns_of_what_it_squeezes() {
    let root = tempfile::tempdir().unwrap();
    let at = |place: &str| {
        let indenter = format!("ball@{place}");
        let more = ["--indenter", &indenter, "--depth", "3mm", "--csv", "c.csv"];
        press(root.path(), "fluidic", &[&more[..], &SKIN[..]].concat())
    };
    let document = at("-15mm,3.25mm");
    let channels = document["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 16);
    let volume = |name: &str, document: &Value| {
        let channels = document["channels"].as_array().unwrap().clone();
        number(&channels.into_iter().find(|c| c["name"] == name).unwrap()["volume_mm3"])
    };
    // The channel below the ball, drawn at y = 3.25 mm; its neighbours less, and alike but for the skin's edges.
    let pressed = volume("left 5", &document);
    let [before, after] = ["left 4", "left 6"].map(|name| volume(name, &document));
    assert!(
        pressed > 2.0 * before && (before / after - 1.0).abs() < 0.1,
        "{pressed} {before} {after}"
    );
    assert!(pressed > 5.0 * volume("right 5", &document));
    // Half of an 80 mm channel of 1.4 x 3 mm, round at its end, and the vent of 0.6 mm below the strip; p V stays.
    let air = 3.0 * (1.4 * (40.0 - 0.7) + std::f64::consts::PI * (0.49 / 2.0 + 0.36));
    assert!((number(&document["shut_in_air_mm3"]) / air - 1.0).abs() < 1e-9);
    for channel in channels {
        let [squeezed, moves, kpa] =
            ["volume_mm3", "column_moves_mm", "pressure_kpa"].map(|key| number(&channel[key]));
        assert!((moves - squeezed / 4.2).abs() < 1e-9, "{channel}");
        assert!((kpa - 101.325 * (air / (air - squeezed) - 1.0)).abs() < 1e-5, "{channel}");
    }
    // Straight down, more with each step.
    let force = vector(&document["force_n"]);
    assert!(force[2] < 0.0 && force[0] == 0.0 && force[1] == 0.0);
    let moment = vector(&document["moment_nmm"]);
    // F times the place, within what nodes of 1.5 mm tell of it.
    assert!((moment[0] / force[2] - 3.25).abs() < 0.3, "{moment:?}");
    assert!((-moment[1] / force[2] + 15.0).abs() < 0.3, "{moment:?}");
    let curve: Vec<f64> =
        document["curve"].as_array().unwrap().iter().map(|s| -number(&s["force_n"][2])).collect();
    assert!(curve.windows(2).all(|pair| pair[1] > pair[0]), "{curve:?}");
    let table = std::fs::read_to_string(root.path().join("c.csv")).unwrap();
    assert!(table.lines().count() == 4 && table.contains("left_5_mm3"), "{table}");
    // Channels that enter from the right are those of the left, turned by half a turn.
    let turned = at("15mm,-3.25mm");
    for k in 1..=8 {
        let [left, right] =
            [volume(&format!("left {k}"), &document), volume(&format!("right {k}"), &turned)];
        assert!((left / right - 1.0).abs() < 1e-6, "{k}: {left} {right}");
    }
}

/// By name: where marks are at rest, where they go, which way they then point.
type Marks = BTreeMap<String, [[f64; 3]; 3]>;

/// Those of which it is known.
fn marks(document: &Value) -> Marks {
    let marks = document["marks"].as_array().unwrap().iter();
    let known = marks.filter(|mark| !mark["displacement_mm"].is_null());
    let read = |mark: &Value| {
        let vectors = ["place_mm", "displacement_mm", "axis"].map(|key| vector(&mark[key]));
        (mark["name"].as_str().unwrap().to_owned(), vectors)
    };
    known.map(read).collect()
}

#[test]
fn a_press_moves_what_the_camera_follows() {
    let root = tempfile::tempdir().unwrap();
    let at = |sensor: &str, indenter: &str, more: &[&str]| {
        let first = ["--indenter", indenter, "--depth", "0.5mm", "--steps", "1"];
        press(root.path(), sensor, &[&first[..], &COARSE, more].concat())
    };
    // The middle dot goes in along the axis, those of the first ring all the same way: outwards and in.
    let document = at("tactip", "disc-107@0deg,0deg", &[]);
    let dots = marks(&document);
    assert_eq!(dots.len(), 57);
    let [_, moved, axis] = dots["dot 1"];
    assert!(moved[0].hypot(moved[1]) < 1e-3 && (-0.6..-0.3).contains(&moved[2]), "{moved:?}");
    assert!((axis[2] + 1.0).abs() < 1e-3, "{axis:?}");
    let ring: Vec<[f64; 2]> = (2..=7)
        .map(|i| {
            let [place, moved, axis] = dots[&format!("dot {i}")];
            assert!((norm(axis) - 1.0).abs() < 1e-9);
            let out = place[0].hypot(place[1]);
            [(place[0] * moved[0] + place[1] * moved[1]) / out, moved[2]]
        })
        .collect();
    for [out, up] in &ring {
        assert!((out - ring[0][0]).abs() < 2e-3 && (up - ring[0][1]).abs() < 2e-3, "{ring:?}");
        assert!(*up < 0.0, "{ring:?}");
    }
    // Gel is volume that stays: what is far away on the other side comes out, or hardly moves.
    assert!(norm(dots["dot 57"][1]) < 0.5 * norm(dots["dot 1"][1]));

    // A dimple below the ball goes less far than the surface, and more than half of it.
    let document = at("shadowtac", "ball@0deg,0deg", &[]);
    let below = -marks(&document)["dimple 1"][1][2];
    assert!((0.25..0.5).contains(&below), "{below}");
    assert_eq!(marks(&document).len(), 469);

    // Dragged along, marks go along, and those beside them less.
    let still = marks(&at("gelsight-like", "ball@0mm,0mm", &[]));
    let nearest = nearest(&still);
    let more = ["--shear", "0.3mm,0mm", "--friction", "1"];
    let dragged = marks(&at("gelsight-like", "ball@0mm,0mm", &more));
    let way = dragged[&nearest][1][0] - still[&nearest][1][0];
    assert!((0.05..0.3).contains(&way), "{nearest}: {way}");

    // The fluidic sensor's markers hang below its skin.
    let document = press(
        root.path(),
        "fluidic",
        &["--indenter", "ball@0mm,0mm", "--depth", "1mm", "--steps", "1", "--spacing", "2.5mm"],
    );
    let markers = marks(&document);
    let sags = markers.values().map(|mark| -mark[1][2]).fold(0.0, f64::max);
    assert!(markers.len() == 100 && sags > 0.2 && sags <= number(&document["sags_mm"]) + 1e-9);
}

/// The mark that is nearest to the axis.
fn nearest(marks: &Marks) -> String {
    let from_axis = |mark: &[[f64; 3]; 3]| mark[0][0].hypot(mark[0][1]);
    let nearest = marks.iter().min_by(|a, b| from_axis(a.1).total_cmp(&from_axis(b.1)));
    nearest.unwrap().0.clone()
}

#[test]
fn a_channel_that_is_pressed_shut_is_an_error() {
    let root = tempfile::tempdir().unwrap();
    let at = |depth: &str| {
        let wide = ["--set", "channels.width=5 mm", "--set", "channels.height=2.3 mm"];
        let thin = ["--set", "channel_layer.roof=1 mm", "--spacing", "2mm"];
        let press = ["press", "fluidic", "--indenter", "ball@-15mm,3.25mm", "--steps", "1"];
        fabkit(root.path(), &[&press[..], &["--depth", depth], &wide, &thin].concat())
    };
    at("2mm").ok();
    let shut = at("5mm");
    let says = "pressed shut: its cover would come down by";
    assert!(shut.code != Some(0) && shut.stderr.contains(says), "{}", shut.stderr);
    assert!(at("14mm").stderr.contains("where the skin ends"));
}
