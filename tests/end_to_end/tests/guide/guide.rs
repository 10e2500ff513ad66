//! The pages to build from say what the design says.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::{Mutex, OnceLock};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fabkit_application::guide::{Guide, Warning};
use fabkit_application::guides;
use fabkit_application::source::CheckErrors;
use fabkit_designs::{Design, builtin_names};
use fabkit_geometry::Action;
use fabkit_tests::{build_design, fabkit, tested_sensors};
use serde_json::Value;

fn texts<'a>(list: &'a Value, key: &str) -> Vec<&'a str> {
    list.as_array().unwrap().iter().map(|one| one[key].as_str().unwrap()).collect()
}

/// What a reader sees: no tags, no images, characters as they are.
fn text_of(html: &str) -> String {
    let (mut text, mut is_tag) = (String::new(), false);
    for letter in html.chars() {
        match letter {
            '<' => is_tag = true,
            '>' => {
                is_tag = false;
                text.push(' ');
            }
            _ if !is_tag => text.push(letter),
            _ => {}
        }
    }
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    text.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
}

fn facts(design: &Design, units: u32) -> Guide {
    let stages = guides::find_stages(design).unwrap();
    guides::collect_facts(design, &stages, None, units, &CheckErrors::default()).unwrap()
}

/// Facts of one built-in sensor as it ships, which several tests ask for.
fn shipped(name: &'static str) -> &'static Guide {
    static GUIDES: Mutex<BTreeMap<&str, &'static OnceLock<Guide>>> = Mutex::new(BTreeMap::new());
    // Not locked while one is made: tests of other sensors go on.
    let guide = *GUIDES.lock().unwrap().entry(name).or_insert_with(|| Box::leak(Box::default()));
    guide.get_or_init(|| facts(&build_design(name, &[]), 1))
}

#[test]
fn names_counts_and_masses_are_those_of_the_design() {
    let root = tempfile::tempdir().unwrap();
    for target in ["rtac0", "tactip", "rtac0/pin-dome"] {
        let run = |words: &[&str]| fabkit(root.path(), words).ok();
        let guide = run(&["guide", target, "-o", "guide", "--json"]).json();
        let show = run(&["show", target, "--json"]).json();
        let chain = run(&["show", target, "--chain", "--json"]).json();
        let page = fs::read_to_string(root.path().join("guide/index.html")).unwrap();
        let read = text_of(&page);
        assert_eq!(guide["design_hash"], show["design_hash"]);

        let quantities: BTreeMap<(&str, &str), &Value> = show["bodies"]
            .as_array()
            .unwrap()
            .iter()
            .map(|body| ((body["kind"].as_str().unwrap(), body["name"].as_str().unwrap()), body))
            .collect();
        let mut found = 0;
        for (list, kind) in [("made", "part"), ("bought", "component")] {
            for one in guide[list].as_array().unwrap() {
                let body = quantities[&(kind, one["name"].as_str().unwrap())];
                assert_eq!(one["quantity"], body["quantity"], "{target}: {one}");
                assert!(read.contains(one["name"].as_str().unwrap()), "{target}: {one}");
                assert!(read.contains(body["summary"].as_str().unwrap()), "{target}: {body}");
                found += 1;
            }
        }
        assert_eq!(found, quantities.keys().filter(|(kind, _)| *kind != "layer").count());
        assert_eq!(texts(&guide["steps"], "name"), texts(&chain["steps"], "name"));

        let mut liquids: BTreeMap<String, f64> = BTreeMap::new();
        for (step, told) in
            chain["steps"].as_array().unwrap().iter().zip(guide["steps"].as_array().unwrap())
        {
            assert_eq!(
                texts(&told["needs"], "name").as_slice(),
                serde_json::from_value::<Vec<String>>(step["bodies"].clone()).unwrap()
            );
            for component in step["batch"]["components"].as_array().into_iter().flatten() {
                let (name, mass_g) =
                    (component["name"].as_str().unwrap(), component["mass_g"].as_f64().unwrap());
                assert!(read.contains(&format!("{mass_g:.2} g {name}")), "{target}: {component}");
                *liquids.entry(name.to_owned()).or_default() += mass_g;
            }
            if let Some(hours) = step["cure"]["hours"].as_f64().filter(|hours| *hours > 0.0) {
                assert!(read.contains(&format!("Then wait {hours} h")), "{target}: {step}");
            }
        }
        for liquid in guide["liquids"].as_array().unwrap() {
            let mass_g = liquids.remove(liquid["name"].as_str().unwrap()).unwrap();
            assert!((liquid["mass_g"].as_f64().unwrap() - mass_g).abs() < 1e-9);
        }
        assert!(liquids.is_empty());
        // What is to be checked, minded and typed stands on the page as it stands in the document.
        for step in guide["steps"].as_array().unwrap() {
            for said in
                ["checks", "tools"].into_iter().flat_map(|key| step[key].as_array().unwrap())
            {
                assert!(read.contains(said.as_str().unwrap()), "{target}: {said}");
            }
        }
        for warning in guide["warnings"].as_array().unwrap() {
            assert!(read.contains(warning["why"].as_str().unwrap()), "{target}: {warning}");
        }
        if let Some(outer) = guide["outer"].as_object() {
            let size = outer["size_mm"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap());
            let size: Vec<String> = size.map(|mm| format!("{mm:.1}")).collect();
            assert!(read.contains(&size.join(" × ")), "{target}: {size:?}");
        }
        for typed in guide["calibration"]["commands"].as_array().into_iter().flatten() {
            assert!(read.contains(typed["line"].as_str().unwrap()), "{target}: {typed}");
        }
        // Nothing is fetched: what runs is in the page, the viewer and its data (whose texts name the addresses of
        // standards, and which a browser opens offline in `cargo xtask pages`).
        let scripts: Vec<&str> = page.split("<script").skip(1).collect();
        assert_eq!(scripts.len(), 2, "{target}");
        assert!(
            scripts[0].starts_with(" type=\"application/json\">") && scripts[1].starts_with('>')
        );
        let written = page.split("<script").map(|piece| match piece.split_once("</script>") {
            Some((_, behind)) => behind,
            None => piece,
        });
        for never in ["http://", "https://", "<link", "url("] {
            assert!(!written.clone().any(|piece| piece.contains(never)), "{target}: {never}");
        }
        model(&scripts[0][..scripts[0].find("</script>").unwrap()], &show, target);
        // Each jump has its place.
        for jump in page.split("href=\"#").skip(1) {
            let id = &jump[..jump.find('"').unwrap()];
            assert!(page.contains(&format!("id=\"{id}\"")), "{target}: {id}");
        }
        assert!(page.len() < 4_000_000, "{target}: {} bytes", page.len());
        tables(&root.path().join("guide"), &guide);
    }
}

/// Of the model that the page carries: each body of the finished sensor stands in it, a page without script has the
/// same facts, and there are rays and a press where there is a camera and a surface.
fn model(data: &str, show: &Value, target: &str) {
    let data: Value = serde_json::from_str(&data[data.find('{').unwrap()..]).unwrap();
    assert_eq!(data["title"], show["title"]);
    let is_sensor = !target.contains('/');
    assert_eq!(data.get("rays").is_some(), is_sensor, "{target}");
    let glb = STANDARD.decode(data["glb"].as_str().unwrap()).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let nodes = document["nodes"].as_array().unwrap();
    let scenes = document["scenes"].as_array().unwrap();
    let mut found = 0;
    for body in show["bodies"].as_array().unwrap() {
        for assembly in body["assemblies"].as_array().unwrap() {
            let scene = scenes.iter().find(|scene| scene["name"] == *assembly).unwrap();
            let root = &nodes[scene["nodes"][0].as_u64().unwrap() as usize];
            let children = root["children"].as_array().unwrap().iter();
            let mut children = children.map(|child| &nodes[child.as_u64().unwrap() as usize]);
            let node = children.find(|node| node["name"] == body["name"]).unwrap();
            for key in ["kind", "summary", "quantity"] {
                assert_eq!(node["extras"][key], body[key], "{target}: {body}");
            }
            found += 1;
        }
    }
    assert!(found > 0, "{target}");
}

/// As many lines as pieces, and the same sums.
fn tables(folder: &Path, guide: &Value) {
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let count = |key: &str| guide[key].as_array().unwrap().len();
    let listed = ["bought", "liquids", "stock", "supplies"].map(count);
    assert_eq!(read("bom.csv").lines().count(), 1 + listed.iter().sum::<usize>());
    assert_eq!(read("parts.csv").lines().count(), 1 + count("made"));
    let written: Value = serde_json::from_str(&read("guide.json")).unwrap();
    assert_eq!(written["made"], guide["made"]);
}

/// What is in a sensor is counted once for each, what helps to build it once; and all designs have a guide.
#[test]
fn more_units_take_more_of_what_stays_in_them() {
    for name in tested_sensors() {
        let design = build_design(name, &[]);
        let (one, three) = (shipped(name), facts(&design, 3));
        let made = one.made.iter().zip(&three.made).map(|(a, b)| (&a.name, a.quantity, b.quantity));
        let bought = one.bought.iter().zip(&three.bought);
        let bought = bought.map(|(a, b)| (&a.name, a.quantity, b.quantity));
        for (body, once, thrice) in made.chain(bought) {
            let body = design.sensor.body(body).unwrap();
            let stays = body.placements.iter().any(|placed| placed.assembly.0 == "sensor");
            assert_eq!(thrice, if stays { 3 * once } else { once }, "{name}: {}", body.name);
        }
        assert!(
            one.timeline.total_h > 0.0 && one.timeline.stretches.iter().any(|s| s.is_critical),
            "{name}"
        );
        // The last step ends when the build does, and no step begins before the hands are free.
        for pair in one.timeline.stretches.windows(2) {
            assert!(pair[1].start_h >= pair[0].hands_end_h, "{name}: {pair:?}");
        }
        for part in &one.made {
            assert!(part.mass_g.is_some(), "{name}: nobody knows how dense {} is", part.material);
        }
    }
}

#[test]
fn the_same_on_any_number_of_threads_and_whole_or_not_at_all() {
    let root = tempfile::tempdir().unwrap();
    let bytes = |threads: &str| {
        fabkit(root.path(), &["guide", "digit-like", "-o", threads, "--threads", threads]).ok();
        guides::FILES.map(|name| fs::read(root.path().join(threads).join(name)).unwrap())
    };
    assert!(bytes("1") == bytes("2"));
    let part = fabkit(root.path(), &["guide", "rtac0/shell", "-o", "no"]);
    assert_eq!(part.code, Some(2), "{part:?}");
    let many = fabkit(root.path(), &["guide", "rtac0", "--units", "0", "-o", "no"]);
    assert_eq!(many.code, Some(2), "{many:?}");
    assert!(!root.path().join("no").exists());
}

fn of<'a>(guide: &'a Guide, rule: &str) -> Vec<&'a Warning> {
    guide.warnings.iter().filter(|warning| warning.rule == rule).collect()
}

