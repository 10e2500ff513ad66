//! Images follow what coats, walls and diffusers are made of, and say what nobody states of it.

use std::path::Path;

use fabkit_application::capturing::LightConstants;
use fabkit_checks::{Rule, Severity};
use fabkit_designs::Design;
use fabkit_geometry::VisibleEffect;
use fabkit_tests::contract::find_faults;
use fabkit_tests::{build_design, fabkit, find_findings};
use serde_json::Value;

const BLACK: &str = "coat.material=Smooth-On Psycho Paint, black";

/// A capture at rest with its document and its values, 0 to 1.
fn capture(folder: &Path, sensor: &str, more: &[&str]) -> (Value, Vec<f64>) {
    let first = ["capture", sensor, "--reference", "-o", "image.png", "--bits", "16", "--json"];
    let json = fabkit(folder, &[&first[..], more].concat()).ok().json();
    assert!(find_faults(&json).is_empty(), "{:?}", find_faults(&json));
    (json, read_values(&folder.join("image.png")))
}

/// Values of an image of 16 bits, 0 to 1.
fn read_values(path: &Path) -> Vec<f64> {
    let file = std::fs::File::open(path).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let value = |pair: &[u8]| f64::from(u16::from_be_bytes([pair[0], pair[1]])) / 65_535.0;
    bytes.chunks(2).map(value).collect()
}

fn subjects(json: &Value) -> Vec<String> {
    let all = json["not_known"].as_array().unwrap().iter();
    let words = |one: &Value| {
        let word = |key: &str| one[key].as_str().unwrap().to_owned();
        format!("{} of {}", word("property"), word("material"))
    };
    all.map(words).collect()
}

/// Black paint reflects 5 %, aluminium 45 % and its gloss; the camera amplifies four times. So each place of the coat
/// gets at most 4 * 5 / 45 of the light, and as much where there is no gloss.
#[test]
fn black_paint_instead_of_aluminium_is_darker_and_noisier() {
    let root = tempfile::tempdir().unwrap();
    for sensor in ["digit-like", "gelsight-like"] {
        let of = |more: &[&str]| capture(root.path(), sensor, more);
        let (bright, before) = of(&["--no-noise"]);
        let (dark, after) = of(&["--no-noise", "--set", BLACK]);
        assert_eq!(subjects(&bright), [""; 0], "{sensor}");
        assert_eq!(subjects(&dark), [""; 0], "{sensor}");
        assert_eq!(bright["camera_gain"]["needed"], 1.0);
        assert_eq!(dark["camera_gain"]["applied"], 4.0);
        assert!(dark["camera_gain"]["needed"].as_f64().unwrap() > 9.0, "{dark}");

        // Rays that meet no coat keep their constant; every other pixel changes.
        let beside = 12.0 / 255.0;
        let is_lit = |value: &f64| *value > 0.02 && (value - beside).abs() > 1e-4;
        let lit: Vec<(f64, f64)> =
            before.iter().copied().zip(after).filter(|(value, _)| is_lit(value)).collect();
        assert!(lit.len() as f64 > 0.9 * before.len() as f64, "{sensor}: {}", lit.len());
        let changed = lit.iter().filter(|(old, new)| (old - new).abs() > 1.0 / 255.0).count();
        assert!(changed as f64 > 0.97 * lit.len() as f64, "{sensor}: {changed}");
        let most = 4.0 * 0.05 / 0.45;
        let within = lit.iter().filter(|(old, new)| *new > 0.0 && new / old < most + 1e-3).count();
        // Printed dots reflect 5 % on either coat, and are amplified.
        assert!(within as f64 > 0.95 * lit.len() as f64, "{sensor}: {within}");

        // Noise in the dark is amplified four times, shot noise by the root of it.
        let noise = |set: &[&str]| {
            let (json, noisy) = of(&[&["--seed", "5"], set].concat());
            let (_, clean) = of(&[&["--no-noise"], set].concat());
            let drift = json["drift_grey"].as_f64().unwrap();
            // What is nearly black is cut off at 0.
            let off: Vec<(f64, f64)> = noisy
                .iter()
                .zip(&clean)
                .map(|(noisy, clean)| (255.0 * (noisy - clean) - drift, 255.0 * clean + drift))
                .filter(|(_, grey)| *grey > 15.0)
                .collect();
            let square = off.iter().map(|(off, _)| off * off).sum::<f64>() / off.len() as f64;
            let grey = off.iter().map(|(_, grey)| grey).sum::<f64>() / off.len() as f64;
            (square, grey)
        };
        for (set, gain) in [(vec![], 1.0), (vec!["--set", BLACK], 4.0)] {
            let (square, grey) = noise(&set);
            let stated = (0.4_f64 * gain).powi(2) + gain * 0.13_f64.powi(2) * grey;
            assert!((square / stated - 1.0).abs() < 0.03, "{sensor} {gain}: {square} {stated}");
        }
    }
}

