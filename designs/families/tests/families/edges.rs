//! Round outer edges, and the side that a cable leaves by, in every family; by default there are none
//! and cables leave as they did.

use std::f64::consts::{FRAC_PI_4, PI};

use fabkit_designs::{Design, builtin_yaml, load};
use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{Body, CompiledSolid, Point3, Profile, Vector3};

fn overridden(sensor: &str, sets: &[&str]) -> Result<Design, String> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    load(sensor, builtin_yaml(sensor).unwrap(), &sets, &["fixtures"]).map_err(|invalid| {
        let told = |p: &fabkit_designs::parameters::Problem| {
            format!("{}\n{}\n", p.message, p.hint.as_deref().unwrap_or_default())
        };
        invalid.problems.iter().map(told).collect()
    })
}

fn made(sensor: &str, sets: &[&str]) -> Design {
    overridden(sensor, sets).unwrap_or_else(|why| panic!("{sensor} {sets:?}: {why}"))
}

fn refused(sensor: &str, sets: &[&str], texts: &[&str]) {
    let why = overridden(sensor, sets).map(|_| ()).expect_err(&format!("{sensor} {sets:?}"));
    for text in texts {
        assert!(why.contains(text), "no `{text}` in:\n{why}");
    }
}

fn body<'a>(design: &'a Design, name: &str) -> &'a Body {
    design.sensor.body(name).unwrap_or_else(|| panic!("no {name}"))
}

fn solid(design: &Design, name: &str) -> CompiledSolid {
    CompiledSolid::new(&body(design, name).solid).unwrap()
}

/// What a round edge lacks per length, for a radius of 1 mm: the square beside it less the quarter of a
/// circle.
const LACKS: f64 = 1.0 - FRAC_PI_4;

/// How far the middle of that lies from either face, for a radius of 1 mm.
const MIDDLE: f64 = (5.0 / 6.0 - FRAC_PI_4) / LACKS;

/// Volume that an edge of radius `r` around a circle lacks (Pappus).
fn around(circle: f64, r: f64) -> f64 {
    2.0 * PI * (circle - MIDDLE * r) * LACKS * r * r
}

/// The same around a rectangle of these half edges, whose corners are round.
fn around_rectangle([x, y]: [f64; 2], corner: f64, r: f64) -> f64 {
    4.0 * (x + y - 2.0 * corner) * LACKS * r * r + around(corner, r)
}

/// The same where a wall ends at a cone of 45 degrees.
fn around_cone(circle: f64, r: f64) -> f64 {
    let half = PI / 8.0;
    let (kite, sector) = (half.tan(), half);
    // Along the line from the arc's centre to the corner.
    let (kite_at, sector_at) =
        ((half.cos() + 1.0 / half.cos()) / 3.0, 2.0 * half.sin() / (3.0 * half));
    let at = (kite * kite_at - sector * sector_at) / (kite - sector);
    let inside = r * (1.0 / half.cos() - at) * half.cos();
    2.0 * PI * (circle - inside) * (kite - sector) * r * r
}

/// Asserts what a part lacks where `edge` is set, and nothing else of the sensor.
fn lacks(sensor: &str, part: &str, wide: &[&str], edge: &str, expected_mm3: f64) {
    let (sharp, round) = (made(sensor, wide), made(sensor, &[wide, &[edge]].concat()));
    let missing = body(&sharp, part).solid.clone().minus(body(&round, part).solid.clone());
    let missing = ray_volume(&CompiledSolid::new(&missing).unwrap(), 150_000).unwrap();
    let off = (missing.value_mm3 - expected_mm3).abs();
    assert!(
        off <= missing.error_mm3 && missing.error_mm3 < 0.04 * expected_mm3,
        "{sensor} {edge}: {missing:?}, not {expected_mm3}"
    );
    let more = body(&round, part).solid.clone().minus(body(&sharp, part).solid.clone());
    let more = ray_volume(&CompiledSolid::new(&more).unwrap(), 20_000).unwrap();
    assert!(more.value_mm3 < 1e-6, "{sensor} {edge}: {more:?}");
    for body in sharp.sensor.bodies.iter().filter(|body| body.name != part) {
        let other = round.sensor.body(&body.name).unwrap();
        assert_eq!(format!("{:?}", body.solid), format!("{:?}", other.solid), "{}", body.name);
    }
}

