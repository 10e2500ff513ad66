//! Calibration chapter of a guide: the sensor's fixtures, and a capture plan for their pins.

use std::collections::BTreeSet;

use fabkit_calibration::landmarks::PinLandmarks;
use fabkit_designs::Design;
use fabkit_fixtures::Project;
use fabkit_guide::{Calibration, CalibrationCommand, FixtureNote, PinCapture};

use crate::source::Target;

/// Function that returns the command lines for the given fixtures and, if any, the fixture whose pins determine the
/// camera pose.
pub type CommandLines<'a> = &'a dyn Fn(&[&str], Option<&str>) -> Vec<CalibrationCommand>;

/// Describes the calibration of a sensor; for a fixture, only its own role, if it has one. If its pins cannot be
/// placed, there is no capture plan, and `check` of the fixture explains why. The command lines come from the caller,
/// which knows the command.
pub fn describe_calibration(
    project: &Project,
    target: Target,
    typed: CommandLines,
) -> Option<Calibration> {
    let names = project.fixture_names();
    let pins_in = project.pin_fixture_name();
    let has_pins = names.contains(&pins_in);
    match target.fixture {
        None => {}
        Some(name) if name == pins_in && has_pins => {}
        Some(_) => return None,
    }
    let captures = if has_pins {
        project
            .fixture(pins_in)
            .map(|fixture| plan_captures(project, &fixture, pins_in))
            .unwrap_or_default()
    } else {
        Vec::new()
    };
    let note = |name: &&str| FixtureNote {
        name: (*name).to_owned(),
        summary: project.summary(name).unwrap_or_default().to_owned(),
    };
    let fixtures = match target.fixture {
        None => names.iter().map(note).collect(),
        Some(_) => Vec::new(),
    };
    Some(Calibration {
        fixtures,
        commands: typed(&names, has_pins.then_some(pins_in)),
        pins_in: if has_pins { pins_in.to_owned() } else { String::new() },
        captures,
    })
}

/// Plans as many images with as many pins as the fixture's forecast assumes. Each hole is used about equally often, the
/// holes of one image are far apart, and pin lengths alternate.
fn plan_captures(project: &Project, fixture: &Design, name: &str) -> Vec<PinCapture> {
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
    let (Some(images), Some(pins)) = (count("count"), count("pins")) else { return Vec::new() };
    if holes.is_empty() || kinds.is_empty() {
        return Vec::new();
    }
    let pins = (pins as usize).min(holes.len());
    // A constant stride over the sorted holes spreads the pins; the start advances by one hole with each image.
    let stride = holes.len() / pins.max(1);
    let capture = |index: usize| {
        let mut of: Vec<u32> =
            (0..pins).map(|pin| holes[(index + pin * stride) % holes.len()]).collect();
        of.sort_unstable();
        PinCapture {
            file: format!("{:02}.png", index + 1),
            pins: format!("pin-{}", kinds[index % kinds.len()]),
            holes: of,
        }
    };
    (0..images as usize).map(capture).collect()
}