/// A coat of one's own without reflectance: the usual one stands for it, and text and JSON say so.
#[test]
fn a_coat_of_unknown_reflectance_is_said_to_be_unknown() {
    let root = tempfile::tempdir().unwrap();
    let material = "kind: paint, density: 1.05 g/cm3, cure: {time: 2 h}, cures: platinum, clarity: opaque, \
                    youngs_modulus: 0.3 MPa";
    let write = |name: &str, more: &str| {
        let text = format!(
            "format: 1\nextends: digit-like\nname: {name}\nmaterials:\n  Lab paint: {{{material}{more}}}\n\
             coat: {{material: Lab paint}}\n"
        );
        std::fs::write(root.path().join(format!("{name}.yaml")), text).unwrap();
        format!("{name}.yaml")
    };
    let (unknown, stated) =
        (write("unknown", ""), write("stated", ", reflectance: \"60 %, 20 %, 10 %\", gloss: 0 %"));
    let (json, of_unknown) = capture(root.path(), &unknown, &["--no-noise"]);
    assert_eq!(subjects(&json), ["reflectance of Lab paint", "gloss of Lab paint"]);
    let (usual, of_usual) = capture(root.path(), "digit-like", &["--no-noise"]);
    assert!(of_unknown == of_usual);
    assert_eq!(subjects(&usual), [""; 0]);
    let text = fabkit(root.path(), &["capture", &unknown, "--reference", "-o", "text.png"]).ok();
    let line = "not known: reflectance of Lab paint; state `reflectance` of `Lab paint` below `materials:`";
    assert!(text.stdout.contains(line), "{}", text.stdout);
    let check = fabkit(root.path(), &["check", &unknown, "--json"]).json();
    assert!(subjects(&check).contains(&"reflectance of Lab paint".to_owned()), "{check}");

    // A red coat sends back red light: 60 to 20 to 10.
    let (json, red) = capture(root.path(), &stated, &["--no-noise"]);
    assert_eq!(subjects(&json), [""; 0]);
    let sums = |image: &[f64]| {
        let sum = |part: usize| image.iter().skip(part).step_by(3).sum::<f64>();
        [0, 1, 2].map(sum)
    };
    let ([red, _, blue], [grey_red, _, grey_blue]) = (sums(&red), sums(&of_usual));
    let share = (red / blue) / (grey_red / grey_blue);
    assert!(share > 3.0 && share < 7.0, "{share}");

    // What lies outside of the limits is refused with them.
    let bright = write("bright", ", reflectance: 130 %");
    let run = fabkit(root.path(), &["check", &bright]);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("between 0 % and 100 %"), "{}", run.stderr);
}

/// A gel of one's own: images of its thickness follow its scattering, and say where nobody states it.
#[test]
fn a_gel_of_unknown_scattering_is_said_to_be_unknown() {
    let root = tempfile::tempdir().unwrap();
    let write = |name: &str, more: &str| {
        let text = format!(
            "format: 1\nextends: rtac0\nname: {name}\nmaterials:\n  Lab gel: {{extends: Smooth-On Solaris, \
             clarity: translucent, youngs_modulus: 69 kPa{more}}}\ntranslucent_gel: {{material: Lab gel}}\n"
        );
        std::fs::write(root.path().join(format!("{name}.yaml")), text).unwrap();
        format!("{name}.yaml")
    };
    let image = |file: &str, scene: &[&str]| {
        let first = ["capture", file, "-o", "image.png", "--bits", "16", "--json", "--no-noise"];
        let json = fabkit(root.path(), &[&first[..], scene].concat()).ok().json();
        (json, read_values(&root.path().join("image.png")))
    };
    let (unknown, open) = image(&write("unknown", ""), &["--reference"]);
    assert_eq!(subjects(&unknown), ["scattering of Lab gel"]);
    // The usual gel stands for it.
    let (usual, stated) = image(&write("usual", ", scattering: 0.14 /mm"), &["--reference"]);
    assert_eq!(subjects(&usual), [""; 0]);
    assert!(open == stated);
    // A cloudier gel is nearer to its whitest, so that losing a part of it costs a smaller share of the light: by Kubelka
    // and Munk s p / (1 + s p), of which half the path costs 0.47 with 0.21, and 0.24 with 2.1.
    let largest_loss = |file: &str| {
        let rest = image(file, &["--reference"]).1;
        let pressed = image(file, &["--press", "ball@0deg,0deg,0.8mm"]).1;
        let losses = rest.iter().zip(&pressed).map(|(rest, pressed)| rest - pressed);
        losses.fold(0.0, f64::max)
    };
    let (usual, cloudy) =
        (largest_loss("usual.yaml"), largest_loss(&write("cloudy", ", scattering: 14 /cm")));
    assert!(cloudy < 0.75 * usual, "{cloudy} {usual}");
}

