//! Arrivals: which bodies come to their places in each step and assembly, and which stand there already.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{Action, Adjustment, BodyKind, Occasion, Pose, Sensor, Step};

use crate::rule_input::Place;
use crate::scene::{Assemblies, Placed};

/// Largest difference of equal poses, mm and parts of 1.
const SAME: f64 = 1e-9;

/// Distance at which bounding boxes count as touching, mm.
const TOUCHING_MM: f64 = 0.1;

/// A step that brings bodies to their places.
pub(crate) struct Arrival<'a> {
    pub(crate) place: Place<'a>,
    pub(crate) step: &'a Step,
    /// Bodies that stand there before the step.
    pub(crate) standing: Vec<&'a Placed<'a>>,
    /// Bodies that the step brings, grouped into pieces that move as one, in the order in which the step names them.
    pub(crate) coming: Vec<Vec<&'a Placed<'a>>>,
}

/// A step in which tools work on bodies that stand in an assembly.
pub(crate) struct Work<'a> {
    pub(crate) place: Place<'a>,
    pub(crate) occasion: Occasion,
    /// Bodies on which the tools work.
    pub(crate) on: Vec<&'a Placed<'a>>,
    /// All bodies that stand there, including those on which the tools work.
    pub(crate) around: Vec<&'a Placed<'a>>,
}

/// Returns every step that brings bodies, in order, and every step that pours, adjusts or demolds.
pub(crate) fn arrivals<'a>(
    sensor: &'a Sensor,
    scene: &'a Assemblies<'a>,
) -> (Vec<Arrival<'a>>, Vec<Work<'a>>) {
    let mut history = AssemblyHistory::new(sensor, scene);
    let arrivals = sensor.chain.iter().filter_map(|step| history.step(step)).collect();
    (arrivals, history.work)
}

/// State of all assemblies while the chain is followed step by step.
pub(super) struct AssemblyHistory<'a> {
    sensor: &'a Sensor,
    scene: &'a Assemblies<'a>,
    /// Indices of the bodies that stand in each assembly.
    standing: BTreeMap<&'a str, BTreeSet<usize>>,
    /// Work of tools so far.
    work: Vec<Work<'a>>,
}

/// Returns the layer that a step makes in place, which is therefore not brought.
fn made(step: &Step) -> Option<&str> {
    match &step.action {
        Action::Pour(pour) => Some(&pour.layer),
        Action::Spray(spray) => Some(&spray.layer),
        _ => None,
    }
}

/// Iterates over the names of the bodies that a step needs in its assembly.
fn needed(step: &Step) -> impl Iterator<Item = &str> {
    let more: &[String] = match &step.action {
        Action::Pour(pour) => &pour.walls,
        Action::Spray(spray) => &spray.onto,
        _ => &[],
    };
    let layer = made(step);
    step.bodies.iter().chain(more).map(String::as_str).filter(move |name| layer != Some(*name))
}

impl<'a> AssemblyHistory<'a> {
    pub(super) fn new(sensor: &'a Sensor, scene: &'a Assemblies<'a>) -> Self {
        Self { sensor, scene, standing: BTreeMap::new(), work: Vec::new() }
    }

    /// Returns the bodies that stand in an assembly now, in the order of the sensor's lists.
    pub(super) fn standing(&mut self, assembly: &'a str) -> Vec<&'a Placed<'a>> {
        let scene = self.scene;
        if !self.standing.contains_key(assembly) {
            let brought = self.initial_bodies(assembly);
            self.standing.insert(assembly, brought);
        }
        self.standing[assembly].iter().map(|&i| &scene.bodies(assembly)[i]).collect()
    }

