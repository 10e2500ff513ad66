//! The built-in TacTip: its layouts, its bayonets, and what it refuses.

use std::f64::consts::PI;

use fabkit_designs::parameters::InvalidDesign;
use fabkit_designs::{Design, builtin_yaml, load};
use fabkit_geometry::measure::overlap_volume;
use fabkit_geometry::{Angle, CompiledSolid, Pose, Solid};

/// Lines through the box that two bodies share: they find a stretch of a lug's size for certain.
const LINES: u32 = 8_000;

fn try_load(overrides: &[&str]) -> Result<Design, InvalidDesign> {
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    load("tactip.yaml", builtin_yaml("tactip").unwrap(), &overrides, &["fixtures"])
}

fn tactip(overrides: &[&str]) -> Design {
    try_load(overrides).unwrap_or_else(|e| panic!("{e}: {:#?}", e.problems))
}

fn solid<'a>(design: &'a Design, name: &str) -> &'a Solid {
    &design.sensor.body(name).unwrap().solid
}

/// Ring and dot centres by layout: the counts follow from circles `spacing` apart on a sphere of
/// 12.5 mm, each holding as many pins as fit at that spacing.
#[test]
fn each_layout_has_its_pins() {
    for (layout, spacing, pins) in [("A", 3.0, 57), ("B", 4.0, 35), ("C", 4.5, 19), ("D", 4.5, 19)]
    {
        let design = tactip(&[&format!("pins.layout={layout}")]);
        let dots = design.sensor.body("dots").unwrap();
        assert_eq!(dots.landmarks.len(), pins, "{layout}");
        // Dots end 2 mm inside the skin, and point at the hemisphere's centre.
        for dot in &dots.landmarks {
            assert!((dot.point.coords.norm() - 10.5).abs() < 1e-12, "{layout}: {}", dot.name);
            assert!((dot.axis + dot.point.coords / 10.5).norm() < 1e-12, "{layout}: {}", dot.name);
        }
        // The first circle is one spacing from the apex, measured along the skin.
        let arc = dots.landmarks[1].point.z.atan2(dots.landmarks[1].point.xy().coords.norm());
        assert!(((PI / 2.0 - arc) * 12.5 - spacing).abs() < 1e-9, "{layout}");
    }
}

/// How much the female part, turned from its locked place and lifted, cuts into the male part, mm3.
fn interference(male: &CompiledSolid, female: &Solid, turned_deg: f64, lift_mm: f64) -> f64 {
    let pose = Pose::translation(0.0, 0.0, lift_mm)
        .then_in(Pose::rotation_z(Angle::from_deg(turned_deg).unwrap()));
    let female = CompiledSolid::new(&female.clone().placed(pose)).unwrap();
    overlap_volume(male, &female, LINES).unwrap().volume.value_mm3
}

/// Puts the female part on, turns it until it locks, and tries all ways out but the one it came.
fn locks(design: &Design, female: &str, male: &str) {
    let (female, male) = (solid(design, female), CompiledSolid::new(solid(design, male)).unwrap());
    let turn_deg = 40.0;
    let cuts = |turned_deg, lift_mm| interference(&male, female, turned_deg, lift_mm);

    for step in 0..=40 {
        let lift_mm = 0.25 * f64::from(40 - step);
        assert_eq!(cuts(turn_deg, lift_mm), 0.0, "put on, {lift_mm} mm above its place");
    }
    for step in 0..=40 {
        let turned_deg = turn_deg * f64::from(40 - step) / 40.0;
        assert_eq!(cuts(turned_deg, 0.0), 0.0, "turned, {turned_deg} deg before its lock");
    }
    // Locked: not further round, not out at any turn that hides the lugs, not deeper.
    assert!(cuts(-3.0, 0.0) > 0.0, "turns beyond its stop");
    assert!(cuts(turn_deg + 3.0, 0.0) > 0.0, "turns beyond its entry");
    for turned_deg in [0.0, 8.0] {
        assert!(cuts(turned_deg, 0.5) > 0.0, "comes off, {turned_deg} deg before its lock");
        assert!(cuts(turned_deg, 2.0) > 0.0, "comes off, {turned_deg} deg before its lock");
    }
    assert!(cuts(0.0, -0.2) > 0.0, "sinks");
    // One way round only: the wide lug does not pass the other entries.
    for wrong_deg in [120.0, 240.0] {
        assert!(cuts(turn_deg + wrong_deg, 3.0) > 0.0, "goes on {wrong_deg} deg off");
    }
}

