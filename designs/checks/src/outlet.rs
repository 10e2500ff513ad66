//! Outlets: an opening lets air out only if a path leads from it to the outside.
//!
//! The search starts at a point where the layer ends in the opening. It follows straight lines through the space
//! between the walls: first along the opening's axis, then sideways from points along those lines, until a line meets
//! nothing any more. If none does, the space behind the opening is closed, like a channel with one end or a vent under
//! a lid.

use std::collections::{HashSet, VecDeque};

use fabkit_geometry::{CompiledSolid, Opening, Point3, Pour, Ray, Vector3};

use crate::finding::Finding;
use crate::memo::{Key, Memo};
use crate::opening;
use crate::rule::Rule;
use crate::rule_input::Place;
use crate::sampling_lines::{Caster, basis};
use crate::scene::Assemblies;

/// Spacing of the points from which lines are followed, mm; narrower channels may be missed. It is not a multiple of
/// usual dimensions: a line in the plane in which two parts meet would slip between them.
const STEP_MM: f64 = 0.293_1;

/// Offset from a surface, so that a point is clearly on one side of it, mm.
const OFF_MM: f64 = 1e-3;

/// Number of points of an opening's disc that are tried as starts.
const STARTS: u32 = 64;

/// Rotation from one such point to the next, rad: the golden angle spreads them evenly.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;

/// Number of points after which a space counts as too large to be a bubble.
const MOST_PLACES: usize = 20_000;

/// Finds openings of one pour that lead into a closed space.
pub(crate) fn examine(place: &Place, pour: &Pour, scene: &Assemblies, memo: &Memo) -> Vec<Finding> {
    let Some(layer) = scene.places(place.assembly, &pour.layer).first().copied() else {
        return Vec::new();
    };
    let bodies = scene.bodies(place.assembly).iter();
    let walls: Vec<_> =
        bodies.filter(|placed| pour.walls.iter().any(|wall| wall == placed.name)).collect();
    let key = opening::add_to_key(Key::new(17).key(layer.key), &pour.openings);
    // The path depends on the walls too, unlike the search for pockets.
    let key = walls.iter().fold(key, |key, wall| key.key(wall.key));
    let mut findings = Vec::new();
    memo.is_clean(&key, || {
        // The layer comes first: it also blocks lines, since it is liquid.
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

/// Reports all closed openings in one finding, since they usually have one cause.
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
            .about_bodies([pour.layer.as_str()])
            .at_position(Some(first.point)),
    )
}

/// Returns whether a path leads from an opening to the outside.
fn leads_out(opening: &Opening, way: &mut Way) -> bool {
    // An opening in which the layer does not end is reported by other rules.
    start(opening, way.solids).is_none_or(|start| way.is_found(start, opening.axis))
}

/// Finds a point on the opening's disc just outside the layer and outside all walls.
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
        // Just inside the layer on one side, outside of it on the other.
        let is_end = layer.contains(&(at - OFF_MM * opening.axis)) && !layer.contains(&outside);
        (is_end && !walls.iter().any(|wall| wall.contains(&outside))).then_some(outside)
    })
}

/// Search for paths between bodies; the first body is the layer.
struct Way<'a> {
    solids: &'a [&'a CompiledSolid],
    /// Grid cells from which a path out is known; openings into one space share them.
    outside: HashSet<[i64; 3]>,
    /// Grid cells reached from the current opening.
    seen: HashSet<[i64; 3]>,
    /// Queue of points to search from, each with the direction of the line that reached it.
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

    /// Returns whether a path leads out from `start`.
    fn is_found(&mut self, start: Point3<f64>, axis: Vector3<f64>) -> bool {
        self.seen.clear();
        self.reached.clear();
        let is_found = self.search(start, axis);
        if is_found {
            // Every cell reached on the way is connected with the outside, too.
            self.outside.extend(self.seen.drain());
        }
        is_found
    }

    /// Searches the space behind an opening, breadth first.
    fn search(&mut self, start: Point3<f64>, axis: Vector3<f64>) -> bool {
        if self.follow(start, axis) {
            return true;
        }
        let [u, v] = basis(&axis);
        while let Some((place, along)) = self.reached.pop_front() {
            let across = [axis, -axis, u, -u, v, -v];
            // Only directions across the line that led here; along it all points are known.
            let mut across = across.into_iter().filter(|to| to.dot(&along).abs() < 0.5);
            // So large a space holds the air without a vent.
            if across.any(|to| self.follow(place, to)) || self.seen.len() > MOST_PLACES {
                return true;
            }
        }
        false
    }

    /// Follows a line up to the first body and queues the points along it. Returns whether the line meets no body, or
    /// reaches a point from which a path out is known.
    fn follow(&mut self, origin: Point3<f64>, direction: Vector3<f64>) -> bool {
        let ray = Ray { origin, direction };
        let mut free_mm = f64::INFINITY;
        for solid in self.solids {
            let ahead = self.caster.intervals(solid, &ray).iter().find(|[_, exit]| *exit > 0.0);
            // The first body ahead, or zero if the line starts inside one.
            free_mm = ahead.map_or(free_mm, |[enter, _]| free_mm.min(enter.max(0.0)));
        }
        if free_mm.is_infinite() {
            return true;
        }
        // The last point stays off the surface that ends the line.
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
