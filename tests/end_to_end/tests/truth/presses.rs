//! Every tool presses as deep as it is asked to, on every sensor; what does not press is refused.

use std::collections::BTreeSet;

use fabkit_application::fixtures::{Project, SurfacePoints, load};
use fabkit_application::geometry::{Point3, TouchSurface};
use fabkit_application::ground_truth::find_penetration;
use fabkit_tests::{Run, fabkit, is_full, read_folder, sample_cases};

const SENSORS: [&str; 6] =
    ["rtac0", "rtac0-published-2025", "shadowtac", "shadowtac-published-cad", "tactip", "uvdtact"];
const ALL: &str = "fixtures.indenters.shapes=[hemisphere, flat, cone, square, triangle, ridge, \
                   ring, ball, sphere, cylinder, disc, volute]";

fn project(sensor: &str, overrides: &[&str]) -> Project {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.into()).collect();
    load(sensor, fabkit_application::designs::builtin_yaml(sensor).unwrap(), &overrides).unwrap()
}

fn touch(project: &Project) -> &TouchSurface {
    project.design.sensor.touch.as_ref().unwrap()
}

fn tools(project: &Project) -> Vec<String> {
    let set = project.fixture("indenters").unwrap();
    set.sensor.parts().map(|part| part.name.clone()).collect()
}

/// A surface is convex, so that depth below it is concave, and no point is deeper than below the
/// plane that touches the surface where it was pressed: the tool's deepest point is at most as deep
/// as asked for, and at least as its tip is, of which [`TouchSurface::depth_mm`] tells. A ring has
/// nothing at its tip; what is deepest of it is on the edge of its bore, a circle.
#[test]
fn every_indenter_goes_as_deep_as_it_is_asked_to_on_every_sensor() {
    let mut tried = 0;
    for sensor in SENSORS {
        let project = project(sensor, &[ALL]);
        let touch = touch(&project);
        let SurfacePoints::Dome(dome) = SurfacePoints::new(touch).unwrap() else { continue };
        let last_deg = dome.max_polar_rad().to_degrees();
        for tool in tools(&project) {
            for (share, azimuth_deg) in [(0.0, 0.0), (0.4, 200.0), (0.7, 35.0)] {
                for part in [0.3, 1.0] {
                    let depth_mm = (1e3 * part * touch.max_indentation_mm()).floor() / 1e3;
                    let polar_deg = share * last_deg;
                    let id = format!("{tool}@{polar_deg}deg,{azimuth_deg}deg,{depth_mm}mm");
                    let press = project.press(&id).unwrap();
                    let found = find_penetration(touch, &press.bodies[0]).unwrap();
                    let found_mm = found.map_or(0.0, |found| found.depth_mm);
                    // Half of 4 mm less a wall of 0.8 mm; degrees of a circle miss its deepest
                    // point by a hundredth of a radian at most.
                    let bore_mm = if tool == "ring" { 1.2 } else { 0.0 };
                    let tip = (0..360).map(|degree| {
                        let (sin, cos) = f64::from(degree).to_radians().sin_cos();
                        let edge = Point3::new(bore_mm * cos, bore_mm * sin, 0.0);
                        touch.depth_mm(&press.bodies[0].sensor_from_body.point(edge)).0
                    });
                    let tip_mm = tip.fold(f64::NEG_INFINITY, f64::max);
                    let expected = tip_mm - 1e-3..=depth_mm + 1e-6;
                    assert!(expected.contains(&found_mm), "{sensor} {id}: {found_mm}, {tip_mm}");
                    if bore_mm > 0.0 {
                        assert!(found_mm <= tip_mm + 1e-3, "{sensor} {id}: {found_mm}, {tip_mm}");
                    }
                    tried += 1;
                }
            }
        }
    }
    assert!(tried >= 6 * 12 * 6, "{tried}");
}

/// Seen through the sensor's own camera: pixels miss the tip, but not by a tenth of the depth. Every third
/// indenter, of published variants those after them; all of them with `FABKIT_FULL=1`.
#[test]
fn every_indenter_of_every_sensor_is_seen_pressing() {
    let all = is_full();
    for sensor in sample_cases(&SENSORS).into_iter().copied() {
        let root = tempfile::tempdir().unwrap();
        let of = project(sensor, &[]);
        let depth_mm = (100.0 * touch(&of).max_indentation_mm()).floor() / 100.0;
        let first = usize::from(sensor.contains("published"));
        let tools = tools(&of);
        assert!(tools.len() > first, "{sensor}: {tools:?}");
        for tool in tools.iter().enumerate().filter(|(i, _)| all || i % 3 == first).map(|(_, t)| t)
        {
            let press = format!("{tool}@30deg,0deg,{depth_mm}mm");
            let run =
                fabkit(root.path(), &["depth", sensor, "--press", &press, "-o", "a.npz", "--json"]);
            let json = run.ok().json();
            let seen_mm = json["deepest_mm"].as_f64().unwrap_or(0.0);
            // A ring's middle is hollow: the test above.
            let least_mm = if tool == "ring" { 0.7 } else { 0.9 } * depth_mm;
            assert!((least_mm..=depth_mm + 1e-6).contains(&seen_mm), "{sensor} {press}: {seen_mm}");
            assert!(json["pixels_in_contact"].as_u64().unwrap() > 20, "{sensor} {press}");
        }
    }
}

