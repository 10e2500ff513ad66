//! Fits follow the process of the part that has the hole, in every family, and limits follow them.

use fabkit_designs::parameters::InvalidDesign;
use fabkit_designs::{Design, Fit, builtin_yaml, gap_mm, load};
use fabkit_geometry::{
    Aabb, CompiledSolid, Point3, Pose, Process, Process::Fdm, Process::Laser, Process::PolyJet,
    Process::Sla, Ray, Solid, Vector3,
};

/// With parts made otherwise (`shell=sla base=sla`), and parameters set.
fn read(sensor: &str, parts: &str, set: &[&str]) -> Result<Design, InvalidDesign> {
    let parts = parts.split_whitespace().map(|given| {
        let (pattern, process) = given.split_once('=').unwrap();
        format!("parts.{pattern}.process={process}")
    });
    // Light needs a little more room where a printer is coarse.
    let roomy = (sensor == "uvdtact").then_some(&"holder.outer_diameter=18.6 mm");
    // Who dips has a container with a holder.
    let dipped = (sensor == "rtac0").then_some(&"coat.method=dip");
    let set = set.iter().chain(roomy).chain(dipped).map(|text| (*text).into());
    let set: Vec<String> = parts.chain(set).collect();
    load(sensor, builtin_yaml(sensor).unwrap(), &set, &["fixtures"])
}

fn design(sensor: &str, parts: &str) -> Design {
    read(sensor, parts, &[]).unwrap_or_else(|e| panic!("{sensor} {parts:?}: {:#?}", e.problems))
}

fn body(design: &Design, name: &str) -> CompiledSolid {
    CompiledSolid::new(&design.sensor.body(name).unwrap().solid).unwrap()
}

/// Where it sits in the sensor; what is not part of the sensor, such as a mold, as it is drawn.
fn in_place(design: &Design, name: &str) -> CompiledSolid {
    let body = design.sensor.body(name).unwrap();
    let place = body.placements.iter().find(|place| place.assembly.0 == "sensor");
    let pose = place.map_or(Pose::identity(), |place| place.assembly_from_body);
    CompiledSolid::new(&body.solid.clone().placed(pose)).unwrap()
}

/// Least play of a body in a hole of another, mm: on lines from the axis, at a height above a body's
/// bottom or, below zero, above its top.
fn play_mm(design: &Design, inner: &str, outer: &str, (at, above_mm): (&str, f64)) -> f64 {
    let Aabb { min, max } = in_place(design, at).bounds();
    let z = if above_mm < 0.0 { max.z } else { min.z } + above_mm;
    let [inner, outer] = [inner, outer].map(|name| in_place(design, name));
    let plays = (0..24).filter_map(|i| {
        let (sin, cos) = f64::from(15 * i).to_radians().sin_cos();
        let ray = Ray { origin: Point3::new(0.0, 0.0, z), direction: Vector3::new(cos, sin, 0.0) };
        let out = inner.crossings(&ray).last()?.t;
        // Further in may be more of the other body, such as a dome on its plate.
        outer.crossings(&ray).iter().map(|crossing| crossing.t - out).find(|play| *play > -0.1)
    });
    plays.fold(f64::INFINITY, f64::min)
}

/// A fit of the table: as usual, and where parts are made otherwise.
#[track_caller]
fn fits(
    sensor: &str,
    [inner, outer]: [&str; 2],
    at: (&str, f64),
    fit: Fit,
    (usual, parts, other): (Process, &str, Process),
) {
    for (parts, process) in [("", usual), (parts, other)] {
        let play = play_mm(&design(sensor, parts), inner, outer, at);
        let gap = gap_mm(process, fit);
        assert!((play - gap).abs() < 1e-9, "{inner} in {outer}, {parts:?}: {play} and not {gap}");
    }
}

/// How far a limit of the first parameter that is set moves, mm, where parts are made otherwise.
#[track_caller]
fn limit_moves(sensor: &str, set: &[&str], parts: &str, by_mm: f64) {
    let (path, _) = set[0].split_once('=').unwrap();
    let limit = |parts| -> f64 {
        let found = read(sensor, parts, set).unwrap_err().problems;
        let problem = found.iter().find(|problem| problem.path == path);
        let facts = &problem.unwrap_or_else(|| panic!("{found:#?}")).facts;
        let limit = facts.at_least.as_ref().or(facts.at_most.as_ref()).unwrap();
        limit.trim_end_matches(" mm").parse().unwrap()
    };
    let moved = limit(parts) - limit("");
    assert!((moved - by_mm).abs() < 2e-3, "{path}, {parts:?}: {moved} and not {by_mm}");
}

