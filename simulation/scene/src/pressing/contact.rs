//! How a surface answers what presses on it, and what it answers.

use fabkit_depth::truth::Yielding;
use fabkit_elastic::{
    Field, Level, Outcome, Place, Press, SoftError, SoftLayer, SoftStack, SurfaceNode, Yielded,
};
use fabkit_fixtures::PressBody;
use fabkit_geometry::{Point3, Sensor, TouchSurface, Vector3};

use super::{Moved, PressingError, Ready, SHEAR_STEPS, Step};
use crate::ground_truth::{Penetration, approach};

/// How the surface answers what presses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    /// It follows the presser, and nothing else moves.
    Rigid,
    /// It also comes back to rest within a distance around contacts, mm.
    Membrane(f64),
    /// It gives way as elastic layers do, at small strain.
    Linear(Linear),
}

/// What elastic contact at small strain may be told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Linear {
    /// Distance of the surface's nodes, mm; nothing for what the surface asks for.
    pub spacing_mm: Option<f64>,
    /// Coulomb's coefficient of ways along the surface; nothing for the touched material's own.
    pub friction: Option<f64>,
}

impl Contact {
    /// From the words and lengths of a call: without a name, `membrane` where there is a distance, else `rigid`.
    ///
    /// # Errors
    /// [`PressingError::Contact`]: no such level, and what belongs to another one.
    pub fn named(
        name: Option<&str>,
        membrane_mm: f64,
        linear: Linear,
    ) -> Result<Self, PressingError> {
        let has_membrane = membrane_mm != 0.0;
        let wrong = |problem: &str| Err(PressingError::Contact { problem: problem.to_owned() });
        let is_told = linear != Linear::default();
        match name.unwrap_or(if has_membrane { "membrane" } else { "rigid" }) {
            "linear" if has_membrane => wrong("`linear` contact has no membrane"),
            "linear" => Ok(Self::Linear(linear)),
            "rigid" | "membrane" if is_told => {
                wrong("friction and the distance of nodes belong to `linear` contact")
            }
            "rigid" if has_membrane => wrong("`rigid` contact has no membrane"),
            "rigid" => Ok(Self::Rigid),
            "membrane" if !has_membrane => wrong(
                "`membrane` contact needs to know within which distance the gel comes back to rest",
            ),
            "membrane" => Ok(Self::Membrane(membrane_mm)),
            other => wrong(&format!("there is no contact `{other}`: rigid, membrane or linear")),
        }
    }

    /// As outputs name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rigid => "rigid",
            Self::Membrane(_) => "membrane",
            Self::Linear(_) => Level::Linear.name(),
        }
    }

    /// Of the transition around contacts, mm; 0 without one.
    pub fn membrane_mm(self) -> f64 {
        match self {
            Self::Membrane(radius_mm) => radius_mm,
            _ => 0.0,
        }
    }
}

/// What soft layers answered to a press, and where their surface now is.
#[derive(Debug)]
pub struct Answer<'a> {
    ready: &'a Ready,
    yielded: Yielded,
    outcome: Outcome,
    /// Forces, moments and contact, in the sensor's frame.
    pub step: Step,
    /// Where the presser went along the surface, sensor frame, mm.
    pub way_mm: Vector3<f64>,
    /// Coulomb's coefficient, where it did.
    pub friction: Option<f64>,
}

impl Answer<'_> {
    /// By which theory.
    pub fn level(&self) -> Level {
        Level::Linear
    }

    /// What gave way, from the touched layer inwards.
    pub fn layers(&self) -> &[SoftLayer] {
        &self.ready.soft.layers
    }

    /// What was simplified, in words.
    pub fn left_out(&self) -> &[String] {
        &self.ready.soft.left_out
    }

    /// The surface's nodes, in the frame of the stack.
    pub fn nodes(&self) -> &[SurfaceNode] {
        &self.outcome.nodes
    }

    /// How the lower face of a layer moves, by its name; nothing of what is no layer here.
    pub fn lower_face(&self, layer: &str) -> Option<LowerFace<'_>> {
        let layers = &self.ready.soft.body.layers;
        let above = layers.iter().rposition(|known| known.name == layer)?;
        let field = Field::new(&self.ready.stack, &self.outcome, above + 1);
        Some(LowerFace { soft: &self.ready.soft, field })
    }

    /// Where a sensor's marks are.
    pub fn marks(&self, sensor: &Sensor, touch: &TouchSurface) -> Vec<Moved> {
        super::marks::moved(sensor, touch, &self.ready.soft, &self.outcome)
    }

    /// How a layer's outer face moves along the surface, by the layer's name; the touched face for what is no layer here.
    pub fn sideways(&self, layer: &str) -> Sideways<'_> {
        let layers = &self.ready.soft.body.layers;
        let interface = layers.iter().position(|known| known.name == layer).unwrap_or(0);
        let field = Field::new(&self.ready.stack, &self.outcome, interface);
        Sideways { soft: &self.ready.soft, field }
    }

    /// Distance of the surface's nodes, mm.
    pub fn spacing_mm(&self) -> f64 {
        self.ready.spacing_mm
    }
}

