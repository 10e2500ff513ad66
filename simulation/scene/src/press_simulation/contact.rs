//! Contact models, and the solution of elastic contact.

use fabkit_depth::ground_truth::SurfaceDisplacement;
use fabkit_elastic::{
    DeformedSurface, DisplacementField, Press, PressOutcome, PressPoint, SoftError, SoftLayer,
    SoftStack, StrainTheory, SurfaceNode,
};
use fabkit_fixtures::PressBody;
use fabkit_geometry::{Point3, Sensor, TouchSurface, Vector3};

use super::{ElasticSolver, MarkerDisplacement, PressStep, PressingError, SHEAR_STEPS};
use crate::ground_truth::{Penetration, find_deepest_point};

/// Contact model: how the surface reacts to indenters.
///
/// ```
/// use fabkit_scene::press_simulation::{ContactModel, LinearOptions};
/// let named = |name, membrane_mm| ContactModel::from_name(name, membrane_mm, LinearOptions::default());
/// assert_eq!(named(None, 0.0)?, ContactModel::Rigid);
/// // A radius alone says that a membrane is meant.
/// assert_eq!(named(None, 1.5)?, ContactModel::Membrane(1.5));
/// assert!(named(Some("linear"), 1.5).is_err());
/// # Ok::<(), fabkit_scene::press_simulation::PressingError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactModel {
    /// The surface follows the indenter inside the contact and stays at rest elsewhere.
    Rigid,
    /// Same as [`ContactModel::Rigid`], with a transition back to rest within this distance around contacts, mm.
    Membrane(f64),
    /// Elastic layers at small strain.
    Linear(LinearOptions),
}

/// Options of elastic contact at small strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearOptions {
    /// Distance of the surface's nodes, mm; `None` for a value derived from the surface and the press.
    pub spacing_mm: Option<f64>,
    /// Coulomb's friction coefficient for displacements along the surface; `None` for that of the touched material.
    pub friction: Option<f64>,
}

impl ContactModel {
    /// Creates a contact model from its name and options. Without a name it is `membrane` if `membrane_mm` is not 0,
    /// else `rigid`.
    ///
    /// # Errors
    /// [`PressingError::Contact`] for an unknown name, and for options that belong to another model.
    pub fn from_name(
        name: Option<&str>,
        membrane_mm: f64,
        linear: LinearOptions,
    ) -> Result<Self, PressingError> {
        let has_membrane = membrane_mm != 0.0;
        let wrong = |problem: &str| Err(PressingError::Contact { problem: problem.to_owned() });
        let is_told = linear != LinearOptions::default();
        match name.unwrap_or(if has_membrane { "membrane" } else { "rigid" }) {
            "linear" if has_membrane => wrong("`linear` contact has no membrane"),
            "linear" => Ok(Self::Linear(linear)),
            "rigid" | "membrane" if is_told => {
                wrong("friction and spacing are only for `linear` contact")
            }
            "rigid" if has_membrane => wrong("`rigid` contact has no membrane"),
            "rigid" => Ok(Self::Rigid),
            "membrane" if !has_membrane => {
                wrong("`membrane` contact needs the distance within which the gel returns to rest")
            }
            "membrane" => Ok(Self::Membrane(membrane_mm)),
            other => wrong(&format!("there is no contact `{other}`: rigid, membrane or linear")),
        }
    }

    /// Returns the name of the model as in outputs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rigid => "rigid",
            Self::Membrane(_) => "membrane",
            Self::Linear(_) => StrainTheory::Linear.name(),
        }
    }

    /// Returns the radius of the transition around contacts, mm; 0 without one.
    pub fn membrane_mm(self) -> f64 {
        match self {
            Self::Membrane(radius_mm) => radius_mm,
            _ => 0.0,
        }
    }
}

