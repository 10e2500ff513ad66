//! Rigid indenters and how they move.

use std::cell::RefCell;

use fabkit_geometry::{CompiledSolid, Point3, Pose, Ray, Scratch, Vector3};

use crate::ElasticError;

/// A rigid indenter as the touched surface needs it: by its gap along a line.
///
/// ```
/// use fabkit_elastic::{BallIndenter, Indenter};
/// use fabkit_geometry::{Point3, Vector3};
///
/// // A plate 4 mm above the origin, as a function: the distance along the normal.
/// let plate = |place: &Point3<f64>, outward: &Vector3<f64>, _: f64| (4.0 - place.z) / outward.z;
/// assert_eq!(plate.gap_mm(&Point3::new(1.0, 0.0, 3.0), &Vector3::z(), 9.0), 1.0);
/// // Of two balls the nearer counts.
/// let ball = |z_mm| BallIndenter::new(Point3::new(0.0, 0.0, z_mm), 2.0);
/// let both = vec![ball(5.0)?, ball(8.0)?];
/// assert_eq!(both.gap_mm(&Point3::origin(), &Vector3::z(), 9.0), 3.0);
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
pub trait Indenter {
    /// Returns the distance from `place` along the unit vector `outward` (out of the soft body) to the indenter, mm.
    ///
    /// Negative where `place` lies inside the indenter, by the depth to which the indenter reaches below it; infinite
    /// where the line misses the indenter. An interval of the line that lies wholly more than `reach_mm` below `place`
    /// belongs to another part of the indenter on the far side of the body and is ignored; an interval that begins
    /// there and ends above counts. All arguments are in the soft body's frame.
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64;
}

impl<F: Fn(&Point3<f64>, &Vector3<f64>, f64) -> f64> Indenter for F {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        self(place, outward, reach_mm)
    }
}

/// Returns the begin of the first interval that does not lie wholly deeper than `reach_mm`; infinite if there is none.
fn first_begin(stretches: impl IntoIterator<Item = [f64; 2]>, reach_mm: f64) -> f64 {
    let first = stretches.into_iter().find(|[_, end]| *end > -reach_mm);
    first.map_or(f64::INFINITY, |[begin, _]| begin)
}

/// A spherical indenter.
///
/// ```
/// use fabkit_elastic::{BallIndenter, Indenter};
/// use fabkit_geometry::{Point3, Vector3};
///
/// // A ball of radius 3 mm, whose lowest point is 1 mm above the origin.
/// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 4.0), 3.0)?;
/// let gap_mm = |x_mm, z_mm| ball.gap_mm(&Point3::new(x_mm, 0.0, z_mm), &Vector3::z(), 5.0);
/// assert_eq!(gap_mm(0.0, 0.0), 1.0);
/// // Half a millimetre inside, the gap is negative; beside the ball there is none.
/// assert_eq!((gap_mm(0.0, 1.5), gap_mm(3.5, 0.0)), (-0.5, f64::INFINITY));
/// # Ok::<(), fabkit_elastic::ElasticError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallIndenter {
    centre_mm: Point3<f64>,
    radius_mm: f64,
}

impl BallIndenter {
    /// Creates a ball from its centre in the soft body's frame and its radius, mm.
    ///
    /// # Errors
    /// A radius that is not positive and finite, or a centre that is not finite.
    pub fn new(centre_mm: Point3<f64>, radius_mm: f64) -> Result<Self, ElasticError> {
        let hint = "positive and finite, in mm";
        if !(radius_mm > 0.0 && radius_mm.is_finite()) {
            return Err(ElasticError::Press { what: "a radius", value: radius_mm, hint });
        }
        match centre_mm.iter().find(|value| !value.is_finite()) {
            Some(&value) => Err(ElasticError::Press { what: "a centre", value, hint }),
            None => Ok(Self { centre_mm, radius_mm }),
        }
    }
}

impl Indenter for BallIndenter {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        let to_centre = self.centre_mm - place;
        // Intersection of the line with the ball: the half chord about the point closest to the centre.
        let along = to_centre.dot(outward);
        let off_squared = (to_centre - along * outward).norm_squared();
        let half_squared = self.radius_mm.powi(2) - off_squared;
        if half_squared <= 0.0 {
            return f64::INFINITY;
        }
        let half = half_squared.sqrt();
        first_begin([[along - half, along + half]], reach_mm)
    }
}

/// An indenter of any exact solid at a pose. It holds scratch memory, so each thread needs one of its own.
///
/// ```
/// use fabkit_elastic::{Indenter, SolidIndenter};
/// use fabkit_geometry::{CompiledSolid, Point3, Pose, Solid, Vector3};
///
/// // A punch of radius 2 mm and length 10 mm, drawn from z = 0 up, held with its lower face at z = 3 mm.
/// let punch = CompiledSolid::new(&Solid::cylinder(2.0, 10.0))?;
/// let held = SolidIndenter::new(&punch, &Pose::translation(0.0, 0.0, 3.0));
/// assert_eq!(held.gap_mm(&Point3::new(1.5, 0.0, 0.0), &Vector3::z(), 5.0), 3.0);
/// assert_eq!(held.gap_mm(&Point3::new(2.5, 0.0, 0.0), &Vector3::z(), 5.0), f64::INFINITY);
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Debug)]
pub struct SolidIndenter<'a> {
    solid: &'a CompiledSolid,
    indenter_from_body: Pose,
    work: RefCell<(Scratch, Vec<[f64; 2]>)>,
}

impl<'a> SolidIndenter<'a> {
    /// Creates the indenter from a solid and the pose that maps its frame to the soft body's.
    pub fn new(solid: &'a CompiledSolid, body_from_indenter: &Pose) -> Self {
        Self { solid, indenter_from_body: body_from_indenter.inverse(), work: RefCell::default() }
    }
}

