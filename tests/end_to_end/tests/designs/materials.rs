//! What no source says of a material counts neither as fine nor as rigid: it is said.

use std::fs;

use fabkit_tests::{Run, fabkit};
use serde_json::Value;

/// Runs `fabkit check` on R-Tac0 with its shell of a material, and returns its document.
fn check_shell(process: &str, material: &str) -> (Run, Value) {
    let folder = tempfile::tempdir().unwrap();
    let settings =
        [format!("parts.shell.process={process}"), format!("parts.shell.material={material}")];
    let run = fabkit(
        folder.path(),
        &["check", "rtac0", "--json", "--set", &settings[0], "--set", &settings[1]],
    );
    let document = serde_json::from_str(&run.stdout).unwrap();
    (run, document)
}

/// Returns `PROPERTY of MATERIAL` for each entry of `not_known`.
fn not_known(document: &Value) -> Vec<String> {
    let entries = document["not_known"].as_array().unwrap().iter();
    entries
        .map(|entry| {
            format!(
                "{} of {}",
                entry["property"].as_str().unwrap(),
                entry["material"].as_str().unwrap()
            )
        })
        .collect()
}

#[test]
fn a_resin_that_nobody_knows_inhibits_as_resins_do() {
    for material in ["grey resin", "Siraya Tech Blu", "Elegoo Water Washable"] {
        let (run, document) = check_shell("sla", material);
        assert_eq!(run.code, Some(1), "{material}: {}", run.stdout);
        let findings = document["findings"].as_array().unwrap();
        let is_chemistry =
            |finding: &&Value| finding["rule"] == "chemistry" && finding["severity"] == "error";
        assert!(findings.iter().any(|finding| is_chemistry(&finding)), "{material}");
    }
}

#[test]
fn a_name_that_no_entry_has_leaves_its_properties_open() {
    let (_, known) = check_shell("fdm", "Delrin");
    assert!(not_known(&known).iter().all(|open| !open.contains("Delrin")), "{known}");
    let (run, document) = check_shell("fdm", "PLA Turbo 3000");
    assert_eq!(run.code, Some(0));
    let open = not_known(&document);
    for property in ["class", "cure inhibition", "hardness", "strength"] {
        let asked = format!("{property} of PLA Turbo 3000");
        assert!(open.contains(&asked), "{open:#?} lacks {asked}");
    }
    let folder = tempfile::tempdir().unwrap();
    let set = "parts.shell.material=PLA Turbo 3000";
    let strict = fabkit(folder.path(), &["check", "rtac0", "--strict", "--set", set]);
    assert_eq!(strict.code, Some(1), "{}", strict.stdout);
    assert!(strict.stdout.contains("can be built, as far as is known; not known:"));
}

#[test]
fn a_printed_material_of_one_s_own_answers_what_it_states() {
    let folder = tempfile::tempdir().unwrap();
    let text = "format: 1\nextends: rtac0\nname: own\nmaterials:\n  Turbo 3000:\n    extends: PLA\n    \
                hardness: Shore A 40\nparts:\n  shell: {material: Turbo 3000}\n";
    fs::write(folder.path().join("own.yaml"), text).unwrap();
    let run = fabkit(folder.path(), &["check", "own.yaml", "--json"]);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let soft = document["findings"].as_array().unwrap().iter().any(|finding| {
        finding["rule"] == "softness" && finding["message"].as_str().unwrap().contains("Shore A 40")
    });
    assert!(soft, "{document}");
    // What the file states is part of the design: another hardness is another design.
    let hash = |text: &str| {
        fs::write(folder.path().join("own.yaml"), text).unwrap();
        let run = fabkit(folder.path(), &["show", "own.yaml", "--json"]);
        serde_json::from_str::<Value>(&run.stdout).unwrap()["design_hash"].clone()
    };
    assert_ne!(hash(text), hash(&text.replace("A 40", "D 75")));
}

