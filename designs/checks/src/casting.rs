//! Virtual casting: the cavity that the walls of a pour enclose must equal the layer.
//!
//! Along lines in three directions, a wall must begin where the layer ends. A gap between the two is volume that the
//! liquid would fill as well. An overlap is volume that it cannot fill. The sum of both, the symmetric difference of
//! cavity and layer, must vanish.

use std::collections::BTreeMap;

use fabkit_geometry::{Crossing, Point3, Pour, Ray};
use rayon::prelude::*;

use crate::declaration::rule;
use crate::finding::Finding;
use crate::memo::{Key, Memo};
use crate::opening;
use crate::rule::Rule;
use crate::rule_input::Place;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::{Bundle, Caster, DIRECTIONS, steepness};
use crate::scene::{Assemblies, Placed};

rule! {
    /// The closed cavity of a pour is the layer.
    Casting = "casting",
    examines: "pours",
    finds: "a closed cavity whose shape differs from the layer that is cast in it",
    limit: "faces within 1e-6 mm of each other coincide",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let found = case.pours.iter().flat_map(|(place, pour)| {
        let found = examine(place, pour, case.scene, case.memo);
        (case.tick)();
        found
    });
    Ok((found.collect(), case.pours.len()))
}

/// Number of lines in each of the three directions.
pub(crate) const LINES: usize = 8192;

/// Number of lines per job. It is fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 512;

/// Largest distance across the faces at which layer and wall touch, mm.
pub(crate) const GAP_MM: f64 = 1e-6;

/// Largest symmetric difference of cavity and layer as a fraction of the layer's volume.
pub(crate) const MISMATCH_LIMIT: f64 = 1e-6;

/// Smallest steepness (cosine between line and normal) for converting distances along a line to distances across a
/// face.
const LEAST_STEEPNESS: f64 = 1e-4;

/// Space beyond the layer's surface at one end of a stretch.
enum Beyond {
    /// A wall, or a declared opening.
    Closed,
    /// A gap up to a wall: `gap_mm` wide along the line and `across_mm` wide across the faces.
    Gap { wall: usize, gap_mm: f64, across_mm: f64 },
    /// No wall at all; the line leaves through a face at the steepness `steep`.
    Leak { steep: f64 },
}

/// Volumes by which a wall differs from the layer.
#[derive(Clone, Copy, Debug, Default)]
struct Mismatch {
    gap_mm3: f64,
    overlap_mm3: f64,
    /// Largest distance across the faces, mm, with its position.
    widest: Option<(f64, Point3<f64>)>,
}

#[derive(Clone, Debug, Default)]
/// Sums over lines.
struct Tally {
    /// Volume of the layer, mm3.
    layer_mm3: f64,
    /// Differences by wall.
    by_wall: BTreeMap<usize, Mismatch>,
    /// Leak area for each direction; the direction that looks straight out of the leak sees all of it.
    leak_mm2: [f64; DIRECTIONS.len()],
    /// A point just outside a leak.
    leak: Option<Point3<f64>>,
}

impl Tally {
    fn add(mut self, other: Self) -> Self {
        self.layer_mm3 += other.layer_mm3;
        for (sum, more) in self.leak_mm2.iter_mut().zip(other.leak_mm2) {
            *sum += more;
        }
        // The first leak in the order of the jobs, whatever thread found it.
        self.leak = self.leak.or(other.leak);
        for (wall, more) in other.by_wall {
            let sum = self.by_wall.entry(wall).or_default();
            sum.gap_mm3 += more.gap_mm3;
            sum.overlap_mm3 += more.overlap_mm3;
            sum.widest = wider(sum.widest, more.widest);
        }
        self
    }

    fn mismatch(&mut self, wall: usize, gap_mm3: f64, overlap_mm3: f64, at: (f64, Point3<f64>)) {
        let sum = self.by_wall.entry(wall).or_default();
        sum.gap_mm3 += gap_mm3;
        sum.overlap_mm3 += overlap_mm3;
        sum.widest = wider(sum.widest, Some(at));
    }
}