    /// Applies a step to the assemblies. Returns the arrival, if the step brings bodies.
    pub(super) fn step(&mut self, step: &'a Step) -> Option<Arrival<'a>> {
        let assembly = step.assembly.as_ref()?.0.as_str();
        let bodies = self.scene.bodies(assembly);
        // Fills the entry of this assembly on its first use, before pieces are looked up in it.
        self.standing(assembly);
        let arrival = self.arrival(step, assembly);
        let standing = self.standing.entry(assembly).or_default();
        if let Some(arrival) = &arrival {
            let coming = arrival.coming.iter().flatten();
            standing.extend(coming.filter_map(|placed| number(bodies, placed)));
        }
        let occasion = match &step.action {
            Action::Pour(_) => Some(Occasion::Pour),
            Action::Demold(_) => Some(Occasion::Removal),
            _ => None,
        };
        let around: Vec<&Placed> = standing.iter().map(|&i| &bodies[i]).collect();
        let place = Place { step: &step.name, assembly };
        self.work.extend(adjusted(step, place, arrival.as_ref(), &around));
        let on = around.clone();
        self.work.extend(occasion.map(|occasion| Work { place, occasion, on, around }));
        let is_made = |placed: &Placed| made(step) == Some(placed.name);
        // The layer stands in the mold only after the tools of the pour have worked.
        standing.extend((0..bodies.len()).filter(|&i| is_made(&bodies[i])));
        if let Action::Demold(pulls) = &step.action {
            let is_pulled = |name: &str| pulls.iter().any(|pull| pull.body == name);
            let fits = &self.sensor.press_fits;
            // Bodies pressed into a tool leave with it, and screws leave before any tool comes off.
            let goes_with =
                |name: &str| fits.iter().any(|fit| fit.inner == name && is_pulled(&fit.outer));
            let stays = |placed: &Placed| {
                !(is_pulled(placed.name) || goes_with(placed.name) || placed.is_drawn())
            };
            standing.retain(|&i| stays(&bodies[i]));
        }
        arrival
    }

    /// Finds the bodies that a step brings, grouped into pieces.
    fn arrival(&self, step: &'a Step, assembly: &'a str) -> Option<Arrival<'a>> {
        let bodies = self.scene.bodies(assembly);
        let standing = &self.standing[assembly];
        let pieces = self.pieces(assembly);
        let mut coming: Vec<Vec<&Placed>> = Vec::new();
        let mut known = BTreeSet::new();
        let wait = self.deferred_bodies(step, assembly);
        for name in needed(step) {
            for i in (0..bodies.len()).filter(|&i| bodies[i].name == name) {
                if standing.contains(&i) || wait.contains(&i) || !known.insert(i) {
                    continue;
                }
                // Bodies of the same piece come along, even if the step does not name them.
                let with: Vec<usize> = (0..bodies.len())
                    .filter(|&k| k == i || pieces[k] == pieces[i])
                    .filter(|k| !standing.contains(k) && !wait.contains(k))
                    .collect();
                known.extend(&with);
                coming.push(with.into_iter().map(|k| &bodies[k]).collect());
            }
        }
        let standing = standing.iter().map(|&i| &bodies[i]).collect();
        let place = Place { step: &step.name, assembly };
        (!coming.is_empty()).then_some(Arrival { place, step, standing, coming })
    }

    /// Finds bodies that the step names but that arrive in a later step, together with the bodies they touch: screws of
    /// one name also hold other bodies, and a later step names them again.
    fn deferred_bodies(&self, step: &Step, assembly: &str) -> BTreeSet<usize> {
        let bodies = self.scene.bodies(assembly);
        let standing = &self.standing[assembly];
        let now: BTreeSet<&str> = needed(step).collect();
        let after = self.sensor.chain.iter().skip_while(|other| other.name != step.name).skip(1);
        let after = after.filter(|step| step.assembly.as_ref().is_some_and(|a| a.0 == assembly));
        let after: Vec<BTreeSet<&str>> = after.map(|step| needed(step).collect()).collect();
        // Names in later steps of the same assembly.
        let later: BTreeSet<&str> = after.iter().flatten().copied().collect();
        // A body with a single placement arrives when it is first named.
        let is_one_of_many =
            |i: usize| bodies.iter().filter(|b| b.name == bodies[i].name).count() > 1;
        let is_again = |&i: &usize| {
            now.contains(bodies[i].name) && later.contains(bodies[i].name) && is_one_of_many(i)
        };
        let may_wait: Vec<usize> = (0..bodies.len()).filter(is_again).collect();
        let is_absent = |i: usize| !standing.contains(&i) && !now.contains(bodies[i].name);
        let mut wait = BTreeSet::new();
        loop {
            // A body only waits for an absent neighbour if a later step names both.
            let is_told_with = |k: usize, i: usize| {
                let mut steps = after.iter();
                steps.any(|s| s.contains(bodies[k].name) && s.contains(bodies[i].name))
            };
            let touches_absent = |i: usize| {
                let near = bodies[i].body.bounds().grown(TOUCHING_MM);
                (0..bodies.len()).any(|k| {
                    k != i
                        && (is_absent(k) && is_told_with(k, i) || wait.contains(&k))
                        && !near.common(&bodies[k].body.bounds()).is_empty()
                })
            };
            let more =
                may_wait.iter().copied().filter(|&i| !wait.contains(&i) && touches_absent(i));
            let more: Vec<usize> = more.collect();
            if more.is_empty() {
                return wait;
            }
            wait.extend(more);
        }
    }

    /// Finds bodies that stand in an assembly although no step brings them there: they arrived as a whole, and later
    /// bodies are added to them.
    fn initial_bodies(&self, assembly: &str) -> BTreeSet<usize> {
        let bodies = self.scene.bodies(assembly);
        let here = |step: &&Step| step.assembly.as_ref().is_some_and(|a| a.0 == assembly);
        let told: BTreeSet<&str> = self.sensor.chain.iter().filter(here).flat_map(needed).collect();
        let pieces = self.pieces(assembly);
        let is_told = |piece: usize| {
            (0..bodies.len()).any(|i| pieces[i] == piece && told.contains(bodies[i].name))
        };
        // A cast layer exists only once it has been cast somewhere.
        let exists = |placed: &Placed| placed.of.kind != BodyKind::Cast || self.stands(placed.name);
        (0..bodies.len()).filter(|&i| !is_told(pieces[i]) && exists(&bodies[i])).collect()
    }

