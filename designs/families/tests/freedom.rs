//! What families can do besides what the built-in sensors ask of them; by default they do nothing of it.

use fabkit_designs::{Design, builtin_names, builtin_yaml, load};
use fabkit_geometry::{Body, CompiledSolid, Point3};

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

/// Where the holes for mounting open, mm.
fn mounts(design: &Design) -> Vec<[f64; 2]> {
    let base = body(design, "base").landmarks.iter();
    let holes = base.filter(|mark| {
        // Nuts of the dome's other joint look sideways.
        (mark.name.starts_with("mounting hole") || mark.name.starts_with("nut"))
            && mark.axis.z < -0.5
    });
    holes.map(|mark| [mark.point.x, mark.point.y]).collect()
}

fn same(found: &[[f64; 2]], expected: &[[f64; 2]]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        assert!(off < 1e-9, "{found:?}, not {expected:?}");
    }
}

#[test]
fn what_families_do_by_default_is_marked_as_such() {
    for sensor in builtin_names() {
        let design = made(sensor, &[]);
        let setting = |path: &str| design.parameters.iter().find(|s| s.path == path);
        assert!(setting("labels.style").is_some_and(|s| s.is_default && s.value == "sunken"));
        let own = design.parameters.iter().filter(|setting| !setting.is_default).count();
        assert!(own > 40, "{sensor}: {own}");
    }
    let design = made("rtac0", &["mount.angle=0 deg"]);
    assert!(design.parameters.iter().any(|s| s.path == "mount.angle" && !s.is_default));
}

#[test]
fn mounting_holes_lie_as_they_are_told() {
    let [a, b] = [10.0, 4.0];
    let rectangle = [[a, b], [-a, b], [-a, -b], [a, -b]];
    let four = ["mount.pattern=rectangle", "mount.width=20mm", "mount.depth=8mm"];
    let four = [&four[..], &["mount.hold=tapped"]].concat();
    same(&mounts(&made("rtac0", &four)), &rectangle);
    let listed = [
        "mount.hold=tapped",
        "mount.pattern=list",
        "mount.x=[10mm,-10mm,4mm]",
        "mount.y=[4mm,4mm,-10mm]",
    ];
    same(&mounts(&made("rtac0", &listed)), &[[a, b], [-a, b], [b, -a]]);
    // A quarter turn in a square floor; three screws of the dome's shell leave no room for it.
    for sensor in ["shadowtac", "9dtact", "digit-like", "gelsight-like"] {
        let sets = ["mount.pattern=rectangle", "mount.width=9mm", "mount.depth=4mm"];
        let turned =
            made(sensor, &[&sets[..], &["mount.angle=180 deg", "mount.thread=M2.5"]].concat());
        same(&mounts(&turned), &[[-4.5, -2.0], [4.5, -2.0], [4.5, 2.0], [-4.5, 2.0]]);
        made(sensor, &["mount.pattern=rectangle"]);
        made(sensor, &["mount.pattern=list"]);
    }
    made("uvdtact", &["mount.pattern=rectangle"]);
    made("uvdtact", &["mount.pattern=list"]);
    made("uvdtact", &["mount.angle=1 deg"]);
}

#[test]
fn inserts_are_bought_and_pressed_in() {
    let sets = ["mount.hold=insert", "mount.thread=M3", "base.thickness=7mm"];
    let design = made("9dtact", &sets);
    let insert = body(&design, "insert-m3");
    assert_eq!((insert.quantity, insert.placements.len()), (2, 2));
    assert!(design.sensor.press_fits.iter().any(|fit| fit.inner == "insert-m3"));
    assert!(
        design.sensor.chain.iter().any(|step| step.bodies.iter().any(|name| name == "insert-m3"))
    );
    // As the nuts of the shell are, which the base holds already.
    let dome = made("rtac0", &["mount.hold=insert", "mount.thread=M2", "mount.pattern=rectangle"]);
    assert_eq!(body(&dome, "nut-m2").quantity, 3 + 4);
}

