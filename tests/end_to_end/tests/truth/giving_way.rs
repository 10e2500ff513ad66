//! Ground truth of surfaces that give way: depth, forces, and halves that are stitched.

use std::path::Path;
use std::sync::Arc;

use fabkit_application::Error;
use fabkit_application::fixtures::load;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::press_simulation::{ContactModel, LinearOptions};
use fabkit_application::scene::{Cast, SensorView};
use fabkit_tests::fabkit;
use serde_json::Value;

/// Nodes this far apart: coarse, so that a press takes a second.
const SPACING_MM: f64 = 0.5;
const BALL: &str = "ball@30deg,120deg,1mm";

struct Map {
    indentation_mm: Vec<f64>,
    contact: Vec<bool>,
    range_mm: Vec<f64>,
    gap: Option<Value>,
    normals: Vec<[f64; 3]>,
    points: Vec<[f64; 3]>,
    width: usize,
}

fn scene(sensor: &str) -> SensorView {
    let yaml = fabkit_application::designs::builtin_yaml(sensor).unwrap();
    let project = load(&format!("{sensor}.yaml"), yaml, &[]).unwrap();
    let viewpoint = Viewpoint::new(&project.design.sensor.camera, None, None).unwrap();
    SensorView::new(Arc::new(project), viewpoint).unwrap()
}

fn linear() -> ContactModel {
    ContactModel::Linear(LinearOptions { spacing_mm: Some(SPACING_MM), friction: None })
}

fn map(scene: &SensorView, presses: &[&str], contact: ContactModel, shear_mm: [f64; 2]) -> Map {
    let presses: Vec<_> = presses.iter().map(|id| scene.project.press(id).unwrap()).collect();
    let cast = Cast {
        presses: &presses,
        samples: 1,
        contact,
        shear_mm,
        print_sigma_mm: 0.05,
        allow_no_contact: false,
    };
    let seen = scene.cast(&cast, 0, |seen| {
        Ok::<_, Error>(Map {
            indentation_mm: seen.map.indentation_mm().collect(),
            contact: seen.map.contact().collect(),
            range_mm: seen.map.range_mm().to_vec(),
            gap: seen.gap.map(|gap| gap.to_json()),
            normals: seen.map.normal_in_sensor().into_iter().map(Into::into).collect(),
            points: seen.map.point_in_sensor().map(Into::into).collect(),
            width: seen.map.width_px() as usize,
        })
    });
    seen.unwrap()
}

/// Thinner than the distance of nodes of a first look, which no pin may slip through.
#[test]
fn a_pin_alone_is_pressed() {
    let scene = scene("rtac0");
    let contact = ContactModel::Linear(LinearOptions::default());
    // At the tip and far from it.
    for pin in ["pin-1-long", "pin-14-short"] {
        let rigid = map(&scene, &[pin], ContactModel::Rigid, [0.0; 2]);
        let linear = map(&scene, &[pin], contact, [0.0; 2]);
        let deepest = |map: &Map| map.indentation_mm.iter().copied().fold(0.0, f64::max);
        let [rigid_mm, linear_mm] = [&rigid, &linear].map(deepest);
        // Below the tip the surface follows it, however it answers.
        assert!((linear_mm - rigid_mm).abs() < 0.02 * rigid_mm, "{pin}: {rigid_mm} {linear_mm}");
        assert!(linear.contact.iter().any(|is| *is), "{pin}");
    }
}

