//! The pages to build from say what the design says.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fabkit_application::guiding;
use fabkit_designs::builtin_names;
use fabkit_tests::{built, fabkit};
use serde_json::Value;

fn texts<'a>(list: &'a Value, key: &str) -> Vec<&'a str> {
    list.as_array().unwrap().iter().map(|one| one[key].as_str().unwrap()).collect()
}

/// What a reader sees: no tags, no pictures, characters as they are.
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

#[test]
fn names_counts_and_masses_are_those_of_the_design() {
    let root = tempfile::tempdir().unwrap();
    for target in ["rtac0", "fluidic", "tactip", "rtac0/pin-dome"] {
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
    for name in builtin_names() {
        let design = built(name, &[]);
        let stages = guiding::stages(&design).unwrap();
        let [one, three] = [1, 3].map(|units| guiding::facts(&design, &stages, units).unwrap());
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
        guiding::FILES.map(|name| fs::read(root.path().join(threads).join(name)).unwrap())
    };
    assert!(bytes("1") == bytes("2"));
    let part = fabkit(root.path(), &["guide", "rtac0/shell", "-o", "no"]);
    assert_eq!(part.code, Some(2), "{part:?}");
    let many = fabkit(root.path(), &["guide", "rtac0", "--units", "0", "-o", "no"]);
    assert_eq!(many.code, Some(2), "{many:?}");
    assert!(!root.path().join("no").exists());
}