#[test]
fn round_edges_lack_what_lies_outside_of_their_circles() {
    lacks("rtac0", "shell", &[], "shell.edge_fillet=1mm", around(15.0, 1.0));
    let wide = ["holder.width=41mm"];
    let corner = |design: &Design| {
        let width = number(design, "holder.width");
        ([width / 2.0; 2], number(design, "holder.corner"))
    };
    let (half, round) = corner(&made("shadowtac", &wide));
    let expected = around_rectangle(half, round, 1.5);
    lacks("shadowtac", "holder", &wide, "holder.edge_fillet=1.5mm", expected);
    let wide = ["holder.outer_diameter=24mm"];
    lacks("uvdtact", "shell-holder", &wide, "holder.edge_fillet=2mm", around(12.0, 2.0));
    let wide = ["shell.rim=3mm"];
    let bounds = solid(&made("9dtact", &wide), "shell").bounds();
    let expected = around_rectangle([bounds.max.x, bounds.max.y], 2.0, 1.6);
    lacks("9dtact", "shell", &wide, "shell.edge_fillet=1.6mm", expected);
    let outer = solid(&made("tactip", &[]), "body").bounds().max.x;
    let expected = around(outer, 0.8) + around_cone(outer, 0.8);
    lacks("tactip", "body", &["controller.seat=none"], "body.edge_fillet=0.8mm", expected);
}

/// A small tip on a wide body: the screws stand further out, and the chamber's corners are sharper.
#[test]
fn leds_of_a_wide_shell_stay_in_its_chamber() {
    for rim in ["0.7", "3", "8"] {
        let design = made("9dtact", &[&format!("shell.rim={rim}mm")]);
        let leds = body(&design, "led");
        let shell = solid(&design, "shell");
        let size = CompiledSolid::new(&leds.solid).unwrap().bounds();
        for place in &leds.placements {
            for x in [size.min.x, size.max.x] {
                for y in [size.min.y, size.max.y] {
                    let corner = Point3::new(x, y, 0.5 * (size.min.z + size.max.z));
                    assert!(!shell.contains(&place.assembly_from_body.point(corner)), "{rim} mm");
                }
            }
        }
    }
}

/// What fixtures stand on and clamp is as wide as they are told, below the edge.
#[test]
fn fixtures_hold_on_below_a_round_edge() {
    for (sensor, upper, lower, sets) in [
        ("rtac0", "shell", "shell", vec!["shell.edge_fillet=1mm"]),
        ("shadowtac", "holder", "base", vec!["holder.edge_fillet=0.8mm"]),
        ("gelsight-like", "shell", "base", vec!["shell.edge_fillet=1.5mm"]),
        (
            "uvdtact",
            "shell-holder",
            "base",
            vec!["holder.outer_diameter=30mm", "holder.edge_fillet=5mm"],
        ),
    ] {
        let design = made(sensor, &sets);
        let grip = design.sensor.touch.as_ref().unwrap().grip();
        let [_, high] = Profile::new(grip.outline.clone()).bounds_mm();
        let is_solid = |part: &str, z: f64| {
            // Just inside of the outline at +x, beside what may be cut out there.
            solid(&design, part).contains(&Point3::new(high[0] - 0.05, 0.4, z))
        };
        assert!(!is_solid(upper, grip.top_z_mm - 0.01), "{sensor}");
        // Half plates and semi-domes clamp 7.2 mm below the top, with M3 screws.
        assert!(is_solid(upper, grip.top_z_mm - 5.5), "{sensor}");
        assert!(is_solid(lower, grip.bottom_z_mm + 0.01), "{sensor}");
    }
}

/// The value of a length, mm.
fn number(design: &Design, path: &str) -> f64 {
    let setting = design.parameters.iter().find(|setting| setting.path == path).unwrap();
    setting.value.trim_end_matches(" mm").parse().unwrap()
}

#[test]
fn edges_that_would_cut_into_something_are_refused() {
    let edge = |part: &str, mm: &str| format!("{part}.edge_fillet={mm}mm");
    for (sensor, part, too_large, texts) in [
        ("shadowtac", "holder", "1", ["holder.edge_fillet is 1 mm", "at most 0.8"]),
        ("9dtact", "shell", "0.8", ["shell.edge_fillet is 0.8 mm", "at most 0.7 mm"]),
        ("uvdtact", "holder", "0.5", ["holder.edge_fillet is 0.5 mm", "at most 0 mm"]),
        ("tactip", "body", "1", ["body.edge_fillet is 1 mm", "at most 0.8 mm"]),
    ] {
        refused(sensor, &[&edge(part, too_large)], &texts);
    }
    // Rounder than the upright edges; into the skirt below the step.
    let wide = ["shell.rim=5mm", "shell.edge_fillet=2.1mm"];
    refused("9dtact", &wide, &["goes around the upright edges", "at most 2 mm"]);
    let wide = ["holder.outer_diameter=40mm", "shell.foot_height=1mm", "holder.edge_fillet=5mm"];
    refused("uvdtact", &wide, &["the skirt below the step"]);
    assert_absent();
    refused("fluidic", &["housing.edge_fillet=1mm"], &["cut sheets have square edges"]);
}

