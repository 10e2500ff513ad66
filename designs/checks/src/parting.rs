//! Parting lines: where two tools together shape the touch surface, their joint leaves a seam that is felt, wears first
//! and darkens the image.
//!
//! Lines leave the sensor's centre (or, for a flat pad, its foot) and end on the layer that a step makes. If the line
//! ends on the touch surface, the tool behind it is recorded. One tool should shape the whole surface.

use fabkit_geometry::sequences::EvenPoints;
use fabkit_geometry::{
    Action, Assembly, CompiledSolid, Point3, Pose, Profile, Ray, Sensor, Step, TouchSurface,
    Vector3,
};

use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::Caster;
use crate::scene::Assemblies;

rule! {
    /// One tool shapes the touch surface, without a seam.
    Parting = "parting",
    examines: "surface-shaping steps",
    finds: "two tools that meet on the touched surface and leave a seam",
    limit: "2 % of the surface for each tool",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    Ok(examine(case.sensor, case.scene))
}

/// Number of lines.
const LINES: usize = 1_024;

/// Largest distance of the made layer from the touch surface, mm: a seam shows through a coat.
const NEAR_MM: f64 = 0.2;

/// Distance behind the surface at which the tool is searched, mm.
const BEHIND_MM: f64 = 0.01;

/// Smallest fraction of the touch surface that a tool must shape to count.
const LEAST_SHARE: f64 = 0.02;

/// A tool behind part of the surface.
struct ShapingTool<'a> {
    tool: &'a str,
    /// Number of lines that ended on it.
    count: usize,
    /// Highest of those points, in the sensor's frame.
    highest: Point3<f64>,
}

/// Finds parting lines on the touch surface. Also returns the number of steps that shape it.
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

/// Returns lines towards the touch surface, in the sensor's frame.
fn lines(touch: &TouchSurface) -> Vec<Ray> {
    let places = EvenPoints::square([0.5; 2]);
    let places = (1..=LINES).map(|number| places.at(number));
    match touch {
        TouchSurface::Dome(dome) => {
            let origin = Point3::new(0.0, 0.0, dome.foot_z_mm.max(dome.centre_z_mm));
            // Directions uniform over the upper hemisphere (Archimedes: equal heights are equal areas).
            let ray = |[u, v]: [f64; 2]| {
                let ((sin, cos), across) =
                    ((std::f64::consts::TAU * u).sin_cos(), (1.0 - v * v).sqrt());
                Ray { origin, direction: Vector3::new(across * cos, across * sin, v) }
            };
            places.map(ray).collect()
        }
        TouchSurface::Plane(plane) => {
            let [low, high] = Profile::new(plane.outline.clone()).bounds_mm();
            // Starts below the top in any case.
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

/// Counts the lines for which each tool of a step shapes the touch surface.
fn shaping<'a>(
    sensor: &'a Sensor,
    scene: &Assemblies,
    touch: &TouchSurface,
    lines: &[Ray],
    step: &'a Step,
) -> Vec<ShapingTool<'a>> {
    let (layer, tools) = match &step.action {
        Action::Pour(pour) => (&pour.layer, &pour.walls),
        Action::Spray(spray) => (&spray.layer, &spray.onto),
        _ => return Vec::new(),
    };
    let Some((assembly, made_from_sensor)) = pose(sensor, step, layer) else { return Vec::new() };
    let Some(made) = scene.places(&assembly.0, layer).first().copied() else { return Vec::new() };
    // A wall that stays in the sensor is no tool.
    let tools = tools.iter().filter(|tool| !stands_in(sensor, tool, &Assembly::sensor()));
    let mut shaping: Vec<(ShapingTool, &CompiledSolid)> = tools
        .filter_map(|tool| {
            let placed = scene.places(&assembly.0, tool).first().copied()?;
            let none = ShapingTool { tool, count: 0, highest: Point3::origin() };
            Some((none, &placed.body))
        })
        .collect();
    let mut caster = Caster::default();
    for line in lines {
        let ray = Ray {
            origin: made_from_sensor.point(line.origin),
            direction: made_from_sensor.vector(line.direction),
        };
        // Outer end of the layer along the line.
        let Some(last) = caster.stretches(&made.body, &ray).last() else { continue };
        let touched = line.at(last.exit.t);
        // The line left through a face that is not touched.
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

/// Returns the assembly of a step and the transform from the sensor's frame to its frame, if the layer is placed in
/// both.
fn pose<'a>(sensor: &'a Sensor, step: &'a Step, layer: &str) -> Option<(&'a Assembly, Pose)> {
    let (assembly, body) = (step.assembly.as_ref()?, sensor.body(layer)?);
    let place = |assembly: &Assembly| {
        let mut places = body.placements.iter();
        places.find(|place| place.assembly == *assembly).map(|place| place.assembly_from_body)
    };
    let (here, in_sensor) = (place(assembly)?, place(&Assembly::sensor())?);
    Some((assembly, here.then_in(in_sensor.inverse())))
}

/// Returns whether a body has a placement in an assembly.
fn stands_in(sensor: &Sensor, body: &str, assembly: &Assembly) -> bool {
    let body = sensor.body(body);
    body.is_some_and(|body| body.placements.iter().any(|place| place.assembly == *assembly))
}

/// Returns the finding if at least two tools shape the surface.
fn finding(step: &Step, shaping: &[ShapingTool]) -> Option<Finding> {
    let all: usize = shaping.iter().map(|shaping| shaping.count).sum();
    let share = |shaping: &ShapingTool| shaping.count as f64 / all as f64;
    let mut shaping: Vec<&ShapingTool> =
        shaping.iter().filter(|s| share(s) >= LEAST_SHARE).collect();
    shaping.sort_by_key(|shaping| std::cmp::Reverse(shaping.count));
    // A single tool leaves no parting line.
    let [first, second, ..] = shaping[..] else { return None };
    let layer = match &step.action {
        Action::Pour(pour) => &pour.layer,
        Action::Spray(spray) => &spray.layer,
        _ => return None,
    };
    let message = format!(
        "the parting line of {} and {} runs across the surface of the {layer}: they shape {:.0} % and {:.0} % of it",
        first.tool,
        second.tool,
        100.0 * share(first),
        100.0 * share(second)
    );
    let fix =
        "cast it in a mold of one piece, part the mold at the surface's foot, or sand the seam";
    let found = Finding::error(Rule::Parting, message, fix).with_severity(Severity::Note);
    let bodies = [first.tool, second.tool, layer.as_str()];
    let found = found.in_step(&step.name).about_bodies(bodies).at_position(Some(second.highest));
    let found = match &step.assembly {
        Some(assembly) => found.in_assembly(&assembly.0),
        None => found,
    };
    Some(found.with_measurement(share(second), LEAST_SHARE, ""))
}