    /// Returns whether a body stands in any assembly by now.
    fn stands(&self, name: &str) -> bool {
        self.standing.iter().any(|(assembly, standing)| {
            standing.iter().any(|&i| self.scene.bodies(assembly)[i].name == name)
        })
    }

    /// Returns the index of the piece to which each body of an assembly belongs. Bodies that stood together before, in
    /// the same relative pose, move together; so do parts that are printed as one.
    fn pieces(&self, assembly: &str) -> Vec<usize> {
        let bodies = self.scene.bodies(assembly);
        let mut pieces: Vec<usize> = (0..bodies.len()).collect();
        let mut join = |a: usize, b: usize| {
            // A piece has the index of its first body.
            let (from, to) = (pieces[a].max(pieces[b]), pieces[a].min(pieces[b]));
            pieces.iter_mut().filter(|piece| **piece == from).for_each(|piece| *piece = to);
        };
        for group in &self.sensor.print_groups {
            let of_group =
                (0..bodies.len()).filter(|&i| group.parts.iter().any(|p| p == bodies[i].name));
            let of_group: Vec<usize> = of_group.collect();
            of_group.windows(2).for_each(|pair| join(pair[0], pair[1]));
        }
        for (other, standing) in self.standing.iter().filter(|(other, _)| **other != assembly) {
            let there: Vec<&Placed> =
                standing.iter().map(|&k| &self.scene.bodies(other)[k]).collect();
            for group in moved_together(&there, bodies) {
                group.windows(2).for_each(|pair| join(pair[0], pair[1]));
            }
        }
        pieces
    }
}

/// Returns the work of a step's adjustments: on the bodies of that name that it brings, or else on those that stand
/// there.
fn adjusted<'a>(
    step: &'a Step,
    place: Place<'a>,
    arrival: Option<&Arrival<'a>>,
    standing: &[&'a Placed<'a>],
) -> Vec<Work<'a>> {
    let coming: Vec<&Placed> =
        arrival.into_iter().flat_map(|arrival| arrival.coming.iter().flatten().copied()).collect();
    let named = |of: &[&'a Placed<'a>], name: &str| -> Vec<&'a Placed<'a>> {
        of.iter().copied().filter(|placed| placed.name == name).collect()
    };
    let work = |adjustment: &Adjustment| {
        let mut on = named(&coming, &adjustment.body);
        if on.is_empty() {
            on = named(standing, &adjustment.body);
        }
        // Adjusted before assembly: only the bodies that come with the step are around.
        let around = if adjustment.is_apart { &coming[..] } else { standing };
        Work { place, occasion: Occasion::Adjustment, on, around: around.to_vec() }
    };
    step.adjustments.iter().map(work).collect()
}

/// Groups the bodies that stood together before and do so here, as indices of bodies here: each group has been moved as
/// one.
///
/// A body cannot have been moved to two places. Among several copies here, the move that takes most bodies along wins.
fn moved_together(there: &[&Placed], here: &[Placed]) -> Vec<Vec<usize>> {
    let mut moves: Vec<(Pose, Vec<[usize; 2]>)> = Vec::new();
    for (to, placed) in here.iter().enumerate() {
        for from in (0..there.len()).filter(|&from| there[from].name == placed.name) {
            // Transform from the other assembly to this one. Bodies with the same transform moved together.
            let to_here = placed.pose.then_in(there[from].pose.inverse());
            match moves.iter_mut().find(|(pose, _)| is_same(pose, &to_here)) {
                Some((_, pairs)) => pairs.push([from, to]),
                None => moves.push((to_here, vec![[from, to]])),
            }
        }
    }
    moves.sort_by_key(|(_, pairs)| std::cmp::Reverse(pairs.len()));
    let mut gone = BTreeSet::new();
    let taken = moves.into_iter().map(|(_, pairs)| {
        // A body that has been assigned to a larger move is not available for another one.
        let left = pairs.into_iter().filter(|[from, _]| gone.insert(*from));
        left.map(|[_, to]| to).collect()
    });
    taken.collect()
}

/// Returns the index of a body, by identity.
fn number(bodies: &[Placed], placed: &Placed) -> Option<usize> {
    bodies.iter().position(|other| std::ptr::eq(other, placed))
}

/// Returns whether two poses are equal up to rounding.
fn is_same(a: &Pose, b: &Pose) -> bool {
    (a.rotation() - b.rotation()).amax() < SAME
        && (a.translation_mm() - b.translation_mm()).amax() < SAME
}
