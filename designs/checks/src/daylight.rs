//! Daylight: straight lines that lead from outside to the surface that the camera looks at.
//!
//! Rays leave the pupil towards the bodies in view and end on the first opaque face. From there, lines leave into the
//! half space in front of the face. A line that meets only air and clear or translucent bodies leads outside. The
//! fraction of such lines is the fraction of the surrounding daylight that falls on the surface. Openings in the
//! mounting face are closed by whatever the sensor is mounted on. Neither refraction nor reflection from walls is
//! counted.

use std::collections::BTreeMap;

use fabkit_geometry::{Aabb, Assembly, OpticalClarity, Point3, Ray, Sensor, Vector3};
use rayon::prelude::*;

use crate::camera_view::{Cone, ViewBody, bodies, pixels_per_steradian};
use crate::declaration::rule;
use crate::finding::Finding;
use crate::material_questions::MaterialQuestions;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::{Caster, basis};
use crate::scene::{Assemblies, Placed};

rule! {
    /// No daylight falls on the surface that the camera looks at.
    Leak = "leak",
    examines: "lines of sight to the outside",
    finds: "straight lines from outside to the surface that the camera looks at, through gaps \
             and through clear or translucent bodies; refraction and reflections from walls are \
             not counted, and holes in the mounting face count as covered",
    limit: "0.05 % of the ambient daylight (chosen), which is a quarter of a lux in a room",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    Ok(examine(case.sensor, case.scene, &case.questions))
}

/// Number of rays towards the bodies in view, and maximum number of points on them from which lines start.
const PLACES: (usize, usize) = (2_048, 256);

/// Number of lines from each point.
const LINES: usize = 32;

/// Largest fraction of the surrounding daylight that may get in (chosen): a quarter of a lux of the 500 lx of a room,
/// where an LED 30 mm away gives thousands. Cameras distinguish a few parts in a thousand.
const MOST_SHARE: f64 = 5e-4;

/// Offset from the face on which a ray ends, mm.
const OFF_MM: f64 = 1e-3;

/// Rotation from one line to the next, rad: the golden angle spreads them evenly.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;

/// A line that leads outside.
struct LightPath<'a> {
    /// Last body that it passes: through it if the body transmits light, otherwise through a gap in it or beside it.
    by: &'a str,
    is_through: bool,
    place: Point3<f64>,
}

/// Finds leaks of daylight. Also returns the number of lines that were followed.
pub(crate) fn examine(
    sensor: &Sensor,
    scene: &Assemblies,
    questions: &MaterialQuestions,
) -> (Vec<Finding>, usize) {
    if sensor.visible_bodies.is_empty() {
        return (Vec::new(), 0);
    }
    let placed = scene.bodies(&Assembly::sensor().0);
    // Opaque bodies stop light, all others let it pass. No leak is claimed of a body of unknown transparency.
    let (stops, passes): (Vec<&Placed>, Vec<&Placed>) = placed.iter().partition(|placed| {
        questions
            .transparency(Rule::Leak, placed.of)
            .is_none_or(|clarity| clarity == OpticalClarity::Opaque)
    });
    let bodies = bodies(sensor, scene, Rule::Leak, questions);
    let faces = faces(sensor, &bodies);
    let open: Vec<Vec<LightPath>> = faces
        .par_iter()
        .enumerate()
        .map_init(Caster::default, |caster, (number, face)| {
            let mut last = 0;
            let rays = (0..LINES).map(|line| outwards(face, number * LINES + line));
            let open = rays.filter(|ray| !is_stopped(&stops, ray, caster, &mut last));
            let open: Vec<Ray> = open.collect();
            open.iter().filter_map(|ray| way_out([&stops, &passes], ray, caster)).collect()
        })
        .collect();
    let open: Vec<LightPath> = open.into_iter().flatten().collect();
    let count = faces.len() * LINES;
    let share = open.len() as f64 / count.max(1) as f64;
    let findings = (share > MOST_SHARE).then(|| finding(sensor, &open, share));
    (findings.into_iter().collect(), count)
}

/// Reports the gap or body through which most light gets in.
fn finding(sensor: &Sensor, open: &[LightPath], share: f64) -> Finding {
    let mut ways = BTreeMap::<(&str, bool), usize>::new();
    for one in open {
        *ways.entry((one.by, one.is_through)).or_default() += 1;
    }
    let most = ways.into_iter().max_by_key(|(_, count)| *count).map(|(way, _)| way);
    let first = open.iter().find(|one| Some((one.by, one.is_through)) == most);
    let how = match most {
        Some((by, true)) => format!("through {by}"),
        Some((by, false)) => format!("through a gap in {by} or beside it"),
        None => String::new(),
    };
    let message = format!(
        "daylight falls {how} onto the bodies in view: {}",
        sensor.visible_bodies.join(", ")
    );
    let fix = "close the gap, cover it with something opaque, or take an opaque material there";
    Finding::error(Rule::Leak, message, fix)
        .in_assembly(&Assembly::sensor().0)
        .about_bodies(
            first
                .map(|one| one.by)
                .into_iter()
                .chain(sensor.visible_bodies.iter().map(String::as_str)),
        )
        .at_position(first.map(|one| one.place))
        .with_measurement(share, MOST_SHARE, "")
}