/// Takes a word out of every step.
fn without(mut design: Design, word: &str) -> Design {
    for step in &mut design.sensor.chain {
        step.instruction = step.instruction.to_lowercase().replace(word, "");
    }
    design
}

/// Each rule speaks where it must, says who deals with it where somebody does, and else is silent.
#[test]
fn warnings_follow_from_what_touches_what() {
    let [rtac0, fluidic, tactip] = ["rtac0", "fluidic", "tactip"].map(shipped);
    // Silicone in silicone molds: step 7 sprays them; without the word nobody does.
    assert!(of(rtac0, "release").iter().all(|w| w.dealt_with_in == Some(7)));
    assert_eq!(of(rtac0, "release").len(), 4);
    let bare = facts(&without(build_design("rtac0", &[]), "release"), 1);
    assert!(of(&bare, "release").iter().any(|w| w.dealt_with_in.is_none()));
    assert!(of(tactip, "release").is_empty());
    // Plywood under platinum silicone, sealed in step 1.
    assert!(of(fluidic, "inhibition").iter().all(|w| w.dealt_with_in == Some(1)));
    assert!(!of(fluidic, "inhibition").is_empty() && of(rtac0, "inhibition").is_empty());
    let bare = facts(&without(build_design("fluidic", &[]), "lacquer"), 1);
    assert!(of(&bare, "inhibition").iter().all(|w| w.dealt_with_in.is_none()));
    // Primers.
    assert!(of(rtac0, "primer").iter().all(|w| w.dealt_with_in == Some(7)));
    assert!(!of(rtac0, "primer").is_empty() && of(tactip, "primer").is_empty());
    // PLA gives way at 55 degrees, and nothing is cured that warm unless somebody asks for it.
    assert!(of(rtac0, "heat").is_empty());
    let mut hot = build_design("rtac0", &[]);
    for step in &mut hot.sensor.chain {
        if let Action::Pour(pour) = &mut step.action {
            pour.cure.celsius = 60.0;
        }
    }
    let hot = facts(&hot, 1);
    assert!(of(&hot, "heat").iter().any(|w| w.why.contains("PLA gives way at 55 °C")));
    // Sil-Poxy sets in five minutes; nothing else of these is so quick.
    assert_eq!(of(fluidic, "pot-life").len(), 2);
    assert!(of(rtac0, "pot-life").is_empty());
    assert!(!of(rtac0, "gloves").is_empty() && of(tactip, "gloves").is_empty());
    assert!(of(tactip, "safety").iter().any(|w| w.why.contains("instant adhesive")));
}

