//! Step by step, what stands where, what comes, and along which way: what pictures of the steps show.

use fabkit_geometry::{Action, Body, Leg, Pose, Sensor, Step, Vector3};
use rayon::prelude::*;

use super::arrival::{Arrival, History};
use super::order::{Left, Order};
use crate::memo::Memo;
use crate::scene::{Assemblies, InvalidBody, Placed};

/// A body in a place of its assembly.
#[derive(Clone, Copy, Debug)]
pub struct Stand<'a> {
    /// Which.
    pub body: &'a Body,
    /// Where.
    pub assembly_from_body: Pose,
}

/// Bodies that come or go together.
#[derive(Clone, Debug)]
pub struct Came<'a> {
    /// Which, in their places.
    pub bodies: Vec<Stand<'a>>,
    /// Which way they leave their places, a unit vector of the assembly's frame: what comes, comes against it. `None`
    /// where nothing stands there yet.
    pub out: Option<Vector3<f64>>,
    /// How they are put together before they come, where that is done in the same step: in the same order.
    pub apart: Vec<Came<'a>>,
}

/// A step of the chain that happens in an assembly.
#[derive(Clone, Debug)]
pub struct Stage<'a> {
    /// Its place in the chain.
    pub step: usize,
    /// What stands there before.
    pub before: Vec<Stand<'a>>,
    /// What comes, in an order in which it can.
    pub coming: Vec<Came<'a>>,
    /// What is taken off, as the step says it.
    pub going: Vec<Came<'a>>,
    /// What stands there afterwards.
    pub after: Vec<Stand<'a>>,
}

/// All steps that happen in an assembly.
///
/// ```
/// use fabkit_checks::{example, stages};
/// let sensor = example::puck();
/// let stages = stages(&sensor)?;
/// // The lid goes up, then the dish down, and the puck is left.
/// let names = |of: &[fabkit_checks::Stand]| of.iter().map(|s| s.body.name.clone()).collect::<Vec<_>>();
/// assert_eq!(stages[1].going[0].bodies[0].body.name, "lid");
/// assert_eq!(names(&stages[1].after), ["puck"]);
/// # Ok::<(), fabkit_checks::InvalidBody>(())
/// ```
///
/// # Errors
/// [`InvalidBody`] if a solid of the sensor is none.
pub fn stages(sensor: &Sensor) -> Result<Vec<Stage<'_>>, InvalidBody> {
    let scene = Assemblies::new(sensor)?;
    let mut history = History::new(sensor, &scene);
    let mut told = Vec::new();
    for (step, of) in sensor.chain.iter().enumerate() {
        let Some(assembly) = &of.assembly else { continue };
        let before = history.standing(&assembly.0);
        let arrival = history.step(of);
        told.push((step, before, arrival, history.standing(&assembly.0)));
    }
    let memo = Memo::default();
    // The scene is this function's own; bodies are the sensor's.
    let stand = |placed: &&Placed| Stand {
        body: &sensor.bodies[number(sensor, placed.of)],
        assembly_from_body: placed.pose,
    };
    let all = |of: &[&Placed]| of.iter().map(stand).collect::<Vec<_>>();
    let stages = told.par_iter().map(|(step, before, arrival, after)| Stage {
        step: *step,
        before: all(before),
        coming: arrival.as_ref().map_or(Vec::new(), |a| coming(sensor, a, &memo, &all)),
        going: going(&sensor.chain[*step].action, before, &all),
        after: all(after),
    });
    Ok(stages.collect())
}

/// From places in the scene to those of the sensor's bodies.
type Stands<'f, 's> = &'f dyn Fn(&[&Placed]) -> Vec<Stand<'s>>;

fn number(sensor: &Sensor, body: &Body) -> usize {
    let is_it = |other: &Body| std::ptr::eq(other, body);
    sensor.bodies.iter().position(is_it).expect("bodies of a scene are the sensor's")
}