/// R-Tac0 with its middle gel of a material that says no more than some lines.
fn gel(lines: &str) -> String {
    format!(
        "format: 1\nextends: rtac0\nname: own\nmaterials:\n  Lab jelly:\n    kind: gel\n    density: 1 \
         g/cm3\n    cure: {{time: 90 min}}\n{lines}translucent_gel:\n  material: Lab jelly\n"
    )
}

#[test]
fn a_gel_gives_way_by_what_is_known_of_it_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let press = |lines: &str| {
        fs::write(folder.path().join("own.yaml"), gel(lines)).unwrap();
        let arguments = ["press", "own.yaml", "--indenter", "ball@0deg,0deg", "--depth", "0.3mm"];
        fabkit(folder.path(), &arguments)
    };
    let lines = [
        ("    hardness: Shore 00-20\n", "Shore 00-20"),
        ("    hardness: Shore A 10\n", "Shore A 10"),
        ("    modulus: 60 kPa\n", "modulus at 100 % strain"),
        // A stated modulus at small strain has priority, then the one at 100 %.
        ("    hardness: Shore 00-20\n    modulus: 60 kPa\n", "modulus at 100 % strain"),
        ("    modulus: 60 kPa\n    youngs_modulus: 50 kPa\n", "E 0.050 MPa"),
    ];
    for (stated, used) in lines {
        let run = press(stated);
        assert_eq!(run.code, Some(0), "{stated}: {}", run.stderr);
        assert!(run.stdout.contains(used), "{stated}: {}", run.stdout);
    }
    let silent = press("");
    assert_eq!(silent.code, Some(2), "{}", silent.stdout);
    assert!(silent.stderr.contains("Young's modulus of translucent-gel of Lab jelly is not known"));
    let run = fabkit(folder.path(), &["check", "own.yaml", "--json"]);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(not_known(&document).contains(&"Young's modulus of Lab jelly".to_owned()));
}

#[test]
fn a_cure_that_nobody_states_is_asked_for_beside_what_inhibits() {
    let folder = tempfile::tempdir().unwrap();
    let run = fabkit(folder.path(), &["check", "tactip", "--json"]);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(not_known(&document).contains(&"curing mechanism of Techsil RTV27905".to_owned()));
    let text = "format: 1\nextends: tactip\nname: own\nmaterials:\n  Techsil RTV27905: {cures: platinum}\n";
    fs::write(folder.path().join("own.yaml"), text).unwrap();
    let run = fabkit(folder.path(), &["check", "own.yaml"]);
    assert_eq!(run.code, Some(1), "{}", run.stdout);
    assert!(run.stdout.contains("error[chemistry]"), "{}", run.stdout);
}

#[test]
fn a_window_of_unknown_transparency_is_asked_for_and_not_taken_for_clear() {
    let folder = tempfile::tempdir().unwrap();
    // A refractive index alone does not say that light passes.
    let text = "format: 1\nextends: digit-like\nname: own\nmaterials:\n  Blue stuff: {sort: plastic, \
                refractive_index: 1.5}\nplate: {material: Blue stuff}\n";
    fs::write(folder.path().join("own.yaml"), text).unwrap();
    let run = fabkit(folder.path(), &["check", "own.yaml", "--json"]);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(not_known(&document).contains(&"transparency of Blue stuff".to_owned()), "{document}");
    for command in [
        &["capture", "own.yaml", "--reference", "-o", "own.png"][..],
        &["depth", "own.yaml", "--reference", "-o", "own.npz"],
    ] {
        let run = fabkit(folder.path(), command);
        assert_eq!(run.code, Some(2), "{}", run.stdout);
        assert!(
            run.stderr.contains("plate: not known: transparency of Blue stuff"),
            "{}",
            run.stderr
        );
        assert!(run.stderr.contains("state `clarity` of the material"), "{}", run.stderr);
    }
    let clear = text.replace("1.5}", "1.5, clarity: clear}");
    fs::write(folder.path().join("own.yaml"), clear).unwrap();
    let run = fabkit(folder.path(), &["check", "own.yaml", "--json"]);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(!not_known(&document).iter().any(|open| open.contains("transparency")), "{document}");
    fabkit(folder.path(), &["depth", "own.yaml", "--reference", "-o", "own.npz"]).ok();
}