/// Depths, sizes and directions are those of the parameters.
#[test]
fn checks_are_the_sizes_of_the_design() {
    let guide = shipped("rtac0");
    let step = |name: &str| guide.steps.iter().find(|step| step.name == name).unwrap();
    // The instruction says 3 mm below the rim; the module is 30 mm wide.
    let cast = &step("cast-transparent-mold").checks;
    assert!(cast.iter().any(|c| c.ends_with("ends 3.0 mm below the top of form-cup")), "{cast:?}");
    let outer = guide.outer.as_ref().unwrap();
    assert!((outer.size_mm[0] - 30.0).abs() < 1e-6, "{outer:?}");
    assert!(outer.unweighed.contains(&"camera".to_owned()) && outer.mass_g > 10.0);
    // LEDs go down onto their board, the base comes up into the shell.
    let along = |step_name: &str, body: &str| {
        let ways = &step(step_name).ways;
        ways.iter().find(|way| way.bodies == [body]).unwrap().along
    };
    assert_eq!(along("mount-leds", "led"), [0.0, 0.0, -1.0]);
    let base = step("focus").ways.iter().rev().find(|way| way.bodies.contains(&"base".into()));
    assert_eq!(base.unwrap().along, [0.0, 0.0, 1.0]);
    assert!(step("close").tools.contains(&"a PH0 screwdriver".to_owned()));
    // A second unit waits for the mold, not for hands.
    let three = facts(&build_design("rtac0", &[]), 3).timeline.units;
    assert!(
        three.waits_for.is_some()
            && three.total_h > guide.timeline.total_h + 2.0 * three.apart_h - 1e-9
    );
}

