//! Constants of light from captures of pins, by the real binary: simulated ones, whose constants are known, and those of a
//! real sensor where a folder of them is named (see `real_captures.rs`).

use std::fs;

use fabkit_tests::contract::find_faults;
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
        let first = ["capture", "rtac0", "--camera", "camera.yaml", "--spacing", "0.5mm", "--json"];
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
    assert!(find_faults(&found).is_empty(), "{:?}", find_faults(&found));
    // Pins go as deep as landmarks say; that they do is found, not taken for granted.
    let [depth_mm, stated_mm] =
        ["pin_depth_mm", "stated_pin_depth_mm"].map(|key| found[key].as_f64().unwrap());
    // Depths are tried in steps of 0.025 mm around the best one; noise may favour its neighbour.
    assert!((depth_mm - stated_mm).abs() < 0.051, "{depth_mm} {stated_mm}");
    let rings = found["held_out_peak_error_grey"].as_array().unwrap();
    let stated = |ring: &Value| ring["stated_pin_depth_mm"].as_f64().unwrap();
    assert!(
        rings.iter().any(|ring| stated(ring) < 0.75) && rings.iter().any(|ring| stated(ring) > 1.3)
    );
    let [spread_mm, was_mm] = [&found, &made].map(|of| constant(of, "spread_mm"));
    // A fifth of a pixel, which is 0.07 to 0.1 mm of the surface: images and fit are one renderer.
    assert!((spread_mm - was_mm).abs() < 0.02, "{spread_mm} {was_mm}");
    // Of a thin layer what it sends back and how much it scatters are hardly told apart; at rest they are one number.
    let at_rest = |of: &Value| {
        let [layer, ground, scatter] =
            ["layer_grey", "ground_grey", "scatter_per_mm"].map(|name| constant(of, name));
        ground + layer * scatter * 1.45 / (1.0 + scatter * 1.45)
    };
    let share = at_rest(&found) / (made["exposure"].as_f64().unwrap() * at_rest(&made));
    // The image at rest has a drift, whose two standard deviations are 2.4 % of it.
    assert!((share - 1.0).abs() < 0.05 + 0.024 + 0.01, "{share}");
    // Rounding to whole intensities, noise of 1.6 grey in each pixel, of which a bin averages at least ten, and marks that
    // are found to a tenth of a pixel where intensities change by 40 grey per mm.
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!(number("held_out_profile_rms_grey") < 0.9 && number("reference_rms_grey") < 1.0);

    // And an image by these constants says so.
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

/// Images of the default ball, pressed in so deep at these places of 9DTact's pad, and the image at rest.
fn balls_on_a_pad(folder: &std::path::Path, presses: &[&str]) -> Value {
    let capture = |more: &[&str]| {
        let all = [&["capture", "9dtact", "--spacing", "0.5mm", "--json"], more].concat();
        fabkit(folder, &all).ok().json()
    };
    fs::create_dir(folder.join("balls")).unwrap();
    for (seed, press) in presses.iter().enumerate() {
        let (seed, name) = (seed.to_string(), format!("balls/{seed}.png"));
        capture(&["--press", &format!("ball@{press}"), "--seed", &seed, "-o", &name]);
    }
    capture(&["--reference", "--seed", "100", "-o", "balls/ref.png"])
}

