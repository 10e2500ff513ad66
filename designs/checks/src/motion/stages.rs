//! Stages of the assembly: which bodies stand, come and go in each step, and in which direction. Images of the steps
//! show them.

use fabkit_geometry::{Action, Body, MotionLeg, Pose, Sensor, Step, Vector3};
use rayon::prelude::*;

use super::arrival::{Arrival, AssemblyHistory};
use super::disassembly::{Disassembly, RemovedPiece};
use crate::memo::Memo;
use crate::scene::{Assemblies, InvalidBody, Placed};

/// A body at its pose in an assembly.
#[derive(Clone, Copy, Debug)]
pub struct PlacedBody<'a> {
    /// The body.
    pub body: &'a Body,
    /// Pose of the body.
    pub assembly_from_body: Pose,
}

/// Bodies that come or go together.
#[derive(Clone, Debug)]
pub struct Movement<'a> {
    /// The bodies at their final poses.
    pub bodies: Vec<PlacedBody<'a>>,
    /// Direction in which they leave their places, a unit vector in the assembly's frame; bodies that come move against
    /// it. `None` if nothing stands there yet, or if the last leg of the stated motion is not straight.
    pub removal_direction: Option<Vector3<f64>>,
    /// Pieces from which they are put together before they come, if this happens in the same step, in the order of
    /// assembly.
    pub parts: Vec<Movement<'a>>,
}

/// A step of the chain that happens in an assembly.
#[derive(Clone, Debug)]
pub struct Stage<'a> {
    /// Index of the step in the chain.
    pub step: usize,
    /// Bodies that stand there before the step.
    pub before: Vec<PlacedBody<'a>>,
    /// Bodies that come, in an order in which they can.
    pub coming: Vec<Movement<'a>>,
    /// Bodies that are taken off, as the step states it.
    pub going: Vec<Movement<'a>>,
    /// Bodies that stand there after the step.
    pub after: Vec<PlacedBody<'a>>,
}

/// Computes the stages of all steps that happen in an assembly.
///
/// ```
/// use fabkit_checks::{example, stages};
/// let sensor = example::puck();
/// let stages = stages(&sensor)?;
/// // The lid goes up, then the dish down, and the puck is left.
/// let names = |of: &[fabkit_checks::PlacedBody]| of.iter().map(|s| s.body.name.clone()).collect::<Vec<_>>();
/// assert_eq!(stages[1].going[0].bodies[0].body.name, "lid");
/// assert_eq!(names(&stages[1].after), ["puck"]);
/// # Ok::<(), fabkit_checks::InvalidBody>(())
/// ```
///
/// # Errors
/// [`InvalidBody`] if the solid of a body is not valid.
pub fn stages(sensor: &Sensor) -> Result<Vec<Stage<'_>>, InvalidBody> {
    let scene = Assemblies::new(sensor)?;
    let mut history = AssemblyHistory::new(sensor, &scene);
    let mut told = Vec::new();
    for (step, of) in sensor.chain.iter().enumerate() {
        let Some(assembly) = &of.assembly else { continue };
        let before = history.standing(&assembly.0);
        let arrival = history.step(of);
        told.push((step, before, arrival, history.standing(&assembly.0)));
    }
    let memo = Memo::default();
    // The scene lives only in this function, so the result borrows the bodies from the sensor instead.
    let stand = |placed: &&Placed| PlacedBody {
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

/// Function that converts bodies of the scene to those of the sensor.
type ToPlacedBodies<'f, 's> = &'f dyn Fn(&[&Placed]) -> Vec<PlacedBody<'s>>;

/// Returns the index of a body of the scene in the sensor's list.
fn number(sensor: &Sensor, body: &Body) -> usize {
    let is_it = |other: &Body| std::ptr::eq(other, body);
    sensor.bodies.iter().position(is_it).expect("bodies of a scene are the sensor's")
}

/// Returns the pieces that a step brings: the piece that left last comes first.
fn coming<'s>(
    sensor: &'s Sensor,
    arrival: &Arrival,
    memo: &Memo,
    stands: ToPlacedBodies<'_, 's>,
) -> Vec<Movement<'s>> {
    let order = Disassembly::find(sensor, arrival, memo);
    let pieces: Vec<Vec<&Placed>> = arrival.coming.clone();
    let mut came = put_together(arrival.step, &pieces, &order.left, stands);
    fix(arrival.step, &mut came);
    came
}

