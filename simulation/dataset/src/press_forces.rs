//! Response of soft layers to half presses: forces, moments, and effects across the seam.

use fabkit_depth::ground_truth::Side;
use fabkit_elastic::{SoftError, SurfaceNode};
use fabkit_files::{Error, Explained as _};
use fabkit_fixtures::{Press, PressBody, SEAM_NORMAL};
use fabkit_geometry::csv::{CsvCell, CsvTable};
use fabkit_geometry::{Pose, TouchSurface};
use fabkit_scene::ground_truth::compile_indenters;
use fabkit_scene::press_simulation::{
    ContactModel, ContactSolution, ElasticSolver, LinearOptions, PressStep, PressingError,
    soft_layers,
};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::request::DatasetRequestError;
use super::{DatasetError, DatasetJob, DatasetRequest, NamedPresses, PressPattern};

/// Pattern with the response of the layers, on the left and on the right.
#[derive(Clone, Debug)]
pub struct PatternResponse {
    touch: TouchSurface,
    shear_mm: [f64; 2],
    bodies: [Vec<PressBody>; 2],
    /// Response on either side; `None` if the half does not touch.
    forces: [Option<PressForces>; 2],
}

/// Response of the layers to a half press.
#[derive(Clone, Copy, Debug)]
struct PressForces {
    step: PressStep,
    friction: Option<f64>,
    /// Largest displacement of the surface on the other side of the seam, mm.
    beyond_seam_mm: f64,
}

impl PatternResponse {
    /// Computes the contact solution of one side; `None` if nothing touches.
    pub(super) fn solve_contact<'r>(
        &self,
        ready: &'r ElasticSolver,
        contact: ContactModel,
        side: Side,
    ) -> Result<Option<ContactSolution<'r>>, DatasetError> {
        let (i, friction) = (usize::from(side != Side::Left), friction_of(contact));
        if self.forces[i].is_none() {
            return Ok(None);
        }
        let answer = ready.solve_contact(&self.touch, &self.bodies[i], self.shear_mm, friction);
        let half = || format!("{side:?}").to_lowercase();
        answer.map(Some).map_err(|error| DatasetError::Press { half: half(), error })
    }
}

fn friction_of(contact: ContactModel) -> Option<f64> {
    match contact {
        ContactModel::Linear(LinearOptions { friction, .. }) => friction,
        _ => None,
    }
}

/// Error of a half press, with advice.
struct Fault {
    text: String,
    hint: Option<String>,
}

fn fault(half: &str, error: &PressingError) -> Fault {
    Fault { text: format!("`{half}`: {error}"), hint: error.hint() }
}

/// Prepares patterns with their bodies at the end of the press, and the response of the layers if they are simulated.
///
/// # Errors
/// Reports every half without a contact solution, and shear on a rigid surface.
pub(super) fn prepare(
    named: &[NamedPresses],
    touch: &TouchSurface,
    ready: Option<&ElasticSolver>,
    order: &DatasetRequest,
) -> Result<Vec<PressPattern>, Error> {
    let prepared: Vec<Result<PressPattern, Vec<Fault>>> = named
        .par_iter()
        .map(|pattern| match ready {
            Some(ready) => press_pattern(pattern, touch, ready, order),
            None if pattern.shear_mm != [0.0; 2] => {
                let error = PressingError::RigidShear { contact: order.contact.name() };
                Err(vec![fault(&pattern.name, &error)])
            }
            None => place_pattern(pattern, &pattern.sides(), None),
        })
        .collect();
    let (mut patterns, mut faults) = (Vec::new(), Vec::new());
    for prepared in prepared {
        match prepared {
            Ok(pattern) => patterns.push(pattern),
            Err(found) => faults.extend(found),
        }
    }
    if faults.is_empty() {
        Ok(patterns)
    } else {
        let hint = faults.iter().find_map(|fault: &Fault| fault.hint.clone());
        let faults = faults.into_iter().map(|fault| fault.text).collect();
        Err(DatasetRequestError::Presses { faults, hint }.into())
    }
}

