//! Grip on rigid tools that are taken off a cast and stick to it: each needs a slot for a screwdriver, or must stand
//! out far enough for two fingers.

use std::f64::consts::TAU;

use fabkit_geometry::{
    Action, MechanicalRole, Occasion, Point3, Process, Pull, Ray, Sensor, Vector3,
};

use crate::finding::Finding;
use crate::rule::Rule;
use crate::sampling_lines::{Caster, basis};
use crate::scene::Placed;

use super::arrival::Work;

/// Smallest height of an edge that two fingers can hold, mm (chosen): half a fingertip.
const GRIP_MM: f64 = 3.0;

/// Distance at which bounding boxes count as touching, mm.
const TOUCHING_MM: f64 = 0.1;

/// Number of sides from which fingers are tried, in opposite pairs.
const SIDES: usize = 8;

/// Number of heights along a tool that are sampled.
const HEIGHTS: usize = 96;

/// Finds tools that a demolding step takes off and that offer no place for a screwdriver or fingers. Screws and nuts
/// are ignored: they are removed before.
pub(super) fn examine(sensor: &Sensor, work: &Work) -> Vec<Finding> {
    if work.occasion != Occasion::Removal {
        return Vec::new();
    }
    let step = sensor.chain.iter().find(|step| step.name == work.place.step);
    let Some(Action::Demold(pulls)) = step.map(|step| &step.action) else { return Vec::new() };
    let is_fastener =
        |one: &Placed| matches!(one.of.duty, MechanicalRole::Fastener | MechanicalRole::Threaded);
    let mut standing: Vec<&Placed> =
        work.around.iter().copied().filter(|one| !is_fastener(one)).collect();
    let mut findings = Vec::new();
    for pull in pulls {
        let pulled = standing.iter().filter(|one| one.name == pull.body && is_rigid(one, pull));
        let least = pulled
            .filter(|one| !is_pried(one, &standing))
            .map(|one| grip_mm(one, &standing, &pull.direction))
            .fold(f64::INFINITY, f64::min);
        if least < GRIP_MM {
            findings.push(told(work, &pull.body, least));
        }
        // The tool is gone for the following pulls.
        standing.retain(|one| one.name != pull.body);
    }
    findings
}

/// Returns whether a tool is rigid and made here. Silicone gives way, and what is bought or peeled comes off in ways of
/// its own.
fn is_rigid(one: &Placed, pull: &Pull) -> bool {
    let made = [Process::Fdm, Process::Sla, Process::PolyJet, Process::Laser, Process::Cnc];
    pull.strain_limit.is_none() && one.of.process().is_some_and(|process| made.contains(&process))
}

/// Returns whether the tool, or a body that it touches, has a place for a screwdriver.
fn is_pried(one: &Placed, standing: &[&Placed]) -> bool {
    let near = one.body.bounds().grown(TOUCHING_MM);
    let touches = |other: &Placed| !near.common(&other.body.bounds()).is_empty();
    let pries = |other: &Placed| other.of.reach.iter().any(|r| r.occasion == Occasion::Removal);
    standing.iter().any(|other| pries(other) && touches(other))
}

/// Computes the height, mm, over which a tool is the outermost body on two opposite sides across its pull. Returns the
/// largest value of all pairs of sides, rounded up by one sampling step.
fn grip_mm(one: &Placed, standing: &[&Placed], along: &Vector3<f64>) -> f64 {
    let bounds = one.body.bounds();
    let (centre, far_mm) = (bounds.centre(), 2.0 * (bounds.max - bounds.min).norm() + 1.0);
    let half_mm = 0.5 * (bounds.max - bounds.min).dot(&along.abs());
    let step_mm = 2.0 * half_mm / HEIGHTS as f64;
    let [across, up] = basis(along);
    let mut caster = Caster::default();
    let mut free_mm = [0.0; SIDES];
    for (side, free_mm) in free_mm.iter_mut().enumerate() {
        // A small offset, so that no side points along corners and notches.
        let (sin, cos) = (TAU * (side as f64 + 0.137) / SIDES as f64).sin_cos();
        let out = across * cos + up * sin;
        for height in 0..HEIGHTS {
            // The offset keeps lines off edges at round heights.
            let shift_mm = (height as f64 + 0.4721) * step_mm - half_mm;
            let origin: Point3<f64> = centre + along * shift_mm + out * far_mm;
            let ray = Ray { origin, direction: -out };
            let mut first = |body: &Placed| {
                let enters = caster.stretches(&body.body, &ray).map(|s| s.enter.t);
                enters.filter(|t| *t > 0.0).fold(f64::INFINITY, f64::min)
            };
            let own = first(one);
            let is_first = own.is_finite() && standing.iter().all(|other| own <= first(other));
            *free_mm += if is_first { step_mm } else { 0.0 };
        }
    }
    // Opposite sides must both be free.
    let pairs = (0..SIDES / 2).map(|side| free_mm[side].min(free_mm[side + SIDES / 2]));
    pairs.fold(0.0, f64::max) + step_mm
}

/// Reports a tool without a grip.
fn told(work: &Work, body: &str, free_mm: f64) -> Finding {
    let message = format!(
        "nothing takes {body} off: no slot for a screwdriver on it or beside it, and {free_mm:.1} mm of its \
         edge for two fingers"
    );
    let fix =
        "cut a pry slot where it meets what it sticks to, make it thicker, or let it stand out";
    Finding::error(Rule::Access, message, fix)
        .in_step(work.place.step)
        .in_assembly(work.place.assembly)
        .about_bodies([body])
        .with_measurement(free_mm, GRIP_MM, "mm")
}