/// Samples points on the opaque surfaces that the camera looks at, each with its normal.
fn faces(sensor: &Sensor, bodies: &[ViewBody]) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let camera = &sensor.camera;
    let pupil = camera.sensor_from_camera.point(Point3::origin());
    let cone = Cone::around(bodies, &pupil);
    let face = |caster: &mut Caster, number| {
        let ray = Ray { origin: pupil, direction: cone.direction(number, PLACES.0) };
        if pixels_per_steradian(camera, &ray.direction) == 0.0 {
            return None;
        }
        let mut ends: Option<(f64, Vector3<f64>)> = None;
        let mut wanted = f64::INFINITY;
        for met in bodies {
            let Some(enter) = caster.first_entry(&met.placed.body, &ray) else { continue };
            if met.clarity == OpticalClarity::Opaque && ends.is_none_or(|(t, _)| enter.t < t) {
                ends = Some((enter.t, enter.normal));
            }
            // Nearest body in view.
            wanted = if met.is_target { wanted.min(enter.t) } else { wanted };
        }
        let (t, normal) = ends?;
        // The ray counts only if the body in view comes first, or is the opaque body itself.
        (wanted <= t).then(|| (ray.at(t) + OFF_MM * normal, normal))
    };
    let found: Vec<Option<_>> =
        (0..PLACES.0).into_par_iter().map_init(Caster::default, face).collect();
    let found: Vec<_> = found.into_iter().flatten().collect();
    let stride = found.len().div_ceil(PLACES.1).max(1);
    found.into_iter().step_by(stride).collect()
}

/// Returns a line out of a face. The lines have a cosine-weighted distribution, as irradiance does.
fn outwards((origin, normal): &(Point3<f64>, Vector3<f64>), number: usize) -> Ray {
    let share = ((number % LINES) as f64 + 0.5) / LINES as f64;
    let (sin, cos) = (number as f64 * GOLDEN_RAD).sin_cos();
    let [u, v] = basis(normal);
    // A uniform distribution over the disc, projected up to the hemisphere, is cosine-weighted.
    let direction = share.sqrt() * (cos * u + sin * v) + (1.0 - share).sqrt() * normal;
    Ray { origin: *origin, direction }
}

/// Returns whether an opaque body blocks a line. Starts with the body that blocked the last line, since neighbouring
/// lines usually end on the same one.
fn is_stopped(stops: &[&Placed], ray: &Ray, caster: &mut Caster, last: &mut usize) -> bool {
    let order = (0..stops.len()).map(|i| (i + *last) % stops.len());
    let mut stops_it = order
        .filter(|&i| caster.intervals(&stops[i].body, ray).iter().any(|[_, exit]| *exit > 0.0));
    let found = stops_it.next();
    *last = found.unwrap_or(*last);
    found.is_some()
}

/// Finds where an unblocked line gets out; `None` if it leaves through the mounting face.
fn way_out<'a>(
    [stops, passes]: [&[&'a Placed<'a>]; 2],
    ray: &Ray,
    caster: &mut Caster,
) -> Option<LightPath<'a>> {
    let mut last: Option<(f64, &Placed, bool)> = None;
    let mut add = |t: f64, placed: &'a Placed<'a>, is_through: bool| {
        if last.is_none_or(|(known, ..)| t > known) {
            last = Some((t, placed, is_through));
        }
    };
    // A gap is reported at the last opaque body whose bounding box the line passes.
    for placed in stops {
        if let Some(t) = box_exit(ray, &placed.body.bounds()) {
            add(t, placed, false);
        }
    }
    for placed in passes {
        // Where the line leaves a transmitting body for the last time.
        if let Some([_, exit]) = caster.intervals(&placed.body, ray).last() {
            add(*exit, placed, true);
        }
    }
    let (t, by, is_through) = last?;
    // Gaps at the mounting face are covered by whatever the sensor is mounted on.
    let is_mounted = !is_through && ray.at(t).z <= mounted_z(stops) + OFF_MM;
    (!is_mounted).then(|| LightPath { by: by.name, is_through, place: ray.at(t) })
}

/// Returns the lowest z of the made bodies, mm. Whatever the sensor is mounted on closes openings there.
fn mounted_z(stops: &[&Placed]) -> f64 {
    let made = stops.iter().filter(|placed| placed.of.is_made());
    made.map(|placed| placed.body.bounds().min.z).fold(f64::INFINITY, f64::min)
}

/// Returns the distance at which a line leaves a box that it passes, mm.
fn box_exit(ray: &Ray, bounds: &Aabb) -> Option<f64> {
    let [enter, exit] = ray.range_in(bounds)?;
    (enter.max(0.0) < exit).then_some(exit)
}
