//! Parting lines: where two tools together shape a surface that is touched, their joint shows on it, as a
//! seam that is felt, wears first, and darkens the picture.
//!
//! Lines leave the sensor's middle (or, from a flat pad, its face) and end on what a step makes. Where that
//! is the surface that is touched, the tool behind it is asked for; of one surface there should be one.

use fabkit_geometry::sequences::EvenPoints;
use fabkit_geometry::{
    Action, Assembly, CompiledSolid, Point3, Pose, Profile, Ray, Sensor, Step, TouchSurface,
    Vector3,
};

use crate::case::{Case, Looked};
use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::lines::Caster;
use crate::rule::Rule;
use crate::scene::Assemblies;

rule! {
    /// One tool shapes what is touched, without a seam.
    Parting = "parting",
    examines: "steps that shape what is touched",
    finds: "two tools that meet on the surface that is touched: a seam",
    limit: "2 % of the surface each",
    for_variants: true,
    look: apply,
}

fn apply(case: &Case<'_>) -> Looked {
    Ok(examine(case.sensor, case.scene))
}

/// Lines.
const LINES: usize = 1_024;

/// How far what a step makes may end below the surface that is touched, mm: under a coat a seam shows.
const NEAR_MM: f64 = 0.2;

/// How far behind the surface the tool is looked for, mm.
const BEHIND_MM: f64 = 0.01;

/// Smallest share of the touched surface that a tool shapes, to count.
const LEAST_SHARE: f64 = 0.02;

/// A tool behind a part of the surface.
struct Shaping<'a> {
    tool: &'a str,
    /// How many lines ended on it.
    count: usize,
    /// The highest place where one did, in the sensor's frame.
    highest: Point3<f64>,
}

/// All findings, and how many steps shape what is touched.
pub(crate) fn examine(sensor: &Sensor, scene: &Assemblies) -> (Vec<Finding>, usize) {
    let Some(touch) = &sensor.touch else { return (Vec::new(), 0) };
    let lines = lines(touch);
    let (mut findings, mut count) = (Vec::new(), 0);
    for step in &sensor.chain {
        let shaping = shaping(sensor, scene, touch, &lines, step);
        count += usize::from(!shaping.is_empty());
        findings.extend(finding(step, &shaping));
    }
    (findings, count)
}

/// In the sensor's frame, towards what is touched.
fn lines(touch: &TouchSurface) -> Vec<Ray> {
    let places = EvenPoints::square([0.5; 2]);
    let places = (1..=LINES).map(|number| places.at(number));
    match touch {
        TouchSurface::Dome(dome) => {
            let origin = Point3::new(0.0, 0.0, dome.foot_z_mm.max(dome.centre_z_mm));
            // All directions above the horizon alike (Archimedes: equal heights are equal areas).
            let ray = |[u, v]: [f64; 2]| {
                let ((sin, cos), across) =
                    ((std::f64::consts::TAU * u).sin_cos(), (1.0 - v * v).sqrt());
                Ray { origin, direction: Vector3::new(across * cos, across * sin, v) }
            };
            places.map(ray).collect()
        }
        TouchSurface::Plane(plane) => {
            let [low, high] = Profile::new(plane.outline.clone()).bounds_mm();
            let foot = plane.foot_z_mm.min(plane.top_z_mm - BEHIND_MM);
            let at = |axis: usize, share: f64| low[axis] + share * (high[axis] - low[axis]);
            let ray = |[u, v]: [f64; 2]| Ray {
                origin: Point3::new(at(0, u), at(1, v), foot),
                direction: Vector3::z(),
            };
            places.map(ray).collect()
        }
    }
}

