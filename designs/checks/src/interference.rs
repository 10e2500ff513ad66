//! Interference: bodies of one assembly overlap only where a press fit is declared, and not deeper than declared.

use fabkit_geometry::measure::overlap_volume;
use fabkit_geometry::proofs::find_overlap_boxes;
use fabkit_geometry::{CompiledSolid, Point3, PressFit, Ray, Sensor, Vector3};
use rayon::prelude::*;

use crate::declaration::rule;
use crate::finding::Finding;
use crate::memo::{Key, Memo};
use crate::rule::Rule;
use crate::rule_input::{Pair, RuleInput, RuleResult};
use crate::sampling_lines::{Bundle, Caster, DIRECTIONS, Stretch};
use crate::scene::{Assemblies, Placed};

rule! {
    /// Bodies of one assembly overlap only where a press fit is declared.
    Interference = "interference",
    examines: "pairs of bodies",
    finds: "bodies that overlap without a declared press fit, or more deeply than it allows",
    limit: "20 000 sampling lines for each pair",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let found = examine(case.sensor, &case.pairs, case.memo, case.tick);
    Ok((found, case.pairs.len()))
}

/// Number of lines through the box that two bodies share.
pub(crate) const LINES: u32 = 20_000;

/// Number of lines per direction that measure the depth of a press fit.
const FIT_LINES: usize = 4_000;

/// Number of directions in which the thickness of an overlap is searched.
const FAN: u32 = 24;

/// Maximum number of points at which the thickness of a press fit is measured; press fits are alike all around.
const FIT_PROBES: usize = 128;

/// Number of refinement rounds along the normals at the ends of the shortest line.
const REFINEMENTS: usize = 3;

/// Relative error of the thickness that may remain after the refinement.
const REFINEMENT_REST: f64 = 1e-3;

/// Rounding allowed in the depth of a press fit, mm.
const FIT_ROUNDING_MM: f64 = 1e-6;

/// Result for one pair.
struct Verdict {
    finding: Option<Finding>,
    /// Whether the two bodies overlap at all.
    overlaps: bool,
}

/// Returns all pairs of bodies whose bounding boxes overlap.
pub(crate) fn pairs<'a>(sensor: &'a Sensor, scene: &'a Assemblies) -> Vec<Pair<'a>> {
    let assemblies = scene.assemblies.iter();
    assemblies.flat_map(|(assembly, bodies)| pairs_of(sensor, assembly, bodies)).collect()
}

/// Finds overlaps, and press fits that overlap nowhere; `tick` is called after each pair.
pub(crate) fn examine(
    sensor: &Sensor,
    pairs: &[Pair],
    memo: &Memo,
    tick: &(dyn Fn() + Sync),
) -> Vec<Finding> {
    let verdict = |pair: &Pair| {
        let verdict = remembered(sensor, pair, memo);
        tick();
        verdict
    };
    let verdicts: Vec<Verdict> = pairs.par_iter().map(verdict).collect();
    // Press fits that overlap in any assembly.
    let mut met = vec![false; sensor.press_fits.len()];
    let mut findings = Vec::new();
    for (pair, verdict) in pairs.iter().zip(verdicts) {
        if let Some(fit) = pair.fit {
            met[fit] |= verdict.overlaps;
        }
        findings.extend(verdict.finding);
    }
    for (fit, _) in sensor.press_fits.iter().zip(met).filter(|(_, met)| !met) {
        findings.push(
            Finding::error(
                Rule::Interference,
                format!(
                    "{} is declared to press into {} but overlaps it nowhere",
                    fit.inner, fit.outer
                ),
                "make it larger, or remove the press fit",
            )
            .about_bodies([fit.inner.as_str(), &fit.outer])
            .with_measurement(0.0, fit.interference_mm, "mm"),
        );
    }
    findings
}

/// Iterates over the pairs of one assembly whose bounding boxes overlap.
fn pairs_of<'a>(
    sensor: &'a Sensor,
    assembly: &'a str,
    bodies: &'a [Placed<'a>],
) -> impl Iterator<Item = Pair<'a>> {
    bodies.iter().enumerate().flat_map(move |(i, a)| {
        let near = move |b: &&Placed| !a.body.bounds().common(&b.body.bounds()).is_empty();
        bodies[i + 1..].iter().filter(near).map(move |b| {
            let fit = sensor.press_fits.iter().position(|fit| {
                (fit.inner == a.name && fit.outer == b.name)
                    || (fit.inner == b.name && fit.outer == a.name)
            });
            Pair { assembly, a, b, fit }
        })
    })
}

