//! Constants of light from captures of pins, by the real binary: simulated ones, whose constants are known, and those of a
//! real sensor where a folder of them is named (see `real_captures.rs`).

use std::fs;

use fabkit_tests::contract::faults;
use fabkit_tests::{OPENCV_CAMERA, fabkit};
use serde_json::Value;

fn constant(document: &Value, name: &str) -> f64 {
    let constants = document["constants"].as_array().unwrap().iter();
    let mut named = constants.filter(|constant| constant["name"] == name);
    let constant = named.next().unwrap();
    constant["value"].as_f64().unwrap()
}

#[test]
fn simulated_captures_give_back_what_they_were_made_with() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("camera.yaml"), OPENCV_CAMERA).unwrap();
    fs::create_dir(root.path().join("pins")).unwrap();
    let capture = |more: &[&str], name: &str, seed: &str| {
        let first = ["capture", "rtac0", "--camera", "camera.yaml", "--spacing", "0.3mm", "--json"];
        fabkit(root.path(), &[&first[..], more, &["--seed", seed, "-o", name]].concat()).ok().json()
    };
    let made = capture(&["--reference"], "pins/ref.png", "100");
    let mut list = String::from("file,hole,kind\n");
    for (seed, holes) in
        [[1, 3, 8, 16], [1, 2, 10, 19], [1, 5, 12, 14], [1, 4, 7, 20]].iter().enumerate()
    {
        // Of both lengths: one does not tell the other's depth.
        let kind = |hole: i32| if hole % 2 == 0 { "short" } else { "long" };
        let presses = holes.map(|hole| format!("pin-{hole}-{}", kind(hole)));
        let more: Vec<&str> =
            presses.iter().flat_map(|press| ["--press", press.as_str()]).collect();
        let name = holes.map(|hole| format!("{hole:02}")).join("_");
        capture(&more, &format!("pins/{name}.png"), &seed.to_string());
        list.extend(holes.map(|hole| format!("{name}.png,{hole},{}\n", kind(hole))));
    }
    fs::write(root.path().join("pins/captures.csv"), list).unwrap();
    let fit = ["fit-light", "rtac0", "--camera", "camera.yaml", "--captures", "pins"];
    let found =
        fabkit(root.path(), &[&fit[..], &["-o", "light.json", "--json"]].concat()).ok().json();
    assert!(faults(&found).is_empty(), "{:?}", faults(&found));
    // Pins go as deep as landmarks say; that they do is found, not taken for granted.
    let [depth_mm, stated_mm] =
        ["pin_depth_mm", "stated_pin_depth_mm"].map(|key| found[key].as_f64().unwrap());
    assert!((depth_mm - stated_mm).abs() < 0.16, "{depth_mm} {stated_mm}");
    let rings = found["held_out_peak_error_grey"].as_array().unwrap();
    let stated = |ring: &Value| ring["stated_pin_depth_mm"].as_f64().unwrap();
    assert!(
        rings.iter().any(|ring| stated(ring) < 0.75) && rings.iter().any(|ring| stated(ring) > 1.3)
    );
    let [spread_mm, was_mm] = [&found, &made].map(|of| constant(of, "spread_mm"));
    assert!((spread_mm - was_mm).abs() < 0.1, "{spread_mm} {was_mm}");
    // Of a thin layer what it sends back and how much it scatters are hardly told apart; at rest they are one number.
    let at_rest = |of: &Value| {
        let [layer, ground, scatter] =
            ["layer_grey", "ground_grey", "scatter_per_mm"].map(|name| constant(of, name));
        ground + layer * scatter * 1.45 / (1.0 + scatter * 1.45)
    };
    let share = at_rest(&found) / (made["exposure"].as_f64().unwrap() * at_rest(&made));
    // The picture at rest has a drift, whose two standard deviations are 2.4 % of it.
    assert!((share - 1.0).abs() < 0.05 + 0.024 + 0.01, "{share}");
    // What the profile leaves out: rays that meet the pin before they meet the surface below it.
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!(number("held_out_profile_rms_grey") < 4.0 && number("reference_rms_grey") < 2.0);

    // And a picture by these constants says so.
    let said = fabkit(
        root.path(),
        &[
            "capture",
            "rtac0",
            "--constants",
            "light.json",
            "--reference",
            "-o",
            "again.png",
            "--json",
        ],
    );
    let said = said.ok().json();
    let known = said["constants"].as_array().unwrap().iter();
    let fitted = known
        .filter(|c| c["source"].as_str().unwrap().starts_with("light.json: fitted to 4 captures"));
    assert_eq!(fitted.count(), 4);
    fs::write(root.path().join("no.json"), "{}").unwrap();
    let run = fabkit(
        root.path(),
        &["capture", "rtac0", "--constants", "no.json", "--reference", "-o", "b.png"],
    );
    assert!(
        run.code == Some(2) && run.stderr.contains("no.json is not of the format"),
        "{}",
        run.stderr
    );
}

#[test]
fn real_captures_that_were_held_out_are_predicted() {
    let Some(folder) = std::env::var_os("FABKIT_REAL_CAPTURES").map(std::path::PathBuf::from)
    else {
        println!("SKIPPED: FABKIT_REAL_CAPTURES does not name a folder of real captures");
        return;
    };
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("camera.yaml"), OPENCV_CAMERA).unwrap();
    let [captures, landmarks] =
        ["", "holes.json"].map(|name| folder.join(name).display().to_string());
    let fit = ["fit-light", "rtac0", "--camera", "camera.yaml", "--captures", &captures, "--json"];
    let found = fabkit(root.path(), &[&fit[..], &["--landmarks", &landmarks]].concat()).ok().json();
    let number = |key: &str| found[key].as_f64().unwrap();
    println!("profiles {:.2} grey rms", number("held_out_profile_rms_grey"));
    println!("at rest {:.2} grey rms", number("reference_rms_grey"));
    for ring in found["held_out_peak_error_grey"].as_array().unwrap() {
        println!("ring {:.0} deg: {:+.1} grey", ring["polar_deg"], ring["error_grey"]);
        assert!(ring["error_grey"].as_f64().unwrap().abs() < 5.0);
    }
    assert!(number("held_out_profile_rms_grey") < 3.0 && number("reference_rms_grey") < 2.0);
}
