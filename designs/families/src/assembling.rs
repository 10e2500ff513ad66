//! Words that every family builds with: where bodies stand, and the steps of a chain.

use fabkit_geometry::{
    Action, Angle, Assembly, Body, Color, Cure, FixedBy, Fixing, Mix, Opening, Placement, Point3,
    Pose, Pour, Process, Pull, Solid, Spray, Step, Vector3,
};

use crate::materials::{Castable, Clarity};

/// Name of an assembly, as a family's constants hold it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AssemblyName(pub &'static str);

/// The sensor in use.
pub const SENSOR: AssemblyName = AssemblyName("sensor");

impl AssemblyName {
    /// The assembly.
    pub fn assembly(self) -> Assembly {
        Assembly(self.0.into())
    }

    /// In the assembly's own frame.
    pub fn in_place(self) -> Placement {
        self.at(Pose::identity())
    }

    /// At a pose.
    pub fn at(self, assembly_from_body: Pose) -> Placement {
        Placement::at(self.assembly(), assembly_from_body)
    }

    /// At a height.
    pub fn at_z(self, z_mm: f64) -> Placement {
        self.at(Pose::translation(0.0, 0.0, z_mm))
    }

    /// At a pose, moved along its z axis in the exploded picture.
    pub fn drawn_out(self, assembly_from_body: &Pose, out_mm: f64) -> Placement {
        let out = assembly_from_body.vector(Vector3::new(0.0, 0.0, out_mm));
        self.at(*assembly_from_body).moved_apart(out)
    }
}

/// In the sensor, in the sensor frame.
pub fn in_sensor() -> Placement {
    SENSOR.in_place()
}

/// A day at room temperature.
pub const ROOM_24_H: Cure = Cure { hours: 24.0, celsius: 23.0 };

/// What glue needs before the next step.
pub const GLUED: Cure = Cure { hours: 1.0, celsius: 23.0 };

/// Upside down.
pub fn flipped() -> Pose {
    Pose::rotation_x(Angle::from_deg(180.0).expect("half a turn is finite"))
}

/// What a body is called and what it is for. It is made with it, and named by it wherever else it
/// takes part, so that a slip does not compile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Name {
    /// `[a-z0-9-]{1,64}`.
    pub name: &'static str,
    /// What it is for; of what is bought, its specification says that.
    pub summary: &'static str,
}

impl AsRef<str> for Name {
    fn as_ref(&self) -> &str {
        self.name
    }
}

impl Name {
    /// A part that is made.
    pub fn made(self, process: Process, solid: Solid) -> Body {
        Body::made(self.name, self.summary, process, solid)
    }

    /// A layer.
    pub fn cast(self, solid: Solid) -> Body {
        Body::cast(self.name, self.summary, solid)
    }

    /// A component of which a lab needs as many as it has places.
    pub fn bought(
        self,
        specification: impl Into<String>,
        solid: Solid,
        placements: impl IntoIterator<Item = Placement>,
    ) -> Body {
        bought(self.name, specification, solid, placements)
    }
}

impl From<Name> for String {
    fn from(name: Name) -> Self {
        name.name.into()
    }
}

/// Steel.
pub const STEEL: Color = [176, 180, 186];

/// A component of which a lab needs as many as it has places.
pub fn bought(
    name: &str,
    specification: impl Into<String>,
    solid: Solid,
    placements: impl IntoIterator<Item = Placement>,
) -> Body {
    Body::bought(name, specification, solid).placed(placements).one_per_place().colored(STEEL)
}