#[test]
fn gel_lies_on_what_presses_and_bulges_beside_it() {
    let scene = scene("rtac0");
    let (rigid, soft) = (
        map(&scene, &[BALL], ContactModel::Rigid, [0.0; 2]),
        map(&scene, &[BALL], linear(), [0.0; 2]),
    );
    let mut touched = 0;
    for pixel in 0..rigid.range_mm.len() {
        if soft.contact[pixel] {
            touched += 1;
            assert!(rigid.contact[pixel]);
            assert_eq!(soft.range_mm[pixel], rigid.range_mm[pixel], "what touches is exact");
        } else if rigid.contact[pixel] {
            assert!(soft.range_mm[pixel] <= rigid.range_mm[pixel], "gel is not in the ball");
        }
    }
    // A ball on a layer three times as thick touches less than where it cuts the surface at rest, and more than
    // Hertz's half of that.
    let cut_of = &rigid.contact;
    let cut = cut_of.iter().filter(|contact| **contact).count();
    assert!((0.6..0.97).contains(&(f64::from(touched) / cut as f64)), "{touched} of {cut}");
    let least = soft.indentation_mm.iter().copied().fold(0.0, f64::min);
    assert!((-0.2..-0.05).contains(&least), "{least}");
    // What the level of contact is worth is said, and is what two maps differ by.
    let gap = soft.gap.as_ref().unwrap();
    let off = |is_touched: bool| {
        let off = (0..cut_of.len()).filter(|pixel| cut_of[*pixel] == is_touched);
        let off = off.map(|pixel| soft.range_mm[pixel] - rigid.range_mm[pixel]);
        let moved: Vec<f64> = off.filter(|mm| is_touched || mm.abs() > 1e-6).collect();
        let rms_mm = (moved.iter().map(|mm| mm * mm).sum::<f64>() / moved.len() as f64).sqrt();
        (moved.len(), rms_mm, moved.iter().fold(0.0, |most: f64, mm| most.max(mm.abs())))
    };
    for (place, is_touched) in [("touched", true), ("beside", false)] {
        let (pixels, rms_mm, max_mm) = off(is_touched);
        assert_eq!(gap[place]["pixels"], pixels);
        assert!((number(&gap[place]["rms_mm"]) - rms_mm).abs() < 1e-12);
        assert_eq!(number(&gap[place]["max_mm"]), max_mm);
    }
    // A layer as soft as that is well below a press of this depth, and not on it at its rim.
    assert!((0.001..0.1).contains(&number(&gap["touched"]["rms_mm"])), "{gap}");
    assert!(rigid.gap.is_none());
    // Far off nothing moves.
    let corner = soft.indentation_mm[..5 * soft.width].iter().filter(|mm| mm.is_finite());
    assert!(corner.map(|mm| mm.abs()).fold(0.0, f64::max) < 0.01);
}

#[test]
fn normals_are_those_of_the_points() {
    let scene = scene("rtac0");
    let soft = map(&scene, &[BALL], linear(), [0.3, 0.1]);
    let (mut compared, mut worst) = (0, Vec::new());
    for (pixel, normal) in soft.normals.iter().enumerate() {
        let column = pixel % soft.width;
        let still = soft.indentation_mm[pixel].abs() < 0.02;
        if column == 0 || column + 1 == soft.width || still || soft.contact[pixel] {
            continue;
        }
        let [before, after] = [soft.points[pixel - 1], soft.points[pixel + 1]];
        let along: [f64; 3] = std::array::from_fn(|i| after[i] - before[i]);
        let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
        let cosine = along.iter().zip(normal).map(|(a, n)| a * n).sum::<f64>() / length;
        if length < 0.3 && cosine.is_finite() {
            compared += 1;
            worst.push(cosine.abs());
        }
    }
    worst.sort_by(f64::total_cmp);
    // Two pixels are 0.1 mm apart, over which what bulges bends by a degree, and at contacts by more.
    assert!(compared > 2000, "{compared}");
    assert!(worst[compared * 95 / 100] < 0.03, "{}", worst[compared * 95 / 100]);
}

