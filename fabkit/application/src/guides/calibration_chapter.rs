//! Calibration chapter of a guide: the sensor's fixtures, and a capture plan for their pins.

use std::collections::{BTreeMap, BTreeSet};

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
/// holes of one image are far apart, and pin lengths alternate. Holes whose pins the camera does not see, as `check` of the
/// fixture says, are left out; if the forecast cannot tell, all are asked for.
fn plan_captures(project: &Project, fixture: &Design, name: &str) -> Vec<PinCapture> {
    let Some(landmarks) = fixture.documents::<PinLandmarks>().next() else { return Vec::new() };
    let key = format!("fixtures.{}.captures.", name.replace('-', "_"));
    let count = |last: &str| -> Option<u32> {
        let path = format!("{key}{last}");
        let setting = project.settings().find(|setting| setting.path == path)?;
        setting.value.parse().ok()
    };
    let invisible: BTreeSet<(u32, String)> = match project.pin_forecast() {
        Ok(Ok(forecast)) => {
            let pins = forecast.landmarks.pins.iter().zip(&forecast.is_seen);
            let unseen = pins.filter(|(_, is_seen)| !**is_seen);
            unseen.map(|(pin, _)| (pin.hole, pin.kind.clone())).collect()
        }
        _ => BTreeSet::new(),
    };
    let mut holes_by_kind: BTreeMap<&str, BTreeSet<u32>> = BTreeMap::new();
    for pin in &landmarks.pins {
        if !invisible.contains(&(pin.hole, pin.kind.clone())) {
            holes_by_kind.entry(&pin.kind).or_default().insert(pin.hole);
        }
    }
    let kinds: Vec<(&str, Vec<u32>)> = holes_by_kind
        .into_iter()
        .map(|(kind, holes)| (kind, holes.into_iter().collect()))
        .collect();
    let (Some(images), Some(pins)) = (count("count"), count("pins")) else { return Vec::new() };
    if kinds.is_empty() {
        return Vec::new();
    }
    let capture = |index: usize| {
        let (kind, holes) = &kinds[index % kinds.len()];
        let pins = (pins as usize).min(holes.len());
        // A constant stride over the sorted holes spreads the pins; the start advances by one hole with each image.
        let stride = holes.len() / pins.max(1);
        let mut of: Vec<u32> =
            (0..pins).map(|pin| holes[(index + pin * stride) % holes.len()]).collect();
        of.sort_unstable();
        PinCapture { file: format!("{:02}.png", index + 1), pins: format!("pin-{kind}"), holes: of }
    };
    (0..images as usize).map(capture).collect()
}