/// Solution of a contact with the elastic layers.
#[derive(Debug)]
pub struct ContactSolution<'a> {
    ready: &'a ElasticSolver,
    yielded: DeformedSurface,
    outcome: PressOutcome,
    /// Forces, moments and contact, sensor frame.
    pub step: PressStep,
    /// Displacement of the indenters along the surface, sensor frame, mm.
    pub shear_displacement_mm: Vector3<f64>,
    /// Coulomb's friction coefficient; `None` if nothing moved along the surface.
    pub friction: Option<f64>,
}

impl ContactSolution<'_> {
    /// Returns the elastic theory behind the solution.
    pub fn level(&self) -> StrainTheory {
        StrainTheory::Linear
    }

    /// Returns the soft layers, from the touched one inwards.
    pub fn layers(&self) -> &[SoftLayer] {
        &self.ready.soft.layers
    }

    /// Returns the simplifications of the model as sentences.
    pub fn simplifications(&self) -> &[String] {
        &self.ready.soft.simplifications
    }

    /// Returns the nodes of the surface, in the frame of the stack.
    pub fn nodes(&self) -> &[SurfaceNode] {
        &self.outcome.nodes
    }

    /// Returns the displacement field of the lower face of a layer, by the layer's name; `None` for an unknown layer.
    pub fn lower_face(&self, layer: &str) -> Option<LowerFaceField<'_>> {
        let layers = &self.ready.soft.body.layers;
        // A layer divided at markers occurs several times under its name: the last part has the lower face. Interfaces
        // are numbered from the touched face.
        let above = layers.iter().rposition(|known| known.name == layer)?;
        let field = DisplacementField::new(&self.ready.stack, &self.outcome, above + 1);
        Some(LowerFaceField { soft: &self.ready.soft, field })
    }

    /// Returns the positions of the sensor's markers during the press.
    pub fn marks(&self, sensor: &Sensor, touch: &TouchSurface) -> Vec<MarkerDisplacement> {
        super::markers::compute_displacements(sensor, touch, &self.ready.soft, &self.outcome)
    }

    /// Returns the displacement field along the surface of a layer's outer face, by the layer's name; the touched face
    /// for an unknown layer.
    pub fn tangential_field(&self, layer: &str) -> TangentialField<'_> {
        let layers = &self.ready.soft.body.layers;
        let interface = layers.iter().position(|known| known.name == layer).unwrap_or(0);
        let field = DisplacementField::new(&self.ready.stack, &self.outcome, interface);
        TangentialField { soft: &self.ready.soft, field }
    }

    /// Returns the distance of the surface's nodes, mm.
    pub fn spacing_mm(&self) -> f64 {
        self.ready.spacing_mm
    }
}

/// Displacement field of the lower face of a layer.
#[derive(Debug)]
pub struct LowerFaceField<'a> {
    soft: &'a SoftStack,
    field: DisplacementField,
}

impl LowerFaceField<'_> {
    /// Returns the outward displacement below a point of the undeformed surface (sensor frame, mm), in mm.
    pub fn outwards_mm(&self, point_in_sensor: &Point3<f64>) -> f64 {
        let [s, azimuth] = self.soft.coordinates(point_in_sensor);
        self.field.outwards_mm(s, azimuth)
    }
}

/// Tangential displacement field of an interface between layers.
#[derive(Debug)]
pub struct TangentialField<'a> {
    soft: &'a SoftStack,
    field: DisplacementField,
}

impl TangentialField<'_> {
    /// Returns the tangential displacement below a point of the undeformed surface with its outward normal, sensor
    /// frame, mm.
    pub fn displacement_mm(
        &self,
        point_in_sensor: &Point3<f64>,
        outward: &Vector3<f64>,
    ) -> Vector3<f64> {
        let [s, azimuth] = self.soft.coordinates(point_in_sensor);
        let [first, second] = self.field.sideways_mm(s, azimuth);
        let [along, around] = self.soft.surface_tangents(point_in_sensor, outward);
        first * along + second * around
    }
}

impl SurfaceDisplacement for ContactSolution<'_> {
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

