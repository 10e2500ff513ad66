//! Virtual casting: what the walls of a pour enclose is the layer, no more and no less.
//!
//! Along lines in three directions, a wall must begin where the layer ends. What lies between them
//! is volume that the liquid would fill as well; what both claim is volume that it cannot fill. The
//! two together, the symmetric difference of cavity and layer, must vanish.

use std::collections::BTreeMap;

use fabkit_geometry::{Crossing, Point3, Pour, Ray};
use rayon::prelude::*;

use crate::chain::Place;
use crate::finding::{Finding, Rule};
use crate::lines::{Bundle, Caster, DIRECTIONS, Stretch, steepness};
use crate::memo::{Key, Memo};
use crate::opening;
use crate::scene::{Assemblies, Placed};

/// Lines of each of the three directions.
pub(crate) const LINES: usize = 8192;

/// Lines handled at once; sums do not depend on the number of threads.
const CHUNK: usize = 512;

/// Layer and wall are together if they are nearer than this, across the face, mm.
pub(crate) const GAP_MM: f64 = 1e-6;

/// Largest symmetric difference of cavity and layer as a fraction of the layer's volume.
pub(crate) const MISMATCH_LIMIT: f64 = 1e-6;

/// Below this steepness the distance across a face says nothing about the one along the line.
const LEAST_STEEPNESS: f64 = 1e-4;

/// What lies beyond the layer's surface at one end of a stretch.
enum Beyond {
    /// A wall, or a declared opening.
    Closed,
    /// Nothing up to a wall, `gap_mm` away along the line, `across_mm` from face to face.
    Gap { wall: usize, gap_mm: f64, across_mm: f64 },
    /// Nothing at all.
    Leak,
}

/// How a wall misses the layer.
#[derive(Clone, Copy, Debug, Default)]
struct Mismatch {
    gap_mm3: f64,
    overlap_mm3: f64,
    /// Largest distance across the face, mm, and where.
    widest: Option<(f64, Point3<f64>)>,
}

#[derive(Clone, Debug, Default)]
struct Tally {
    layer_mm3: f64,
    by_wall: BTreeMap<usize, Mismatch>,
    /// For each direction; one that looks straight out of the leak sees all of it.
    leak_mm2: [f64; DIRECTIONS.len()],
    leak: Option<Point3<f64>>,
}