#[test]
fn shear_takes_the_print_along() {
    let scene = scene("rtac0");
    let middle = |map: &Map| {
        let touched = (0..map.contact.len()).filter(|pixel| map.contact[*pixel]);
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for pixel in touched {
            (0..3).for_each(|i| sum[i] += map.points[pixel][i]);
            count += 1.0;
        }
        sum.map(|part| part / count)
    };
    let still = middle(&map(&scene, &[BALL], linear(), [0.0; 2]));
    let moved = middle(&map(&scene, &[BALL], linear(), [0.0, 0.4]));
    let way: [f64; 3] = std::array::from_fn(|i| moved[i] - still[i]);
    // Around the tip, counter-clockwise: at 120 degrees along (-sin, cos).
    let around = [-120f64.to_radians().sin(), 120f64.to_radians().cos()];
    let along = way[0] * around[0] + way[1] * around[1];
    // Nodes at the contact's edge are half a millimetre apart.
    assert!((along - 0.4).abs() < 0.12, "{way:?}");
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Rows of `halves.csv` by column.
fn halves(folder: &Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let text = std::fs::read_to_string(folder.join("halves.csv")).unwrap();
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().unwrap().split(',').map(String::from).collect();
    let row = |line: &str| names.iter().cloned().zip(line.split(',').map(String::from)).collect();
    lines.map(row).collect()
}

#[test]
fn forces_are_the_same_through_every_door() {
    let root = tempfile::tempdir().unwrap();
    let spacing = ["--spacing", "0.5mm"];
    let pressed = fabkit(
        root.path(),
        &[
            &["press", "rtac0", "--json", "--indenter", "ball@30deg,120deg", "--depth", "1mm"][..],
            &["--steps", "1", "--shear", "0.2mm,0.1mm"],
            &spacing,
        ]
        .concat(),
    )
    .ok()
    .json();
    let depth = fabkit(
        root.path(),
        &[
            &["depth", "rtac0", "--json", "--press", BALL, "--contact", "linear"][..],
            &["--shear", "0.2mm,0.1mm", "-o", "a.npz"],
            &spacing,
        ]
        .concat(),
    )
    .ok()
    .json();
    assert_eq!(
        (&depth["contact_level"], &depth["elastic"]["is_simulated"]),
        (&"linear".into(), &true.into())
    );
    let list = format!("one = {BALL} shear 0.2mm,0.1mm\ntwo = hemisphere@50deg,200deg,0.6mm\n");
    std::fs::write(root.path().join("list.txt"), list).unwrap();
    let order = ["dataset", "rtac0", "-o", "set", "--contact", "linear", "--presses", "list.txt"];
    fabkit(root.path(), &[&order[..], &spacing].concat()).ok();
    let rows = halves(&root.path().join("set"));
    assert_eq!(rows.len(), 4);
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        let force = number(&pressed["force_n"][i]);
        assert!((number(&depth["elastic"]["force_n"][i]) - force).abs() < 1e-9);
        let of = |row: usize| rows[row][&format!("force_{axis}_n")].parse::<f64>().unwrap();
        assert!((of(0) - force).abs() < 1e-6, "{axis}: {} {force}", of(0));
        // The right halves are the left ones after half a turn; nodes stand elsewhere under them.
        let turned = if *axis == "z" { of(0) } else { -of(0) };
        assert!((of(2) - turned).abs() < 0.05, "{axis}: {} {turned}", of(2));
    }
    assert_eq!(rows[0]["side"], "left");
    assert_eq!(rows[2]["side"], "right");
    let document: Value =
        serde_json::from_slice(&std::fs::read(root.path().join("set/dataset.json")).unwrap())
            .unwrap();
    let elastic = &document["about"]["elastic"];
    assert_eq!(document["about"]["contact"], "linear");
    assert!(elastic["layers"][0]["source"].as_str().is_some_and(|source| !source.is_empty()));
    let beyond = rows.iter().map(|row| row["beyond_seam_mm"].parse::<f64>().unwrap());
    assert!((beyond.fold(0.0, f64::max) - number(&elastic["beyond_seam_mm"])).abs() < 1e-6);
    // The card compares all four halves with rigid contact; one of them is the press that `depth` was asked for.
    let card = std::fs::read_to_string(root.path().join("set/README.md")).unwrap();
    let (_, after) = card.split_once("in 4 of the halves ranges are ").unwrap();
    let said: Vec<f64> = after.split(['(', ' ']).filter_map(|word| word.parse().ok()).collect();
    let own = &depth["elastic"]["against_rigid"]["touched"];
    assert!(said[0] > 0.0 && said[0] < said[1], "{said:?}");
    // Three digits are written.
    assert!(said[1] > number(&own["max_mm"]) - 5e-4, "{said:?} {own}");
}

