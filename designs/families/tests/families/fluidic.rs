//! The built-in fluidic sensor: every arrangement of its channels builds, silicone and liquid fill
//! each other out, the cameras see what they track, and what cannot be built is refused.

use fabkit_designs::parameters::{InvalidDesign, Problem};
use fabkit_designs::{Design, builtin_yaml, load};
use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{Action, CompiledSolid, Process, Solid, Vector3};

const ARRANGEMENTS: [&str; 3] = ["straight", "grid", "radial"];

/// Lines through each body; enough for about 1e-5 of its volume.
const LINES: u32 = 200_000;

fn try_fluidic(overrides: &[&str]) -> Result<Design, InvalidDesign> {
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    load("fluidic.yaml", builtin_yaml("fluidic").unwrap(), &overrides, &[])
}

fn fluidic(overrides: &[&str]) -> Design {
    try_fluidic(overrides).unwrap_or_else(|e| panic!("{overrides:?}: {:#?}", e.problems))
}

fn problems(overrides: &[&str]) -> Vec<Problem> {
    try_fluidic(overrides).map_or_else(|e| e.problems, |_| Vec::new())
}

fn with_arrangement(arrangement: &str) -> Design {
    fluidic(&[&format!("channels.arrangement={arrangement}")])
}

fn layer_volume_mm3(design: &Design, name: &str) -> f64 {
    let layer = design.sensor.layers().find(|layer| layer.name == name).unwrap();
    ray_volume(&CompiledSolid::new(&layer.solid).unwrap(), LINES).unwrap().value_mm3
}

#[test]
fn every_solid_of_every_arrangement_is_valid() {
    for arrangement in ARRANGEMENTS {
        let sensor = with_arrangement(arrangement).sensor;
        for body in sensor.bodies {
            body.solid.validate().unwrap_or_else(|e| panic!("{arrangement}: {}: {e}", body.name));
        }
    }
}

#[test]
fn every_sheet_is_one_plain_extrusion() {
    for part in fluidic(&[]).sensor.parts() {
        assert_eq!(part.process(), Some(Process::Laser), "{}", part.name);
        assert!(matches!(part.solid, Solid::Extrusion(_)), "{}", part.name);
    }
}

#[test]
fn silicone_liquid_and_tube_ends_fill_the_block() {
    for arrangement in ARRANGEMENTS {
        let design = with_arrangement(arrangement);
        let silicone = layer_volume_mm3(&design, "channel-layer");
        let liquid =
            layer_volume_mm3(&design, "liquid-left") + layer_volume_mm3(&design, "liquid-right");
        // 16 channels of 3 x 3 mm are taken by tubes and glue for their first 6 mm.
        let tube_ends = 16.0 * 3.0 * 3.0 * 6.0;
        let block = 60.0 * 60.0 * (3.0 + 3.0);
        let off = silicone + liquid + tube_ends - block;
        assert!(off.abs() < 1e-4 * block, "{arrangement}: {off} mm3 of {block}");
    }
}

#[test]
fn liquid_of_straight_channels_has_its_closed_form() {
    // From the tube's end at -24 to half a wall and half a width before the middle, with a round
    // end: eight of them.
    let (height, width, length) = (3.0, 3.0, 24.0 - 0.75 - 1.5);
    let one = height * (width * length + std::f64::consts::PI * 1.5 * 1.5 / 2.0);
    let measured = layer_volume_mm3(&fluidic(&[]), "liquid-left");
    assert!((measured - 8.0 * one).abs() < 2e-4 * 8.0 * one, "{measured} {}", 8.0 * one);
}

#[test]
fn glue_surrounds_every_tube() {
    // A sleeve: 3 x 3 mm without a tube of 2.5 mm, 6 mm long; eight on each side.
    let one = 6.0 * (9.0 - std::f64::consts::PI * 1.25 * 1.25);
    for side in ["left", "right"] {
        let measured = layer_volume_mm3(&fluidic(&[]), &format!("tube-glue-{side}"));
        assert!((measured - 8.0 * one).abs() < 1e-3 * 8.0 * one, "{side}: {measured}");
    }
}

#[test]
fn the_camera_sees_a_hundred_markers() {
    let sensor = fluidic(&[]).sensor;
    let plate = sensor.body("mold-marker-plate").unwrap();
    assert_eq!(plate.landmarks.len(), 100);
    let placement = plate.placements.first().unwrap();
    let camera_from_sensor = sensor.camera.sensor_from_camera.inverse();
    for marker in &plate.landmarks {
        let in_sensor = placement.assembly_from_body.point(marker.point);
        let seen = camera_from_sensor.point(in_sensor).coords;
        let off_axis = seen.angle(&Vector3::z());
        assert!(off_axis < sensor.camera.field_of_view.rad() / 2.0, "{}", marker.name);
        // The markers hang free in the box, above the lens.
        assert!(seen.z > 30.0, "{}: {seen}", marker.name);
    }
}