#[test]
fn mounting_holes_that_cannot_be_are_refused_with_what_to_change() {
    let four =
        ["base.mount_holes=4", "shell.screws=3", "mount.hold=tapped", "base.mount_radius=11.4mm"];
    refused("rtac0", &four, &["within 0.35 mm of a nut", "`mount.pattern: rectangle`"]);
    refused("rtac0", &["mount.hold=through"], &["stand above the holes", "`tapped` or `insert`"]);
    refused(
        "rtac0",
        &["mount.thread=M4", "mount.hold=insert"],
        &["base.height", "8.1 mm of depth"],
    );
    refused("uvdtact", &["mount.hold=insert"], &["resin", "write `tapped`"]);
    refused("uvdtact", &["mount.thread=M4"], &["3.3 mm deep", "`M2.5`"]);
    refused(
        "9dtact",
        &["mount.hold=insert"],
        &["base.thickness", "at least 5.7 mm", "`mount.thread`"],
    );
    let wide = ["mount.pattern=rectangle", "mount.width=60mm"];
    refused("9dtact", &wide, &["mount.width is 60 mm", "mounting hole 1", "`mount.depth`"]);
    let uneven = ["mount.pattern=list", "mount.x=[1mm]", "mount.y=[1mm,2mm]"];
    refused("shadowtac", &uneven, &["mount.x has 1 items and mount.y has 2"]);
    let below = ["mount.pattern=rectangle", "mount.depth=11mm"];
    refused("9dtact", &below, &["the wall to a screw of the camera lacks", "`mount.angle`"]);
    let near = ["mount.pattern=list", "mount.x=[1mm,2mm]", "mount.y=[5mm,5mm]"];
    refused("shadowtac", &near, &["holes 1 and 2", "`mount.x`"]);
    let thread = ["mount.thread=M6"];
    refused("rtac0", &thread, &["M2, M2.5, M3, M4"]);
}

#[test]
fn boards_may_be_longer_than_wide() {
    let sets = ["camera.board_size=12mm", "camera.screw_spacing=8mm", "camera.holder_size=7mm"];
    let wide =
        ["camera.board_size_y=18mm", "camera.screw_spacing_y=14mm", "camera.barrel_diameter=7mm"];
    for sensor in ["rtac0", "9dtact"] {
        let mut sets = [&sets[..], &wide].concat();
        if sensor == "rtac0" {
            // Beside the screws, which are where holes of a ring would be.
            sets.push("mount.pattern=rectangle");
        } else {
            sets.extend(["camera.screw_spacing=11mm", "camera.board_size=14mm"]);
            sets.drain(0..2);
        }
        let design = made(sensor, &sets);
        let camera = CompiledSolid::new(&body(&design, "camera").solid).unwrap().bounds();
        let size = camera.max - camera.min;
        let expected = if sensor == "rtac0" { 12.0 } else { 14.0 };
        assert!((size.x - expected).abs() < 1e-9 && (size.y - 18.0).abs() < 1e-9, "{size:?}");
    }
    let boards = [
        (
            "tactip",
            ["camera.board_size_y=36mm", "camera.screw_spacing_y=20mm"],
            [33.0, 36.0],
            [27.0, 20.0],
        ),
        (
            "fluidic",
            ["camera.board_size_y=30mm", "camera.hole_spacing_y=24mm"],
            [38.0, 30.0],
            [34.0, 24.0],
        ),
    ];
    for (sensor, sets, [x, y], holes) in boards {
        let design = made(sensor, &sets);
        let camera = CompiledSolid::new(&body(&design, "camera").solid).unwrap();
        let size = camera.bounds().max - camera.bounds().min;
        assert!((size.x - x).abs() < 1e-9 && (size.y - y).abs() < 1e-9, "{sensor}: {size:?}");
        // The board's holes are where the screws are.
        let [low, high] = [camera.bounds().min.z, camera.bounds().max.z];
        let is_met = |x: f64, y: f64| {
            let heights = (0..=400).map(|i| low + (high - low) * f64::from(i) / 400.0);
            heights.into_iter().any(|z| camera.contains(&Point3::new(x, y, z)))
        };
        let [u, v] = holes.map(|spacing| 0.5 * spacing);
        assert!(!is_met(u, v) && !is_met(-u, -v), "{sensor}");
        assert!(is_met(u, v - 4.0) && is_met(u - 4.0, v), "{sensor}");
    }
    refused("rtac0", &["camera.board_size_y=30mm"], &["camera.board_size", "corners"]);
    refused("9dtact", &["camera.screw_spacing_y=1mm"], &["camera.screw_spacing_y"]);
}

