//! Outlets: an opening lets air out only where a way leads from it to the outside.
//!
//! From a place where the layer ends in the opening, straight lines are followed through what its walls
//! leave free, first along the opening's axis, then from places along those lines to their sides, until
//! one meets nothing any more. Where none does, the room behind the opening is closed: a channel with
//! one end, a vent that a lid covers.

use std::collections::{HashSet, VecDeque};

use fabkit_geometry::{CompiledSolid, Opening, Point3, Pour, Ray, Vector3};

use crate::case::Place;
use crate::finding::Finding;
use crate::lines::{Caster, basis};
use crate::memo::{Key, Memo};
use crate::opening;
use crate::rule::Rule;
use crate::scene::Assemblies;

/// Distance of places from which lines are followed, mm; what is narrower may be missed. It has no common
/// measure with what parts are made in: a line in the plane in which two parts meet would slip between them.
const STEP_MM: f64 = 0.293_1;

/// Off a surface, so that a place is clearly on one side of it, mm.
const OFF_MM: f64 = 1e-3;

/// Places of an opening's disc that are tried for one where the layer ends.
const STARTS: u32 = 64;

/// Turn from one of them to the next, rad: the golden angle spreads them evenly.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;

/// Places after which a room counts as too large to be a bubble.
const MOST_PLACES: usize = 20_000;

/// All findings about one pour.
pub(crate) fn examine(place: &Place, pour: &Pour, scene: &Assemblies, memo: &Memo) -> Vec<Finding> {
    let Some(layer) = scene.places(place.assembly, &pour.layer).first().copied() else {
        return Vec::new();
    };
    let bodies = scene.bodies(place.assembly).iter();
    let walls: Vec<_> =
        bodies.filter(|placed| pour.walls.iter().any(|wall| wall == placed.name)).collect();
    let key = opening::keyed(Key::new(17).key(layer.key), &pour.openings);
    let key = walls.iter().fold(key, |key, wall| key.key(wall.key));
    let mut findings = Vec::new();
    memo.is_clean(&key, || {
        let mut solids = vec![&layer.body];
        solids.extend(walls.iter().map(|wall| &wall.body));
        let mut way = Way::new(&solids);
        let closed: Vec<&Opening> =
            pour.openings.iter().filter(|opening| !leads_out(opening, &mut way)).collect();
        findings.extend(finding(place, pour, &closed));
        findings.is_empty()
    });
    findings
}

/// One cause, one finding, whatever the number of openings.
fn finding(place: &Place, pour: &Pour, closed: &[&Opening]) -> Option<Finding> {
    let first = closed.first()?;
    let others = match closed.len() {
        1 => String::new(),
        count => format!(" (and {} more)", count - 1),
    };
    let message = format!(
        "air cannot leave the {}: behind its opening {}{others} lies a closed room",
        pour.layer, first.name
    );
    let fix = "give that room a vent to the outside, and close it after the pour if need be";
    Some(
        Finding::error(Rule::TrappedAir, message, fix)
            .in_step(place.step)
            .in_assembly(place.assembly)
            .of([pour.layer.as_str()])
            .at(Some(first.point)),
    )
}

/// Whether a way leads from an opening to the outside.
fn leads_out(opening: &Opening, way: &mut Way) -> bool {
    // Where the layer does not end in it, other rules say so.
    start(opening, way.solids).is_none_or(|start| way.is_found(start, opening.axis))
}

/// A place just outside of the layer, on the opening's disc.
fn start(opening: &Opening, solids: &[&CompiledSolid]) -> Option<Point3<f64>> {
    let (layer, walls) = solids.split_first()?;
    let [u, v] = basis(&opening.axis);
    let on_disc = |i: u32| {
        let radius = opening.radius_mm * (f64::from(i) / f64::from(STARTS)).sqrt();
        let (sin, cos) = (GOLDEN_RAD * f64::from(i)).sin_cos();
        opening.point + radius * (cos * u + sin * v)
    };
    (0..STARTS).map(on_disc).find_map(|at| {
        let outside = at + OFF_MM * opening.axis;
        let is_end = layer.contains(&(at - OFF_MM * opening.axis)) && !layer.contains(&outside);
        (is_end && !walls.iter().any(|wall| wall.contains(&outside))).then_some(outside)
    })
}

/// Ways between bodies, the layer first.
struct Way<'a> {
    solids: &'a [&'a CompiledSolid],
    /// Places from which a way out has been found: openings into one room share them.
    outside: HashSet<[i64; 3]>,
    /// Places that lines have reached from the present opening.
    seen: HashSet<[i64; 3]>,
    /// Those to look around from, with the direction of the line that led there.
    reached: VecDeque<(Point3<f64>, Vector3<f64>)>,
    caster: Caster,
}

impl<'a> Way<'a> {
    fn new(solids: &'a [&'a CompiledSolid]) -> Self {
        Self {
            solids,
            outside: HashSet::new(),
            seen: HashSet::new(),
            reached: VecDeque::new(),
            caster: Caster::default(),
        }
    }

    /// Whether any line leads out.
    fn is_found(&mut self, start: Point3<f64>, axis: Vector3<f64>) -> bool {
        self.seen.clear();
        self.reached.clear();
        let is_found = self.search(start, axis);
        if is_found {
            self.outside.extend(self.seen.drain());
        }
        is_found
    }

    fn search(&mut self, start: Point3<f64>, axis: Vector3<f64>) -> bool {
        if self.follow(start, axis) {
            return true;
        }
        let [u, v] = basis(&axis);
        while let Some((place, along)) = self.reached.pop_front() {
            let across = [axis, -axis, u, -u, v, -v];
            let mut across = across.into_iter().filter(|to| to.dot(&along).abs() < 0.5);
            if across.any(|to| self.follow(place, to)) || self.seen.len() > MOST_PLACES {
                return true;
            }
        }
        false
    }

    /// Notes the places along a line up to the first body; whether there is none, or the way out from
    /// one of the places is known.
    fn follow(&mut self, origin: Point3<f64>, direction: Vector3<f64>) -> bool {
        let ray = Ray { origin, direction };
        let mut free_mm = f64::INFINITY;
        for solid in self.solids {
            let ahead = self.caster.ends(solid, &ray).iter().find(|[_, exit]| *exit > 0.0);
            free_mm = ahead.map_or(free_mm, |[enter, _]| free_mm.min(enter.max(0.0)));
        }
        if free_mm.is_infinite() {
            return true;
        }
        // Not on the surface that ends the line.
        let steps = ((free_mm - OFF_MM).max(0.0) / STEP_MM) as usize;
        (1..=steps).any(|i| {
            let place = origin + STEP_MM * i as f64 * direction;
            let cell = [place.x, place.y, place.z].map(|x| (x / STEP_MM).round() as i64);
            if self.seen.insert(cell) {
                self.reached.push_back((place, direction));
            }
            self.outside.contains(&cell)
        })
    }
}