/// What the page says to type is what the command understands.
#[test]
fn commands_of_the_calibration_are_understood() {
    let root = tempfile::tempdir().unwrap();
    // A few halves: one of the commands makes them.
    let set = ["--set", "surface.radius=16mm", "--set", "fixtures.semi_domes.count=3"];
    let words = [&["guide", "rtac0", "-o", "g", "--json"], &set[..]].concat();
    let guide = fabkit(root.path(), &words).ok().json();
    let calibration = &guide["calibration"];
    let commands = texts(&calibration["commands"], "line");
    assert_eq!(commands.len(), 7);
    for line in commands {
        assert!(line.contains(&set.join(" ")), "{line}");
        let words: Vec<&str> = line.split(' ').filter(|word| !word.is_empty()).collect();
        assert_eq!(words[0], "fabkit");
        let run = fabkit(root.path(), &words[1..]);
        // Images and camera are missing here; the words are not.
        assert!(!run.stderr.contains("Usage:"), "{line}: {run:?}");
    }
    // Each image has as many different holes as pins, all of them holes of the dome.
    let captures = calibration["captures"].as_array().unwrap();
    assert_eq!(captures.len(), 30);
    for capture in captures {
        let mut holes: Vec<u64> = capture["holes"]
            .as_array()
            .unwrap()
            .iter()
            .map(|hole| hole.as_u64().unwrap())
            .collect();
        holes.dedup();
        assert_eq!(holes.len(), 5, "{capture}");
    }
    // At 14 mm the dome's numbers do not fit: there is no plan, and the commands stay.
    let small = ["guide", "rtac0", "--set", "surface.radius=14mm", "-o", "s", "--json"];
    let small = &fabkit(root.path(), &small).ok().json()["calibration"];
    assert!(
        small["captures"].as_array().unwrap().is_empty()
            && texts(&small["commands"], "line").len() == 7
    );
    let other = fabkit(root.path(), &["guide", "rtac0", "--language", "de", "-o", "no"]);
    assert_eq!(other.code, Some(2), "{other:?}");
}