#[test]
fn cables_leave_where_they_are_told_and_edges_are_round() {
    let floor = ["base.cable_exit=floor", "base.cable_angle=90 deg", "shell.edge_fillet=1mm"];
    let turned = made("rtac0", &[&floor[..], &["labels.style=none"]].concat());
    let base = CompiledSolid::new(&body(&turned, "base").solid).unwrap();
    let bottom = base.bounds().min.z + 0.2;
    assert!(!base.contains(&Point3::new(0.0, 3.5, bottom)));
    assert!(base.contains(&Point3::new(3.5, 0.0, bottom)));
    let shell = CompiledSolid::new(&body(&turned, "shell").solid).unwrap();
    // A corner of 1 mm is left outside of a circle: 1 - 1 / sqrt(2) = 0.29 mm beside its edge.
    assert!(!shell.contains(&Point3::new(14.8, 0.0, -0.2)));
    assert!(shell.contains(&Point3::new(14.6, 0.0, -0.4)));
    refused("rtac0", &["shell.edge_fillet=1.4mm"], &["shell.edge_fillet", "at most 1.1 mm"]);
    for (side, at) in [("left", [-1.0, 0.0]), ("back", [0.0, 1.0]), ("right", [1.0, 0.0])] {
        let design = made("9dtact", &[&format!("shell.cable_side={side}")]);
        let shell = CompiledSolid::new(&body(&design, "shell").solid).unwrap();
        let bounds = shell.bounds();
        // In the middle of a wall, just inside and just above the shell's lower edge.
        let wall = |way: f64| {
            let [x, y] = [bounds.max.x - 0.3, bounds.max.y - 0.3];
            shell.contains(&Point3::new(way * at[0] * x, way * at[1] * y, bounds.min.z + 0.5))
        };
        assert!(!wall(1.0) && wall(-1.0), "{side}");
    }
}

/// A narrow tip on a wide body.
#[test]
fn the_tip_of_a_dome_may_be_narrower_than_its_shell() {
    let design = made("rtac0", &["surface.radius=11mm", "shell.shoulder=2.5mm"]);
    let width = |name: &str| {
        let bounds = CompiledSolid::new(&body(&design, name).solid).unwrap().bounds();
        bounds.max.x - bounds.min.x
    };
    assert!((width("shell") - 30.0).abs() < 1e-9 && (width("black-coat") - 22.0).abs() < 1e-9);
    // The shell covers the diffuser's edge: 13.5 mm less the shoulder, with 0.2 mm to slide.
    assert!((width("diffuser") - 21.6).abs() < 1e-9);
    let shell = CompiledSolid::new(&body(&design, "shell").solid).unwrap();
    assert!(shell.contains(&Point3::new(11.1, 0.0, -0.1)));
    assert!(!shell.contains(&Point3::new(10.9, 0.0, -0.1)));
    refused(
        "rtac0",
        &["shell.shoulder=3mm"],
        &["shell.shoulder", "the tube stands on the diffuser"],
    );
}

#[test]
fn parts_carry_text_where_they_have_room_that_nothing_touches() {
    let plain = made("9dtact", &["labels.style=none"]);
    for style in ["sunken", "raised"] {
        let design = made("9dtact", &[&format!("labels.style={style}")]);
        let labelled: Vec<&str> = design
            .derived
            .iter()
            .filter(|(name, _)| name == "labelled parts")
            .flat_map(|(_, names)| names.split(", "))
            .collect();
        assert!(labelled.contains(&"shell") && labelled.len() >= 3, "{style}: {labelled:?}");
        for body in &design.sensor.bodies {
            let before = plain.sensor.body(&body.name).unwrap();
            let is_same = format!("{:?}", body.solid) == format!("{:?}", before.solid);
            assert_eq!(is_same, !labelled.contains(&&*body.name), "{style} {}", body.name);
            assert_eq!(body.genus, before.genus);
        }
    }
    let texts = ["labels.style=sunken", "labels.text=LAB 3/7", "labels.parts=[shell]"];
    let design = made("9dtact", &texts);
    assert!(design.derived.contains(&("labelled parts".into(), "shell".into())));
    refused("9dtact", &["labels.style=sunken", "labels.parts=[shel]"], &["did you mean `shell`?"]);
    refused("9dtact", &["labels.style=sunken", "labels.parts=[plate]"], &["not a printed part"]);
    refused("9dtact", &["labels.style=sunken", "labels.text=50 %"], &["no letters for `%`"]);
    let low = ["labels.style=sunken", "labels.height=2mm"];
    refused("9dtact", &low, &["labels.height", "below 2.5 mm they cannot be read"]);
    let text = "labels.text=LAB-LAB-LAB-LAB";
    let tall = ["labels.style=raised", "labels.parts=[shell]", text, "labels.height=30mm"];
    refused("9dtact", &tall, &["no free flat face of", "`labels.height`"]);
}