#[test]
fn every_layer_is_made_once() {
    let sensor = fluidic(&[]).sensor;
    let mut made: Vec<&str> = sensor
        .chain
        .iter()
        .filter_map(|step| match &step.action {
            Action::Pour(pour) => Some(pour.layer.as_str()),
            Action::Spray(spray) => Some(spray.layer.as_str()),
            _ => None,
        })
        .collect();
    let mut layers: Vec<&str> = sensor.layers().map(|layer| layer.name.as_str()).collect();
    made.sort_unstable();
    layers.sort_unstable();
    assert_eq!(made, layers);
}

#[test]
fn what_cannot_be_built_is_refused() {
    for (overrides, path, reason) in [
        (&["stock.length=100 mm", "stock.width=90 mm"][..], "stock.length", "measures"),
        (&["stock.width=100 mm"], "stock.width", "measures"),
        (&["channels.width=5.5 mm"], "channels.width", "wall between"),
        (&["channels.pitch=4 mm"], "channels.width", "wall between"),
        (
            &["channels.arrangement=grid", "channels.chamber_diameter=8 mm"],
            "channels.chamber_diameter",
            "channel beside it",
        ),
        (
            &["channels.per_side=10", "channel_layer.side=60 mm"],
            "channel_layer.side",
            "beside each other",
        ),
        (&["channels.arrangement=radial", "channels.wall=2 mm"], "channels.pitch", "short spokes"),
        (&["channels.arrangement=radial", "channels.per_side=7"], "channels.per_side", "even"),
        (&["channels.arrangement=radial", "channels.per_side=7"], "channels.arrangement", "within"),
        (&["markers.diameter=4.5 mm"], "markers.diameter", "wood between"),
        (
            &["markers.per_row=14", "housing.window=64 mm", "markers.pitch=5 mm"],
            "housing.window",
            "hang in the window",
        ),
        (&["marker_layer.side=70 mm", "housing.clamp_gap=3 mm"], "marker_layer.side", "bars"),
        (
            &["marker_layer.side=90 mm", "plate.bolt_spacing=90 mm"],
            "plate.bolt_spacing",
            "cavity's corners",
        ),
        (&["tubes.outer_diameter=3 mm"], "tubes.outer_diameter", "glue"),
        (
            &["tubes.needle_outer_diameter=1.5 mm", "tubes.inner_diameter=1.5 mm"],
            "tubes.needle_outer_diameter",
            "grip",
        ),
        (&["display.channel_width=2 mm"], "display.channel_width", "edges"),
        (&["display.pitch=2.5 mm"], "display.pitch", "side by side"),
        (&["display.rest_length=79 mm"], "display.rest_length", "drives it back"),
        (&["housing.height=50 mm", "markers.pitch=5 mm"], "housing.height", "every marker"),
        (
            &["display.camera_spacer=60 mm", "display.channel_length=80 mm"],
            "display.camera_spacer",
            "every channel",
        ),
        (&["molds.floor=5 mm"], "molds.floor", "M3x12"),
        (&["channel_layer.material=Jelly"], "channel_layer.material", "neither mix nor cure"),
    ] {
        let found = problems(overrides);
        let problem = found.iter().find(|p| p.path == path && p.message.contains(reason));
        assert!(problem.is_some(), "{overrides:?}: {found:#?}");
        // Where a length is offered, it lifts the refusal.
        let hint = problem.and_then(|p| p.hint.clone()).unwrap();
        let Some(rest) = hint.strip_prefix("write at ") else { continue };
        let offered = rest.split(' ').skip(1).take(2).collect::<Vec<_>>().join(" ");
        let offered = format!("{path}={}", offered.trim_end_matches(','));
        // A later override of the same parameter is not allowed: take its place.
        let mut repaired: Vec<&str> =
            overrides.iter().copied().filter(|o| !o.starts_with(&format!("{path}="))).collect();
        repaired.push(&offered);
        let left = problems(&repaired);
        let again = left.iter().find(|p| p.path == path && p.message.contains(reason));
        assert!(again.is_none(), "{offered}: {again:#?}");
    }
}

#[test]
fn sizes_follow_the_parameters() {
    // A smaller and a finer sensor, in one go.
    let small = fluidic(&[
        "channels.per_side=6",
        "channel_layer.side=46 mm",
        "marker_layer.side=60 mm",
        "markers.per_row=8",
        "housing.window=50 mm",
        "plate.bolt_spacing=70 mm",
        "plate.side=90 mm",
        "housing.led_strip_length=40 mm",
    ]);
    let liquid = small.sensor.layers().find(|l| l.name == "liquid-display").unwrap();
    assert_eq!(liquid.solid.children().len(), 12);
    let large = fluidic(&["markers.per_row=12", "markers.pitch=4 mm"]);
    let plate = large.sensor.body("mold-marker-plate").unwrap();
    assert_eq!(plate.genus, Some(144 + 4));
}