#[test]
fn balls_on_a_pad_give_back_light_and_depth() {
    let root = tempfile::tempdir().unwrap();
    let deep = [0.7, 1.5];
    let places = ["-5mm,1mm", "3mm,-2mm"];
    let presses: Vec<String> =
        places.iter().zip(deep).map(|(place, mm)| format!("{place},{mm}mm")).collect();
    let made = balls_on_a_pad(root.path(), &presses.iter().map(String::as_str).collect::<Vec<_>>());
    let fit = ["fit-light", "9dtact", "--captures", "balls", "--ball-diameter", "5mm", "--json"];
    let found = fabkit(root.path(), &[&fit[..], &["-o", "light.json"]].concat()).ok().json();
    assert!(find_faults(&found).is_empty(), "{:?}", find_faults(&found));
    let number = |key: &str| found[key].as_f64().unwrap();
    for ((ball, depth_mm), place) in found["balls"].as_array().unwrap().iter().zip(deep).zip(places)
    {
        let number = |key: &str| ball[key].as_f64().unwrap();
        let place: Vec<f64> =
            place.split(',').map(|mm| mm.trim_end_matches("mm").parse().unwrap()).collect();
        for (axis, mm) in place.iter().enumerate() {
            // Slanted rays meet what is pressed in beside where they meet it at rest: by its depth times 5 mm over 20.
            let off_mm = (ball["at_mm"][axis].as_f64().unwrap() - mm).abs();
            assert!(off_mm < 0.35, "{}", ball["at_mm"]);
        }
        assert!((number("depth_mm") - depth_mm).abs() < 0.08, "{} {depth_mm}", number("depth_mm"));
        assert!(number("dark_profile_rms_grey") < 1.5);
    }
    // Taken apart, constants of a thin layer are known badly; what pressing it to half does to its light, well.
    let half = |of: &Value| {
        let scatter = constant(of, "scatter_per_mm");
        let back = |mm: f64| scatter * mm / (1.0 + scatter * mm);
        constant(of, "layer_grey") * (back(2.5) - back(1.25))
    };
    let share = half(&found) / (made["exposure"].as_f64().unwrap() * half(&made));
    assert!((share - 1.0).abs() < 0.05, "{share}");
    assert!(number("held_out_profile_rms_grey") < 1.0 && number("reference_rms_grey") < 4.0);

    // Images rest on these; how far light spreads is as it was.
    let again = ["capture", "9dtact", "--constants", "light.json", "--press", "ball@0mm,0mm,1mm"];
    let said = fabkit(root.path(), &[&again[..], &["--json", "-o", "again.png"]].concat());
    let said = said.ok().json();
    let known = said["constants"].as_array().unwrap();
    let fitted = |c: &&Value| {
        c["source"].as_str().unwrap().starts_with("light.json: fitted to 2 captures of balls")
    };
    assert_eq!(known.iter().filter(fitted).count(), 3);
    assert!((constant(&said, "spread_mm") - constant(&made, "spread_mm")).abs() < 1e-12);

    // One capture alone is fitted, and nothing is said to be held out. A ball that is smaller than it was leaves something
    // that is not explained, and says so.
    fs::create_dir(root.path().join("one")).unwrap();
    for name in ["ref.png", "1.png"] {
        let from = root.path().join("balls").join(name);
        fs::copy(from, root.path().join("one").join(name)).unwrap();
    }
    let small = ["fit-light", "9dtact", "--captures", "one", "--ball-diameter", "3mm", "--json"];
    let small = fabkit(root.path(), &small).ok().json();
    assert!(
        find_faults(&small).is_empty() && small["held_out_profile_rms_grey"].is_null(),
        "{small:#}"
    );
    let said = small["unexplained"].as_array().unwrap().iter();
    let asks = |words: &&Value| words.as_str().unwrap().contains("is the ball as large");
    assert_eq!(said.filter(asks).count(), 1, "{:#}", small["unexplained"]);
    let first = &small["constants"].as_array().unwrap()[3];
    assert!(first["name"] == "layer_grey_per_mm" && first["sigma"].as_f64().unwrap() > 0.0);
}

#[test]
fn what_shows_no_ball_is_said() {
    let root = tempfile::tempdir().unwrap();
    balls_on_a_pad(root.path(), &["11mm,9mm,1mm"]);
    fs::copy(root.path().join("balls/ref.png"), root.path().join("balls/same.png")).unwrap();
    let fit = ["fit-light", "9dtact", "--captures", "balls"];
    let wrong = |more: &[&str], expected: &[&str]| {
        let run = fabkit(root.path(), &[&fit[..], more].concat());
        let is_said = expected.iter().all(|words| run.stderr.contains(words));
        assert!(run.code == Some(2) && is_said, "{more:?}: {}", run.stderr);
    };
    wrong(&[], &["the diameter of the ball is not given", "--ball-diameter LENGTH"]);
    let sized = ["--ball-diameter", "5mm"];
    wrong(&sized, &["same.png shows no ball", "0.png is too near to the side: around"]);
    let two = ["capture", "9dtact", "--spacing", "0.5mm", "--press", "ball@-6mm,0mm,1mm"];
    let two = [&two[..], &["--press", "ball@6mm,0mm,1mm", "-o", "balls/two.png"]].concat();
    fabkit(root.path(), &two).ok();
    wrong(&sized, &["two.png shows more than one ball"]);
    wrong(&["--ball-diameter", "5mm", "--pin-radius", "1mm"], &["--pin-radius is for domes"]);
    wrong(&["--ball-diameter", "50mm"], &["20 mm"]);
    let dome = ["fit-light", "rtac0", "--captures", "balls"];
    let run = fabkit(root.path(), &dome);
    assert!(
        run.code == Some(2) && run.stderr.contains("write --camera FILE.yaml"),
        "{}",
        run.stderr
    );
    let run = fabkit(root.path(), &[&dome[..], &["--scale", "0.05mm"]].concat());
    assert!(run.code == Some(2) && run.stderr.contains("is for pads"), "{}", run.stderr);
}

/// A folder with `ref.png` and images of a ball of 8 mm at 0.051 mm to a pixel, as 9DTact's authors published.
#[test]
fn a_real_ball_is_explained_where_it_is_dark() {
    let Some(folder) = std::env::var_os("FABKIT_REAL_BALLS") else {
        println!("SKIPPED: FABKIT_REAL_BALLS does not name a folder of real captures");
        return;
    };
    let root = tempfile::tempdir().unwrap();
    let folder = std::path::PathBuf::from(folder).display().to_string();
    let fit = ["fit-light", "9dtact", "--captures", &folder, "--scale", "0.051mm"];
    let found = fabkit(root.path(), &[&fit[..], &["--ball-diameter", "8mm", "--json"]].concat());
    for ball in found.ok().json()["balls"].as_array().unwrap() {
        println!("{:#} {:#}", ball["real"], ball["predicted"]);
        println!("dark profile {:.2} grey rms", ball["dark_profile_rms_grey"]);
        assert!(ball["dark_profile_rms_grey"].as_f64().unwrap() < 4.0);
    }
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
