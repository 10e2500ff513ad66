//! Flat-gel sensors: published sizes follow from 9DTact's parameters, volumes are those of closed form, the
//! camera sees what it should, and what cannot be built is refused.

use std::f64::consts::PI;

use fabkit_designs::parameters::InvalidDesign;
use fabkit_designs::{Design, builtin_names, builtin_yaml, load};
use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{Assembly, BodyKind, CompiledSolid, Point3, Ray, Sensor, Vector3};

/// Every built-in sensor of the family.
fn sensors() -> impl Iterator<Item = &'static str> {
    let is_flat = |name: &&str| try_load(name, &[]).is_ok_and(|it| it.family == "flat-gel");
    builtin_names().into_iter().filter(is_flat)
}

/// The pad that a user writes over 9DTact's; nothing else changes.
const OTHER_PAD: &str = "format: 1\nextends: 9dtact\nname: mine\n\
                         pad: {length: 20 mm, width: 25 mm, thickness: 3 mm}\n";

fn try_load(name: &str, overrides: &[&str]) -> Result<Design, InvalidDesign> {
    let overrides: Vec<String> = overrides.iter().map(|o| o.to_string()).collect();
    load(&format!("{name}.yaml"), builtin_yaml(name).unwrap(), &overrides, &["fixtures"])
}

fn built(name: &str, overrides: &[&str]) -> Sensor {
    try_load(name, overrides).unwrap_or_else(|e| panic!("{e}: {:#?}", e.problems)).sensor
}

fn compiled(sensor: &Sensor, body: &str) -> CompiledSolid {
    CompiledSolid::new(&sensor.body(body).unwrap().solid).unwrap()
}

/// Length, width and height of a body, mm.
fn size_mm(sensor: &Sensor, body: &str) -> [f64; 3] {
    let bounds = compiled(sensor, body).bounds();
    let size = bounds.max - bounds.min;
    [size.x, size.y, size.z]
}

fn assert_near(found: [f64; 3], expected: [f64; 3], within_mm: f64, what: &str) {
    let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
    assert!(off <= within_mm, "{what}: {found:?}, expected {expected:?}");
}

/// Area of a rectangle with round corners.
fn area_mm2(x: f64, y: f64, corner: f64) -> f64 {
    x * y - (4.0 - PI) * corner * corner
}

#[test]
fn every_solid_is_valid() {
    for name in sensors() {
        for body in &built(name, &[]).bodies {
            body.solid.validate().unwrap_or_else(|e| panic!("{name} / {}: {e}", body.name));
        }
    }
}

/// The authors' black_base.obj, white_shell.obj and black_contact.obj: boxes of 32.5 x 25.5 x 3 and
/// 19.5, 31.1 x 24.1. Their second mold is 2.8 mm thick, the first 2.5 mm with a hole of 29.5 x 22.5.
#[test]
fn the_published_outlines_of_9dtact_follow_from_its_parameters() {
    let sensor = built("9dtact", &[]);
    // The camera's angle is written to 0.1 degree: 0.01 mm at 15 mm.
    assert_near(size_mm(&sensor, "shell"), [32.5, 25.5, 19.5], 0.01, "shell");
    assert_near(size_mm(&sensor, "coat"), [31.1, 24.1, 2.8], 1e-9, "coat");
    assert_near(size_mm(&sensor, "gel"), [29.5, 22.5, 2.5], 1e-9, "gel");
    let base = size_mm(&sensor, "base");
    // Posts stand on it.
    assert_near([base[0], base[1], 3.0], [32.5, 25.5, 3.0], 1e-9, "base");
    let (grip, joint_z) =
        (sensor.touch.as_ref().unwrap().grip(), compiled(&sensor, "shell").bounds());
    assert!((joint_z.min.z - grip.bottom_z_mm - 3.0).abs() < 1e-9);
}