impl ElasticSolver {
    /// Computes the reaction of the layers to bodies that are all pressed in at once and then move along the surface by
    /// `shear_mm`: on a dome away from the tip and around it, at the deepest point of contact; on a pad along x and y.
    ///
    /// # Errors
    /// Returns an error without contact, for contact that is deeper than the layers or does not converge, and for a
    /// displacement along a surface of unknown friction.
    pub fn solve_contact(
        &self,
        touch: &TouchSurface,
        bodies: &[PressBody],
        shear_mm: [f64; 2],
        friction: Option<f64>,
    ) -> Result<ContactSolution<'_>, PressingError> {
        // The straight press is the result without shear; with shear, the deformed surface is built from both
        // solutions.
        let straight = self.press(bodies, &Press::in_place())?;
        let depth_mm = straight.depth_mm;
        if shear_mm == [0.0; 2] {
            return Ok(ContactSolution {
                ready: self,
                yielded: DeformedSurface::new(&self.stack, &straight, None),
                step: PressStep::from_outcome([depth_mm, 0.0], &straight, &self.soft),
                outcome: straight,
                shear_displacement_mm: Vector3::zeros(),
                friction: None,
            });
        }
        let friction = self.friction(friction)?;
        let way_mm = self.surface_displacement(touch, &deepest_place(touch, bodies)?, shear_mm);
        // The solver works in the frame of the stack.
        let way_in_stack = self.soft.sensor_from_stack.inverse().vector(way_mm);
        let press = Press::in_place().with_shear(friction, way_in_stack, SHEAR_STEPS)?;
        let sheared = self.press(bodies, &press)?;
        Ok(ContactSolution {
            ready: self,
            yielded: DeformedSurface::new(&self.stack, &straight, Some(&sheared)),
            step: PressStep::from_outcome([depth_mm, way_mm.norm()], &sheared, &self.soft),
            outcome: sheared,
            shear_displacement_mm: way_mm,
            friction: Some(friction),
        })
    }

    /// Returns the given friction coefficient, else that of the touched material.
    ///
    /// # Errors
    /// [`PressingError::NoFriction`] if neither is known.
    pub(super) fn friction(&self, given: Option<f64>) -> Result<f64, PressingError> {
        let touched = self.soft.layers.first();
        let known = given.or(touched.and_then(|layer| layer.elasticity.friction));
        let material = || touched.map_or_else(String::new, |layer| layer.material.clone());
        known.ok_or_else(|| PressingError::NoFriction { material: material() })
    }

    /// Converts a displacement along the surface at a place to the sensor frame, mm.
    pub(super) fn surface_displacement(
        &self,
        touch: &TouchSurface,
        (point, outward): &PressPoint,
        [first, second]: [f64; 2],
    ) -> Vector3<f64> {
        let [x, y] = match touch {
            // On a pad the sensor's axes are the directions, on a dome meridian and parallel.
            TouchSurface::Plane(_) => [Vector3::x(), Vector3::y()],
            TouchSurface::Dome(_) => self.soft.surface_tangents(point, outward),
        };
        first * x + second * y
    }
}

/// Finds the deepest point of contact of all bodies, and returns the point of the undeformed surface above it with its
/// normal, sensor frame, mm.
pub(super) fn deepest_place(
    touch: &TouchSurface,
    bodies: &[PressBody],
) -> Result<PressPoint, PressingError> {
    let mut deepest: Option<Penetration> = None;
    for body in bodies {
        let found = find_deepest_point(touch, body).map_err(SoftError::Solid)?;
        deepest = match (deepest, found) {
            (Some(a), Some(b)) => Some(if b.depth_mm > a.depth_mm { b } else { a }),
            (a, b) => a.or(b),
        };
    }
    // Bodies that lie below the surface's foot have no deepest point; the origin stands in.
    let point = deepest.map_or_else(Point3::origin, |deepest| deepest.point_in_sensor);
    let (depth_mm, outward) = touch.depth_mm(&point);
    Ok((point + depth_mm * outward, outward))
}