/// Images take layers that scatter differently as one: the mean, which the constant's source says.
#[test]
fn layers_that_scatter_differently_are_drawn_as_their_mean() {
    let root = tempfile::tempdir().unwrap();
    let inks = [("blue", "0.2 /mm"), ("red", "0.6 /mm")].map(|(ink, scattering)| {
        format!("  Smooth-On Ecoflex 00-50 with {ink} UV ink: {{scattering: {scattering}}}\n")
    });
    let text = format!("format: 1\nextends: uvdtact\nname: inks\nmaterials:\n{}", inks.concat());
    std::fs::write(root.path().join("inks.yaml"), text).unwrap();
    let (json, _) = capture(root.path(), "inks.yaml", &["--light", "white", "--no-noise"]);
    assert_eq!(subjects(&json), [""; 0]);
    let constants = json["constants"].as_array().unwrap();
    let scattering = constants.iter().find(|one| one["name"] == "scatter_per_mm").unwrap();
    assert!((scattering["value"].as_f64().unwrap() - 0.4).abs() < 1e-12, "{scattering}");
    assert!(scattering["source"].as_str().unwrap().contains("the mean of layers"), "{scattering}");
}

/// Every command that draws light or weighs bodies says, in text and JSON, which property it had to assume.
#[test]
fn every_command_says_what_it_had_to_assume() {
    let root = tempfile::tempdir().unwrap();
    let unknown = |property: &str| format!("not known: {property} of Lab plastic; ");
    let few = "--set=fixtures.semi_domes.count=2";
    for (property, args) in [
        ("reflectance", &["capture", "digit-like", "--reference", "-o=image.png"][..]),
        ("reflectance", &["optics-pack", "digit-like", "-o=pack"]),
        ("reflectance", &["dataset", "rtac0", "--images", few, "-o=data"]),
        ("density", &["export", "digit-like", "--robot=urdf", "--force", "-o=robot"]),
    ] {
        let set = "--set=shell.material=Lab plastic";
        let text = fabkit(root.path(), &[args, &[set]].concat()).ok().stdout;
        assert_eq!(text.matches(&unknown(property)).count(), 1, "{args:?}: {text}");
        let args = args.iter().map(|arg| arg.replace("-o=", "-o=json-"));
        let args: Vec<String> = args.chain([set.to_owned(), "--json".to_owned()]).collect();
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let json = fabkit(root.path(), &args).ok().json();
        let expected = format!("{property} of Lab plastic");
        assert!(subjects(&json).contains(&expected), "{args:?}: {json}");
    }
    let robot = std::fs::read_to_string(root.path().join("robot/robot.json")).unwrap();
    let robot: Value = serde_json::from_str(&robot).unwrap();
    assert_eq!(subjects(&robot), ["density of Lab plastic"]);
}