/// What a step brings, the last that could leave first.
fn coming<'s>(
    sensor: &'s Sensor,
    arrival: &Arrival,
    memo: &Memo,
    stands: Stands<'_, 's>,
) -> Vec<Came<'s>> {
    let order = Order::find(sensor, arrival, memo);
    let pieces: Vec<Vec<&Placed>> = arrival.coming.clone();
    let mut came = put_together(arrival.step, &pieces, &order.left, stands);
    fix(arrival.step, &mut came);
    came
}

/// What never left stood there first; the others come against the order in which they left.
fn put_together<'s>(
    step: &Step,
    pieces: &[Vec<&Placed>],
    left: &[Left],
    stands: Stands<'_, 's>,
) -> Vec<Came<'s>> {
    let is_known = |placed: &&&Placed| {
        let mut known = left.iter().flat_map(|left| &left.piece);
        known.any(|other| std::ptr::eq(*other, **placed))
    };
    let first = pieces
        .iter()
        .map(|piece| piece.iter().filter(|placed| !is_known(placed)).copied().collect::<Vec<_>>());
    let first = first.filter(|rest| !rest.is_empty());
    let mut came: Vec<Came> =
        first.map(|rest| Came { bodies: stands(&rest), out: None, apart: Vec::new() }).collect();
    for Left { piece, way, apart } in left.iter().rev() {
        let stated = || {
            let motion = step.motions.iter().find(|motion| {
                piece.iter().any(|placed| motion.bodies.iter().any(|name| name == placed.name))
            });
            motion.and_then(|motion| motion.legs.iter().rev().find_map(straight))
        };
        let alone: Vec<Vec<&Placed>> = piece.iter().map(|placed| vec![*placed]).collect();
        let apart = match apart.is_empty() {
            true => Vec::new(),
            false => put_together(step, &alone, apart, stands),
        };
        came.push(Came { bodies: stands(piece), out: way.or_else(stated), apart });
    }
    came
}

/// What is soldered or stuck onto something comes with it.
fn fix(step: &Step, came: &mut Vec<Came>) {
    for fixing in &step.fixings {
        let is_small = |one: &Came| {
            one.apart.is_empty()
                && one.bodies.iter().all(|stand| fixing.bodies.contains(&stand.body.name))
        };
        let (small, mut rest): (Vec<Came>, Vec<Came>) =
            std::mem::take(came).into_iter().partition(is_small);
        let onto = rest
            .iter()
            .position(|one| one.bodies.iter().any(|stand| fixing.onto.contains(&stand.body.name)));
        let Some(onto) = onto else {
            // It stands there already: what is small goes straight to it.
            rest.extend(small);
            *came = rest;
            continue;
        };
        let host = &mut rest[onto];
        if host.apart.is_empty() {
            host.apart.push(Came { bodies: host.bodies.clone(), out: None, apart: Vec::new() });
        }
        for one in small {
            host.bodies.extend(&one.bodies);
            let out = one.bodies.first().map(|stand| stand.assembly_from_body.vector(Vector3::z()));
            host.apart.push(Came { out, ..one });
        }
        *came = rest;
    }
}

/// Back along a straight leg.
fn straight(leg: &Leg) -> Option<Vector3<f64>> {
    match leg {
        Leg::Straight { along, .. } => Some(-along),
        Leg::Turn { .. } => None,
    }
}

/// What a step takes off, one pull after the other.
fn going<'s>(action: &Action, before: &[&Placed], stands: Stands<'_, 's>) -> Vec<Came<'s>> {
    let Action::Demold(pulls) = action else { return Vec::new() };
    let gone = pulls.iter().map(|pull| {
        let bodies: Vec<&Placed> =
            before.iter().copied().filter(|placed| placed.name == pull.body).collect();
        let out = pull.direction.try_normalize(0.0);
        Came { bodies: stands(&bodies), out, apart: Vec::new() }
    });
    gone.filter(|came| !came.bodies.is_empty()).collect()
}