#[test]
fn layers_have_the_volumes_of_closed_form() {
    let coat_mm3 = |pad: [f64; 4], gel: [f64; 4]| {
        let [of_pad, of_gel] = [pad, gel].map(|[x, y, corner, z]| area_mm2(x, y, corner) * z);
        (of_gel, of_pad - of_gel)
    };
    let cases = [
        ("9dtact", coat_mm3([31.1, 24.1, 1.8, 2.8], [29.5, 22.5, 1.0, 2.5]), 0),
        ("digit-like", coat_mm3([22.0, 18.0, 2.0, 3.0], [21.8, 17.8, 1.9, 2.9]), 0),
        ("gelsight-like", coat_mm3([25.0, 20.0, 2.0, 4.0], [24.8, 19.8, 1.9, 3.9]), 63),
    ];
    let dot_mm3 = PI * 0.25 * 0.25 * 0.02;
    for (name, (gel, coat), dots) in cases {
        let sensor = built(name, &[]);
        let mut expected = vec![("gel", gel), ("coat", coat - f64::from(dots) * dot_mm3)];
        if name == "9dtact" {
            // Around and over the plate, which has 0.2 mm of play.
            let plate = area_mm2(28.1, 21.1, 0.5) * 2.0;
            expected.push(("bed", area_mm2(28.5, 21.5, 0.5) * 8.3 - plate));
        }
        if dots > 0 {
            expected.push(("markers", f64::from(dots) * dot_mm3));
            assert_eq!(sensor.body("markers").unwrap().shells.unwrap().pieces, dots as usize);
        }
        assert_eq!(sensor.layers().count(), expected.len(), "{name}");
        for (layer, expected_mm3) in expected {
            let volume = ray_volume(&compiled(&sensor, layer), 400_000).unwrap();
            let off = (volume.value_mm3 - expected_mm3).abs();
            assert!(off < volume.error_mm3, "{name} {layer}: {volume:?}, expected {expected_mm3}");
            assert!(volume.error_mm3 < 0.02 * expected_mm3, "{name} {layer}: {volume:?}");
        }
    }
}

/// Distance of neighbouring pixels in the middle of a plane at `z`, mm, for an equidistant lens.
fn pitch_mm(sensor: &Sensor, z: f64) -> f64 {
    let camera = &sensor.camera;
    let diagonal_px = f64::from(camera.width_px).hypot(f64::from(camera.height_px));
    let rad_per_px = camera.field_of_view.rad() / diagonal_px;
    (z - camera.sensor_from_camera.translation_mm().z) * rad_per_px.tan()
}

#[test]
fn a_pixel_of_9dtact_is_as_wide_as_its_authors_calibrated() {
    let sensor = built("9dtact", &[]);
    assert_eq!([sensor.camera.width_px, sensor.camera.height_px], [640, 480]);
    let top_z = sensor.touch.as_ref().unwrap().apex_z_mm();
    for z in [top_z - 0.3, top_z] {
        let found = pitch_mm(&sensor, z);
        assert!((found / 0.050 - 1.0).abs() < 0.02, "{found} mm at {z} mm");
    }
}

/// From the camera to a point under the coat, bent at the plate (Fermat: bisection for the slope in air).
fn way_in_air(sensor: &Sensor, to: Point3<f64>) -> (Ray, f64) {
    let pupil_z = sensor.camera.sensor_from_camera.translation_mm().z;
    let plate_z = compiled(sensor, "plate").bounds().min.z;
    let (air, inside, out) = (plate_z - pupil_z, to.z - plate_z, to.x.hypot(to.y));
    // Acrylic all the way: gel bends less.
    let n = 1.49_f64;
    let reach = |slope: f64| {
        let sin = slope / slope.hypot(1.0) / n;
        air * slope + inside * sin / (1.0 - sin * sin).sqrt()
    };
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..80 {
        let middle = (low + high) / 2.0;
        if reach(middle) < out { low = middle } else { high = middle }
    }
    let across = Vector3::new(to.x, to.y, 0.0) / out.max(1e-12);
    let direction = (Vector3::z() + low * across).normalize();
    (Ray { origin: Point3::new(0.0, 0.0, pupil_z), direction }, air / direction.z)
}