/// Calls [`examine_pair`] unless the same bodies at the same poses were clean before.
fn remembered(sensor: &Sensor, pair: &Pair, memo: &Memo) -> Verdict {
    let key = Key::new(u64::from(pair.fit.is_some())).key(pair.a.key).key(pair.b.key);
    let key = match pair.fit {
        // The depth does not depend on which of the two is pressed in.
        Some(fit) => key.number(sensor.press_fits[fit].interference_mm),
        None => key,
    };
    let mut verdict = None;
    let is_clean = memo.is_clean(&key, || {
        let found = verdict.insert(examine_pair(sensor, pair));
        found.finding.is_none() && found.overlaps == pair.fit.is_some()
    });
    let clean = Verdict { finding: None, overlaps: pair.fit.is_some() };
    verdict.filter(|_| !is_clean).unwrap_or(clean)
}

/// Examines a pair: its overlap, or the depth of its press fit.
fn examine_pair(sensor: &Sensor, pair: &Pair) -> Verdict {
    let Pair { assembly, a, b, fit } = *pair;
    if let Some(fit) = fit {
        let fit = &sensor.press_fits[fit];
        let (inner, outer) = if fit.inner == a.name { (a, b) } else { (b, a) };
        return examine_fit(fit, assembly, &inner.body, &outer.body);
    }
    let overlap = match overlap_volume(&a.body, &b.body, LINES) {
        Ok(overlap) => overlap,
        // Two unbounded bodies have no finite overlap.
        Err(error) => {
            let fix = "bound at least one of them";
            let finding = Finding::error(Rule::Interference, error.to_string(), fix)
                .in_assembly(assembly)
                .about_bodies([a.name, b.name]);
            return Verdict { finding: Some(finding), overlaps: true };
        }
    };
    let volume_mm3 = overlap.volume.value_mm3;
    let finding = (volume_mm3 > 0.0).then(|| {
        Finding::error(
            Rule::Interference,
            format!("{} and {} overlap", a.name, b.name),
            "move or shrink one of them, or declare a press fit",
        )
        .in_assembly(assembly)
        .about_bodies([a.name, b.name])
        .at_position(overlap.witness)
        .with_measurement(volume_mm3, 0.0, "mm3")
    });
    Verdict { finding, overlaps: volume_mm3 > 0.0 }
}

/// Compares the depth of a press fit with its declaration.
fn examine_fit(
    fit: &PressFit,
    assembly: &str,
    inner: &CompiledSolid,
    outer: &CompiledSolid,
) -> Verdict {
    // The depth is found only to within the refinement's tolerance.
    let allowed_mm = fit.interference_mm * (1.0 + REFINEMENT_REST) + FIT_ROUNDING_MM;
    let Some((depth_mm, place)) = deepest(inner, outer, allowed_mm) else {
        return Verdict { finding: None, overlaps: false };
    };
    let finding = (depth_mm > allowed_mm).then(|| {
        Finding::error(
            Rule::Interference,
            format!("{} presses deeper into {} than its fit says", fit.inner, fit.outer),
            "widen the hole, or declare the fit as it is meant",
        )
        .in_assembly(assembly)
        .about_bodies([fit.inner.as_str(), &fit.outer])
        .at_position(Some(place))
        .with_measurement(depth_mm, fit.interference_mm, "mm")
    });
    Verdict { finding, overlaps: true }
}