/// The face below a layer, as it moves.
#[derive(Debug)]
pub struct LowerFace<'a> {
    soft: &'a SoftStack,
    field: Field,
}

impl LowerFace<'_> {
    /// How far it moves outwards below a point of the surface at rest, sensor frame, mm.
    pub fn outwards_mm(&self, point_in_sensor: &Point3<f64>) -> f64 {
        let [s, azimuth] = self.soft.coordinates(point_in_sensor);
        self.field.outwards_mm(s, azimuth)
    }
}

/// A face within the layers, as it moves along the surface.
#[derive(Debug)]
pub struct Sideways<'a> {
    soft: &'a SoftStack,
    field: Field,
}

impl Sideways<'_> {
    /// How far it moves below a point of the surface at rest with its outward normal, sensor frame, mm.
    pub fn mm(&self, point_in_sensor: &Point3<f64>, outward: &Vector3<f64>) -> Vector3<f64> {
        let [s, azimuth] = self.soft.coordinates(point_in_sensor);
        let [first, second] = self.field.sideways_mm(s, azimuth);
        let [along, around] = self.soft.along(point_in_sensor, outward);
        first * along + second * around
    }
}

impl Yielding for Answer<'_> {
    #[inline]
    fn outwards_mm(&self, point_in_sensor: &Point3<f64>, outward: &Vector3<f64>) -> f64 {
        self.yielded.outwards_mm(&self.ready.soft, point_in_sensor, outward)
    }

    #[inline]
    fn is_touched(&self, point_in_sensor: &Point3<f64>, outward: &Vector3<f64>) -> bool {
        self.yielded.pressure_mpa(&self.ready.soft, point_in_sensor, outward) > 0.0
    }

    fn limits_mm(&self) -> [f64; 2] {
        [self.step.max_indentation_mm, self.step.bulge_mm]
    }
}

impl Ready {
    /// What the layers answer to bodies that are pressed in all at once, and then move on along the surface, mm: on a
    /// dome away from the tip and around it where they go deepest, on a pad along x and y.
    ///
    /// # Errors
    /// No contact, one that is deeper than the layers or does not converge; a way along a surface of unknown friction.
    pub fn answer(
        &self,
        touch: &TouchSurface,
        bodies: &[PressBody],
        shear_mm: [f64; 2],
        friction: Option<f64>,
    ) -> Result<Answer<'_>, PressingError> {
        let straight = self.press(bodies, &Press::in_place())?;
        let depth_mm = straight.depth_mm;
        if shear_mm == [0.0; 2] {
            return Ok(Answer {
                ready: self,
                yielded: Yielded::new(&self.stack, &straight, None),
                step: Step::of([depth_mm, 0.0], &straight, &self.soft),
                outcome: straight,
                way_mm: Vector3::zeros(),
                friction: None,
            });
        }
        let friction = self.friction(friction)?;
        let way_mm = self.along_surface(touch, &deepest_place(touch, bodies)?, shear_mm);
        let way_in_stack = self.soft.sensor_from_stack.inverse().vector(way_mm);
        let press = Press::in_place().sheared(friction, way_in_stack, SHEAR_STEPS)?;
        let sheared = self.press(bodies, &press)?;
        Ok(Answer {
            ready: self,
            yielded: Yielded::new(&self.stack, &straight, Some(&sheared)),
            step: Step::of([depth_mm, way_mm.norm()], &sheared, &self.soft),
            outcome: sheared,
            way_mm,
            friction: Some(friction),
        })
    }

    /// The touched material's own friction unless another is given.
    ///
    /// # Errors
    /// Nobody says how much there is.
    pub(super) fn friction(&self, given: Option<f64>) -> Result<f64, PressingError> {
        let touched = self.soft.layers.first();
        let known = given.or(touched.and_then(|layer| layer.elasticity.friction));
        let material = || touched.map_or_else(String::new, |layer| layer.material.clone());
        known.ok_or_else(|| PressingError::NoFriction { material: material() })
    }

    /// A way along the surface at a place of it, sensor frame, mm.
    pub(super) fn along_surface(
        &self,
        touch: &TouchSurface,
        (point, outward): &Place,
        [first, second]: [f64; 2],
    ) -> Vector3<f64> {
        let [x, y] = match touch {
            TouchSurface::Plane(_) => [Vector3::x(), Vector3::y()],
            TouchSurface::Dome(_) => self.soft.along(point, outward),
        };
        first * x + second * y
    }
}

/// Where bodies go deepest: a point of the surface and its normal, sensor frame, mm.
pub(super) fn deepest_place(
    touch: &TouchSurface,
    bodies: &[PressBody],
) -> Result<Place, PressingError> {
    let mut deepest: Option<Penetration> = None;
    for body in bodies {
        let found = approach(touch, body).map_err(SoftError::Solid)?;
        deepest = match (deepest, found) {
            (Some(a), Some(b)) => Some(if b.depth_mm > a.depth_mm { b } else { a }),
            (a, b) => a.or(b),
        };
    }
    let point = deepest.map_or_else(Point3::origin, |deepest| deepest.point_in_sensor);
    let (depth_mm, outward) = touch.depth_mm(&point);
    Ok((point + depth_mm * outward, outward))
}