/// Returns the wider of two gaps.
fn wider(
    a: Option<(f64, Point3<f64>)>,
    b: Option<(f64, Point3<f64>)>,
) -> Option<(f64, Point3<f64>)> {
    match (a, b) {
        (Some(a), Some(b)) if b.0 > a.0 => Some(b),
        (Some(a), _) => Some(a),
        (None, b) => b,
    }
}

/// A pour with its bodies.
struct Cavity<'a> {
    pour: &'a Pour,
    layer: &'a Placed<'a>,
    walls: Vec<&'a Placed<'a>>,
}

/// Finds differences between the cavity and the layer of one pour.
pub(crate) fn examine(place: &Place, pour: &Pour, scene: &Assemblies, memo: &Memo) -> Vec<Finding> {
    let bodies = scene.bodies(place.assembly);
    let is_wall = |placed: &&Placed| pour.walls.iter().any(|wall| wall == placed.name);
    let Some(layer) = bodies.iter().find(|placed| placed.name == pour.layer) else {
        // The rule of the chain reports missing layers.
        return Vec::new();
    };
    let cavity = Cavity { pour, layer, walls: bodies.iter().filter(is_wall).collect() };
    let key = opening::add_to_key(Key::new(2).key(layer.key), &pour.openings);
    let key = cavity.walls.iter().fold(key, |key, wall| key.key(wall.key));
    let mut findings = Vec::new();
    memo.is_clean(&key, || {
        findings = findings_of(place, &cavity, bodies);
        findings.is_empty()
    });
    findings
}

/// Reports leaks, and differences between cavity and layer by wall.
fn findings_of(place: &Place, cavity: &Cavity, bodies: &[Placed]) -> Vec<Finding> {
    let tally = cast(cavity);
    let pour = cavity.pour;
    let mut findings = Vec::new();
    if tally.leak.is_some() {
        findings.push(leak(place, cavity, &tally, bodies));
    }
    // A finding names a body, so placements of one wall are summed.
    let mut by_name = BTreeMap::<&str, Mismatch>::new();
    for (wall, more) in &tally.by_wall {
        let sum = by_name.entry(cavity.walls[*wall].name).or_default();
        sum.gap_mm3 += more.gap_mm3;
        sum.overlap_mm3 += more.overlap_mm3;
        sum.widest = wider(sum.widest, more.widest);
    }
    let total_mm3: f64 = by_name.values().map(|m| m.gap_mm3 + m.overlap_mm3).sum();
    if total_mm3 > MISMATCH_LIMIT * tally.layer_mm3 {
        findings.extend(
            by_name
                .iter()
                .map(|(wall, mismatch)| mismatched(place, pour, wall, mismatch, tally.layer_mm3)),
        );
    }
    findings
}

fn mismatched(
    place: &Place,
    pour: &Pour,
    wall: &str,
    mismatch: &Mismatch,
    layer_mm3: f64,
) -> Finding {
    let Mismatch { gap_mm3, overlap_mm3, widest } = mismatch;
    let (widest_mm, at) = widest.unzip();
    Finding::error(
        Rule::Casting,
        format!(
            "the cavity is not the {}: beside {wall} there are {gap_mm3:.3} mm3 too much and \
             {overlap_mm3:.3} mm3 too little, up to {:.4} mm from face to face",
            pour.layer,
            widest_mm.unwrap_or(0.0)
        ),
        "derive the wall from the layer, with the same numbers",
    )
    .in_step(place.step)
    .in_assembly(place.assembly)
    .about_bodies([pour.layer.as_str(), wall])
    .at_position(at)
    .with_measurement((gap_mm3 + overlap_mm3) / layer_mm3, MISMATCH_LIMIT, "of the volume")
}