#[test]
fn the_camera_sees_every_marker_past_ledge_and_leds() {
    let sensor = built("gelsight-like", &[]);
    let camera = &sensor.camera;
    let seen_z = compiled(&sensor, "gel").bounds().max.z;
    let stencil = sensor.body("marker-stencil").unwrap();
    assert_eq!(stencil.genus, Some(63));
    let in_the_way: Vec<CompiledSolid> = sensor
        .bodies
        .iter()
        .filter(|body| ["shell", "led"].contains(&body.name.as_str()))
        .flat_map(|body| {
            let used = body.placements.iter().filter(|p| p.assembly == Assembly::sensor());
            used.map(|place| {
                CompiledSolid::new(&body.solid.clone().placed(place.assembly_from_body)).unwrap()
            })
        })
        .collect();
    assert_eq!(in_the_way.len(), 1 + 18);
    let rad_per_px =
        camera.field_of_view.rad() / f64::from(camera.width_px).hypot(f64::from(camera.height_px));
    let mut seen = 0;
    for (column, row) in (0..9).flat_map(|c| (0..7).map(move |r| (c, r))) {
        // The outermost point of the dot.
        let middle = [1.8 * (f64::from(column) - 4.0), 1.8 * (f64::from(row) - 3.0)];
        let scale = 1.0 + 0.25 / f64::hypot(middle[0], middle[1]).max(1e-9);
        let scale = if scale.is_finite() && scale < 2.0 { scale } else { 1.0 };
        let (ray, until) =
            way_in_air(&sensor, Point3::new(scale * middle[0], scale * middle[1], seen_z));
        let blocked = in_the_way.iter().any(|b| b.crossings(&ray).iter().any(|c| c.t < until));
        assert!(!blocked, "dot {column}, {row}");
        let off_axis = ray.direction.z.acos();
        let across = ray.direction.xy().norm().max(1e-12);
        let [x, y] = [ray.direction.x, ray.direction.y].map(|d| off_axis * d.abs() / across);
        assert!(x / rad_per_px < 320.0 && y / rad_per_px < 240.0, "dot {column}, {row}");
        seen += 1;
    }
    assert_eq!(seen, 63);
}

#[test]
fn another_pad_takes_its_housing_with_it() {
    let design = load("mine.yaml", OTHER_PAD, &[], &["fixtures"]).unwrap();
    let sensor = &design.sensor;
    assert_near(size_mm(sensor, "coat"), [20.0, 25.0, 3.0], 1e-9, "coat");
    // As around the original: 0.7 mm of rim; plate and gel follow.
    let shell = size_mm(sensor, "shell");
    assert_near([shell[0], shell[1], 0.0], [21.4, 26.4, 0.0], 1e-9, "shell");
    assert_near(size_mm(sensor, "plate"), [17.0, 22.0, 2.0], 1e-9, "plate");
    assert_near(size_mm(sensor, "mold-coat"), [20.0 + 18.4, 25.0 + 18.4, 3.0], 1e-9, "frame");
    // The image's long side turns with the pad's.
    let right = sensor.camera.sensor_from_camera.vector(Vector3::x());
    assert!((right.y.abs() - 1.0).abs() < 1e-12, "{right:?}");
    let seen_z = compiled(sensor, "gel").bounds().max.z;
    assert!((pitch_mm(sensor, seen_z) / 0.050 - 1.0).abs() < 1e-4);
}

/// Bounds of lengths from 8 to 120 mm: whatever loads has only valid solids, at other proportions too.
#[test]
fn pads_of_other_proportions_are_built_or_refused() {
    let mut counts = [0, 0];
    for name in sensors() {
        for [length, width] in [[8, 8], [14, 40], [18, 18], [40, 18], [60, 60], [120, 90]] {
            let pad = [format!("pad.length={length}mm"), format!("pad.width={width}mm")];
            match try_load(name, &[&pad[0], &pad[1]]) {
                Ok(design) => {
                    for body in design.sensor.bodies.iter().filter(|b| b.kind != BodyKind::Bought) {
                        body.solid.validate().unwrap_or_else(|e| panic!("{name} {pad:?}: {e}"));
                    }
                    counts[0] += 1;
                }
                Err(error) => {
                    assert!(error.problems.iter().all(|p| p.hint.is_some()), "{error:#?}");
                    counts[1] += 1;
                }
            }
        }
    }
    println!("{counts:?} built and refused");
    assert!(counts[0] >= 6 && counts[1] >= 3, "{counts:?}");
}