#[test]
fn the_tip_locks_onto_the_body() {
    locks(&tactip(&[]), "ring", "body");
}

#[test]
fn the_body_locks_onto_the_mount() {
    locks(&tactip(&[]), "body", "robot-mount");
}

#[test]
fn every_variant_has_valid_solids_and_locks() {
    for overrides in [
        &["tip.diameter=30 mm", "body.shaft_diameter=26 mm", "pins.reach=11 mm"][..],
        &["pins.layout=D", "pins.reach=9 mm"],
        &["pins.layout=free", "pins.diameter=0.8 mm", "pins.spacing=2.5 mm"],
        &["bayonet.lugs=2", "mount.bolts=6"],
    ] {
        let design = tactip(overrides);
        for part in design.sensor.parts() {
            part.solid.validate().unwrap_or_else(|e| panic!("{overrides:?} {}: {e}", part.name));
        }
        let (ring, body) =
            (solid(&design, "ring"), CompiledSolid::new(solid(&design, "body")).unwrap());
        for (turned_deg, lift_mm) in [(40.0, 3.0), (40.0, 0.0), (20.0, 0.0), (0.0, 0.0)] {
            let cut = interference(&body, ring, turned_deg, lift_mm);
            assert_eq!(cut, 0.0, "{overrides:?}: {turned_deg} deg, {lift_mm} mm");
        }
        assert!(interference(&body, ring, 0.0, 1.0) > 0.0, "{overrides:?} comes off");
    }
}

/// Each is refused with its path, with a limit, and with a hint.
#[test]
fn what_cannot_be_built_is_refused() {
    for (overrides, path, says) in [
        // A pin beyond the hemisphere misses the skin: a quarter circle less half a pin.
        (&["pins.reach=19.5 mm"][..], "pins.reach", "at most 19.134 mm"),
        // What the pixels see ends before that.
        (
            &["pins.reach=15 mm", "camera.depth=43.5 mm"],
            "camera.depth",
            "the pixels must see all dots",
        ),
        (&["pins.layout=free", "pins.spacing=1.2 mm"], "pins.length", "0.3 mm apart"),
        (&["pins.length=8 mm"], "pins.length", "0.3 mm apart"),
        (&["leds.count=32"], "leds.count", "at most 29, because the LEDs"),
        (&["leds.circle_radius=9.5 mm"], "leds.circle_radius", "inside the body"),
        (
            &["led_board.bore_radius=6 mm", "pins.reach=12 mm"],
            "led_board.bore_radius",
            "camera's sight",
        ),
        (&["skin.upstand=0.9 mm"], "skin.upstand", "at most 0.7 mm"),
        (
            &["lens.hole_radius=7 mm", "pins.reach=12 mm"],
            "lens.hole_radius",
            "out of the camera's sight",
        ),
        (&["lens.hole_radius=10 mm"], "lens.hole_radius", "not onto the ledge"),
        (&["bayonet.turn=95 deg"], "bayonet.turn", "between one groove and the next entry"),
        (&["bayonet.turn=15 deg"], "bayonet.turn", "leave its entry"),
        (
            &["bayonet.key_width=4 mm", "bayonet.lug_width=4 mm"],
            "bayonet.key_width",
            "at least 4.9 mm",
        ),
        (
            &["camera.board_size=20 mm", "camera.screw_spacing=27 mm"],
            "camera.screw_spacing",
            "heads must stay on the board",
        ),
        (
            &["body.shaft_length=60 mm", "camera.depth=43.5 mm"],
            "body.shaft_length",
            "as wide as the camera board",
        ),
        (&["mount.bolt_circle=50 mm"], "mount.bolt_circle", "inside the spigot"),
        (&["camera.lens_view=25 deg"], "camera.lens_view", "the chip's corners"),
        (&["mount.bolts=12"], "mount.bolts", "at most"),
        (&["fill.material=water"], "fill.material", "neither mix nor cure"),
    ] {
        let error = try_load(overrides).err().unwrap_or_else(|| panic!("{overrides:?} was taken"));
        let found = error.problems.iter().find(|p| p.path == path && p.message.contains(says));
        let found = found.unwrap_or_else(|| panic!("{overrides:?}: {:#?}", error.problems));
        assert!(found.hint.is_some(), "{overrides:?}");
    }
}