fn leak(place: &Place, cavity: &Cavity, tally: &Tally, bodies: &[Placed]) -> Finding {
    let layer = cavity.layer;
    // A body may stand there and have been left out of the walls.
    let other = tally.leak.and_then(|point| {
        let others = bodies.iter().filter(|b| b.name != layer.name);
        others
            .filter(|b| !cavity.pour.walls.iter().any(|wall| wall == b.name))
            .find(|b| b.body.bounds().contains(&point) && b.body.contains(&point))
    });
    let fix = match other {
        Some(other) => format!("{} stands there; name it among the walls", other.name),
        None => "close the cavity, or declare the opening".into(),
    };
    Finding::error(Rule::Casting, format!("the cavity of the {} is open", layer.name), fix)
        .in_step(place.step)
        .in_assembly(place.assembly)
        .about_bodies(std::iter::once(layer.name).chain(other.map(|b| b.name)))
        .at_position(tally.leak)
        .with_measurement(tally.leak_mm2.into_iter().fold(0.0, f64::max), 0.0, "mm2")
}

/// Casts all lines through the layer.
fn cast(cavity: &Cavity) -> Tally {
    let bounds = cavity.layer.body.bounds();
    let bundles = DIRECTIONS.map(|d| Bundle::through(&bounds, d.into(), LINES));
    let jobs: Vec<(usize, usize)> = (0..bundles.len())
        .flat_map(|direction| (0..LINES).step_by(CHUNK).map(move |from| (direction, from)))
        .collect();
    let tallies: Vec<Tally> = jobs
        .par_iter()
        .map(|&(direction, from)| cast_chunk(cavity, &bundles[direction], direction, from))
        .collect();
    tallies.into_iter().fold(Tally::default(), Tally::add)
}

fn cast_chunk(cavity: &Cavity, bundle: &Bundle, direction: usize, from: usize) -> Tally {
    // Each direction alone measures the whole volume, so a third of it is counted for each.
    let cell_mm2 = bundle.cell_mm2() / DIRECTIONS.len() as f64;
    let mut tally = Tally::default();
    let mut line = Line { cavity, caster: Caster::default(), layer: Vec::new(), walls: Vec::new() };
    for ray in (from..from + CHUNK).map(|index| bundle.line(index)) {
        line.cast(&ray);
        for stretch in line.layer.clone() {
            tally.layer_mm3 += (stretch[1] - stretch[0]) * cell_mm2;
            for (wall, other) in line.walls.clone() {
                if let Some((length_mm, deep_mm, middle)) = line.overlap(&ray, stretch, wall, other)
                {
                    tally.mismatch(wall, 0.0, length_mm * cell_mm2, (deep_mm, middle));
                }
            }
            for (end_mm, sign) in [(stretch[0], -1.0), (stretch[1], 1.0)] {
                match line.beyond(&ray, end_mm, sign) {
                    Beyond::Closed => {}
                    Beyond::Gap { wall, gap_mm, across_mm } => {
                        let middle = ray.at(end_mm + 0.5 * sign * gap_mm);
                        tally.mismatch(wall, gap_mm * cell_mm2, 0.0, (across_mm, middle));
                    }
                    Beyond::Leak { steep } => {
                        tally.leak_mm2[direction] += bundle.cell_mm2() / steep.max(LEAST_STEEPNESS);
                        // The point is moved outwards, so that a body that stands there contains it.
                        tally.leak.get_or_insert(ray.at(end_mm + sign * 10.0 * GAP_MM));
                    }
                }
            }
        }
    }
    tally
}

/// Intervals of one line inside the layer and inside the walls, mm. Normals are computed on demand: they take as long
/// as the intervals, and nearly all lines of a sound mold need none.
struct Line<'a> {
    cavity: &'a Cavity<'a>,
    caster: Caster,
    layer: Vec<[f64; 2]>,
    walls: Vec<(usize, [f64; 2])>,
}