#[test]
fn of_domes() {
    let to_sla = |part| (Fdm, part, Sla);
    fits("rtac0", ["base", "shell"], ("base", 0.5), Fit::Slide, to_sla("shell=sla"));
    fits("rtac0", ["led-board", "shell"], ("led-board", 0.5), Fit::Press, to_sla("shell=sla"));
    fits("rtac0", ["shell", "collar"], ("collar", 0.5), Fit::Slide, to_sla("collar=sla"));
    let [lid, lids] = ["lid-transparent-gel", "lid-*=sla"];
    fits("rtac0", ["connector", lid], (lid, 0.5), Fit::Slide, to_sla(lids));
    fits("rtac0", ["connector", "tube"], ("tube", 0.3), Fit::Slide, to_sla("connector=sla"));
    let [holder, container] = ["coating-holder", "coating-container"];
    let given = to_sla("coating-container=sla");
    fits("rtac0", [holder, container], (container, 0.5), Fit::Slide, given);
    let [tube, bridge] = ["form-tube-transparent-gel", "form-bridge-transparent-gel"];
    fits("rtac0", [tube, bridge], (bridge, 0.5), Fit::Slide, to_sla("form-bridge-*=sla"));
    // What has no such hole moves nothing.
    let plain = play_mm(&design("rtac0", "base=sla"), "base", "shell", ("base", 0.5));
    assert!((plain - gap_mm(Fdm, Fit::Slide)).abs() < 1e-9);

    let press = |design: &Design| {
        let fits = &design.sensor.press_fits;
        fits.iter().find(|fit| fit.inner == "led-board").unwrap().interference_mm
    };
    assert_eq!(press(&design("rtac0", "shell=sla")), -gap_mm(Sla, Fit::Press));
    limit_moves("rtac0", &["coating.gap=1 mm"], "coating-container=sla", -0.1);
    limit_moves("rtac0", &["tube.wall=0.4 mm"], "coating-holder=sla", -0.15);
    limit_moves("rtac0", &["tube.wall=0.4 mm"], "connector=sla", 0.1);
}

#[test]
fn of_caps() {
    let given = (Fdm, "holder=sla", Sla);
    fits("shadowtac", ["plate", "holder"], ("plate", 0.5), Fit::Slide, given);
    // One pocket in both pieces.
    let camera =
        |parts: &str| play_mm(&design("shadowtac", parts), "camera", "holder", ("holder", 0.5));
    for (parts, process) in [("base=sla", Fdm), ("base=sla holder=sla", Sla)] {
        assert!((camera(parts) - gap_mm(process, Fit::Slide)).abs() < 1e-9, "{parts:?}");
    }
    limit_moves(
        "shadowtac",
        &["holder.screw_spacing=36 mm", "holder.width=37 mm"],
        "base=sla",
        0.1,
    );
    limit_moves(
        "shadowtac",
        &["mold.diameter=48 mm", "mold.bolt_circle=47 mm"],
        "mold-skin-block=fdm",
        0.2 / 0.75f64.sqrt(),
    );
}

#[test]
fn of_half_ellipsoids() {
    let to_fdm = |part| (Sla, part, Fdm);
    let [holder, post, ring] = ["shell-holder", "camera-holder", "diffusion-ring"];
    let given = to_fdm("shell-holder=fdm");
    fits("uvdtact", ["base", holder], (holder, 0.3), Fit::Slide, given);
    fits("uvdtact", [ring, holder], (ring, -0.2), Fit::Free, given);
    fits("uvdtact", ["shell", holder], (holder, -0.5), Fit::Snug, given);
    fits("uvdtact", [post, "base"], (post, 0.2), Fit::Snug, to_fdm("base=fdm"));
    fits("uvdtact", ["camera", post], (post, -0.2), Fit::Snug, to_fdm("camera-holder=fdm"));
    fits("uvdtact", [post, ring], (ring, -0.2), Fit::Free, to_fdm("diffusion-ring=fdm"));
    let [sleeve, negative] = ["casting-sleeve", "negative-cup-inner"];
    fits("uvdtact", [sleeve, negative], (sleeve, 0.5), Fit::Slide, to_fdm("negative-*=fdm"));
    limit_moves("uvdtact", &["holder.skirt=6 mm"], "shell-holder=fdm", -0.05);
}

