//! A family small enough to see through, with every kind of parameter.

use fabkit_designs::parameters::{InvalidDesign, Problem, RuleReport};
use fabkit_designs::{Family, FamilyEntry, FamilyOutput, Header, Registry, choices, parameters};
use fabkit_geometry::{Angle, Length, NominalCamera, Pose, Sensor};

choices! {
    /// Outline of the base, seen from above.
    pub enum Outline {
        /// A circle.
        Round = "round",
        /// A square.
        Square = "square",
    }
}

parameters! {
    /// The sensing surface: a hemisphere on a straight wall.
    pub struct Surface {
        /// Radius of hemisphere and wall.
        ///
        /// More about it, which is not part of the summary.
        radius: Length = 4.0..=60.0,
        /// Height of the straight wall.
        wall_height: Length = 0.0..=60.0,
    }
}

parameters! {
    /// What is poured, inside out.
    pub struct Layers {
        /// The gel that moves.
        gel: Gel,
        /// Share of thinner in the coat.
        thinner: f64 = 0.0..=1.0,
    }
}

parameters! {
    /// One gel.
    pub struct Gel {
        /// Thickness over the whole surface.
        thickness: Length = 0.1..=50.0,
        /// What to buy.
        material: String = 1..=20,
    }
}

parameters! {
    /// Light and lens.
    pub struct Optics {
        /// Number of LEDs.
        leds: u32 = 1..=64,
        /// Full angle of view.
        field_of_view: Angle = 10.0..=220.0,
        /// Heights of the rings.
        rings: Vec<Length> = (1..=3, 0.0..=60.0),
        /// Whether a diffuser is fitted.
        diffuser: bool,
        /// Outline of the base.
        outline: Outline,
    }
}

parameters! {
    /// Everything about a bulb sensor.
    pub struct BulbParameters {
        /// The sensing surface.
        surface: Surface,
        /// The layers.
        layers: Layers,
        /// Light and lens.
        optics: Optics,
    }
}

pub struct Bulb;

impl Family for Bulb {
    type Parameters = BulbParameters;
    const NAME: &'static str = "bulb";
    const SUMMARY: &'static str = "A bulb for tests.";
    const EXAMPLE: &'static str = "glow";

    fn check(p: &BulbParameters, report: &mut RuleReport) {
        report.at_most(
            "layers.gel.thickness",
            p.layers.gel.thickness,
            p.surface.radius.mm() / 3.0,
            "two thirds of the radius are taken by the tube",
        );
        report.require(
            p.optics.diffuser || p.optics.leds <= 8,
            "optics.leds",
            || format!("optics.leds is {}; without diffuser it must be at most 8", p.optics.leds),
            || "write `8`, or set `optics.diffuser` to `true`".into(),
        );
    }

    fn build(p: &BulbParameters, header: &Header, report: &mut RuleReport) -> Option<FamilyOutput> {
        if header.name.as_str() == "unbuildable" {
            report.require(false, "name", || "it cannot be built".into(), || "rename it".into());
            return None;
        }
        let sensor = Sensor::new(
            header.name.as_str(),
            &header.title,
            &header.reference,
            NominalCamera {
                sensor_from_camera: Pose::identity(),
                width_px: 640,
                height_px: 480,
                field_of_view: p.optics.field_of_view,
                lens: Default::default(),
            },
            [],
        );
        let height_mm = p.surface.radius.mm() + p.surface.wall_height.mm();
        let derived = vec![("height".into(), format!("{height_mm} mm"))];
        Some(FamilyOutput { sensor, derived, face: None })
    }
}

/// The built-in sensor of the family.
pub const GLOW: &str = "\
format: 1
family: bulb
name: glow
title: Glow
reference: nobody et al.
surface:
  radius: {value: 15.0 mm, source: measured, note: published mesh}
  wall_height: {value: 6.0 mm, source: paper, note: III-B}
layers:
  gel:
    thickness: {value: 1.5 mm, source: paper, note: III-C}
    material: {value: Ecoflex 00-30, source: paper, note: III-C}
  thinner: {value: 0.5, source: chosen, note: sprays well}
optics:
  leds: {value: 8, source: paper, note: III-A}
  field_of_view: {value: 160 deg, source: paper, note: III-B}
  rings: {value: [1 mm, 2.5 mm], source: chosen, note: even light}
  diffuser: {value: true, source: paper, note: III-A}
  outline: {value: round, source: paper, note: Fig. 1}
";

const WIDE: &str = "\
format: 1
extends: glow
name: glow-wide
surface:
  radius: {value: 20 mm, source: chosen, note: wider}
";

const LOOP: &str = "format: 1\nextends: loop\nname: loop\n";

pub static REGISTRY: Registry = Registry::new(
    &[FamilyEntry::new::<Bulb>()],
    &[("glow", GLOW), ("glow-wide", WIDE), ("loop", LOOP)],
);

/// The built-in sensor with one line replaced, so that line numbers stay.
pub fn glow_with(line: &str, replacement: &str) -> String {
    assert!(GLOW.contains(line), "{line}");
    GLOW.replace(line, replacement)
}

/// What is wrong with a file; panics if nothing is.
pub fn problems(yaml: &str, overrides: &[&str]) -> Vec<Problem> {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    let InvalidDesign { problems, .. } =
        REGISTRY.load("my.yaml", yaml, &overrides, &[]).map(|_| ()).unwrap_err();
    assert!(!problems.is_empty());
    problems
}

/// The only thing wrong with a file.
pub fn problem(yaml: &str, overrides: &[&str]) -> Problem {
    let mut problems = problems(yaml, overrides);
    assert_eq!(problems.len(), 1, "{problems:#?}");
    problems.remove(0)
}
