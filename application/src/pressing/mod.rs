//! What a press does to a sensor's soft layers: forces, contact, how the surface moves.
//!
//! The layers are those that are drawn below the surface, with the moduli of their materials; the presser is the
//! exact solid of a fixture's press. By [`fabkit_elastic`], at small strain.

mod curve;
mod error;
mod files;
mod layers;

use fabkit_elastic::{Division, Level, Outcome, Press, SolidPresser, Stack};
use fabkit_fixtures::Project;
use fabkit_geometry::{CompiledSolid, Point3, SurfacePoints, TouchSurface, Vector3};

pub use curve::{Pressed, Step};
pub use error::PressingError;
pub use files::{arrays, curve_csv, curve_svg};
pub use layers::{SoftLayer, SoftStack};

/// Most steps of a curve.
pub const MAX_STEPS: u32 = 200;
/// Nodes of a dome's surface, about: what a press of some tens of milliseconds takes.
const DOME_NODES: f64 = 5000.0;
/// Nodes across the contact of a pad, from its middle to its edge, about.
const ACROSS_CONTACT: f64 = 10.0;
/// Harmonics of the azimuth on a pad, whose presses are in its middle.
const PAD_HARMONICS: usize = 24;

/// What to press, and how finely to look.
#[derive(Clone, Debug)]
pub struct Pressing<'a> {
    /// An indenter and a place without its depth: `ball@30deg,120deg`, or `ball@2mm,-3mm` on a pad.
    pub indenter: &'a str,
    /// How deep, mm, along the surface's normal at that place.
    pub depth_mm: f64,
    /// Of how many equal steps of depth the force curve is made.
    pub steps: u32,
    /// Distance of the surface's nodes, mm; nothing for what the surface and the press ask for.
    pub spacing_mm: Option<f64>,
    /// Threads for the setup; the result does not depend on how many.
    pub threads: usize,
}

impl Pressing<'_> {
    /// Presses step by step, and keeps what the last one does.
    ///
    /// # Errors
    /// [`PressingError`]: no such press, nothing soft, a contact that does not converge.
    pub fn run(&self, project: &Project) -> Result<Pressed, PressingError> {
        self.check()?;
        let finder = project.press_finder();
        let id = |depth_mm: f64| format!("{},{depth_mm}mm", self.indenter);
        let last = finder.press(&id(self.depth_mm))?;
        let sensor = &project.design.sensor;
        let touch = sensor.touch.as_ref().ok_or_else(|| PressingError::Stiff { sensor: sensor.name.clone() })?;
        let points = SurfacePoints::new(touch).map_err(PressingError::Solid)?;
        let place = place_of(&last, touch, self.depth_mm);
        let soft = SoftStack::of(sensor, &points, &place)?;
        let spacing_mm = self.spacing_mm.unwrap_or_else(|| self.spacing(touch, &points));
        let division = match touch {
            TouchSurface::Dome(dome) => {
                let around_mm = std::f64::consts::TAU * dome.equator_radius_mm();
                Division::even(spacing_mm, (around_mm / (2.0 * spacing_mm)).ceil() as usize)
            }
            TouchSurface::Plane(_) => {
                let reach_mm = ACROSS_CONTACT * spacing_mm * 2.0;
                Division::around_pole(spacing_mm, reach_mm, PAD_HARMONICS)
            }
        };
        let stack = Stack::new(&soft.body, &division, self.threads).map_err(PressingError::Elastic)?;
        let mut steps = Vec::new();
        let mut outcome = None;
        for i in 1..=self.steps {
            let depth_mm = self.depth_mm * f64::from(i) / f64::from(self.steps);
            let pressed = self.at(&finder.press(&id(depth_mm))?, &soft, &stack)?;
            steps.push(Step::of(depth_mm, &pressed, &soft));
            outcome = Some(pressed);
        }
        let outcome = outcome.ok_or_else(|| self.no_steps())?;
        Ok(Pressed { id: last.id, level: Level::Linear, spacing_mm, steps, outcome, soft, nodes: stack.surface_nodes() })
    }

    fn at(
        &self,
        press: &fabkit_fixtures::Press,
        soft: &SoftStack,
        stack: &Stack,
    ) -> Result<Outcome, PressingError> {
        let stack_from_sensor = soft.sensor_from_stack.inverse();
        // A tool is one body; what has several is no tool, and has no place.
        let Some(body) = press.bodies.first() else { return Err(self.no_steps()) };
        let solid = CompiledSolid::new(&body.solid).map_err(PressingError::Solid)?;
        let presser = SolidPresser::new(solid, &stack_from_sensor.then_in(body.sensor_from_body));
        stack.press(&presser, &Press::in_place()).map_err(PressingError::Elastic)
    }

    fn spacing(&self, touch: &TouchSurface, points: &SurfacePoints) -> f64 {
        match touch {
            TouchSurface::Dome(_) => (points.area_mm2() / DOME_NODES).sqrt(),
            // A ball of 4 mm touches a circle of radius sqrt(2 r d).
            TouchSurface::Plane(_) => (8.0 * self.depth_mm).sqrt() / ACROSS_CONTACT,
        }
    }

    fn check(&self) -> Result<(), PressingError> {
        if !(1..=MAX_STEPS).contains(&self.steps) {
            return Err(self.no_steps());
        }
        let is_spacing = self.spacing_mm.is_none_or(|mm| (0.01..=5.0).contains(&mm));
        if !is_spacing {
            let value = format!("{} mm", self.spacing_mm.unwrap_or(f64::NAN));
            return Err(PressingError::Range { what: "spacing", value, limit: "0.01 mm to 5 mm".into() });
        }
        Ok(())
    }

    fn no_steps(&self) -> PressingError {
        let limit = format!("1 to {MAX_STEPS} steps");
        PressingError::Range { what: "steps", value: self.steps.to_string(), limit }
    }
}

/// As many threads as work is done on.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// Where a tool touches first: its tip frame has z out of the tool.
fn place_of(press: &fabkit_fixtures::Press, touch: &TouchSurface, depth_mm: f64) -> (Point3<f64>, Vector3<f64>) {
    let Some(body) = press.bodies.first() else { return (Point3::origin(), Vector3::z()) };
    let tip = body.sensor_from_body.point(Point3::origin());
    let (_, outward) = touch.depth_mm(&tip);
    (tip + depth_mm * outward, outward)
}
