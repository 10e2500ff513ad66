//! Elastic solver of a sensor's soft layers for bodies of fixtures.

use std::f64::consts::PI;

use fabkit_elastic::SolverResources;
use fabkit_elastic::{
    ElasticStack, Press, PressOutcome, PressPoint, SoftError, SoftStack, SolidIndenter,
};
use fabkit_fixtures::PressBody;
use fabkit_geometry::{CompiledSolid, Point3, Sensor, SurfacePoints, TouchSurface, Vector3};

use super::PressingError;
use super::contact::deepest_place;

/// Approximate number of a dome's surface nodes for a first estimate: a press takes some milliseconds.
const COARSE_NODES: f64 = 5000.0;
/// Maximum number of surface nodes unless a spacing is requested: the setup takes some seconds.
const MOST_NODES: f64 = 25_000.0;
/// Finest node spacing in the search for a contact, mm. No indenter is thinner.
const LEAST_LOOK_MM: f64 = 0.1;
/// Approximate number of nodes from the middle of a contact to its edge.
const NODES_PER_RADIUS: f64 = 8.0;
/// Radius of the finely divided part of a pad, in contact radii.
const FINE_RADII: f64 = 2.5;
/// Number of azimuthal harmonics around a single contact in the middle of the fine part.
const SINGLE_CONTACT_HARMONICS: usize = 24;
/// Limits of the distance of nodes, mm.
const SPACING_LIMITS_MM: [f64; 2] = [0.01, 5.0];

/// Soft layers with their compliance to surface tractions.
///
/// ```
/// use fabkit_scene::press_simulation::ElasticSolver;
///
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
/// let sensor = &project.design.sensor;
/// let touch = sensor.touch.as_ref().ok_or("no surface")?;
/// let bodies = project.press("ball@0mm,0mm,0.3mm")?.bodies;
/// let solver = ElasticSolver::for_press(sensor, &bodies, Some(0.5), 1.into())?;
/// let answer = solver.solve_contact(touch, &bodies, [0.0; 2], None)?;
/// // The gel yields as deep as the ball goes, and rises beside it.
/// assert!((answer.step.max_indentation_mm - 0.3).abs() < 0.03);
/// assert!(answer.step.bulge_mm > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ElasticSolver {
    /// The soft layers.
    pub soft: SoftStack,
    /// Discretised layers with the solver.
    pub stack: ElasticStack,
    /// Distance of the surface's nodes, mm.
    pub spacing_mm: f64,
}

impl ElasticSolver {
    /// Creates a solver for one press, with nodes as fine as its contact needs, or `spacing_mm` apart. Several bodies
    /// get the solver of [`ElasticSolver::for_any_press`].
    ///
    /// # Errors
    /// Returns an error for a sensor without soft layers, a node spacing outside its limits, and if the solver fails.
    pub fn for_press(
        sensor: &Sensor,
        bodies: &[PressBody],
        spacing_mm: Option<f64>,
        resources: SolverResources,
    ) -> Result<Self, PressingError> {
        check_spacing(spacing_mm)?;
        let touch = touch(sensor)?;
        let points = SurfacePoints::new(touch).map_err(SoftError::Solid)?;
        if bodies.len() > 1 {
            return Self::for_any_press(sensor, spacing_mm, false, resources);
        }
        let place = deepest_place(touch, bodies)?;
        let new = |soft: SoftStack, spacing_mm: f64| {
            let reach_mm = FINE_RADII * NODES_PER_RADIUS * spacing_mm;
            let stack =
                soft.build_stack(spacing_mm, reach_mm, SINGLE_CONTACT_HARMONICS, resources)?;
            Ok::<_, PressingError>(Self { soft, stack, spacing_mm })
        };
        let soft = build_stack(sensor, touch, &points, &place)?;
        if let Some(spacing_mm) = spacing_mm {
            return new(soft, spacing_mm);
        }
        // A coarse press estimates the contact's radius, from which the final spacing follows.
        let (coarse_mm, finest_mm) = match touch {
            TouchSurface::Dome(_) => {
                let apart_mm = |nodes: f64| (points.area_mm2() / nodes).sqrt();
                (apart_mm(COARSE_NODES), apart_mm(MOST_NODES))
            }
            // A ball of 4 mm touches a circle of radius sqrt(2 r d).
            TouchSurface::Plane(_) => {
                let depth_mm = deepest_mm(touch, bodies)?.max(0.01);
                ((8.0 * depth_mm).sqrt() / 4.0, 0.0)
            }
        };
        let (mut coarse, mut coarse_mm) = (new(soft, coarse_mm)?, coarse_mm);
        let contact_mm = loop {
            match coarse.press(bodies, &Press::in_place()) {
                Ok(found) => break found.contact_radius_mm,
                // The body slips between the nodes, as a pin does: the spacing is halved until one touches.
                Err(error) if error.is_too_coarse() && coarse_mm > finest_mm.max(LEAST_LOOK_MM) => {
                    coarse_mm = (0.5 * coarse_mm).max(finest_mm);
                    coarse = new(coarse.soft, coarse_mm)?;
                }
                Err(error) => return Err(error),
            }
        };
        let fine_mm = (contact_mm / NODES_PER_RADIUS).clamp(finest_mm, coarse_mm);
        if fine_mm == coarse_mm { Ok(coarse) } else { new(coarse.soft, fine_mm) }
    }

