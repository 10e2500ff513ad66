//! R-Tac0 can be built by hands: its dome is held, wires have a way out, molds have no seam over the tip,
//! every tool is there. Each figure is measured on the drawn bodies, and each has a design that lacks it.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_designs::{Design, builtin_yaml, load};
use fabkit_geometry::{Action, CompiledSolid, Point3, Ray, Sensor, Vector3};
use fabkit_tests::find_findings;

fn design(sensor: &str, settings: &[&str]) -> Design {
    let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
    load(sensor, builtin_yaml(sensor).unwrap(), &settings, &["fixtures"])
        .unwrap_or_else(|error| panic!("{sensor} {settings:?}: {:#?}", error.problems))
}

fn rtac0(settings: &[&str]) -> Sensor {
    design("rtac0", settings).sensor
}

/// A body where it stands in the sensor.
fn body(sensor: &Sensor, name: &str) -> CompiledSolid {
    let body = sensor.body(name).unwrap_or_else(|| panic!("no {name}"));
    let place = body.placements.iter().find(|place| place.assembly.0 == "sensor").unwrap();
    CompiledSolid::new(&body.solid.clone().placed(place.assembly_from_body)).unwrap()
}

/// Lines of a direction through all of a body, and the area that each stands for, mm2.
fn lines(solid: &CompiledSolid, axis: usize) -> (Vec<Ray>, f64) {
    const STEP_MM: f64 = 0.15;
    let (low, high) = (solid.bounds().min, solid.bounds().max);
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let count = |i: usize| ((high[i] - low[i]) / STEP_MM).ceil() as usize;
    let mut rays = Vec::new();
    for i in 0..count(u) {
        for j in 0..count(v) {
            let mut origin = Point3::origin();
            (origin[u], origin[v], origin[axis]) = (
                low[u] + (i as f64 + 0.483) * STEP_MM,
                low[v] + (j as f64 + 0.517) * STEP_MM,
                low[axis] - 1.0,
            );
            rays.push(Ray { origin, direction: Vector3::ith(axis, 1.0) });
        }
    }
    (rays, STEP_MM * STEP_MM)
}

/// How much of a body's surface lies on another one, mm2: each piece is measured along the axis that it
/// faces most.
fn contact_mm2(of: &CompiledSolid, on: &CompiledSolid) -> f64 {
    let mut area = 0.0;
    for axis in 0..3 {
        let (rays, cell) = lines(of, axis);
        for ray in &rays {
            for crossing in of.crossings(ray) {
                let normal = crossing.normal;
                let behind = ray.at(crossing.t) + 0.01 * normal;
                if normal.iamax() == axis && on.contains(&behind) {
                    area += cell / normal[axis].abs();
                }
            }
        }
    }
    area
}

/// How much of a body, moved, is inside of another one, mm3.
fn overlap_mm3(of: &CompiledSolid, by: Vector3<f64>, on: &CompiledSolid) -> f64 {
    let (rays, cell) = lines(of, 2);
    let mut volume = 0.0;
    for ray in &rays {
        for piece in of.crossings(ray).chunks_exact(2) {
            const STEPS: usize = 24;
            let step = (piece[1].t - piece[0].t) / STEPS as f64;
            let at = |i: usize| ray.at(piece[0].t + (i as f64 + 0.5) * step) + by;
            let inside = (0..STEPS).filter(|i| on.contains(&at(*i))).count();
            volume += cell * step * inside as f64;
        }
    }
    volume
}