/// The same shape is used again, under another name too; what is wanted twice is bought once more.
#[test]
fn a_difference_names_what_is_used_again() {
    let root = tempfile::tempdir().unwrap();
    let diff = |words: &[&str]| {
        let words: Vec<&str> = ["diff"].iter().chain(words).chain(&["--json"]).copied().collect();
        fabkit(root.path(), &words).ok().json()
    };
    let body = |diff: &Value, name: &str| {
        let bodies = diff["bodies"].as_array().unwrap();
        bodies.iter().find(|body| body["name"] == name).unwrap().clone()
    };
    let none = diff(&["rtac0", "rtac0"]);
    assert!(none["parameters"].as_array().unwrap().is_empty());
    assert!(none["bodies"].as_array().unwrap().iter().all(|body| body["change"] == "same"));

    let wider = diff(&["rtac0", "rtac0", "--set-to", "surface.radius=16mm", "-o", "page.html"]);
    assert_eq!(body(&wider, "shell")["differs"], serde_json::json!(["shape"]));
    assert_eq!(body(&wider, "camera")["change"], "same");
    assert!(texts(&wider["parameters"], "path").contains(&"surface.radius"));
    let page = fs::read_to_string(root.path().join("page.html")).unwrap();
    assert!(page.matches("<img").count() >= 20 && text_of(&page).contains("shell"), "no images");

    let route = diff(&["rtac0-published-2025", "rtac0"]);
    assert_eq!(body(&route, "shell")["change"], "same");
    assert_eq!(body(&route, "form-cup")["change"], "added");
    assert_eq!(body(&route, "mold-transparent-gel-a")["change"], "removed");
    assert_eq!(body(&route, "form-cup")["besides"], 2);
}

/// Air leaves what is poured, and in time: a sentence of the page says how long, and that nobody measured it.
#[test]
fn mixes_say_how_long_air_takes() {
    let (mut degassed, mut rested) = (0, 0);
    for name in builtin_names() {
        let guide = shipped(name);
        let read = text_of(&guide.to_html(&Default::default()));
        for mix in &guide.mixes {
            assert_eq!(mix.air_source, "chosen");
            let is_poured = guide.steps[mix.step - 1].action == "pour";
            assert_eq!(mix.air_h > 0.0, is_poured || mix.degas, "{name}: {mix:?}");
            // A third of the pot life at most, but for rounding.
            assert!(
                mix.pot_life_h.is_none_or(|life_h| 3.0 * mix.air_h <= life_h * 1.000_001),
                "{name}: {mix:?}"
            );
            if mix.air_h > 0.0 {
                let what = if mix.degas { "degas" } else { "let stand" };
                let said = format!("{what} {:.0} min", 60.0 * mix.air_h);
                assert!(read.contains(&said), "{name}: {said}");
                *(if mix.degas { &mut degassed } else { &mut rested }) += 1;
            }
        }
        assert!(
            guide.mixes.is_empty() || read.contains("Times for air to leave are chosen"),
            "{name}"
        );
    }
    assert!(degassed > 0, "nothing is degassed; {rested} rest");
}