    /// Creates a solver for presses anywhere, with nodes as fine as a few seconds of setup allow, or `spacing_mm`
    /// apart. With `is_dragged`, displacements along the surface are solved for as well: three times the work.
    ///
    /// # Errors
    /// Returns the errors of [`ElasticSolver::for_press`].
    pub fn for_any_press(
        sensor: &Sensor,
        spacing_mm: Option<f64>,
        is_dragged: bool,
        resources: SolverResources,
    ) -> Result<Self, PressingError> {
        check_spacing(spacing_mm)?;
        let touch = touch(sensor)?;
        let points = SurfacePoints::new(touch).map_err(SoftError::Solid)?;
        let (place, reach_mm, area_mm2) = stack_extent(&points);
        let soft = build_stack(sensor, touch, &points, &place)?;
        let spacing_mm = spacing_mm.unwrap_or((area_mm2 / MOST_NODES).sqrt());
        let stack = soft.build_stack(spacing_mm, reach_mm, usize::MAX, resources)?;
        let stack = stack.solve_everywhere(is_dragged).map_err(SoftError::from)?;
        Ok(Self { soft, stack, spacing_mm })
    }

    /// Presses all bodies in at once.
    ///
    /// # Errors
    /// Returns an error without contact, and for contact that is deeper than the layers or does not converge.
    pub fn press(&self, bodies: &[PressBody], how: &Press) -> Result<PressOutcome, PressingError> {
        let solids = bodies.iter().map(|body| CompiledSolid::new(&body.solid));
        let solids = solids.collect::<Result<Vec<_>, _>>().map_err(SoftError::Solid)?;
        let stack_from_sensor = self.soft.sensor_from_stack.inverse();
        let indenters: Vec<SolidIndenter> = solids
            .iter()
            .zip(bodies)
            .map(|(solid, body)| {
                SolidIndenter::new(solid, &stack_from_sensor.then_in(body.sensor_from_body))
            })
            .collect();
        Ok(self.stack.press(&indenters, how)?)
    }
}

/// Builds the stack of layers below a place, divided where the camera tracks markers.
pub(super) fn build_stack(
    sensor: &Sensor,
    touch: &TouchSurface,
    points: &SurfacePoints,
    place: &PressPoint,
) -> Result<SoftStack, SoftError> {
    let mut soft = SoftStack::from_sensor(sensor, points, place)?;
    soft.divide_at_markers(touch, &sensor.marks);
    Ok(soft)
}

/// Returns the surface that is pressed.
pub(super) fn touch(sensor: &Sensor) -> Result<&TouchSurface, PressingError> {
    let stiff = || SoftError::NothingSoft { sensor: sensor.name.clone() };
    Ok(sensor.touch.as_ref().ok_or_else(stiff)?)
}

/// Returns the centre of a stack for all presses, its radius, mm, and the area within, mm2.
fn stack_extent(points: &SurfacePoints) -> (PressPoint, f64, f64) {
    match points {
        // A dome's stack covers the whole surface, so its radius is not used.
        SurfacePoints::Dome(_) => ((Point3::origin(), Vector3::z()), 0.0, points.area_mm2()),
        SurfacePoints::Plane(face) => {
            let [x, y] = face.bounds_mm();
            let centre = [x, y].map(|[least, most]| f64::midpoint(least, most));
            let reach_mm = 0.5 * (x[1] - x[0]).hypot(y[1] - y[0]);
            let z_mm = face.at(centre).map_or(0.0, |(point, _)| point.z);
            let point = Point3::new(centre[0], centre[1], z_mm);
            ((point, Vector3::z()), reach_mm, PI * reach_mm * reach_mm)
        }
    }
}

fn deepest_mm(touch: &TouchSurface, bodies: &[PressBody]) -> Result<f64, PressingError> {
    let mut deepest_mm = 0.0;
    for body in bodies {
        let found = crate::ground_truth::find_penetration(touch, body).map_err(SoftError::Solid)?;
        deepest_mm = found.map_or(deepest_mm, |found| found.depth_mm.max(deepest_mm));
    }
    Ok(deepest_mm)
}

fn check_spacing(spacing_mm: Option<f64>) -> Result<(), PressingError> {
    let [least, most] = SPACING_LIMITS_MM;
    match spacing_mm.filter(|mm| !(least..=most).contains(mm)) {
        None => Ok(()),
        Some(mm) => Err(PressingError::Range {
            what: "spacing",
            value: format!("{mm} mm"),
            limit: format!("{least} mm to {most} mm"),
        }),
    }
}