/// Declares what bodies are called and what they are for: `SHELL "shell" "holds all";`.
#[macro_export]
macro_rules! bodies {
    ($($(#[$doc:meta])* $vis:vis $constant:ident $name:literal $($summary:literal)?;)+) => {$(
        $(#[$doc])*
        $vis const $constant: $crate::assembling::Name =
            $crate::assembling::Name { name: $name, summary: concat!($($summary)?) };
    )+};
}
pub use crate::bodies;

/// Names of bodies.
pub fn names(of: &[Name]) -> Vec<String> {
    of.iter().copied().map(String::from).collect()
}

/// What a camera is there to see: layers that glow or darken as they are pressed, from the inside out,
/// and the one that ends its view. Where one of them is opaque, those beyond it are hidden.
pub fn sight(dim: &[(Name, &Castable)], last: Name) -> Vec<String> {
    let is_opaque =
        |material: &Castable| material.material().figures.clarity == Some(Clarity::Opaque);
    let dim = dim.iter().filter(|(_, material)| !is_opaque(material)).map(|(name, _)| *name);
    dim.chain([last]).map(String::from).collect()
}

/// A step that nobody has been told yet how to do.
#[must_use]
pub struct Doing(Step);

/// A step that does not say yet where it comes from.
#[must_use]
pub struct Told(Step);

impl Doing {
    /// What to do, as a sentence to the person who does it.
    pub fn told(self, instruction: impl Into<String>) -> Told {
        Told(Step { instruction: instruction.into(), ..self.0 })
    }
}

impl Told {
    /// More bodies that it needs: what a joint takes.
    pub fn also(self, bodies: impl IntoIterator<Item = String>) -> Self {
        Self(self.0.also(bodies))
    }

    /// What keeps small bodies where it puts them: each piece on one of `onto`.
    pub fn fixing(mut self, bodies: &[Name], onto: &[Name], by: FixedBy) -> Self {
        self.0.fixings.push(Fixing { bodies: names(bodies), onto: names(onto), by });
        self
    }

    /// Section of the paper, or why fabkit chose it.
    pub fn source(self, source: impl Into<String>) -> Step {
        Step { source: source.into(), ..self.0 }
    }
}

/// One step of a chain, in an assembly or none, with the bodies that it needs or joins.
pub fn step(
    name: impl Into<String>,
    place: impl Into<Option<AssemblyName>>,
    bodies: &[Name],
    action: Action,
) -> Doing {
    Doing(Step {
        name: name.into(),
        instruction: String::new(),
        assembly: place.into().map(AssemblyName::assembly),
        bodies: names(bodies),
        motions: Vec::new(),
        fixings: Vec::new(),
        adjustments: Vec::new(),
        during: None,
        action,
        source: String::new(),
    })
}

/// The first step: print, cut or etch all parts.
pub fn make(instruction: impl Into<String>) -> Told {
    step("make", None, &[], Action::Make).told(instruction)
}

/// Clean, prime, spray release agent.
pub fn prepare(name: &str, place: impl Into<Option<AssemblyName>>, bodies: &[Name]) -> Doing {
    step(name, place, bodies, Action::Prepare)
}

/// Put bodies together: press, screw, slide.
pub fn assemble(name: &str, place: AssemblyName, bodies: &[Name]) -> Doing {
    step(name, place, bodies, Action::Assemble)
}

/// Glue bodies together.
pub fn bond(name: &str, place: AssemblyName, bodies: &[Name], cure: Cure) -> Doing {
    step(name, place, bodies, Action::Bond(cure))
}

/// Take tools off what was cast, one after the other.
pub fn demold(name: impl Into<String>, place: AssemblyName, pulls: Vec<Pull>) -> Doing {
    step(name, place, &[], Action::Demold(pulls))
}

/// What is poured or sprayed.
#[derive(Clone, Debug, PartialEq)]
pub struct Liquid {
    /// What is mixed.
    pub mix: Mix,
    /// Surplus to mix, as a fraction of the layer's mass.
    pub waste: f64,
    /// How it cures.
    pub cure: Cure,
}

/// A material by its trade name, with so much surplus, as its maker says that it cures.
pub fn liquid(material: &Castable, waste: f64) -> Liquid {
    Liquid { mix: mix(material), waste, cure: cure(material) }
}

impl Liquid {
    /// The same, cured otherwise.
    #[must_use]
    pub fn curing(self, cure: Cure) -> Self {
        Self { cure, ..self }
    }

    /// Fills what these bodies enclose and becomes a layer.
    pub fn fills(
        self,
        walls: &[Name],
        layer: Name,
        up: Vector3<f64>,
        openings: Vec<Opening>,
    ) -> Action {
        let Self { mix, waste, cure } = self;
        let (layer, walls) = (layer.into(), names(walls));
        Action::Pour(Pour { layer, walls, up, openings, mix, waste, cure })
    }

    /// Coats bodies and becomes a layer.
    pub fn coats(self, onto: &[Name], layer: Name) -> Action {
        let Self { mix, waste, cure } = self;
        Action::Spray(Spray { layer: layer.into(), onto: names(onto), mix, waste, cure })
    }
}

/// What a layer is mixed from.
pub fn mix(material: &Castable) -> Mix {
    material.mix()
}

/// How a layer cures.
pub fn cure(material: &Castable) -> Cure {
    material.cure()
}

/// How much a material shrinks as it cures, as a share.
pub fn shrinkage(material: &Castable) -> f64 {
    material.shrinkage()
}

/// A rigid tool that comes off in a direction.
pub fn rigid(body: Name, direction: Vector3<f64>) -> Pull {
    Pull { body: body.into(), direction, strain_limit: None }
}

/// A body that comes off in a direction while a soft material gives way: the body's own, or what was
/// cast.
pub fn peeled(body: Name, direction: Vector3<f64>, material: &Castable) -> Pull {
    Pull { strain_limit: material.breaking_strain(), ..rigid(body, direction) }
}

/// The open top of what is poured, within `radius_mm` around the z axis, at a height; `up` is out of it.
pub fn free_surface(radius_mm: f64, z_mm: f64, up: Vector3<f64>) -> Opening {
    let point = Point3::new(0.0, 0.0, z_mm);
    Opening { name: "free surface".into(), point, axis: up, radius_mm }
}

/// An opening of a layer at a pose, out of the layer along its z axis.
pub fn opening(name: impl Into<String>, out: &Pose, radius_mm: f64) -> Opening {
    let (point, axis) = (out.point(Point3::origin()), out.vector(Vector3::z()));
    Opening { name: name.into(), point, axis, radius_mm }
}
