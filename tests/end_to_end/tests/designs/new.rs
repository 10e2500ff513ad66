//! `fabkit new`: what it writes is a sensor that can be built, and it replaces nothing unasked.

use std::f64::consts::TAU;
use std::fs;

use fabkit_application::designs::{Design, REGISTRY};
use fabkit_application::source::Source;
use fabkit_tests::{Run, fabkit, read_folder, sampled_sensors};

#[path = "../../../../fabkit/application/examples/own_part.rs"]
#[allow(dead_code)]
mod own_part;
#[path = "../../../../fabkit/application/examples/sweep_gel.rs"]
#[allow(dead_code)]
mod sweep_gel;

fn load(sensor: &str) -> Design {
    let project = Source::find(sensor).and_then(|source| source.load(&[]));
    project.unwrap_or_else(|error| panic!("{sensor}: {error}")).design
}

/// Path and value of every parameter, whoever states them.
fn values(sensor: &str) -> Vec<(String, String)> {
    let source = Source::find(sensor).unwrap();
    let project = source.load(&[]).unwrap_or_else(|error| panic!("{sensor}: {error}"));
    project.settings().map(|setting| (setting.path.clone(), setting.value.clone())).collect()
}

/// Everything that files are made of: the bodies, and what follows from the parameters.
fn made(design: &Design) -> String {
    format!("{:?} {:?} {:?}", design.sensor.bodies, design.sensor.camera, design.derived)
}

#[test]
fn a_new_sensor_of_each_family_is_its_example_under_another_name() {
    let root = tempfile::tempdir().unwrap();
    assert!(REGISTRY.families().len() >= 5);
    for family in REGISTRY.families() {
        let (file, family_name) = (format!("./{}-x.yaml", family.name()), family.name());
        let name = format!("{family_name}-x");
        fabkit(root.path(), &["new", &name, "--family", family_name]).ok();
        let check = fabkit(root.path(), &["check", &file]).ok();
        assert!(!check.stderr.contains("changes nothing in this design"), "{}", check.stderr);
        let path = root.path().join(&file).display().to_string();
        let text = fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        // What counts only in other designs is a comment, with the example's value.
        for ((path, own), (_, example)) in values(&path).iter().zip(values(family.example())) {
            let commented = format!("# {}: ", path.rsplit('.').next().unwrap());
            let is_comment = || lines.iter().any(|line| line.trim_start().starts_with(&commented));
            assert!(*own == example || is_comment(), "{family_name} {path}: {own}, not {example}");
        }
        let (own, example) = (load(&path), load(family.example()));
        assert_eq!(made(&own), made(&example), "{family_name}");
        assert_eq!((&*own.sensor.name, &*own.sensor.title), (&*name, &*name));
        // All of them are the user's now, and stand below what they are and may be.
        for setting in &own.parameters {
            let key = setting.path.rsplit('.').next().unwrap();
            let is_comment = setting.source.kind.word() != "user";
            let key = if is_comment { format!("# {key}") } else { key.to_owned() };
            let is_told = |pair: &[&str]| {
                pair[0].ends_with(&format!("{}.", setting.limits))
                    && pair[1].trim_start().starts_with(&format!("{key}: "))
            };
            // A comment that is broken says its limits on two lines.
            let is_broken = lines.windows(3).any(|three| {
                let comment = format!("{} {}", three[0], three[1].trim_start_matches([' ', '#']));
                is_told(&[&comment, three[2]])
            });
            assert!(is_broken || lines.windows(2).any(is_told), "{}:\n{text}", setting.path);
        }
    }
}

#[test]
fn files_of_a_new_sensor_are_those_of_the_example() {
    let root = tempfile::tempdir().unwrap();
    fabkit(root.path(), &["new", "mine", "--family", "dome"]).ok();
    for (sensor, folder) in [("mine.yaml", "mine"), ("rtac0", "rtac0")] {
        let part = ["--part=shell", "--part=collar", "--part=led-board"];
        let export = ["export", sensor, "--format=stl", "-o", folder];
        fabkit(root.path(), &[&export[..], &part].concat()).ok();
    }
    let files = |folder: &str| {
        let mut files = read_folder(&root.path().join(folder));
        files.remove("manifest.json").unwrap();
        files
    };
    assert_eq!(files("mine").len(), 3);
    assert!(files("mine") == files("rtac0"));
}