/// A diffuser of black sheet or resin stops the light, in every family that has one; frosted and white ones do not.
#[test]
fn black_diffusers_are_found_in_every_family() {
    let mut families = Vec::new();
    for name in fabkit_designs::builtin_names() {
        let drawn = build_design(name, &[]);
        if families.contains(&drawn.family)
            || drawn.sensor.lightings.iter().all(|lighting| lighting.diffuser.is_none())
        {
            continue;
        }
        let stops = |design: &Design| {
            let findings = find_findings(&design.sensor, &[Rule::Sight]).unwrap();
            findings.into_iter().filter(|f| f.severity == Severity::Error).collect::<Vec<_>>()
        };
        assert!(stops(&drawn).is_empty(), "{name}");
        for material in ["black acrylic", "black resin", "Vero Black", "black acrylic, frosted"] {
            let design = build_design(name, &[&format!("diffuser.material={material}")]);
            let found = stops(&design);
            let is_it = |message: &str| message.contains("stops 100 % of the `white` light");
            assert!(found.iter().any(|f| is_it(&f.message)), "{name} {material}: {found:#?}");
        }
        families.push(drawn.family);
    }
    assert_eq!(families.len(), 2, "{families:?}");
}

/// A clear sheet spreads nothing, and white pigment does, whatever share of the light passes. The user's file decides what
/// a name means.
#[test]
fn a_clear_sheet_is_no_diffuser_and_a_white_one_is() {
    let folder = tempfile::tempdir().unwrap();
    let spots = |material: &str, stated: &str| {
        let yaml = format!(
            "format: 1\nextends: rtac0\nname: own\n{stated}diffuser: {{material: {material}}}\n"
        );
        std::fs::write(folder.path().join("own.yaml"), yaml).unwrap();
        let run = fabkit(folder.path(), &["check", "own.yaml", "--json"]);
        assert_eq!(run.code, Some(0), "{material}: {run:?}");
        let json = run.json();
        let mut messages =
            json["findings"].as_array().unwrap().iter().map(|one| one["message"].as_str().unwrap());
        (messages.any(|one| one.contains("spreads none of the `white` light")), subjects(&json))
    };
    assert!(spots("clear PMMA", "").0);
    let (is_clear, open) = spots("white PMMA", "");
    assert!(!is_clear && open.contains(&"transmission of white PMMA".to_owned()), "{open:?}");
    let frosted =
        "materials: {Lab sheet: {sort: acrylic, clarity: translucent, transmission: 60 %}}\n";
    let (is_clear, open) = spots("Lab sheet", frosted);
    assert!(!is_clear && !open.iter().any(|one| one.starts_with("trans")), "{open:?}");
    assert!(spots("Lab sheet", &frosted.replace("translucent", "clear")).0);
    let (_, open) = spots("Lab sheet", "materials: {Lab sheet: {sort: acrylic}}\n");
    assert!(open.contains(&"transparency of Lab sheet".to_owned()), "{open:?}");
}

/// Every material that is cast, as the coat whose slopes are seen: its own numbers, or a line that they are not known.
#[test]
fn each_coat_of_the_catalogue_has_its_own_numbers_or_is_not_known() {
    let text = include_str!("../../../../designs/families/materials.yaml");
    let names = text.lines().filter_map(|line| line.strip_prefix("  ")?.strip_suffix(':'));
    let names: Vec<&str> = names.filter(|name| !name.starts_with(' ')).collect();
    assert!(names.len() > 10, "{names:?}");
    let (mut stated, mut unknown) = (0, 0);
    for name in names {
        let set = format!("coat.material={name}");
        let yaml = fabkit_designs::builtin_yaml("digit-like").unwrap();
        // Some cannot be coats.
        let Ok(design) = fabkit_designs::load("digit-like", yaml, &[set], &["fixtures"]) else {
            continue;
        };
        let figures = &design.materials.iter().find(|one| ***one == *name).unwrap();
        let figures = &figures.material().figures;
        let shows = VisibleEffect::Slopes { coat: "coat".into(), printed: None };
        let constants = LightConstants::for_sensor(&design.sensor);
        let not_known: Vec<String> =
            constants.not_known(&shows).iter().map(|one| one.subject()).collect();
        let is_listed = |word: &str| not_known.contains(&format!("{word} of {name}"));
        match figures.reflectance {
            Some(reflectance) => {
                let [red, green, blue] = reflectance.shares();
                let mean = constants.coat[0].value;
                assert!((mean - (red + green + blue) / 3.0).abs() < 1e-12, "{name}");
                assert!(!is_listed("reflectance"), "{name}: {not_known:?}");
                stated += 1;
            }
            None => {
                assert!(is_listed("reflectance"), "{name}: {not_known:?}");
                unknown += 1;
            }
        }
        assert_eq!(is_listed("gloss"), figures.gloss.is_none(), "{name}: {not_known:?}");
    }
    assert!(stated >= 4 && unknown >= 4, "{stated} {unknown}");
}