/// Each refusal: sensor, overrides, the path it is reported at, and what the message must name.
#[test]
fn what_cannot_be_built_is_refused_with_limit_and_remedy() {
    let cases: &[(&str, &str, &str, &str)] = &[
        ("9dtact", "pad.material=Jelly", "pad.material", "mix"),
        ("9dtact", "coat.thickness=2mm", "coat.thickness", "gel"),
        ("9dtact", "pad.corner=0.5mm", "pad.corner", "round"),
        ("9dtact", "pad.corner=8mm", "pad.corner", "straight"),
        ("9dtact", "bed.thickness=0.5mm", "bed.thickness", "level"),
        ("9dtact", "plate.overlap=10mm", "plate.overlap", "past the ledge"),
        ("9dtact", "plate.overlap=0.9mm", "plate.overlap", "joint"),
        ("9dtact", "pad.length=9mm pad.width=9mm", "camera.board_size", "overhang"),
        (
            "9dtact",
            "pad.width=18mm camera.holder_size=8.8mm camera.screw_spacing=12.2mm \
             camera.board_size=15mm",
            "pad.width",
            "holder",
        ),
        ("9dtact", "bed.thickness=12mm", "camera.pixel_pitch", "touch"),
        ("9dtact", "camera.lens_height=4mm", "camera.lens_height", "heads"),
        ("9dtact", "camera.back_clearance=1.2mm", "camera.back_clearance", "lip"),
        (
            "9dtact",
            "camera.screw_spacing=9mm camera.holder_size=8mm",
            "camera.screw_spacing",
            "heads",
        ),
        (
            "9dtact",
            "camera.screw_spacing=13mm camera.board_size=15mm",
            "camera.screw_spacing",
            "board",
        ),
        ("9dtact", "base.thickness=2.4mm", "base.thickness", "sunk"),
        ("9dtact", "base.thickness=1mm", "camera.back_clearance", "end inside"),
        ("9dtact", "shell.corner=4mm", "shell.corner", "heads"),
        ("9dtact", "shell.cable_height=15mm", "shell.cable_height", "wall"),
        ("9dtact", "shell.cable_width=28mm", "shell.cable_width", "screws"),
        ("9dtact", "leds.count=10", "leds.pitch", "row"),
        ("9dtact", "mold.floor=5mm", "mold.floor", "socket"),
        ("9dtact", "mold.pry_depth=6mm mold.dowel_diameter=2mm", "mold.pry_depth", "cavity"),
        ("9dtact", "mold.dowel_length=4mm pad.thickness=5mm", "mold.dowel_length", "socket"),
        ("digit-like", "pad.thickness=1.2mm", "pad.thickness", "dowels"),
        ("digit-like", "leds.count=5", "leds.count", "4 walls"),
        ("digit-like", "leds.pitch=20mm", "leds.pitch", "straight"),
        ("digit-like", "leds.package_height=4mm", "leds.package_height", "neighbouring"),
        ("digit-like", "leds.below_plate=9mm", "leds.below_plate", "heads"),
        (
            "gelsight-like",
            "markers.columns=14 markers.spacing=1.8mm",
            "markers.columns",
            "camera sees",
        ),
        ("gelsight-like", "markers.rows=9 markers.spacing=1.8mm", "markers.rows", "camera sees"),
        ("gelsight-like", "markers.diameter=1.7mm", "markers.diameter", "stencil"),
        ("gelsight-like", "markers.thickness=0.08mm", "markers.thickness", "ink"),
    ];
    let mut missed = Vec::new();
    for (name, settings, path, word) in cases {
        let settings: Vec<&str> = settings.split(' ').collect();
        let problems = try_load(name, &settings).err().map_or(vec![], |e| e.problems);
        let as_expected = problems
            .iter()
            .any(|p| p.path == *path && p.message.contains(word) && p.hint.is_some());
        if !as_expected {
            missed.push(format!("{name} {settings:?} at {path}: {problems:#?}"));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