/// Solves for the contact on both sides, and moves the bodies to the end of the press.
fn press_pattern(
    pattern: &NamedPresses,
    touch: &TouchSurface,
    ready: &ElasticSolver,
    order: &DatasetRequest,
) -> Result<PressPattern, Vec<Fault>> {
    let mut sides = pattern.sides();
    let (mut forces, mut faults) = ([None, None], Vec::new());
    let bodies = sides.each_ref().map(|presses| bodies_of(presses));
    for (i, side) in ["left", "right"].iter().enumerate() {
        let friction = friction_of(order.contact);
        match ready.solve_contact(touch, &bodies[i], pattern.shear_mm, friction) {
            Ok(answer) => {
                let way = answer.shear_displacement_mm;
                // Bodies are stored where the press ends, after pressing and shear.
                let way = Pose::translation(way.x, way.y, way.z);
                for body in sides[i].iter_mut().flat_map(|press| &mut press.bodies) {
                    body.sensor_from_body = way.then_in(body.sensor_from_body);
                }
                forces[i] = Some(PressForces {
                    step: answer.step,
                    friction: answer.friction,
                    beyond_seam_mm: motion_beyond_seam_mm(ready, &answer, i == 0),
                });
            }
            // The caller accepts presses that miss the surface.
            Err(error) if error.is_no_contact() && order.allow_no_contact => {}
            Err(error) => faults.push(fault(&format!("{} {side}", pattern.name), &error)),
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let felt = PatternResponse { touch: touch.clone(), shear_mm: pattern.shear_mm, bodies, forces };
    place_pattern(pattern, &sides, Some(felt))
}

fn bodies_of(presses: &[Press]) -> Vec<PressBody> {
    presses.iter().flat_map(|press| press.bodies.clone()).collect()
}

/// Creates a pattern from presses in their final poses.
fn place_pattern(
    pattern: &NamedPresses,
    sides: &[Vec<Press>; 2],
    felt: Option<PatternResponse>,
) -> Result<PressPattern, Vec<Fault>> {
    let prepared = |presses: &[Press]| {
        let solid = |error| vec![fault(&pattern.name, &SoftError::Solid(error).into())];
        compile_indenters(presses).map_err(solid)
    };
    Ok(PressPattern {
        name: pattern.name.clone(),
        left: prepared(&sides[0])?,
        right: prepared(&sides[1])?,
        response: felt,
    })
}

/// Computes the largest motion of the surface beyond the plane between the halves, mm. Stitching leaves it out,
/// although the other half would change it first.
fn motion_beyond_seam_mm(ready: &ElasticSolver, answer: &ContactSolution, is_left: bool) -> f64 {
    // The seam's normal points from left to right.
    let sign = if is_left { 1.0 } else { -1.0 };
    let pose = ready.soft.sensor_from_stack;
    let is_beyond =
        |node: &&SurfaceNode| sign * SEAM_NORMAL.dot(&pose.point(node.place_mm).coords) > 0.0;
    let moved = answer.nodes().iter().filter(is_beyond);
    moved.map(|node| node.displacement_mm.dot(&node.outward).abs()).fold(0.0, f64::max)
}

/// Writes a table with a line for each half; `None` if the layers are not simulated.
pub(super) fn halves_csv(job: &DatasetJob) -> Option<String> {
    job.elastic_solver?;
    let mut table = CsvTable::new(
        "half,pattern,side,contact_level,depth_mm,shear_mm,friction,force_x_n,force_y_n,force_z_n,moment_x_nmm,\
         moment_y_nmm,moment_z_nmm,contact_area_mm2,max_indentation_mm,bulge_mm,beyond_seam_mm",
    );
    for half in 0..2 * job.patterns.len() {
        let (pattern, side) = job.half(half);
        let is_left = side == Side::Left;
        let side = if is_left { "left" } else { "right" };
        let first = [half.into(), (&pattern.name).into(), side.into(), job.contact.name().into()];
        let forces = pattern.response.as_ref().and_then(|felt| felt.forces[usize::from(!is_left)]);
        let numbers = match forces {
            Some(PressForces { step, friction, beyond_seam_mm }) => vec![
                Some(step.depth_mm),
                Some(step.shear_mm),
                friction,
                Some(step.force_n.x),
                Some(step.force_n.y),
                Some(step.force_n.z),
                Some(step.moment_nmm.x),
                Some(step.moment_nmm.y),
                Some(step.moment_nmm.z),
                Some(step.contact_area_mm2),
                Some(step.max_indentation_mm),
                Some(step.bulge_mm),
                Some(beyond_seam_mm),
            ],
            // A half that does not touch has no forces; its friction stays empty.
            None => [[Some(0.0); 2].as_slice(), &[None], &[Some(0.0); 10]].concat(),
        };
        let numbers = numbers.into_iter();
        let numbers = numbers.map(|number| number.map(|number| CsvCell::fixed(number, 6)).into());
        table.row(first.into_iter().chain(numbers));
    }
    Some(table.finish())
}

/// Describes the assumptions behind forces and displacements.
pub(super) fn describe_elasticity(ready: &ElasticSolver, patterns: &[PressPattern]) -> Value {
    let forces = patterns.iter().filter_map(|pattern| pattern.response.as_ref());
    let forces = forces.flat_map(|felt| felt.forces.iter().flatten());
    let beyond_seam_mm = forces.map(|forces| forces.beyond_seam_mm).fold(0.0, f64::max);
    json!({
        "is_simulated": true,
        "layers": soft_layers(&ready.soft.layers),
        "left_out": ready.soft.simplifications,
        "spacing_mm": ready.spacing_mm,
        "nodes": ready.stack.surface_nodes(),
        "force": "of the indenter on the sensor, N; moment about the sensor's origin, N mm; sensor frame",
        "beyond_seam_mm": beyond_seam_mm,
        "stitching": "halves are stitched as if neither felt the other; beyond_seam_mm is how far any half moves the \
                      surface on the other side of the seam, which is what stitching leaves out, to first order",
    })
}
