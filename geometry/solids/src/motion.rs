//! How hands bring a body to its place, and the room that they and their tools need there.

use nalgebra::{Point3, Vector3};

use crate::{Angle, Solid};

/// The way of a body to its place in an assembly, as the person goes who builds it.
///
/// Where a step states none, a check looks for a straight one by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// The bodies that move, all together, by name.
    pub bodies: Vec<String>,
    /// One after the other; the last one ends in place.
    pub legs: Vec<Leg>,
}

/// A part of a way, in the assembly's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Leg {
    /// Straight on.
    Straight {
        /// Where to: unit vector.
        along: Vector3<f64>,
        /// How far, mm; `None`: from outside of everything.
        length_mm: Option<f64>,
    },
    /// A turn: a hinge, a bayonet; with a lead, a thread.
    Turn {
        /// A point on the axis, mm.
        point: Point3<f64>,
        /// The axis, a unit vector; a positive angle turns right-handed around it.
        axis: Vector3<f64>,
        /// How far it is turned.
        angle: Angle,
        /// How far it goes along the axis meanwhile, mm.
        rise_mm: f64,
    },
}

impl Motion {
    /// Straight in from outside of everything, then on along other legs.
    pub fn of(bodies: impl IntoIterator<Item = String>, legs: impl Into<Vec<Leg>>) -> Self {
        Self { bodies: bodies.into_iter().collect(), legs: legs.into() }
    }
}

impl Leg {
    /// Straight in from outside of everything.
    pub fn from_afar(along: Vector3<f64>) -> Self {
        Self::Straight { along, length_mm: None }
    }
}

/// When a hand or a tool needs its room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Occasion {
    /// As the body is brought to its place.
    #[default]
    Arrival,
    /// While something is poured against the body: a syringe.
    Pour,
    /// While the body is set right: a lens that is focused.
    Adjustment,
    /// While tools are taken off, as long as the body stands there: a screwdriver that pries.
    Removal,
}

/// Room that a hand or a tool needs where it works on a body.
///
/// ```
/// use fabkit_geometry::{Body, Reach, Solid};
/// let driver = Reach::driver("PH0 screwdriver", Solid::cylinder(1.5, 60.0).at_z(1.0));
/// let screw = Body::bought("screw", "M1.6 x 5", Solid::cylinder(0.8, 5.0).at_z(-5.0)).reached(driver);
/// assert!(screw.reach[0].is_drawn);
/// ```
#[derive(Clone, Debug)]
pub struct Reach {
    /// Which tool, for people: `PH1 screwdriver`.
    pub tool: String,
    /// The room that it takes, in the body's frame, while the body is in place.
    pub solid: Solid,
    /// Other places for it; one of all must be free.
    pub instead: Vec<Solid>,
    /// Whether other copies of the body do not count: they are there at other times.
    pub passes_copies: bool,
    /// Whether the tool drives the body in along its own -z, so that it comes out along +z and no
    /// other way, and holds until it does: a screw, a nut that is melted in.
    pub is_drawn: bool,
    /// When it is needed.
    pub occasion: Occasion,
}

impl Reach {
    /// A tool that drives the body in along its own -z.
    pub fn driver(tool: impl Into<String>, solid: Solid) -> Self {
        Self { is_drawn: true, ..Self::room(tool, solid) }
    }

    /// A tool, or fingers, that only need room.
    pub fn room(tool: impl Into<String>, solid: Solid) -> Self {
        Self {
            tool: tool.into(),
            solid,
            instead: Vec::new(),
            passes_copies: false,
            is_drawn: false,
            occasion: Occasion::Arrival,
        }
    }

    /// The same on another occasion; then the body itself must leave the room free, too.
    #[must_use]
    pub fn on(self, occasion: Occasion) -> Self {
        Self { occasion, ..self }
    }

    /// The same, with another place where the tool may be.
    #[must_use]
    pub fn or(mut self, solid: Solid) -> Self {
        self.instead.push(solid);
        self
    }

    /// The same, past other copies of the body.
    #[must_use]
    pub fn past_copies(self) -> Self {
        Self { passes_copies: true, ..self }
    }

    /// Every place where the tool may be.
    pub fn rooms(&self) -> impl Iterator<Item = &Solid> {
        std::iter::once(&self.solid).chain(&self.instead)
    }
}