#[test]
fn of_pin_tips() {
    let to_sla = (Fdm, "body=sla", Sla);
    fits("tactip", ["robot-mount", "body"], ("body", 0.5), Fit::Slide, to_sla);
    fits("tactip", ["led-board", "body"], ("led-board", 0.5), Fit::Press, to_sla);
    // The ring is jetted, the body printed: the larger gap.
    let at = ("ring", 0.5);
    fits("tactip", ["body", "ring"], at, Fit::Slide, (Fdm, "body=sla", PolyJet));
    let printed = "skin=fdm dots=fdm ring=fdm";
    fits("tactip", ["lens", "ring"], ("lens", 0.5), Fit::Slide, (Laser, printed, Fdm));
    limit_moves("tactip", &["lens.ledge=0.3 mm"], printed, 0.1);
}

#[test]
fn of_sheet_molds() {
    let (plain, given) = (design("fluidic", ""), design("fluidic", "box-floor=fdm"));
    let grown = gap_mm(Fdm, Fit::Slide) - gap_mm(Laser, Fit::Slide);
    let place = |name: &str| {
        let place = &plain.sensor.body(name).unwrap().placements[0];
        *place.assembly_from_body.translation_mm()
    };
    // Half of a bolt and half of a sheet are 1.5 mm: to the edges of the holes for either.
    let (bolt, wall) = (place("box-spacer"), place("box-wall-cable").x);
    for at in [[bolt.x, bolt.y], [wall + 1.5, wall / 2.0]] {
        let play_mm = |design: &Design, name: &str| {
            let origin = Point3::new(at[0], at[1], 1.5);
            let ray = Ray { origin, direction: Vector3::x() };
            let crossings = body(design, name).crossings(&ray);
            crossings.iter().map(|c| c.t).find(|t| *t > 0.0).unwrap() - 1.5
        };
        for (name, grown) in [("box-floor", grown), ("box-ceiling", 0.0)] {
            let [old, new] = [&plain, &given].map(|design| play_mm(design, name));
            assert!((old - gap_mm(Laser, Fit::Slide)).abs() < 1e-9, "{name}: {old}");
            assert!((new - old - grown).abs() < 1e-9, "{name}: {old} {new}");
        }
    }
    limit_moves(
        "fluidic",
        &["plate.side=100 mm", "plate.bolt_spacing=90 mm"],
        "box-floor=fdm",
        2.0 * grown,
    );
}

#[test]
fn of_flat_gels() {
    let given = (Fdm, "shell=sla", Sla);
    fits("9dtact", ["plate", "shell"], ("plate", 0.5), Fit::Slide, given);
    fits("9dtact", ["base", "shell"], ("shell", 0.7), Fit::Slide, given);
    limit_moves("9dtact", &["plate.overlap=0.2 mm"], "shell=sla", -0.1);

    // Both frames stand on the same dowels: the larger gap.
    let dowel_mm = |design: &Design, name: &str, feature: &str| {
        let radius = body(design, name).leaves().iter().find_map(|leaf| match &leaf.primitive {
            Solid::Cylinder(hole) if leaf.feature == feature => Some(hole.radius_mm),
            _ => None,
        });
        radius.unwrap()
    };
    let (plain, given) = (design("9dtact", ""), design("9dtact", "mold-coat=fdm"));
    for (name, feature, grown) in [
        ("mold-gel", "dowel hole 1", 0.1),
        ("mold-coat", "dowel hole 1", 0.1),
        ("mold-floor", "socket 1", 0.0),
    ] {
        let [old, new] = [&plain, &given].map(|design| dowel_mm(design, name, feature));
        assert!((new - old - grown).abs() < 1e-9, "{name}: {old} {new}");
    }
    let floor = design("9dtact", "mold-floor=fdm");
    let press = floor.sensor.press_fits.iter().find(|fit| fit.inner == "dowel").unwrap();
    assert_eq!(press.interference_mm, -gap_mm(Fdm, Fit::Press));
}