impl Indenter for SolidIndenter<'_> {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        let ray = Ray {
            origin: self.indenter_from_body.point(*place),
            direction: self.indenter_from_body.vector(*outward),
        };
        let (scratch, stretches) = &mut *self.work.borrow_mut();
        self.solid.stretches_into(&ray, scratch, stretches);
        first_begin(stretches.iter().copied(), reach_mm)
    }
}

/// Several indenters at once: the smallest gap counts.
impl<P: Indenter> Indenter for [P] {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        let gaps = self.iter().map(|body| body.gap_mm(place, outward, reach_mm));
        gaps.fold(f64::INFINITY, f64::min)
    }
}

impl<P: Indenter> Indenter for Vec<P> {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        self.as_slice().gap_mm(place, outward, reach_mm)
    }
}

/// Motion of an indenter: optionally an approach until it touches and a given depth further, then optionally a shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    pub(crate) approach: Option<(Vector3<f64>, f64)>,
    pub(crate) friction: f64,
    pub(crate) shear_mm: Vector3<f64>,
    pub(crate) shear_steps: usize,
}

impl Press {
    /// Creates a press of an indenter that already stands at its final pose.
    ///
    /// ```
    /// use fabkit_elastic::{BallIndenter, ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody};
    /// use fabkit_elastic::{MeshDensity, Press};
    /// use fabkit_geometry::Point3;
    ///
    /// // The pad's face is at z = 2 mm; the ball's lowest point already stands 0.2 mm below it.
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
    /// let stack = ElasticStack::new(&pad, &MeshDensity::around_pole(0.1, 2.0, 0), 1)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 4.8), 3.0)?;
    /// let outcome = stack.press(&ball, &Press::in_place())?;
    /// assert!((outcome.depth_mm - 0.2).abs() < 1e-12);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn in_place() -> Self {
        Self { approach: None, friction: 0.0, shear_mm: Vector3::zeros(), shear_steps: 1 }
    }

    /// Creates a press whose indenter moves along `direction` (in the soft body's frame) until it touches the
    /// undeformed surface, and then `depth_mm` further.
    ///
    /// # Errors
    /// A depth that is not positive and finite, or a direction without length.
    ///
    /// ```
    /// use fabkit_elastic::Press;
    /// use fabkit_geometry::Vector3;
    ///
    /// // Only the direction counts, not the length of the vector.
    /// assert_eq!(Press::along(-2.0 * Vector3::z(), 0.5)?, Press::along(-Vector3::z(), 0.5)?);
    /// let error = Press::along(-Vector3::z(), -0.5).unwrap_err();
    /// assert_eq!(error.to_string(), "a depth of -0.5 is not positive and finite, in mm");
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn along(direction: Vector3<f64>, depth_mm: f64) -> Result<Self, ElasticError> {
        if !(depth_mm > 0.0 && depth_mm.is_finite()) {
            let hint = "positive and finite, in mm";
            return Err(ElasticError::Press { what: "a depth", value: depth_mm, hint });
        }
        let length = direction.norm();
        if !(length > 0.0 && length.is_finite()) {
            let hint = "the length of a direction: it must be positive and finite";
            return Err(ElasticError::Press { what: "a length", value: length, hint });
        }
        Ok(Self { approach: Some((direction / length, depth_mm)), ..Self::in_place() })
    }

    /// Adds a shear: after pressing, the indenter moves by `way_mm` (in the soft body's frame) in `steps` equal steps
    /// with Coulomb friction on the surface. Steps resolve the history of stick and slip; a path that does not reverse
    /// needs few.
    ///
    /// # Errors
    /// A friction coefficient that is negative or not finite, a displacement that is not finite, or zero steps.
    ///
    /// ```
    /// use fabkit_elastic::{BallIndenter, ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody};
    /// use fabkit_elastic::{MeshDensity, Press};
    /// use fabkit_geometry::{Point3, Vector3};
    ///
    /// let gel = ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(0.2, 0.49)? };
    /// let pad = LayeredBody::pad(10.0, vec![(gel, 2.0)]);
    /// let stack = ElasticStack::new(&pad, &MeshDensity::around_pole(0.3, 1.5, 6), 1)?;
    /// let ball = BallIndenter::new(Point3::new(0.0, 0.0, 9.0), 3.0)?;
    /// // Pressed down, then dragged along x by so much that it slides: the friction is half of the normal force.
    /// let dragged = Press::along(-Vector3::z(), 0.2)?.with_shear(0.5, 3.0 * Vector3::x(), 1)?;
    /// let outcome = stack.press(&ball, &dragged)?;
    /// assert!((outcome.force_n.x / -outcome.force_n.z - 0.5).abs() < 0.05);
    /// assert_eq!(outcome.stick_area_mm2, 0.0);
    /// # Ok::<(), fabkit_elastic::ElasticError>(())
    /// ```
    pub fn with_shear(
        self,
        friction: f64,
        way_mm: Vector3<f64>,
        steps: usize,
    ) -> Result<Self, ElasticError> {
        if !(friction >= 0.0 && friction.is_finite()) {
            let hint = "at least 0, and finite; silicone on what is printed has 0.5 to 1.5";
            return Err(ElasticError::Press { what: "a friction", value: friction, hint });
        }
        if let Some(&value) = way_mm.iter().find(|value| !value.is_finite()) {
            return Err(ElasticError::Press { what: "a shear", value, hint: "finite, in mm" });
        }
        if steps == 0 {
            let hint = "at least 1";
            return Err(ElasticError::Press { what: "a number of steps", value: 0.0, hint });
        }
        Ok(Self { friction, shear_mm: way_mm, shear_steps: steps, ..self })
    }
}