/// Orders pieces for assembly: those that never left stand there first, the others come in the reverse order of
/// leaving.
fn put_together<'s>(
    step: &Step,
    pieces: &[Vec<&Placed>],
    left: &[RemovedPiece],
    stands: ToPlacedBodies<'_, 's>,
) -> Vec<Movement<'s>> {
    let is_known = |placed: &&&Placed| {
        let mut known = left.iter().flat_map(|left| &left.piece);
        known.any(|other| std::ptr::eq(*other, **placed))
    };
    let first = pieces
        .iter()
        .map(|piece| piece.iter().filter(|placed| !is_known(placed)).copied().collect::<Vec<_>>());
    // Pieces from which nothing is left have been taken out completely.
    let first = first.filter(|rest| !rest.is_empty());
    let mut came: Vec<Movement> = first
        .map(|rest| Movement { bodies: stands(&rest), removal_direction: None, parts: Vec::new() })
        .collect();
    for RemovedPiece { piece, way, apart } in left.iter().rev() {
        let stated = || {
            let motion = step.motions.iter().find(|motion| {
                piece.iter().any(|placed| motion.bodies.iter().any(|name| name == placed.name))
            });
            // The last straight leg shows the direction of arrival.
            motion.and_then(|motion| motion.legs.iter().rev().find_map(straight))
        };
        let alone: Vec<Vec<&Placed>> = piece.iter().map(|placed| vec![*placed]).collect();
        let apart =
            if apart.is_empty() { Vec::new() } else { put_together(step, &alone, apart, stands) };
        came.push(Movement {
            bodies: stands(piece),
            removal_direction: way.or_else(stated),
            parts: apart,
        });
    }
    came
}

/// Merges small bodies that are soldered or stuck onto another one with it: they come together.
fn fix(step: &Step, came: &mut Vec<Movement>) {
    for fixing in &step.fixings {
        // Only single small bodies, not pieces that are assembled outside.
        let is_small = |one: &Movement| {
            one.parts.is_empty()
                && one.bodies.iter().all(|stand| fixing.bodies.contains(&stand.body.name))
        };
        let (small, mut rest): (Vec<Movement>, Vec<Movement>) =
            std::mem::take(came).into_iter().partition(is_small);
        let onto = rest
            .iter()
            .position(|one| one.bodies.iter().any(|stand| fixing.onto.contains(&stand.body.name)));
        let Some(onto) = onto else {
            // The carrier stands there already, so the small bodies come by themselves.
            rest.extend(small);
            *came = rest;
            continue;
        };
        let host = &mut rest[onto];
        // The carrier itself is the first piece of the assembly outside.
        if host.parts.is_empty() {
            host.parts.push(Movement {
                bodies: host.bodies.clone(),
                removal_direction: None,
                parts: Vec::new(),
            });
        }
        for one in small {
            host.bodies.extend(&one.bodies);
            let out = one.bodies.first().map(|stand| stand.assembly_from_body.vector(Vector3::z()));
            host.parts.push(Movement { removal_direction: out, ..one });
        }
        *came = rest;
    }
}

/// Returns the direction backwards along a straight leg; `None` for a turn.
fn straight(leg: &MotionLeg) -> Option<Vector3<f64>> {
    match leg {
        MotionLeg::Straight { along, .. } => Some(-along),
        MotionLeg::Turn { .. } => None,
    }
}

/// Returns the bodies that a step takes off, one pull after the other.
fn going<'s>(
    action: &Action,
    before: &[&Placed],
    stands: ToPlacedBodies<'_, 's>,
) -> Vec<Movement<'s>> {
    let Action::Demold(pulls) = action else { return Vec::new() };
    let gone = pulls.iter().map(|pull| {
        let bodies: Vec<&Placed> =
            before.iter().copied().filter(|placed| placed.name == pull.body).collect();
        let out = pull.direction.try_normalize(0.0);
        Movement { bodies: stands(&bodies), removal_direction: out, parts: Vec::new() }
    });
    gone.filter(|came| !came.bodies.is_empty()).collect()
}
