//! What gets to its place when, in each assembly, past what.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{Action, Adjustment, Kind, Occasion, Pose, Sensor, Step};

use crate::case::Place;
use crate::scene::{Assemblies, Placed};

/// Poses that differ by less are the same, mm and parts of 1.
const SAME: f64 = 1e-9;

/// Bodies whose boxes are this near touch each other, mm.
const TOUCHING_MM: f64 = 0.1;

/// A step that brings bodies to their places.
pub(crate) struct Arrival<'a> {
    pub(crate) place: Place<'a>,
    pub(crate) step: &'a Step,
    /// What stands there before.
    pub(crate) standing: Vec<&'a Placed<'a>>,
    /// What comes; each of them as one piece, in the order in which the step names them.
    pub(crate) coming: Vec<Vec<&'a Placed<'a>>>,
}

/// A step in which tools work on what stands there.
pub(crate) struct Work<'a> {
    pub(crate) place: Place<'a>,
    pub(crate) occasion: Occasion,
    /// What they work on.
    pub(crate) on: Vec<&'a Placed<'a>>,
    /// What stands there, with what they work on.
    pub(crate) around: Vec<&'a Placed<'a>>,
}

/// Every step that brings something, in order, and every step that pours, adjusts or takes off.
pub(crate) fn arrivals<'a>(
    sensor: &'a Sensor,
    scene: &'a Assemblies<'a>,
) -> (Vec<Arrival<'a>>, Vec<Work<'a>>) {
    let mut history = History::new(sensor, scene);
    let arrivals = sensor.chain.iter().filter_map(|step| history.step(step)).collect();
    (arrivals, history.work)
}

pub(super) struct History<'a> {
    sensor: &'a Sensor,
    scene: &'a Assemblies<'a>,
    /// What stands in each assembly, as numbers of its bodies.
    standing: BTreeMap<&'a str, BTreeSet<usize>>,
    work: Vec<Work<'a>>,
}

/// The layer that a step makes: it is not brought.
fn made(step: &Step) -> Option<&str> {
    match &step.action {
        Action::Pour(pour) => Some(&pour.layer),
        Action::Spray(spray) => Some(&spray.layer),
        _ => None,
    }
}

/// What a step needs where it happens.
fn needed(step: &Step) -> impl Iterator<Item = &str> {
    let more: &[String] = match &step.action {
        Action::Pour(pour) => &pour.walls,
        Action::Spray(spray) => &spray.onto,
        _ => &[],
    };
    let layer = made(step);
    step.bodies.iter().chain(more).map(String::as_str).filter(move |name| layer != Some(*name))
}

impl<'a> History<'a> {
    pub(super) fn new(sensor: &'a Sensor, scene: &'a Assemblies<'a>) -> Self {
        Self { sensor, scene, standing: BTreeMap::new(), work: Vec::new() }
    }

    /// What stands in an assembly now, in the order of the sensor's lists.
    pub(super) fn standing(&mut self, assembly: &'a str) -> Vec<&'a Placed<'a>> {
        let scene = self.scene;
        if !self.standing.contains_key(assembly) {
            let brought = self.brought_untold(assembly);
            self.standing.insert(assembly, brought);
        }
        self.standing[assembly].iter().map(|&i| &scene.bodies(assembly)[i]).collect()
    }