#[test]
fn what_stitching_leaves_out_is_stated() {
    // Two balls on either side of the seam, near it: what each half's image lacks is what the other one moves.
    let scene = scene("rtac0");
    let (left, right) = ("ball@15deg,180deg,0.6mm", "ball@15deg,0deg,0.6mm");
    let both = map(&scene, &[left, right], linear(), [0.0; 2]);
    let [left, right] = [left, right].map(|id| map(&scene, &[id], linear(), [0.0; 2]));
    let (mut worst, mut stated) = (0.0f64, 0.0f64);
    for pixel in 0..both.range_mm.len() {
        let x = both.points[pixel][0];
        if x.is_nan() || x.abs() < 0.5 {
            continue;
        }
        let (own, other) = if x < 0.0 { (&left, &right) } else { (&right, &left) };
        worst = worst.max((both.indentation_mm[pixel] - own.indentation_mm[pixel]).abs());
        stated = stated.max(other.indentation_mm[pixel].abs());
    }
    assert!(stated > 0.01, "they feel each other: {stated}");
    // To first order: contacts change a little by what the other one lifts.
    assert!(worst < 1.5 * stated, "{worst} {stated}");
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let root = tempfile::tempdir().unwrap();
    let made = |threads: &str| {
        let folder = root.path().join(threads);
        std::fs::create_dir(&folder).unwrap();
        let list = "one = ball@30deg,120deg,0.8mm shear 0.2mm,0mm\ntwo = ball@50deg,200deg,0.6mm\n";
        std::fs::write(folder.join("list.txt"), list).unwrap();
        let order = ["dataset", "rtac0", "-o", "set", "--contact", "linear"];
        let more = ["--presses", "list.txt", "--spacing", "0.7mm", "--threads", threads];
        fabkit(&folder, &[&order[..], &more].concat()).ok();
        ["halves.csv", "dataset.json", "halves/indentation_mm/c/0/0/0"]
            .map(|name| std::fs::read(folder.join("set").join(name)).unwrap())
    };
    let one = made("1");
    assert!(one == made("2") && one == made("8"));
}

#[test]
fn words_that_do_not_go_together_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let refused = |more: &[&str], words: &[&str]| {
        let base = ["depth", "rtac0", "--press", BALL, "-o", "a.npz"];
        let run = fabkit(root.path(), &[&base[..], more].concat());
        assert_eq!(run.code, Some(2), "{more:?}: {run:?}");
        for word in words {
            assert!(run.stderr.contains(word), "{word} is not in {}", run.stderr);
        }
        assert!(!root.path().join("a.npz").exists());
    };
    refused(&["--shear", "0.1mm,0mm"], &["not `rigid`", "linear"]);
    refused(&["--contact", "membrane"], &["the distance within which"]);
    refused(&["--contact", "linear", "--membrane", "1mm"], &["`linear` contact has no membrane"]);
    refused(&["--contact", "rigid", "--friction", "1"], &["friction"]);
    refused(&["--contact", "liner"], &["liner", "linear"]);
    refused(&["--contact", "linear", "--spacing", "9mm"], &["9 mm"]);
    refused(&["--contact", "linear", "--shear", "1mm"], &["two lengths"]);
    std::fs::write(root.path().join("list.txt"), format!("one = {BALL} shear 1mm\n")).unwrap();
    let run = fabkit(root.path(), &["dataset", "rtac0", "-o", "set", "--presses", "list.txt"]);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("list.txt:1:1") && run.stderr.contains("shear 0.5mm,0mm"));
    std::fs::write(root.path().join("list.txt"), format!("one = {BALL} shear 1mm,0mm\n")).unwrap();
    let run = fabkit(root.path(), &["dataset", "rtac0", "-o", "set", "--presses", "list.txt"]);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("`one`") && run.stderr.contains("ask for `linear` contact"));
}
