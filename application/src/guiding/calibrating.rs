//! What a guide says of calibration: what the sensor's fixtures are, and a plan for their pins.

use std::collections::BTreeSet;

use fabkit_calibration::landmarks::PinLandmarks;
use fabkit_designs::Design;
use fabkit_fixtures::Project;
use fabkit_guide::{Calibration, Capture, FixtureNote, Typed};

use crate::source::Target;

/// How the sensor is calibrated; of a fixture, its own part in it, if it has one. Where pins cannot be placed there
/// is no plan for them, and the command that checks the fixture says why.
pub fn calibration(project: &Project, target: Target, overrides: &[String]) -> Option<Calibration> {
    let names = project.fixture_names();
    let pins_in = project.pin_fixture_name();
    let has_pins = names.contains(&pins_in);
    match target.fixture {
        None => {}
        Some(name) if name == pins_in && has_pins => {}
        Some(_) => return None,
    }
    let captures = match has_pins {
        true => project
            .fixture(pins_in)
            .map(|fixture| captures(project, &fixture, pins_in))
            .unwrap_or_default(),
        false => Vec::new(),
    };
    let note = |name: &&str| FixtureNote {
        name: (*name).to_owned(),
        summary: project.summary(name).unwrap_or_default().to_owned(),
    };
    let fixtures = match target.fixture {
        None => names.iter().map(note).collect(),
        Some(_) => Vec::new(),
    };
    let commands = commands(&names, has_pins.then_some(pins_in), target, overrides);
    Some(Calibration {
        fixtures,
        commands,
        pins_in: if has_pins { pins_in.to_owned() } else { String::new() },
        captures,
    })
}

fn commands(
    names: &[&str],
    pins_in: Option<&str>,
    target: Target,
    overrides: &[String],
) -> Vec<Typed> {
    let sensor = match target.preset {
        None => target.sensor.to_owned(),
        Some(preset) => format!("{}-{preset}", target.sensor),
    };
    let sensor = quoted(&sensor);
    let set: String = overrides.iter().map(|set| format!(" --set {}", quoted(set))).collect();
    let typed = |what: &str, line: String| Typed { what: what.to_owned(), line };
    let mut lines = Vec::new();
    if names.contains(&"boards") {
        lines.push(typed(
            "print the board at 100 % and measure its ruler; take 10 to 20 pictures of it before the camera goes \
             into the sensor, tilted, out to the picture's border",
            format!("fabkit export {sensor}/boards{set} -o boards"),
        ));
        lines.push(typed(
            "the lens",
            format!(
                "fabkit calibrate intrinsics {sensor}{set} --board boards/charuco.board.json pictures/*.png \
                 -o camera.yaml --report lens.html"
            ),
        ));
    }
    if let Some(fixture) = pins_in {
        lines.push(typed(
            "print the pins and what guides them; its own guide says how",
            format!("fabkit export {sensor}/{fixture}{set} -o {fixture}"),
        ));
        lines.push(typed(
            "what they will tell, before you print",
            format!("fabkit check {sensor}/{fixture}{set}"),
        ));
        lines.push(typed(
            "the camera's place, once the pictures of the sheet below lie in `captures`",
            format!(
                "fabkit calibrate extrinsics {sensor}{set} --camera camera.yaml --captures captures \
                 -o pose.yaml --report pose.html"
            ),
        ));
    }
    for halves in names.iter().filter(|name| matches!(**name, "semi-domes" | "half-plates")) {
        lines.push(typed(
            "halves that press known shapes into the surface, for training",
            format!("fabkit export {sensor}/{halves}{set} -o {halves}"),
        ));
        lines.push(typed(
            "what the camera must see under each of them",
            format!("fabkit dataset {sensor}{set} --camera camera.yaml --pose pose.yaml -o data"),
        ));
    }
    lines
}

/// As a shell takes it for one word.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:%+@".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

/// As many pictures with as many pins as the fixture's own forecast counts on, each hole about as often as any
/// other, in each picture far from each other, with lengths taking turns.
fn captures(project: &Project, fixture: &Design, name: &str) -> Vec<Capture> {
    let Some(landmarks) = fixture.documents::<PinLandmarks>().next() else { return Vec::new() };
    let key = format!("fixtures.{}.captures.", name.replace('-', "_"));
    let count = |last: &str| -> Option<u32> {
        let path = format!("{key}{last}");
        let setting = project.settings().find(|setting| setting.path == path)?;
        setting.value.parse().ok()
    };
    let holes: Vec<u32> =
        landmarks.pins.iter().map(|pin| pin.hole).collect::<BTreeSet<_>>().into_iter().collect();
    let kinds: Vec<&str> = landmarks
        .pins
        .iter()
        .map(|pin| pin.kind.as_str())
        .collect::<BTreeSet<_>>()
        .into_iter()
        .collect();
    let (Some(pictures), Some(pins)) = (count("count"), count("pins")) else { return Vec::new() };
    if holes.is_empty() || kinds.is_empty() {
        return Vec::new();
    }
    let pins = (pins as usize).min(holes.len());
    let stride = holes.len() / pins.max(1);
    let capture = |index: usize| {
        let mut of: Vec<u32> =
            (0..pins).map(|pin| holes[(index + pin * stride) % holes.len()]).collect();
        of.sort_unstable();
        Capture {
            file: format!("{:02}.png", index + 1),
            pins: format!("pin-{}", kinds[index % kinds.len()]),
            holes: of,
        }
    };
    (0..pictures as usize).map(capture).collect()
}