    pub(super) fn step(&mut self, step: &'a Step) -> Option<Arrival<'a>> {
        let assembly = step.assembly.as_ref()?.0.as_str();
        let bodies = self.scene.bodies(assembly);
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
        standing.extend((0..bodies.len()).filter(|&i| is_made(&bodies[i])));
        if let Action::Demold(pulls) = &step.action {
            let is_pulled = |name: &str| pulls.iter().any(|pull| pull.body == name);
            let fits = &self.sensor.press_fits;
            // What is pressed into a tool leaves with it, and no tool comes off before its screws.
            let goes_with =
                |name: &str| fits.iter().any(|fit| fit.inner == name && is_pulled(&fit.outer));
            let stays = |placed: &Placed| {
                !(is_pulled(placed.name) || goes_with(placed.name) || placed.is_drawn())
            };
            standing.retain(|&i| stays(&bodies[i]));
        }
        arrival
    }

    fn arrival(&self, step: &'a Step, assembly: &'a str) -> Option<Arrival<'a>> {
        let bodies = self.scene.bodies(assembly);
        let standing = &self.standing[assembly];
        let pieces = self.pieces(assembly);
        let mut coming: Vec<Vec<&Placed>> = Vec::new();
        let mut known = BTreeSet::new();
        let wait = self.waiting(step, assembly);
        for name in needed(step) {
            for i in (0..bodies.len()).filter(|&i| bodies[i].name == name) {
                if standing.contains(&i) || wait.contains(&i) || !known.insert(i) {
                    continue;
                }
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

    /// What a step names though its turn comes later, with what it touches: the same screws hold other
    /// bodies too, and a later step names them again.
    fn waiting(&self, step: &Step, assembly: &str) -> BTreeSet<usize> {
        let bodies = self.scene.bodies(assembly);
        let standing = &self.standing[assembly];
        let now: BTreeSet<&str> = needed(step).collect();
        let after = self.sensor.chain.iter().skip_while(|other| other.name != step.name).skip(1);
        let after = after.filter(|step| step.assembly.as_ref().is_some_and(|a| a.0 == assembly));
        let after: Vec<BTreeSet<&str>> = after.map(|step| needed(step).collect()).collect();
        let later: BTreeSet<&str> = after.iter().flatten().copied().collect();
        // What stands in one place comes when it is named first.
        let is_one_of_many =
            |i: usize| bodies.iter().filter(|b| b.name == bodies[i].name).count() > 1;
        let is_again = |&i: &usize| {
            now.contains(bodies[i].name) && later.contains(bodies[i].name) && is_one_of_many(i)
        };
        let may_wait: Vec<usize> = (0..bodies.len()).filter(is_again).collect();
        let is_absent = |i: usize| !standing.contains(&i) && !now.contains(bodies[i].name);
        let mut wait = BTreeSet::new();
        loop {
            // What only comes to lie beside it in a step of its own is not waited for.
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

    /// What no step brings to an assembly though it stands there: it has been brought as a whole, and
    /// what comes later comes to it.
    fn brought_untold(&self, assembly: &str) -> BTreeSet<usize> {
        let bodies = self.scene.bodies(assembly);
        let here = |step: &&Step| step.assembly.as_ref().is_some_and(|a| a.0 == assembly);
        let told: BTreeSet<&str> = self.sensor.chain.iter().filter(here).flat_map(needed).collect();
        let pieces = self.pieces(assembly);
        let is_told = |piece: usize| {
            (0..bodies.len()).any(|i| pieces[i] == piece && told.contains(bodies[i].name))
        };
        let exists = |placed: &Placed| placed.of.kind != Kind::Cast || self.stands(placed.name);
        (0..bodies.len()).filter(|&i| !is_told(pieces[i]) && exists(&bodies[i])).collect()
    }

    /// Whether a body stands anywhere by now.
    fn stands(&self, name: &str) -> bool {
        self.standing.iter().any(|(assembly, standing)| {
            standing.iter().any(|&i| self.scene.bodies(assembly)[i].name == name)
        })
    }

    /// Of which piece each body of an assembly is: what stood together before, as it does here, moves
    /// together, and so do parts that are printed as one.
    fn pieces(&self, assembly: &str) -> Vec<usize> {
        let bodies = self.scene.bodies(assembly);
        let mut pieces: Vec<usize> = (0..bodies.len()).collect();
        let mut join = |a: usize, b: usize| {
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

/// What is set right in a step: what it brings of that name, or else what stands there.
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
        let around = if adjustment.is_apart { &coming[..] } else { standing };
        Work { place, occasion: Occasion::Adjustment, on, around: around.to_vec() }
    };
    step.adjustments.iter().map(work).collect()
}

/// What stood together there and does so here, as numbers of bodies here: each group has been moved as one.
///
/// Nothing has been moved to two places: of copies here, those are meant that take most along.
fn moved_together(there: &[&Placed], here: &[Placed]) -> Vec<Vec<usize>> {
    let mut moves: Vec<(Pose, Vec<[usize; 2]>)> = Vec::new();
    for (to, placed) in here.iter().enumerate() {
        for from in (0..there.len()).filter(|&from| there[from].name == placed.name) {
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
        let left = pairs.into_iter().filter(|[from, _]| gone.insert(*from));
        left.map(|[_, to]| to).collect()
    });
    taken.collect()
}

fn number(bodies: &[Placed], placed: &Placed) -> Option<usize> {
    bodies.iter().position(|other| std::ptr::eq(other, placed))
}

fn is_same(a: &Pose, b: &Pose) -> bool {
    (a.rotation() - b.rotation()).amax() < SAME
        && (a.translation_mm() - b.translation_mm()).amax() < SAME
}
