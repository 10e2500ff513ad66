//! Daylight: whether straight lines lead from outside to what the camera looks at.
//!
//! Rays leave the pupil towards what is there to be seen, and end on the first face that stops light. From
//! there, lines go out into the half space that the camera looks from; those that meet nothing that stops
//! light, only air and what is clear or lets light through, lead outside. Their share is the share of the
//! daylight around the sensor that falls on what the camera looks at; holes in the face that the sensor is
//! mounted with are covered by what it is mounted on. Lines are straight: neither refraction
//! nor what walls throw back is counted.

use std::collections::BTreeMap;

use fabkit_geometry::{Aabb, Assembly, Clarity, Point3, Ray, Sensor, Vector3};
use rayon::prelude::*;

use crate::case::{Case, Looked};
use crate::declaration::rule;
use crate::finding::Finding;
use crate::lines::{Caster, basis};
use crate::rule::Rule;
use crate::scene::{Assemblies, Placed};
use crate::sight::{Cone, bodies, pixels};

rule! {
    /// No daylight falls on what the camera looks at.
    Leak = "leak",
    examines: "lines to where daylight might be",
    finds: "straight lines from outside to what the camera looks at, through gaps and what is \
             clear or translucent; refraction and what walls throw back are not counted, and \
             holes in the face that is mounted are covered",
    limit: "0.05 % of the daylight around (chosen): a quarter of a lux in a room",
    for_variants: true,
    look: apply,
}

fn apply(case: &Case<'_>) -> Looked {
    Ok(examine(case.sensor, case.scene))
}

/// Rays towards what is there to be seen, and the most places of it that are looked at.
const PLACES: (usize, usize) = (2_048, 256);

/// Lines out from each place.
const LINES: usize = 32;

/// Largest share of the daylight around that may get in. Chosen: of the 500 lx of a room a quarter of one,
/// where an LED 30 mm away gives thousands; cameras tell a few parts of a thousand from each other.
const MOST_SHARE: f64 = 5e-4;

/// Off the face on which a ray ends, mm.
const OFF_MM: f64 = 1e-3;

/// Turn from one line to the next, rad: the golden angle spreads them evenly.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;

/// A line that leads out.
struct Open<'a> {
    /// What it passes last: through it, as it lets light pass, or by a gap in it or beside it.
    by: &'a str,
    is_through: bool,
    place: Point3<f64>,
}

/// All findings, and how many lines were followed.
pub(crate) fn examine(sensor: &Sensor, scene: &Assemblies) -> (Vec<Finding>, usize) {
    if sensor.sight.is_empty() {
        return (Vec::new(), 0);
    }
    let placed = scene.bodies(&Assembly::sensor().0);
    let (stops, passes): (Vec<&Placed>, Vec<&Placed>) =
        placed.iter().partition(|placed| placed.of.clarity() == Clarity::Opaque);
    let faces = faces(sensor, scene);
    let open: Vec<Vec<Open>> = faces
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
    let open: Vec<Open> = open.into_iter().flatten().collect();
    let count = faces.len() * LINES;
    let share = open.len() as f64 / count.max(1) as f64;
    let findings = (share > MOST_SHARE).then(|| finding(sensor, &open, share));
    (findings.into_iter().collect(), count)
}

fn finding(sensor: &Sensor, open: &[Open], share: f64) -> Finding {
    let mut ways = BTreeMap::<(&str, bool), usize>::new();
    for one in open {
        *ways.entry((one.by, one.is_through)).or_default() += 1;
    }
    let most = ways.into_iter().max_by_key(|(_, count)| *count).map(|(way, _)| way);
    let first = open.iter().find(|one| Some((one.by, one.is_through)) == most);
    let how = match most {
        Some((by, true)) => format!("through {by}"),
        Some((by, false)) => format!("by a gap in {by} or beside it"),
        None => String::new(),
    };
    let message =
        format!("daylight falls {how} onto what the camera looks at: {}", sensor.sight.join(", "));
    let fix = "close the gap, cover it with something opaque, or take an opaque material there";
    Finding::error(Rule::Leak, message, fix)
        .in_assembly(&Assembly::sensor().0)
        .of(first.map(|one| one.by).into_iter().chain(sensor.sight.iter().map(String::as_str)))
        .at(first.map(|one| one.place))
        .measured(share, MOST_SHARE, "")
}