/// Finds the deepest overlap of two bodies and its position: the largest of the thicknesses that their common volume
/// has at points within it.
///
/// The search stops as soon as a depth is known not to exceed `allowed_mm`.
pub(crate) fn deepest(
    a: &CompiledSolid,
    b: &CompiledSolid,
    allowed_mm: f64,
) -> Option<(f64, Point3<f64>)> {
    let common = a.bounds().common(&b.bounds());
    if common.is_empty() || !common.is_finite() {
        return None;
    }
    let mut casters = [Caster::default(), Caster::default()];
    let mut met = Vec::new();
    // Outside of these boxes the bodies provably share nothing, so lines that miss them are skipped.
    let boxes = find_overlap_boxes(a, b)?;
    for direction in DIRECTIONS {
        let bundle = Bundle::through(&common, direction.into(), FIT_LINES);
        for ray in bundle.through_boxes(&boxes).map(|index| bundle.line(index)) {
            let [in_a, in_b] = &mut casters;
            let in_a = in_a.intervals(a, &ray);
            // Lines that miss the first body need not be cast through the second.
            let in_b = if in_a.is_empty() { &[] } else { in_b.intervals(b, &ray) };
            for [from_b, to_b] in in_b {
                for [from_a, to_a] in in_a {
                    let (enter, exit) = (from_a.max(*from_b), to_a.min(*to_b));
                    // Touching is no overlap.
                    if exit - enter > FIT_ROUNDING_MM {
                        // The middle of the interval lies inside the common volume.
                        met.push((exit - enter, ray.at(0.5 * (enter + exit))));
                    }
                }
            }
        }
    }
    // An even sample of the points.
    let probes = met.iter().step_by(met.len().div_ceil(FIT_PROBES).max(1));
    probes
        .map(|&(known_mm, point)| {
            (thickness_mm(a, b, point, known_mm, allowed_mm, &mut casters), point)
        })
        .max_by(|x, y| x.0.total_cmp(&y.0))
}

/// Computes the thickness of the common volume of two bodies at a point within it: the length of the shortest line
/// through the point.
///
/// Lines of a fan end near the bounding faces. Lines along the normals of those faces are shorter. The shortest of all
/// is refined further, until one is no longer than `allowed_mm`.
fn thickness_mm(
    a: &CompiledSolid,
    b: &CompiledSolid,
    point: Point3<f64>,
    known_mm: f64,
    allowed_mm: f64,
    casters: &mut [Caster; 2],
) -> f64 {
    let through = |direction: Vector3<f64>, casters: &mut [Caster; 2]| {
        let ray = Ray { origin: point, direction };
        let stretches = common_stretches(a, b, &ray, casters);
        // The stretch that contains the point itself.
        stretches.into_iter().find(|s| s.enter.t <= 0.0 && s.exit.t >= 0.0)
    };
    let mut shortest: Option<Stretch> = None;
    // Called with `None`, returns the shortest stretch so far.
    let mut keep_shorter = |found: Option<Stretch>| {
        let both = shortest.into_iter().chain(found);
        shortest = both.min_by(|x, y| x.length_mm().total_cmp(&y.length_mm()));
        shortest
    };
    // The line that found the point is already short enough.
    if known_mm <= allowed_mm {
        return known_mm;
    }
    for index in 0..FAN {
        let Some(stretch) = through(fan_direction(index), casters) else { continue };
        keep_shorter(Some(stretch));
        for normal in [stretch.enter.normal, stretch.exit.normal] {
            keep_shorter(through(normal, casters));
        }
        if let Some(length_mm) = keep_shorter(None).map(|s| s.length_mm())
            && length_mm <= allowed_mm
        {
            return length_mm;
        }
    }
    for _ in 0..REFINEMENTS {
        let Some(stretch) = keep_shorter(None) else { break };
        for normal in [stretch.enter.normal, stretch.exit.normal] {
            keep_shorter(through(normal, casters));
        }
    }
    keep_shorter(None).map_or(known_mm, |s| s.length_mm().min(known_mm))
}

/// Returns a direction of an even distribution over half a sphere (Swinbank and Purser, "Fibonacci grids", 2006).
fn fan_direction(index: u32) -> Vector3<f64> {
    let z = (f64::from(index) + 0.5) / f64::from(FAN);
    let (sin, cos) = (f64::from(index) * std::f64::consts::PI * (3.0 - 5f64.sqrt())).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    Vector3::new(radius * cos, radius * sin, z)
}

/// Returns the stretches of a line that lie inside both bodies.
fn common_stretches(
    a: &CompiledSolid,
    b: &CompiledSolid,
    ray: &Ray,
    casters: &mut [Caster; 2],
) -> Vec<Stretch> {
    let [in_a, in_b] = casters;
    let in_a: Vec<Stretch> = in_a.stretches(a, ray).collect();
    if in_a.is_empty() {
        return Vec::new();
    }
    let mut common = Vec::new();
    for y in in_b.stretches(b, ray) {
        for x in &in_a {
            let enter = if x.enter.t >= y.enter.t { x.enter } else { y.enter };
            let exit = if x.exit.t <= y.exit.t { x.exit } else { y.exit };
            // Touching is no overlap.
            if exit.t - enter.t > FIT_ROUNDING_MM {
                common.push(Stretch { enter, exit });
            }
        }
    }
    common
}