/// What goes by another name, or by none, in some families.
fn assert_absent() {
    refused("shadowtac", &["holder.shoulder=2mm"], &["`holder.width`"]);
    refused("9dtact", &["shell.shoulder=2mm"], &["`shell.rim`"]);
    refused("tactip", &["body.shoulder=2mm"], &["however narrow the tip is"]);
    refused("9dtact", &["base.cable_angle=90 deg"], &["is not a parameter"]);
    refused("rtac0", &["shell.cable_side=left"], &["`cable_angle`"]);
}

#[test]
fn cables_leave_on_any_side() {
    let turned = |[x, y]: [f64; 2], quarters: u32| match quarters {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    };
    for (side, quarters) in [("right", 0), ("back", 1), ("left", 2), ("front", 3)] {
        let design = made("shadowtac", &[&format!("base.cable_side={side}")]);
        let base = solid(&design, "base");
        let [low, half] = [base.bounds().min.z, base.bounds().max.x];
        // In the middle of the wall, above the floor of at most 4 mm and its margin of 1 mm.
        let is_open = |quarters: u32| {
            let [x, y] = turned([half - 1.0, 0.0], quarters);
            !base.contains(&Point3::new(x, y, low + 6.0))
        };
        assert_eq!([0, 1, 2, 3].map(is_open), [0, 1, 2, 3].map(|i| i == quarters), "{side}");
        // The image's right is where the plug's right is, a quarter turn after the plug.
        let right = design.sensor.camera.sensor_from_camera.vector(Vector3::x());
        let [x, y] = turned([0.0, 1.0], quarters);
        assert_eq!([right.x, right.y], [x, y], "{side}");
        let grip = design.sensor.touch.as_ref().unwrap().grip();
        let out = grip.key.unwrap().vector(Vector3::z());
        let [x, y] = turned([1.0, 0.0], quarters);
        assert!((out - Vector3::new(x, y, 0.0)).norm() < 1e-12, "{side}: {out}");

        let design = made("fluidic", &[&format!("housing.cable_side={side}")]);
        let place = &body(&design, "box-wall-cable").placements[0].assembly_from_body;
        let out = place.vector(Vector3::z());
        assert!((out - Vector3::new(x, y, 0.0)).norm() < 1e-12, "{side}: {out}");
        let others = &body(&design, "box-wall").placements;
        let all =
            others.iter().fold(out, |sum, at| sum + at.assembly_from_body.vector(Vector3::z()));
        assert!(others.len() == 3 && all.norm() < 1e-12, "{side}");
    }
    let slot =
        |angle: &str| solid(&made("tactip", &[&format!("body.cable_angle={angle} deg")]), "body");
    for (angle, [x, y]) in [("0", [1.0, 0.0]), ("90", [0.0, 1.0]), ("-135", [-0.5f64.sqrt(); 2])] {
        let body = slot(angle);
        let out = body.bounds().max.x - 0.5;
        let heights = |way: f64| {
            let z = |i: i32| body.bounds().min.z + 0.1 * f64::from(i);
            (0..300).any(|i| {
                let at = |z| body.contains(&Point3::new(way * out * x, way * out * y, z));
                // A gap in the wall, between material below and above.
                (0..i).any(|below| at(z(below))) && !at(z(i)) && (i..300).any(|up| at(z(up)))
            })
        };
        assert!(heights(1.0) && !heights(-1.0), "{angle}");
    }
    // The slot of the wires, whatever it is turned by; mounting holes keep off it.
    let far = |degrees: f64| {
        let base = solid(&made("uvdtact", &[&format!("base.cable_angle={degrees} deg")]), "base");
        let z = base.bounds().min.z + 0.2;
        let (sin, cos) = degrees.to_radians().sin_cos();
        let open = |out: f64| !base.contains(&Point3::new(out * cos, out * sin, z));
        // Beyond the passage of the camera's cable.
        let slot: Vec<f64> =
            (10..90).map(|i| 0.05 + 0.1 * f64::from(i)).filter(|out| open(*out)).collect();
        (slot[0], slot[slot.len() - 1])
    };
    let ends = [0.0, 35.0, 60.0, 90.0, 120.0, 180.0, -45.0].map(far);
    assert!(ends.iter().all(|end| *end == ends[0]), "{ends:?}");
    let fixed = ["base.cable_angle=60 deg", "mount.angle=0 deg"];
    refused("uvdtact", &fixed, &["mounting hole comes within", "`base.cable_angle`"]);
    let long = ["base.wire_slot_length=6mm", "base.cable_angle=87 deg"];
    refused("uvdtact", &long, &["a bolt comes within 0.37 mm of the wires' slot"]);
}