impl Tally {
    fn add(mut self, other: Self) -> Self {
        self.layer_mm3 += other.layer_mm3;
        for (sum, more) in self.leak_mm2.iter_mut().zip(other.leak_mm2) {
            *sum += more;
        }
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

/// One pour with its bodies.
struct Cavity<'a> {
    pour: &'a Pour,
    layer: &'a Placed<'a>,
    walls: Vec<&'a Placed<'a>>,
}

/// All findings about one pour.
pub(crate) fn examine(place: &Place, pour: &Pour, scene: &Assemblies, memo: &Memo) -> Vec<Finding> {
    let bodies = scene.bodies(place.assembly);
    let is_wall = |placed: &&Placed| pour.walls.iter().any(|wall| wall == placed.name);
    let Some(layer) = bodies.iter().find(|placed| placed.name == pour.layer) else {
        // The chain's own rule says so.
        return Vec::new();
    };
    let cavity = Cavity { pour, layer, walls: bodies.iter().filter(is_wall).collect() };
    let key = opening::keyed(Key::new(2).key(layer.key), &pour.openings);
    let key = cavity.walls.iter().fold(key, |key, wall| key.key(wall.key));
    let mut findings = Vec::new();
    memo.is_clean(&key, || {
        findings = findings_of(place, &cavity, bodies);
        findings.is_empty()
    });
    findings
}

fn findings_of(place: &Place, cavity: &Cavity, bodies: &[Placed]) -> Vec<Finding> {
    let tally = cast(cavity);
    let pour = cavity.pour;
    let mut findings = Vec::new();
    if tally.leak.is_some() {
        findings.push(leak(place, cavity, &tally, bodies));
    }
    // Several placements of one wall are one body to whoever reads this.
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
    .of([pour.layer.as_str(), wall])
    .at(at)
    .measured((gap_mm3 + overlap_mm3) / layer_mm3, MISMATCH_LIMIT, "of the volume")
}

fn leak(place: &Place, cavity: &Cavity, tally: &Tally, bodies: &[Placed]) -> Finding {
    let layer = cavity.layer;
    // What stands there may merely have been forgotten.
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
        .of(std::iter::once(layer.name).chain(other.map(|b| b.name)))
        .at(tally.leak)
        .measured(tally.leak_mm2.into_iter().fold(0.0, f64::max), 0.0, "mm2")
}

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
    // Each direction alone measures the whole.
    let cell_mm2 = bundle.cell_mm2() / DIRECTIONS.len() as f64;
    let mut caster = Caster::default();
    let mut tally = Tally::default();
    let mut in_walls: Vec<(usize, Stretch)> = Vec::new();
    for index in from..from + CHUNK {
        let ray = bundle.line(index);
        let in_layer: Vec<Stretch> = caster.stretches(&cavity.layer.body, &ray).collect();
        if in_layer.is_empty() {
            continue;
        }
        in_walls.clear();
        for (wall, placed) in cavity.walls.iter().enumerate() {
            in_walls.extend(caster.stretches(&placed.body, &ray).map(|s| (wall, s)));
        }
        for stretch in &in_layer {
            tally.layer_mm3 += stretch.length_mm() * cell_mm2;
            for (wall, other) in &in_walls {
                if let Some((length_mm, deep_mm, middle)) = overlap(&ray, stretch, other) {
                    tally.mismatch(*wall, 0.0, length_mm * cell_mm2, (deep_mm, middle));
                }
            }
            for (end, sign) in [(&stretch.enter, -1.0), (&stretch.exit, 1.0)] {
                match beyond(cavity, &ray, end, sign, &in_walls) {
                    Beyond::Closed => {}
                    Beyond::Gap { wall, gap_mm, across_mm } => {
                        let middle = ray.at(end.t + 0.5 * sign * gap_mm);
                        tally.mismatch(wall, gap_mm * cell_mm2, 0.0, (across_mm, middle));
                    }
                    Beyond::Leak => {
                        let area_mm2 =
                            bundle.cell_mm2() / steepness(&ray, end).max(LEAST_STEEPNESS);
                        tally.leak_mm2[direction] += area_mm2;
                        tally.leak.get_or_insert(ray.at(end.t + sign * 10.0 * GAP_MM));
                    }
                }
            }
        }
    }
    tally
}

/// Length, depth across the faces, and middle of what a line has in layer and wall.
fn overlap(ray: &Ray, layer: &Stretch, wall: &Stretch) -> Option<(f64, f64, Point3<f64>)> {
    let enter = if layer.enter.t >= wall.enter.t { layer.enter } else { wall.enter };
    let exit = if layer.exit.t <= wall.exit.t { layer.exit } else { wall.exit };
    let length_mm = exit.t - enter.t;
    let depth_mm = length_mm * steepness(ray, &enter).min(steepness(ray, &exit));
    (depth_mm > GAP_MM).then(|| (length_mm, depth_mm, ray.at(0.5 * (enter.t + exit.t))))
}

/// What follows where the line leaves the layer, forwards (`sign` 1) or backwards (-1).
fn beyond(
    cavity: &Cavity,
    ray: &Ray,
    end: &Crossing,
    sign: f64,
    in_walls: &[(usize, Stretch)],
) -> Beyond {
    let steep = steepness(ray, end);
    let tolerance_mm = GAP_MM / steep.max(LEAST_STEEPNESS);
    // The nearest wall that does not end at once, with its face towards the layer.
    let ahead = in_walls.iter().map(|(wall, stretch)| {
        let (near, far) = match sign > 0.0 {
            true => (stretch.enter, stretch.exit),
            false => (stretch.exit, stretch.enter),
        };
        (*wall, (near.t - end.t) * sign, (far.t - end.t) * sign, near)
    });
    let nearest =
        ahead.filter(|(_, _, far_mm, _)| *far_mm > tolerance_mm).min_by(|a, b| a.1.total_cmp(&b.1));
    if nearest.is_some_and(|(_, near_mm, _, _)| near_mm <= tolerance_mm) {
        return Beyond::Closed;
    }
    let point = ray.at(end.t);
    if cavity.pour.openings.iter().any(|o| opening::holds(o, &point, &end.normal, 0.0)) {
        return Beyond::Closed;
    }
    match nearest {
        Some((wall, gap_mm, _, face)) => {
            Beyond::Gap { wall, gap_mm, across_mm: gap_mm * steep.min(steepness(ray, &face)) }
        }
        None => Beyond::Leak,
    }
}