/// Places on what the camera looks at where light ends, and the directions out of them.
fn faces(sensor: &Sensor, scene: &Assemblies) -> Vec<(Point3<f64>, Vector3<f64>)> {
    let camera = &sensor.camera;
    let pupil = camera.sensor_from_camera.point(Point3::origin());
    let bodies = bodies(sensor, scene);
    let cone = Cone::around(&bodies, &pupil);
    let face = |caster: &mut Caster, number| {
        let ray = Ray { origin: pupil, direction: cone.direction(number, PLACES.0) };
        if pixels(camera, &ray.direction) == 0.0 {
            return None;
        }
        let mut ends: Option<(f64, Vector3<f64>)> = None;
        let mut wanted = f64::INFINITY;
        for met in &bodies {
            let Some(enter) = caster.first_entry(&met.placed.body, &ray) else { continue };
            if met.clarity == Clarity::Opaque && ends.is_none_or(|(t, _)| enter.t < t) {
                ends = Some((enter.t, enter.normal));
            }
            wanted = if met.is_wanted { wanted.min(enter.t) } else { wanted };
        }
        let (t, normal) = ends?;
        (wanted <= t).then(|| (ray.at(t) + OFF_MM * normal, normal))
    };
    let found: Vec<Option<_>> =
        (0..PLACES.0).into_par_iter().map_init(Caster::default, face).collect();
    let found: Vec<_> = found.into_iter().flatten().collect();
    let stride = found.len().div_ceil(PLACES.1).max(1);
    found.into_iter().step_by(stride).collect()
}

/// One of many lines out of a face, more of them the steeper: as light that falls on it counts.
fn outwards((origin, normal): &(Point3<f64>, Vector3<f64>), number: usize) -> Ray {
    let share = ((number % LINES) as f64 + 0.5) / LINES as f64;
    let (sin, cos) = (number as f64 * GOLDEN_RAD).sin_cos();
    let [u, v] = basis(normal);
    let direction = share.sqrt() * (cos * u + sin * v) + (1.0 - share).sqrt() * normal;
    Ray { origin: *origin, direction }
}

/// Whether anything stops a line; what stopped the last one is asked first.
fn is_stopped(stops: &[&Placed], ray: &Ray, caster: &mut Caster, last: &mut usize) -> bool {
    let order = (0..stops.len()).map(|i| (i + *last) % stops.len());
    let mut stops_it =
        order.filter(|&i| caster.ends(&stops[i].body, ray).iter().any(|[_, exit]| *exit > 0.0));
    let found = stops_it.next();
    *last = found.unwrap_or(*last);
    found.is_some()
}

/// Where a line that nothing stops gets out; nowhere, if that is the face that the sensor is mounted with.
fn way_out<'a>(
    [stops, passes]: [&[&'a Placed<'a>]; 2],
    ray: &Ray,
    caster: &mut Caster,
) -> Option<Open<'a>> {
    let mut last: Option<(f64, &Placed, bool)> = None;
    let mut add = |t: f64, placed: &'a Placed<'a>, is_through: bool| {
        if last.is_none_or(|(known, ..)| t > known) {
            last = Some((t, placed, is_through));
        }
    };
    // The last one past which it goes: the gap is in it, or beside it.
    for placed in stops {
        if let Some(t) = leaves(ray, &placed.body.bounds()) {
            add(t, placed, false);
        }
    }
    for placed in passes {
        if let Some([_, exit]) = caster.ends(&placed.body, ray).last() {
            add(*exit, placed, true);
        }
    }
    let (t, by, is_through) = last?;
    let is_mounted = !is_through && ray.at(t).z <= mounted_z(stops) + OFF_MM;
    (!is_mounted).then(|| Open { by: by.name, is_through, place: ray.at(t) })
}

/// Where what is made ends below: whatever the sensor is mounted on closes holes there.
fn mounted_z(stops: &[&Placed]) -> f64 {
    let made = stops.iter().filter(|placed| placed.of.is_made());
    made.map(|placed| placed.body.bounds().min.z).fold(f64::INFINITY, f64::min)
}

/// Where a line leaves a box that it passes, mm.
fn leaves(ray: &Ray, bounds: &Aabb) -> Option<f64> {
    let (mut enter, mut exit) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let ends = [bounds.min, bounds.max]
            .map(|corner| (corner[axis] - ray.origin[axis]) / ray.direction[axis]);
        enter = enter.max(ends[0].min(ends[1]));
        exit = exit.min(ends[0].max(ends[1]));
    }
    (enter < exit).then_some(exit)
}