#[test]
fn the_dome_is_glued_to_its_shell_and_locked_to_it_by_shape() {
    let sensor = rtac0(&[]);
    let [gel, shell, diffuser, filling] =
        ["locking-gel", "shell", "diffuser", "filling-gel"].map(|name| body(&sensor, name));
    let areas = [&shell, &diffuser, &filling].map(|on| contact_mm2(&gel, on));
    println!("locking gel on shell, diffuser, filling gel: {areas:.0?} mm2");
    let [on_shell, on_diffuser, on_filling] = areas;
    assert!(on_shell > 400.0 && on_diffuser > 350.0 && on_filling > 260.0, "{areas:?}");
    // Pulled by 0.2 mm, whichever way, it meets the groove, the ribs, or the wall.
    for by in [Vector3::z(), -Vector3::z(), Vector3::x(), Vector3::y()] {
        let overlap = overlap_mm3(&gel, 0.2 * by, &shell);
        println!("moved by 0.2 mm along {by:?}: {overlap:.2} mm3 of the shell in its way");
        assert!(overlap > 3.0, "{by:?}: {overlap}");
    }
    // As it was: the gel ends above the diffuser.
    let before = rtac0(&["filling_gel.lock_depth=0mm", "shell.lock_groove=0mm", "baffle.wall=0mm"]);
    assert!(before.body("locking-gel").is_none());
    assert!(contact_mm2(&body(&before, "filling-gel"), &body(&before, "shell")) < 1.0);
}

#[test]
fn wires_and_cable_leave_by_the_side() {
    let sensor = rtac0(&[]);
    let names = ["base", "shell", "camera", "camera-cable", "led-wire", "led-board"];
    let [base, shell, camera, cable, wire, board] = names.map(|name| body(&sensor, name));
    assert_eq!(sensor.body("led-wire").unwrap().placements.len(), 2);
    // A wire begins under the LED board and ends outside of the shell; so does the cable.
    assert!((wire.bounds().max.z - board.bounds().min.z).abs() < 1e-6);
    for out in [&wire, &cable] {
        assert!(out.bounds().min.y < shell.bounds().min.y - 10.0);
        for what in [&base, &shell, &camera, &board] {
            assert_eq!(overlap_mm3(out, Vector3::zeros(), what), 0.0);
        }
    }
    // The face that is mounted has no hole for them: what lies on it closes nothing.
    let bottom = shell.bounds().min.z;
    for y in [-3.0, -6.0, -9.0, 0.0, 3.0] {
        assert!(base.contains(&Point3::new(0.0, y, bottom + 0.2)), "{y}");
    }
    assert!(cable.bounds().min.z > bottom + 1.0);
    // As it was, it leaves through that face, and no wire is drawn.
    let before = rtac0(&["base.cable_exit=floor"]);
    assert!(before.body("led-wire").is_none());
    assert!(!body(&before, "base").contains(&Point3::new(0.0, 0.0, bottom + 0.2)));
}

/// What is set, and which parameter is named.
const REFUSED: [(&[&str], &str); 14] = [
    (&["base.exit_angle=-60deg"], "base.exit_angle"),
    (&["base.exit_angle=-45deg"], "base.exit_angle"),
    (&["base.exit_angle=0deg"], "base.exit_angle"),
    (&["cables.diameter=4.5mm"], "cables.diameter"),
    (&["cables.wire_bend=0.8mm"], "cables.wire_bend"),
    (&["cables.wire_bend=4mm"], "cables.wire_bend"),
    (&["filling_gel.lock_depth=4.5mm"], "filling_gel.lock_depth"),
    (&["filling_gel.lock_depth=1mm", "shell.lock_groove=0.5mm"], "filling_gel.lock_depth"),
    (&["shell.lock_groove=1.2mm"], "shell.lock_groove"),
    (&["shell.rib_depth=0.6mm", "filling_gel.lock_depth=3mm"], "shell.rib_depth"),
    (&["baffle.wall=0.4mm"], "baffle.wall"),
    (&["baffle.wall=3mm"], "led_board.bore_radius"),
    (
        &["camera.board_size=38mm", "form.silicone=10mm", "camera.screw_spacing=34mm"],
        "form.silicone",
    ),
    (&["molds.route=printed", "mold.width=49mm", "shell.outer_diameter=44mm"], "mold.width"),
];

#[test]
fn what_leaves_no_room_is_refused_by_name() {
    for (settings, path) in REFUSED {
        let set: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
        let loaded = load("rtac0", builtin_yaml("rtac0").unwrap(), &set, &["fixtures"]);
        let error = loaded.err().unwrap_or_else(|| panic!("{settings:?} is made"));
        let problem = error.problems.iter().find(|problem| problem.path == path);
        let problem = problem.unwrap_or_else(|| panic!("{settings:?}: {:#?}", error.problems));
        assert!(problem.hint.is_some(), "{settings:?}");
    }
}