impl Line<'_> {
    fn cast(&mut self, ray: &Ray) {
        let Self { cavity, caster, layer, walls } = self;
        layer.clear();
        layer.extend_from_slice(caster.intervals(&cavity.layer.body, ray));
        walls.clear();
        if layer.is_empty() {
            return;
        }
        for (wall, placed) in cavity.walls.iter().enumerate() {
            walls.extend(caster.intervals(&placed.body, ray).iter().map(|ends| (wall, *ends)));
        }
    }

    /// Returns the face of the layer (`wall` is `None`) or of a wall at a position on the line.
    fn face(&mut self, wall: Option<usize>, ray: &Ray, at_mm: f64) -> Option<Crossing> {
        let body = wall.map_or(&self.cavity.layer.body, |wall| &self.cavity.walls[wall].body);
        let mut stretches = self.caster.stretches(body, ray);
        // Exact comparison is safe: intervals and crossings come from the same spans of the solid.
        stretches.find_map(|s| [s.enter, s.exit].into_iter().find(|end| end.t == at_mm))
    }

    /// Returns the steepness of a face at a position on the line; 1 if there is no face.
    fn steepness(&mut self, wall: Option<usize>, ray: &Ray, at_mm: f64) -> f64 {
        self.face(wall, ray, at_mm).map_or(1.0, |face| steepness(ray, &face))
    }

    /// Returns the length, the depth across the faces, and the middle of the interval that layer and wall share.
    fn overlap(
        &mut self,
        ray: &Ray,
        layer: [f64; 2],
        wall: usize,
        other: [f64; 2],
    ) -> Option<(f64, f64, Point3<f64>)> {
        let enter = if layer[0] >= other[0] { (None, layer[0]) } else { (Some(wall), other[0]) };
        let exit = if layer[1] <= other[1] { (None, layer[1]) } else { (Some(wall), other[1]) };
        let length_mm = exit.1 - enter.1;
        // The depth across the faces never exceeds the length.
        if length_mm <= GAP_MM {
            return None;
        }
        // The less steep face bounds the depth.
        let [at_enter, at_exit] = [enter, exit].map(|(of, at_mm)| self.steepness(of, ray, at_mm));
        let depth_mm = length_mm * at_enter.min(at_exit);
        (depth_mm > GAP_MM).then(|| (length_mm, depth_mm, ray.at(0.5 * (enter.1 + exit.1))))
    }

    /// Finds what lies beyond the end of a stretch of the layer, forwards (`sign` 1) or backwards (-1).
    fn beyond(&mut self, ray: &Ray, end_mm: f64, sign: f64) -> Beyond {
        // Distances along the line from the layer's end to the near and the far face of each wall.
        let ahead = |(wall, ends): &(usize, [f64; 2])| {
            let [near, far] = if sign > 0.0 { *ends } else { [ends[1], ends[0]] };
            (*wall, near, (near - end_mm) * sign, (far - end_mm) * sign)
        };
        // A wall that begins here and is thick enough closes the cavity at any angle, so no normal is needed.
        let thick_mm = GAP_MM / LEAST_STEEPNESS;
        let closes = |(_, _, near_mm, far_mm)| near_mm <= GAP_MM && far_mm > thick_mm;
        if self.walls.iter().map(ahead).any(closes) {
            return Beyond::Closed;
        }
        let Some(end) = self.face(None, ray, end_mm) else { return Beyond::Closed };
        let steep = steepness(ray, &end);
        let tolerance_mm = GAP_MM / steep.max(LEAST_STEEPNESS);
        // Nearest wall that does not end at once.
        let lasting = self.walls.iter().map(ahead).filter(|(_, _, _, far)| *far > tolerance_mm);
        let nearest = lasting.min_by(|a, b| a.2.total_cmp(&b.2));
        if nearest.is_some_and(|(_, _, near_mm, _)| near_mm <= tolerance_mm) {
            return Beyond::Closed;
        }
        let (point, openings) = (ray.at(end_mm), &self.cavity.pour.openings);
        if openings.iter().any(|o| opening::contains_surface_point(o, &point, &end.normal, 0.0)) {
            return Beyond::Closed;
        }
        let Some((wall, face_mm, gap_mm, _)) = nearest else { return Beyond::Leak { steep } };
        let across_mm = gap_mm * steep.min(self.steepness(Some(wall), ray, face_mm));
        Beyond::Gap { wall, gap_mm, across_mm }
    }
}
