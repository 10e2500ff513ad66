//! Assembly motions of bodies, and the space that hands and tools need.

use nalgebra::{Point3, Vector3};

use crate::{Angle, Solid};

/// Path of a body to its place in an assembly, as the builder moves it.
///
/// If a step states none, the check looks for a straight one.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Names of the bodies that move together.
    pub bodies: Vec<String>,
    /// Successive legs of the path; the last one ends in place.
    pub legs: Vec<MotionLeg>,
}

/// Leg of a path, in the assembly's frame.
///
/// ```
/// use fabkit_geometry::{Angle, Motion, MotionLeg, Point3, Vector3};
/// // A bayonet: down onto the base, then an eighth of a turn clockwise, seen from above.
/// let lock = MotionLeg::Turn {
///     point: Point3::origin(),
///     axis: Vector3::z(),
///     angle: Angle::from_deg(-45.0).unwrap(),
///     rise_mm: 0.0,
/// };
/// let path = Motion::new(["tip".to_owned()], [MotionLeg::from_afar(-Vector3::z()), lock]);
/// assert!(matches!(path.legs[0], MotionLeg::Straight { length_mm: None, .. })); // from outside of everything
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionLeg {
    /// Straight movement.
    Straight {
        /// Direction: unit vector.
        along: Vector3<f64>,
        /// Length, mm; `None` for a movement that starts outside of everything.
        length_mm: Option<f64>,
    },
    /// Rotation: a hinge or a bayonet; with an advance along the axis, a thread.
    Turn {
        /// Point on the axis, mm.
        point: Point3<f64>,
        /// Axis: unit vector; a positive angle is a right-handed rotation around it.
        axis: Vector3<f64>,
        /// Angle of the rotation.
        angle: Angle,
        /// Advance along the axis during the rotation, mm.
        rise_mm: f64,
    },
}

impl Motion {
    /// Creates the path of these bodies along the given legs.
    pub fn new(bodies: impl IntoIterator<Item = String>, legs: impl Into<Vec<MotionLeg>>) -> Self {
        Self { bodies: bodies.into_iter().collect(), legs: legs.into() }
    }
}

impl MotionLeg {
    /// Returns a straight leg that starts outside of everything.
    pub fn from_afar(along: Vector3<f64>) -> Self {
        Self::Straight { along, length_mm: None }
    }
}

/// Occasion on which a hand or a tool needs its space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Occasion {
    /// While the body is brought to its place.
    #[default]
    Arrival,
    /// While liquid is poured at the body: a syringe.
    Pour,
    /// While the body is adjusted: a lens that is focused.
    Adjustment,
    /// While tools are removed, as long as the body is there: a screwdriver that pries.
    Removal,
}

/// Space that a hand or a tool needs to work on a body.
///
/// ```
/// use fabkit_geometry::{Body, ToolAccess, Solid};
/// let driver = ToolAccess::driver("PH0 screwdriver", Solid::cylinder(1.5, 60.0).at_z(1.0));
/// let screw = Body::bought("screw", "M1.6 x 5", Solid::cylinder(0.8, 5.0).at_z(-5.0)).with_tool_access(driver);
/// assert!(screw.reach[0].is_driven_in);
/// ```
#[derive(Clone, Debug)]
pub struct ToolAccess {
    /// Description of the tool: `PH1 screwdriver`.
    pub tool: String,
    /// Space that the tool takes, in the body's frame, while the body is in place.
    pub solid: Solid,
    /// Alternative spaces; one of all must be free.
    pub alternatives: Vec<Solid>,
    /// True if other copies of the body are ignored because they are present at other times.
    pub ignores_copies: bool,
    /// True if the tool drives the body in along its own -z. Then the body comes out only along +z and holds until it
    /// does: a screw, a nut that is melted in.
    pub is_driven_in: bool,
    /// Occasion on which the space is needed.
    pub occasion: Occasion,
}

impl ToolAccess {
    /// Creates the space of a tool that drives the body in along its own -z.
    pub fn driver(tool: impl Into<String>, solid: Solid) -> Self {
        Self { is_driven_in: true, ..Self::new(tool, solid) }
    }

    /// Creates the space of a tool, or of fingers.
    pub fn new(tool: impl Into<String>, solid: Solid) -> Self {
        Self {
            tool: tool.into(),
            solid,
            alternatives: Vec::new(),
            ignores_copies: false,
            is_driven_in: false,
            occasion: Occasion::Arrival,
        }
    }

    /// Sets the occasion. On occasions other than arrival the body itself must leave the space free, too.
    #[must_use]
    pub fn with_occasion(self, occasion: Occasion) -> Self {
        Self { occasion, ..self }
    }

    /// Adds an alternative space for the tool.
    ///
    /// ```
    /// use fabkit_geometry::{Occasion, Solid, ToolAccess};
    /// let blade = || Solid::cuboid(6.0, 40.0, 1.0);
    /// let pry = ToolAccess::new("screwdriver", blade().at(0.0, 25.0, 0.0))
    ///     .with_alternative(blade().at(0.0, -25.0, 0.0))
    ///     .with_occasion(Occasion::Removal);
    /// assert_eq!(pry.spaces().count(), 2); // from either side
    /// ```
    #[must_use]
    pub fn with_alternative(mut self, solid: Solid) -> Self {
        self.alternatives.push(solid);
        self
    }

    /// Makes the check ignore other copies of the body.
    #[must_use]
    pub fn ignoring_copies(self) -> Self {
        Self { ignores_copies: true, ..self }
    }

    /// Returns all alternative spaces of the tool.
    pub fn spaces(&self) -> impl Iterator<Item = &Solid> {
        std::iter::once(&self.solid).chain(&self.alternatives)
    }
}