fn findings(sensor: &Sensor) -> Vec<Finding> {
    fabkit_tests::check(sensor).unwrap().findings
}

fn grave(sensor: &Sensor) -> Vec<Finding> {
    let is_grave = |found: &Finding| {
        // Walls beside melted inserts and below countersinks are thinner than two lines of filament, as the paper has them.
        let is_thin_wall = found.rule == Rule::Printability && found.severity == Severity::Warning;
        found.severity != Severity::Note && !is_thin_wall
    };
    findings(sensor).into_iter().filter(is_grave).collect()
}

/// Boards of 25 and 38 mm, with the holes that theirs have.
#[test]
fn larger_cameras_make_the_sensor_wider() {
    for (board, screws) in [("25mm", "21mm"), ("38mm", "34mm")] {
        let set = [
            format!("camera.board_size={board}"),
            format!("camera.screw_spacing={screws}"),
            format!("camera.screw_spacing_y={screws}"),
        ];
        let sensor = rtac0(&set.each_ref().map(String::as_str));
        let found = grave(&sensor);
        assert!(found.is_empty(), "{board}: {found:#?}");
        println!("{board}: shell {:.1} mm", 2.0 * body(&sensor, "shell").bounds().max.x);
    }
}

#[test]
fn a_seam_over_the_tip_is_found() {
    let of = |sensor: &str, settings: &[&str]| {
        find_findings(&design(sensor, settings).sensor, &[Rule::Parting]).unwrap()
    };
    assert_eq!(of("rtac0", &[]), []);
    let halves = ["mold-translucent-gel-a", "mold-translucent-gel-b"];
    for (sensor, settings) in [
        ("rtac0", &["molds.route=printed"][..]),
        ("rtac0", &["molds.route=printed", "coat.method=dip"]),
        ("rtac0-published-2025", &[]),
    ] {
        let found = of(sensor, settings);
        let [seam] = &found[..] else { panic!("{sensor} {settings:?}: {found:#?}") };
        assert!(halves.iter().all(|half| seam.bodies.iter().any(|body| body == half)), "{seam:#?}");
        assert!(seam.place.unwrap().z > 20.0, "{seam:#?}");
    }
}

/// What one route needs, the other one does not list.
#[test]
fn each_route_has_its_own_tools() {
    let routes = ["silicone", "printed"].map(|route| {
        let sensor = rtac0(&[&format!("molds.route={route}")]);
        assert_eq!(grave(&sensor), [], "{route}");
        sensor
    });
    let [silicone, printed] = &routes;
    for name in [
        "form-cup",
        "form-bridge-transparent-gel",
        "form-bridge-translucent-gel",
        "form-tube-transparent-gel",
        "form-tube-translucent-gel",
        "silicone-mold-transparent-gel",
        "silicone-mold-translucent-gel",
    ] {
        assert!(silicone.body(name).is_some() && printed.body(name).is_none(), "{name}");
    }
    for name in ["mold-transparent-gel-a", "mold-translucent-gel-b", "dowel"] {
        assert!(silicone.body(name).is_none() && printed.body(name).is_some(), "{name}");
    }
    // What a silicone mold is cast for is a wall of a pour of a later step.
    for (mold, gel) in [
        ("silicone-mold-transparent-gel", "transparent-gel"),
        ("silicone-mold-translucent-gel", "translucent-gel"),
    ] {
        let pour = silicone.chain.iter().find_map(|step| match &step.action {
            Action::Pour(pour) if pour.layer == gel => Some(pour),
            _ => None,
        });
        assert!(pour.unwrap().walls.iter().any(|wall| wall == mold), "{gel}");
    }
}

