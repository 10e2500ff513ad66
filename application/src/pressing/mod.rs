//! What a press does to a sensor's soft layers: forces, contact, how the surface moves.
//!
//! The layers are those that are drawn below the surface, with the moduli of their materials; the presser is the
//! exact solid of a fixture's press. By [`fabkit_elastic`], at small strain.

mod bodies;
mod curve;
mod error;
mod files;
mod layers;
mod meridian;

use fabkit_elastic::{Division, Level, Outcome, Press, SolidPresser, Stack};
use fabkit_fixtures::Project;
use fabkit_geometry::{CompiledSolid, Point3, SurfacePoints, TouchSurface, Vector3};

pub use curve::{Pressed, Step};
pub use error::PressingError;
pub use files::{arrays, curve_csv, curve_svg};
pub use layers::{Place, SoftLayer, SoftStack};

/// Most steps of a curve.
pub const MAX_STEPS: u32 = 200;
/// Nodes of a dome's surface for a first look, about: a press takes some tens of milliseconds.
const COARSE_NODES: f64 = 5000.0;
/// The most nodes of a dome's surface that nobody asked for: its setup takes some ten seconds.
const MOST_NODES: f64 = 25_000.0;
/// Nodes across the contact, from its middle to its edge, about.
const ACROSS_CONTACT: f64 = 8.0;
/// Steps of a way along the surface, in which what slips is told from what sticks.
const SHEAR_STEPS: usize = 8;
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
    /// How far the presser moves on along the surface, mm: on a dome away from the tip and around it, counter-clockwise
    /// seen from the tip; on a pad along x and y.
    pub shear_mm: [f64; 2],
    /// Coulomb's coefficient for that; nothing for the touched material's own.
    pub friction: Option<f64>,
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
        let touch = sensor
            .touch
            .as_ref()
            .ok_or_else(|| PressingError::Stiff { sensor: sensor.name.clone() })?;
        let points = SurfacePoints::new(touch).map_err(PressingError::Solid)?;
        let place = place_of(&last, touch, self.depth_mm);
        let soft = SoftStack::of(sensor, &points, &place)?;
        let spacing_mm = match self.spacing_mm {
            Some(spacing_mm) => spacing_mm,
            None => {
                // A coarse press tells how wide the contact is.
                let coarse_mm = self.coarse_mm(touch, &points);
                let stack = self.stack(&soft, touch, coarse_mm)?;
                let contact_mm =
                    self.at(&last, &soft, &stack, Press::in_place())?.contact_radius_mm;
                let finest_mm = match touch {
                    TouchSurface::Dome(_) => (points.area_mm2() / MOST_NODES).sqrt(),
                    TouchSurface::Plane(_) => 0.0,
                };
                (contact_mm / ACROSS_CONTACT).clamp(finest_mm, coarse_mm)
            }
        };
        let stack = self.stack(&soft, touch, spacing_mm)?;
        let mut steps = Vec::new();
        let mut outcome = None;
        for i in 1..=self.steps {
            let depth_mm = self.depth_mm * f64::from(i) / f64::from(self.steps);
            let pressed =
                self.at(&finder.press(&id(depth_mm))?, &soft, &stack, Press::in_place())?;
            steps.push(Step::of([depth_mm, 0.0], &pressed, &soft));
            outcome = Some(pressed);
        }
        let friction = self.friction_on(&soft)?;
        if let Some(friction) = friction {
            let way_mm = soft.sensor_from_stack.inverse().vector(along_surface(
                touch,
                &place,
                self.shear_mm,
            ));
            let press = Press::in_place()
                .sheared(friction, way_mm, SHEAR_STEPS)
                .map_err(PressingError::Elastic)?;
            let pressed = self.at(&last, &soft, &stack, press)?;
            steps.push(Step::of([self.depth_mm, way_mm.norm()], &pressed, &soft));
            outcome = Some(pressed);
        }
        let outcome = outcome.ok_or_else(|| self.no_steps())?;
        let nodes = stack.surface_nodes();
        Ok(Pressed {
            id: last.id,
            level: Level::Linear,
            spacing_mm,
            friction,
            steps,
            outcome,
            soft,
            nodes,
        })
    }

    /// Nothing where the presser does not move along the surface.
    fn friction_on(&self, soft: &SoftStack) -> Result<Option<f64>, PressingError> {
        if self.shear_mm == [0.0; 2] {
            return Ok(None);
        }
        let touched = soft.layers.first();
        let known = self.friction.or(touched.and_then(|layer| layer.elasticity.friction));
        let material = || touched.map_or_else(String::new, |layer| layer.material.clone());
        known.map(Some).ok_or_else(|| PressingError::NoFriction { material: material() })
    }

    fn at(
        &self,
        press: &fabkit_fixtures::Press,
        soft: &SoftStack,
        stack: &Stack,
        how: Press,
    ) -> Result<Outcome, PressingError> {
        let stack_from_sensor = soft.sensor_from_stack.inverse();
        // A tool is one body; what has several is no tool, and has no place.
        let Some(body) = press.bodies.first() else { return Err(self.no_steps()) };
        let solid = CompiledSolid::new(&body.solid).map_err(PressingError::Solid)?;
        let presser = SolidPresser::new(&solid, &stack_from_sensor.then_in(body.sensor_from_body));
        stack.press(&presser, &how).map_err(PressingError::Elastic)
    }

    fn stack(
        &self,
        soft: &SoftStack,
        touch: &TouchSurface,
        spacing_mm: f64,
    ) -> Result<Stack, PressingError> {
        let division = match touch {
            TouchSurface::Dome(dome) => {
                let around_mm = std::f64::consts::TAU * dome.equator_radius_mm();
                Division::even(spacing_mm, (around_mm / (2.0 * spacing_mm)).ceil() as usize)
            }
            TouchSurface::Plane(_) => {
                let reach_mm = 2.5 * ACROSS_CONTACT * spacing_mm;
                Division::around_pole(spacing_mm, reach_mm, PAD_HARMONICS)
            }
        };
        Stack::new(&soft.body, &division, self.threads).map_err(PressingError::Elastic)
    }

    /// Distance of nodes for a first look, mm.
    fn coarse_mm(&self, touch: &TouchSurface, points: &SurfacePoints) -> f64 {
        match touch {
            TouchSurface::Dome(_) => (points.area_mm2() / COARSE_NODES).sqrt(),
            // A ball of 4 mm touches a circle of radius sqrt(2 r d).
            TouchSurface::Plane(_) => (8.0 * self.depth_mm).sqrt() / 4.0,
        }
    }

    fn check(&self) -> Result<(), PressingError> {
        if !(1..=MAX_STEPS).contains(&self.steps) {
            return Err(self.no_steps());
        }
        let is_spacing = self.spacing_mm.is_none_or(|mm| (0.01..=5.0).contains(&mm));
        if !is_spacing {
            let value = format!("{} mm", self.spacing_mm.unwrap_or(f64::NAN));
            return Err(PressingError::Range {
                what: "spacing",
                value,
                limit: "0.01 mm to 5 mm".into(),
            });
        }
        Ok(())
    }

    fn no_steps(&self) -> PressingError {
        let limit = format!("1 to {MAX_STEPS} steps");
        PressingError::Range { what: "steps", value: self.steps.to_string(), limit }
    }
}

/// A way along the surface at a place of it, sensor frame, mm.
fn along_surface(
    touch: &TouchSurface,
    (point, outward): &Place,
    [first, second]: [f64; 2],
) -> Vector3<f64> {
    let [x, y] = match touch {
        TouchSurface::Plane(_) => [Vector3::x(), Vector3::y()],
        TouchSurface::Dome(_) => {
            let out = Vector3::new(point.x, point.y, 0.0);
            // At the tip every direction is away from it: along x.
            let out = out.try_normalize(1e-9).unwrap_or_else(Vector3::x);
            let around = Vector3::z().cross(&out);
            [around.cross(outward), around]
        }
    };
    first * x + second * y
}

/// As many threads as work is done on.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// Where a tool touches first: its tip frame has z out of the tool.
fn place_of(
    press: &fabkit_fixtures::Press,
    touch: &TouchSurface,
    depth_mm: f64,
) -> (Point3<f64>, Vector3<f64>) {
    let Some(body) = press.bodies.first() else { return (Point3::origin(), Vector3::z()) };
    let tip = body.sensor_from_body.point(Point3::origin());
    let (_, outward) = touch.depth_mm(&tip);
    (tip + depth_mm * outward, outward)
}