/// What stands between backticks after a word of a message.
fn recommended<'a>(run: &'a Run, after: &str) -> &'a str {
    let start = run.stderr.find(after).unwrap_or_else(|| panic!("no `{after}` in {run:?}"));
    run.stderr[start + after.len()..].split('`').nth(1).unwrap()
}

#[test]
fn what_messages_recommend_presses() {
    // Published variants have the same tools.
    for sensor in
        sample_cases(&SENSORS).into_iter().copied().filter(|name| !name.contains("published"))
    {
        let root = tempfile::tempdir().unwrap();
        let depth = |press: &str| {
            fabkit(root.path(), &["depth", sensor, "--press", press, "-o", "a.npz", "--json"])
        };
        let tool = &tools(&project(sensor, &[]))[0];
        // Most messages recommend the same.
        let mut seen = BTreeSet::new();
        for wrong in [tool.clone(), format!("{tool}@30deg"), "nonsense".into()] {
            let run = fabkit(root.path(), &["depth", sensor, "--press", &wrong, "-o", "a.npz"]);
            assert_eq!(run.code, Some(2), "{run:?}");
            let better = recommended(&run, "like ");
            if seen.insert(better.to_owned()) {
                let json = depth(better).ok().json();
                assert!(json["pixels_in_contact"].as_u64().unwrap() > 0, "{sensor} {better}");
            }
        }
    }
}

#[test]
fn a_press_that_does_not_touch_is_refused_unless_asked_for() {
    let root = tempfile::tempdir().unwrap();
    let ring = ["--set", "fixtures.indenters.shapes=[ring]", "-o", "a.npz"];
    let depth =
        |more: &[&str]| fabkit(root.path(), &[&["depth", "rtac0"], &ring[..], more].concat());
    // The bore's edge is 1.2 mm off the axis: 0.048 mm outside of a ball of 15 mm, less 0.02 mm.
    let run = depth(&["--press", "ring@30deg,0deg,0.02mm"]);
    assert_eq!(run.code, Some(2), "{run:?}");
    for text in ["`ring@30deg,0deg,0.02mm` does not touch", "0.028 mm"] {
        assert!(run.stderr.contains(text), "{}", run.stderr);
    }
    assert!(read_folder(root.path()).is_empty());
    let better = recommended(&run, "for example ").to_owned();
    depth(&["--press", &better]).ok();
    let run = depth(&["--press", "ring@30deg,0deg,0.02mm", "--allow-no-contact"]);
    assert!(run.ok().stdout.contains("0 of these see contact"));
    // Pins that are too short: nothing to write instead, but how far they end from the surface.
    let short = ["--set", "fixtures.pin_dome.pins.lengths=[4mm,6mm]", "--press", "pin-1-short"];
    let run = depth(&short);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("`pin-1-short` does not touch the surface: it ends 0.650 mm"));
    // It touches, where the camera does not look.
    let aside = ["depth", "shadowtac", "--press", "ball@47deg,90deg,0.3mm", "-o", "a.npz"];
    let run = fabkit(root.path(), &aside);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("the camera sees nothing of `ball@47deg,90deg,0.3mm`"), "{run:?}");
    fabkit(root.path(), &[&aside[..], &["--allow-no-contact"]].concat()).ok();
}

#[test]
fn a_data_set_refuses_patterns_that_do_not_touch() {
    let root = tempfile::tempdir().unwrap();
    let list = "one = ring@30deg,180deg,0.02mm\ntwo = ring@30deg,180deg,1mm\n";
    std::fs::write(root.path().join("presses.txt"), list).unwrap();
    let dataset = |more: &[&str]| {
        let shapes = ["--set", "fixtures.indenters.shapes=[ring]", "--presses", "presses.txt"];
        let command = ["dataset", "rtac0", "-o", "data"];
        fabkit(root.path(), &[&command[..], &shapes, more].concat())
    };
    let run = dataset(&[]);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("`one`: `ring@30deg,180deg,0.02mm` does not touch"), "{run:?}");
    assert!(!root.path().join("data").exists());
    dataset(&["--allow-no-contact"]).ok();
}