/// A step that goes on with what is wet follows one that does not wait for a cure.
#[test]
fn steps_follow_each_other() {
    for settings in [&[][..], &["molds.route=printed"], &["coat.method=dip"]] {
        let sensor = rtac0(settings);
        assert_eq!(grave(&sensor), [], "{settings:?}");
        for pair in sensor.chain.windows(2) {
            let hours = match &pair[0].action {
                Action::Pour(pour) => pour.cure.hours,
                Action::Spray(spray) => spray.cure.hours,
                Action::Bond(cure) => cure.hours,
                _ => continue,
            };
            let says = &pair[1].instruction;
            let is_wet =
                says.contains(" wet ") || says.contains("is wet") || says.contains("at once");
            // What is done meanwhile has wet paper of its own.
            let is_meanwhile = pair[1].during_cure_of.is_some();
            assert!(!is_wet || is_meanwhile || hours == 0.0, "{}: {says}", pair[1].name);
        }
        let at = |name: &str| sensor.chain.iter().position(|step| step.name == name);
        assert!(at("mount-leds") < at("focus") && at("focus") < at("close"));
        assert!(at("cut-tube").unwrap() < at("pour-transparent-gel").unwrap());
        assert_eq!(at("dip-coat").is_some(), settings.contains(&"coat.method=dip"));
        assert_eq!(at("dip-coat").is_some(), at("spray-coat").is_none());
    }
}

#[test]
fn the_jig_shows_where_the_tube_is_cut() {
    let sensor = rtac0(&[]);
    let solid = |name: &str| CompiledSolid::new(&sensor.body(name).unwrap().solid).unwrap();
    let (jig, tube) = (solid("tube-jig"), solid("tube"));
    let axis = Ray { origin: Point3::new(0.0, 0.0, -5.0), direction: Vector3::z() };
    let floor = axis.at(jig.crossings(&axis)[0].t).z;
    let rim = jig.bounds().min.z;
    let length = tube.bounds().max.z - tube.bounds().min.z;
    assert!((floor - rim - length).abs() < 1e-9, "{floor} {rim} {length}");
    assert!((length - 18.0).abs() < 1e-9, "{length}");
}

#[test]
fn nothing_printed_hangs_over_and_the_mount_holds_brass() {
    let sensor = rtac0(&[]);
    assert_eq!(find_findings(&sensor, &[Rule::Overhang]).unwrap(), []);
    let inserts = sensor.body("insert-m3").unwrap();
    assert_eq!(inserts.quantity, 3);
    assert!(inserts.summary.contains("4 mm long"), "{}", inserts.summary);
}

/// The cosine to the axis of each LED's mirror image that the camera sees in the gel's flat face.
fn mirrored(sensor: &Sensor, face_z: f64) -> Vec<f64> {
    let pupil = sensor.camera.sensor_from_camera.point(Point3::origin());
    let opaque = ["baffle", "shell", "led-board", "camera"];
    let opaque: Vec<CompiledSolid> =
        opaque.iter().filter(|name| sensor.body(name).is_some()).map(|n| body(sensor, n)).collect();
    let leds = &sensor.body("led").unwrap().placements;
    let top = body(sensor, "led").bounds().max.z;
    let seen = leds.iter().filter_map(|place| {
        let at = place.assembly_from_body.translation_mm();
        let led = Point3::new(at.x, at.y, top + 0.01);
        let image = Point3::new(led.x, led.y, 2.0 * face_z - led.z);
        let look = (image - pupil).normalize();
        let met = pupil + look * ((face_z - pupil.z) / look.z);
        let way = met - led;
        let ray = Ray { origin: led, direction: way.normalize() };
        let is_hidden = opaque
            .iter()
            .any(|body| body.crossings(&ray).iter().any(|hit| hit.t > 0.0 && hit.t < way.norm()));
        (!is_hidden).then_some(look.z)
    });
    seen.collect()
}

#[test]
fn the_baffle_hides_the_mirror_images_of_all_leds() {
    assert!(mirrored(&rtac0(&[]), -5.0).is_empty());
    // As it was: all eight, 33 degrees from the axis.
    let before = rtac0(&["baffle.wall=0mm", "filling_gel.lock_depth=0mm", "shell.lock_groove=0mm"]);
    let seen = mirrored(&before, 0.0);
    assert_eq!(seen.len(), 8);
    assert!(seen.iter().all(|cos| (cos.acos().to_degrees() - 33.0).abs() < 0.5), "{seen:?}");
}