#[test]
fn what_extends_a_sensor_lists_all_that_it_may_change() {
    let root = tempfile::tempdir().unwrap();
    for sensor in sampled_sensors() {
        let name = format!("{sensor}-x");
        fabkit(root.path(), &["new", &name, "--extends", sensor]).ok();
        let place = root.path().join(format!("{name}.yaml"));
        let path = place.display().to_string();
        assert_eq!(values(&path), values(sensor), "{sensor}");
        // Every line that is a comment below the header becomes a value when its mark is removed.
        let text = fs::read_to_string(&place).unwrap();
        let (header, rest) = text.split_once("\n\n# # ").unwrap();
        assert!(header.contains(&format!("extends: {sensor}")), "{header}");
        let bare = |line: &str| line.strip_prefix("# ").unwrap_or(line).to_owned() + "\n";
        let all: String = format!("# # {rest}").lines().map(bare).collect();
        fs::write(&place, format!("{header}\n\n{all}")).unwrap();
        assert_eq!(values(&path), values(sensor), "{sensor}");
        let own = load(&path).parameters;
        assert!(own.iter().all(|setting| setting.source.kind.word() == "user"), "{sensor}");
    }
}

fn assert_refused(run: &Run, texts: &[&str]) {
    assert_eq!(run.code, Some(2), "{run:?}");
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}

#[test]
fn nothing_is_replaced_unasked_and_what_is_wrong_is_named() {
    let root = tempfile::tempdir().unwrap();
    let new = |arguments: &[&str]| fabkit(root.path(), &[&["new"], arguments].concat());
    let json = new(&["a", "--family=dome", "--json"]).ok().json();
    assert_eq!(json["file"], "a.yaml");
    let before = read_folder(root.path());
    let there = new(&["a", "--extends=rtac0"]);
    assert_refused(&there, &["a.yaml is there already", "-o", "--force"]);
    assert_refused(&new(&["b", "--family=dom"]), &["did you mean `dome`?", "half-ellipsoid"]);
    assert_refused(&new(&["b", "--extends=rtac"]), &["did you mean `rtac0`?", "tactip"]);
    let long = "x".repeat(65);
    for wrong in ["A", "", "a b", "../a", "ä", "a.yaml", &long] {
        let run = new(&[wrong, "--family=dome"]);
        assert_refused(&run, &["cannot be a sensor's name", "1 to 64 of a-z, 0-9 and -"]);
    }
    assert_refused(&new(&["b", "--family=dome", "-o", "b.txt"]), &["does not end in .yaml"]);
    assert_refused(&new(&["b", "--family=dome", "--extends=rtac0"]), &["cannot be used with"]);
    assert_refused(&new(&["b"]), &["--family", "--extends"]);
    assert_eq!(read_folder(root.path()), before);
    new(&["a", "--extends=rtac0", "--force", "--quiet"]).ok();
    assert_ne!(read_folder(root.path()), before);
    new(&["b", "--extends=rtac0", "-o", "new/b.yml"]).ok();
    fabkit(root.path(), &["show", "new/b.yml"]).ok();
    // Names that mean something else in YAML stay names.
    for name in ["null", "7", "no", "1e3"] {
        new(&[name, "--extends=rtac0"]).ok();
        assert_eq!(
            load(&root.path().join(format!("{name}.yaml")).display().to_string()).sensor.name,
            name
        );
    }
}

#[test]
fn examples_of_the_library_do_what_they_say() {
    let root = tempfile::tempdir().unwrap();
    own_part::run(root.path()).unwrap();
    let files = read_folder(root.path());
    assert_eq!(
        files.keys().collect::<Vec<_>>(),
        [".written-by-fabkit.json", "foot.3mf", "foot.stl"]
    );
    // Binary STL: a header of 84 bytes, 50 for each triangle.
    let stl = &files["foot.stl"];
    assert!(stl.len() > 84 + 50 * 100 && (stl.len() - 84).is_multiple_of(50));
    assert!(files["foot.3mf"].starts_with(b"PK"));

    let volumes = sweep_gel::run(&["1.4 mm", "1.5 mm", "0.7 mm"]).unwrap();
    let cm3 = |i: usize| *volumes[i].as_ref().unwrap_or_else(|e| panic!("{e:?}"));
    // What a thicker gel has more lies inside: a hemisphere's shell and the wall below it.
    let more = |r: f64, dr: f64, wall: f64| TAU * (r * r + r * wall) * dr / 1e3;
    let (least, most) = (more(13.5, 0.1, 6.0), more(13.6, 0.1, 7.0));
    assert!((least..most).contains(&(cm3(1) - cm3(0))), "{} {}", cm3(0), cm3(1));
    // No vent that prints opens over a gel of 0.7 mm alone, and the message says so.
    let problems = &volumes[2].as_ref().unwrap_err().problems;
    assert!(problems.iter().any(|problem| problem.message.contains("vent")), "{problems:?}");
}
