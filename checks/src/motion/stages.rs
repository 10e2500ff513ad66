//! Step by step, what stands where, what comes, and along which way: what pictures of the steps show.

use fabkit_geometry::{Action, Body, Leg, Pose, Sensor, Vector3};
use rayon::prelude::*;

use super::arrival::{Arrival, History};
use super::order::Order;
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
    let stands = |placed: &[&Placed]| -> Vec<(usize, Pose)> {
        placed.iter().map(|placed| (number(sensor, placed.of), placed.pose)).collect()
    };
    let stages = told.par_iter().map(|(step, before, arrival, after)| {
        let coming = arrival.as_ref().map_or(Vec::new(), |arrival| coming(sensor, arrival, &memo));
        let going = going(&sensor.chain[*step].action, before);
        let came = |(placed, out): (Vec<&Placed>, Option<Vector3<f64>>)| (stands(&placed), out);
        (
            *step,
            stands(before),
            coming.into_iter().map(came).collect::<Vec<_>>(),
            going.into_iter().map(came).collect::<Vec<_>>(),
            stands(after),
        )
    });
    let stages: Vec<_> = stages.collect();
    let stand = |(body, pose): (usize, Pose)| Stand {
        body: &sensor.bodies[body],
        assembly_from_body: pose,
    };
    let all = |of: Vec<(usize, Pose)>| of.into_iter().map(stand).collect::<Vec<_>>();
    let moved = |of: Vec<(Vec<(usize, Pose)>, Option<Vector3<f64>>)>| {
        of.into_iter().map(|(bodies, out)| Came { bodies: all(bodies), out }).collect()
    };
    let stage = |(step, before, coming, going, after)| Stage {
        step,
        before: all(before),
        coming: moved(coming),
        going: moved(going),
        after: all(after),
    };
    Ok(stages.into_iter().map(stage).collect())
}

fn number(sensor: &Sensor, body: &Body) -> usize {
    let is_it = |other: &Body| std::ptr::eq(other, body);
    sensor.bodies.iter().position(is_it).expect("bodies of a scene are the sensor's")
}

/// What a step brings, the last that could leave first.
fn coming<'a>(
    sensor: &'a Sensor,
    arrival: &Arrival<'a>,
    memo: &'a Memo,
) -> Vec<(Vec<&'a Placed<'a>>, Option<Vector3<f64>>)> {
    let order = Order::find(sensor, arrival, memo);
    let is_known = |placed: &&Placed| {
        let mut left = order.left.iter().flat_map(|(piece, _)| piece);
        left.any(|other| std::ptr::eq(*other, *placed))
    };
    let first = arrival.coming.iter().map(|piece| {
        let rest: Vec<&Placed> = piece.iter().copied().filter(|p| !is_known(p)).collect();
        (rest, None)
    });
    let first: Vec<_> = first.filter(|(rest, _)| !rest.is_empty()).collect();
    let left = order.left.iter().rev().map(|(piece, way)| {
        let stated = || {
            let motion = arrival.step.motions.iter().find(|motion| {
                piece.iter().any(|placed| motion.bodies.iter().any(|name| name == placed.name))
            });
            motion.and_then(|motion| motion.legs.iter().rev().find_map(straight))
        };
        (piece.clone(), way.or_else(stated))
    });
    // Of a group that came together, its pieces have met outside: once is enough.
    let mut seen: Vec<&Placed> = Vec::new();
    let mut all = first;
    for (piece, way) in left.collect::<Vec<_>>().into_iter() {
        let is_new = |placed: &&&Placed| !seen.iter().any(|other| std::ptr::eq(*other, **placed));
        let fresh: Vec<&Placed> = piece.iter().filter(is_new).copied().collect();
        seen.extend(&fresh);
        if !fresh.is_empty() {
            all.push((fresh, way));
        }
    }
    all
}

/// Back along a straight leg.
fn straight(leg: &Leg) -> Option<Vector3<f64>> {
    match leg {
        Leg::Straight { along, .. } => Some(-along),
        Leg::Turn { .. } => None,
    }
}

/// What a step takes off, one pull after the other.
fn going<'a>(
    action: &Action,
    before: &[&'a Placed<'a>],
) -> Vec<(Vec<&'a Placed<'a>>, Option<Vector3<f64>>)> {
    let Action::Demold(pulls) = action else { return Vec::new() };
    let gone = pulls.iter().map(|pull| {
        let bodies = before.iter().copied().filter(|placed| placed.name == pull.body).collect();
        (bodies, pull.direction.try_normalize(0.0))
    });
    gone.filter(|(bodies, _): &(Vec<_>, _)| !bodies.is_empty()).collect()
}