/// The tools that shape what a step makes where it is touched, by how much.
fn shaping<'a>(
    sensor: &'a Sensor,
    scene: &Assemblies,
    touch: &TouchSurface,
    lines: &[Ray],
    step: &'a Step,
) -> Vec<Shaping<'a>> {
    let (layer, tools) = match &step.action {
        Action::Pour(pour) => (&pour.layer, &pour.walls),
        Action::Spray(spray) => (&spray.layer, &spray.onto),
        _ => return Vec::new(),
    };
    let Some((assembly, made_from_sensor)) = pose(sensor, step, layer) else { return Vec::new() };
    let Some(made) = scene.places(&assembly.0, layer).first().copied() else { return Vec::new() };
    // What stays in the sensor is no tool.
    let tools = tools.iter().filter(|tool| !stands_in(sensor, tool, &Assembly::sensor()));
    let mut shaping: Vec<(Shaping, &CompiledSolid)> = tools
        .filter_map(|tool| {
            let placed = scene.places(&assembly.0, tool).first().copied()?;
            let none = Shaping { tool, count: 0, highest: Point3::origin() };
            Some((none, &placed.body))
        })
        .collect();
    let mut caster = Caster::default();
    for line in lines {
        let ray = Ray {
            origin: made_from_sensor.point(line.origin),
            direction: made_from_sensor.vector(line.direction),
        };
        let Some(last) = caster.stretches(&made.body, &ray).last() else { continue };
        let touched = line.at(last.exit.t);
        if touch.depth_mm(&touched).0.abs() > NEAR_MM {
            continue;
        }
        let behind = ray.at(last.exit.t) + BEHIND_MM * last.exit.normal;
        if let Some((found, _)) = shaping.iter_mut().find(|(_, body)| body.contains(&behind)) {
            if found.count == 0 || touched.z > found.highest.z {
                found.highest = touched;
            }
            found.count += 1;
        }
    }
    shaping.into_iter().map(|(shaping, _)| shaping).filter(|s| s.count > 0).collect()
}

/// Where a step happens, and its frame from the sensor's, if what it makes stands in both.
fn pose<'a>(sensor: &'a Sensor, step: &'a Step, layer: &str) -> Option<(&'a Assembly, Pose)> {
    let (assembly, body) = (step.assembly.as_ref()?, sensor.body(layer)?);
    let place = |assembly: &Assembly| {
        let mut places = body.placements.iter();
        places.find(|place| place.assembly == *assembly).map(|place| place.assembly_from_body)
    };
    let (here, in_sensor) = (place(assembly)?, place(&Assembly::sensor())?);
    Some((assembly, here.then_in(in_sensor.inverse())))
}

fn stands_in(sensor: &Sensor, body: &str, assembly: &Assembly) -> bool {
    let body = sensor.body(body);
    body.is_some_and(|body| body.placements.iter().any(|place| place.assembly == *assembly))
}

/// The finding, if there are two tools or more.
fn finding(step: &Step, shaping: &[Shaping]) -> Option<Finding> {
    let all: usize = shaping.iter().map(|shaping| shaping.count).sum();
    let share = |shaping: &Shaping| shaping.count as f64 / all as f64;
    let mut shaping: Vec<&Shaping> = shaping.iter().filter(|s| share(s) >= LEAST_SHARE).collect();
    shaping.sort_by_key(|shaping| std::cmp::Reverse(shaping.count));
    let [first, second, ..] = shaping[..] else { return None };
    let layer = match &step.action {
        Action::Pour(pour) => &pour.layer,
        Action::Spray(spray) => &spray.layer,
        _ => return None,
    };
    let message = format!(
        "the parting line of {} and {} runs over what is touched of the {layer}: they shape {:.0} and \
         {:.0} percent of it",
        first.tool,
        second.tool,
        100.0 * share(first),
        100.0 * share(second)
    );
    let fix =
        "cast it in a mold of one piece, part the mold at the surface's foot, or sand the seam";
    let found = Finding::error(Rule::Parting, message, fix).with_severity(Severity::Note);
    let bodies = [first.tool, second.tool, layer.as_str()];
    let found = found.in_step(&step.name).of(bodies).at(Some(second.highest));
    let found = match &step.assembly {
        Some(assembly) => found.in_assembly(&assembly.0),
        None => found,
    };
    Some(found.measured(share(second), LEAST_SHARE, ""))
}
