//! Presses at large strain, at the tip of a dome or anywhere on a pad: the reference for small strain.

use fabkit_elastic::{FiniteStack, Press, SoftError, SolidIndenter, StrainTheory};
use fabkit_fixtures::Project;
use fabkit_geometry::{CompiledSolid, Pose, SurfacePoints};

use super::contact::deepest_place;
use super::{PressRequest, PressResult, PressStep, PressingError, elastic_solver, markers};

/// Largest distance from the axis at which a press still counts as one at the tip, mm.
const OFF_AXIS_MM: f64 = 1e-6;
/// Approximate number of nodes from the middle of a contact to its edge.
const NODES_PER_RADIUS: f64 = 16.0;
/// Radius of the finely divided part of the surface, in contact radii.
const FINE_RADII: f64 = 2.5;
/// Distance of the indenter's start above the surface, mm.
const ABOVE_MM: f64 = 0.5;

impl PressRequest<'_> {
    /// Solves the press at increasing depths, with force, contact and bulge of each.
    ///
    /// # Errors
    /// Returns an error for a press off the axis, along the surface, or by bodies that are not symmetric, and if the
    /// solver does not converge.
    pub(super) fn run_finite(&self, project: &Project) -> Result<PressResult, PressingError> {
        let press = project.press_finder().press(&self.id(self.depth_mm))?;
        let sensor = &project.design.sensor;
        let touch = elastic_solver::touch(sensor)?;
        let place = deepest_place(touch, &press.bodies)?;
        let points = SurfacePoints::new(touch).map_err(SoftError::Solid)?;
        let soft = elastic_solver::build_stack(sensor, touch, &points, &place)?;
        let pole = soft.sensor_from_stack.inverse().point(place.0);
        if self.shear_mm != [0.0; 2] {
            return Err(PressingError::Finite { what: "cannot have shear" });
        }
        let [body] = &press.bodies[..] else {
            return Err(PressingError::Finite { what: "must be of a single body" });
        };
        if pole.x.hypot(pole.y) > OFF_AXIS_MM {
            return Err(PressingError::Finite { what: "must be at the tip" });
        }
        let solid = CompiledSolid::new(&body.solid).map_err(SoftError::Solid)?;
        // Lifts the indenter from its final pose to its start.
        let up = Pose::translation(0.0, 0.0, self.depth_mm + ABOVE_MM);
        let pose = soft.sensor_from_stack.inverse().then_in(body.sensor_from_body);
        let indenter = SolidIndenter::new(&solid, &up.then_in(pose));
        let around = |spacing_mm: f64, across: f64| {
            soft.division_at_pole(spacing_mm, FINE_RADII * across * spacing_mm)
        };
        // A coarse press at small strain estimates the contact's radius, which sets the fine mesh. Without an estimate,
        // a ball of 4 mm touches a circle of radius sqrt(8 depth).
        let coarse_mm = (8.0 * self.depth_mm).sqrt() / 8.0;
        let coarse =
            fabkit_elastic::ElasticStack::new(&soft.body, &around(coarse_mm, 8.0), self.resources)?;
        let down = Press::along(-fabkit_geometry::Vector3::z(), self.depth_mm)?;
        let contact_mm = coarse.press(&indenter, &down)?.contact_radius_mm;
        let spacing_mm = self.spacing_mm.unwrap_or(contact_mm.max(coarse_mm) / NODES_PER_RADIUS);
        let stack = FiniteStack::new(&soft.body, &around(spacing_mm, NODES_PER_RADIUS))?;
        let depths_mm: Vec<f64> = (1..=self.steps).map(|i| self.depth_at(i)).collect();
        let mut outcomes = stack.press(&indenter, &depths_mm)?;
        let both = depths_mm.iter().zip(&outcomes);
        let steps =
            both.map(|(mm, outcome)| PressStep::from_outcome([*mm, 0.0], outcome, &soft)).collect();
        let outcome = outcomes.pop().ok_or_else(|| self.no_steps())?;
        let nodes = outcome.nodes.len();
        let marks = markers::compute_displacements(sensor, touch, &soft, &outcome);
        Ok(PressResult {
            id: press.id,
            level: StrainTheory::Finite,
            spacing_mm,
            friction: None,
            steps,
            outcome,
            marks,
            soft,
            nodes,
        })
    }
}
