//! Helpers that every family builds with: placements of bodies in assemblies, and the steps of a fabrication chain.

use fabkit_geometry::{
    Action, Angle, Assembly, Body, Color, Cure, Fixing, FixingMeans, Mix, Opening, Placement,
    Point3, Pose, Pour, Process, Pull, Solid, Spray, Step, Vector3,
};

use crate::materials::{Castable, Clarity};

/// Name of an assembly; families hold these as constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AssemblyName(pub &'static str);

/// The assembled sensor, as it is used.
pub const SENSOR: AssemblyName = AssemblyName("sensor");

impl AssemblyName {
    /// Returns the assembly of this name.
    pub fn assembly(self) -> Assembly {
        Assembly(self.0.into())
    }

    /// Returns the placement at the origin of the assembly's frame.
    pub fn in_place(self) -> Placement {
        self.at(Pose::identity())
    }

    /// Returns the placement at a pose in the assembly's frame.
    pub fn at(self, assembly_from_body: Pose) -> Placement {
        Placement::at(self.assembly(), assembly_from_body)
    }

    /// Returns the placement at a height above the origin of the assembly's frame, mm.
    pub fn at_z(self, z_mm: f64) -> Placement {
        self.at(Pose::translation(0.0, 0.0, z_mm))
    }

    /// Returns the placement at a pose, shifted by `out_mm` along the body's z axis in the exploded view.
    ///
    /// ```
    /// use fabkit_designs::{blocks::hanging, chain_builder::SENSOR};
    /// use fabkit_geometry::Vector3;
    /// // A screw from below: in the exploded view it is drawn 20 mm lower.
    /// let placement = SENSOR.at_exploded(&hanging([5.0, 0.0], 0.0), -20.0);
    /// let apart = placement.explode_mm;
    /// assert!((apart - Vector3::new(0.0, 0.0, 20.0)).norm() < 1e-9);
    /// ```
    pub fn at_exploded(self, assembly_from_body: &Pose, out_mm: f64) -> Placement {
        let out = assembly_from_body.vector(Vector3::new(0.0, 0.0, out_mm));
        self.at(*assembly_from_body).moved_apart(out)
    }
}

/// Returns the placement at the origin of the sensor frame.
pub fn in_sensor() -> Placement {
    SENSOR.in_place()
}

/// Cure for one day at room temperature.
pub const ROOM_24_H: Cure = Cure { hours: 24.0, celsius: 23.0 };

/// Time and temperature that glue needs before the next step.
pub const GLUE_CURE: Cure = Cure { hours: 1.0, celsius: 23.0 };

/// Returns the pose that turns a body upside down, half a turn around the x axis.
pub fn flipped() -> Pose {
    Pose::rotation_x(Angle::from_deg(180.0).expect("half a turn is finite"))
}

/// Name and purpose of a body. The body is made from this constant and named by it wherever else it takes part, so that
/// a misspelt name does not compile.
///
/// ```
/// use fabkit_geometry::{Process, Solid};
///
/// fabkit_designs::bodies! {
///     /// Lid of the box.
///     pub LID "lid" "closes the box";
/// }
/// let lid = LID.made(Process::Fdm, Solid::cuboid(20.0, 20.0, 2.0));
/// assert_eq!((&*lid.name, &*lid.summary), ("lid", "closes the box"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Name {
    /// Identifier of the body, `[a-z0-9-]{1,64}`.
    pub name: &'static str,
    /// Purpose of the body. Empty for bought bodies, whose specification states it.
    pub summary: &'static str,
}

impl AsRef<str> for Name {
    fn as_ref(&self) -> &str {
        self.name
    }
}

impl Name {
    /// Returns a body of this name that is made by a process.
    pub fn made(self, process: Process, solid: Solid) -> Body {
        Body::made(self.name, self.summary, process, solid)
    }

    /// Returns a cast layer of this name.
    pub fn cast(self, solid: Solid) -> Body {
        Body::cast(self.name, self.summary, solid)
    }

    /// Returns a bought component of this name; one piece is needed for each placement.
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

/// Colour of steel.
pub const STEEL: Color = [176, 180, 186];

/// Returns a bought component; one piece is needed for each placement. Drawn in the colour of steel.
pub fn bought(
    name: &str,
    specification: impl Into<String>,
    solid: Solid,
    placements: impl IntoIterator<Item = Placement>,
) -> Body {
    Body::bought(name, specification, solid).placed(placements).one_per_place().colored(STEEL)
}

/// Declares names and purposes of bodies as constants: `SHELL "shell" "holds all";`.
#[macro_export]
macro_rules! bodies {
    ($($(#[$doc:meta])* $vis:vis $constant:ident $name:literal $($summary:literal)?;)+) => {$(
        $(#[$doc])*
        $vis const $constant: $crate::chain_builder::Name =
            $crate::chain_builder::Name { name: $name, summary: concat!($($summary)?) };
    )+};
}
pub use crate::bodies;

/// Returns the names as strings.
pub fn names(of: &[Name]) -> Vec<String> {
    of.iter().copied().map(String::from).collect()
}

/// Returns the names of the layers that a camera observes: those of `dim` that are not opaque, from the inside out,
/// then `last`, at which its view ends. The layers in `dim` glow or darken as they are pressed.
pub fn visible_layers(dim: &[(Name, &Castable)], last: Name) -> Vec<String> {
    let is_opaque =
        |material: &Castable| material.material().figures.clarity == Some(Clarity::Opaque);
    let dim = dim.iter().filter(|(_, material)| !is_opaque(material)).map(|(name, _)| *name);
    dim.chain([last]).map(String::from).collect()
}

/// Step without an instruction yet.
///
/// ```
/// use fabkit_designs::chain_builder::{SENSOR, assemble};
/// fabkit_designs::bodies! {
///     SHELL "shell" "holds all";
///     BASE "base" "closes the shell";
/// }
/// // A step is complete once it has an instruction and a source.
/// let step = assemble("close", SENSOR, &[SHELL, BASE])
///     .with_instruction("Slide the base into the shell.")
///     .source("chosen: the paper does not say how it is closed");
/// assert_eq!(step.bodies, ["shell", "base"]);
/// ```
#[must_use]
pub struct StepBuilder(Step);

/// Step with an instruction but without a source yet.
#[must_use]
pub struct InstructedStep(Step);

impl StepBuilder {
    /// Sets the instruction, a sentence addressed to the person who does the step.
    pub fn with_instruction(self, instruction: impl Into<String>) -> InstructedStep {
        InstructedStep(Step { instruction: instruction.into(), ..self.0 })
    }
}

impl InstructedStep {
    /// Adds further bodies that the step needs, such as the screws of a joint.
    pub fn also(self, bodies: impl IntoIterator<Item = String>) -> Self {
        Self(self.0.with_bodies(bodies))
    }

    /// Adds how small bodies are fixed where the step puts them: each piece on one of `onto`.
    pub fn fixing(mut self, bodies: &[Name], onto: &[Name], by: FixingMeans) -> Self {
        self.0.fixings.push(Fixing { bodies: names(bodies), onto: names(onto), means: by });
        self
    }

    /// Sets the source: a section of the paper, or the reason why fabkit chose the step.
    pub fn source(self, source: impl Into<String>) -> Step {
        Step { source: source.into(), ..self.0 }
    }
}

/// Starts a step of a chain, in an assembly or in none, with the bodies that it needs or joins.
pub fn step(
    name: impl Into<String>,
    place: impl Into<Option<AssemblyName>>,
    bodies: &[Name],
    action: Action,
) -> StepBuilder {
    // The types make sure that instruction and source, empty here, are filled in.
    StepBuilder(Step {
        name: name.into(),
        instruction: String::new(),
        assembly: place.into().map(AssemblyName::assembly),
        bodies: names(bodies),
        motions: Vec::new(),
        fixings: Vec::new(),
        adjustments: Vec::new(),
        during_cure_of: None,
        action,
        source: String::new(),
    })
}

/// Returns the first step: print, cut or etch all parts.
pub fn make(instruction: impl Into<String>) -> InstructedStep {
    step("make", None, &[], Action::Make).with_instruction(instruction)
}

/// Starts a step that prepares bodies: clean, prime, spray release agent.
pub fn prepare(name: &str, place: impl Into<Option<AssemblyName>>, bodies: &[Name]) -> StepBuilder {
    step(name, place, bodies, Action::Prepare)
}

/// Starts a step that joins bodies: press, screw, slide.
pub fn assemble(name: &str, place: AssemblyName, bodies: &[Name]) -> StepBuilder {
    step(name, place, bodies, Action::Assemble)
}

/// Starts a step that glues bodies together.
pub fn bond(name: &str, place: AssemblyName, bodies: &[Name], cure: Cure) -> StepBuilder {
    step(name, place, bodies, Action::Bond(cure))
}

/// Starts a step that takes mold parts off what was cast, one after the other.
pub fn demold(name: impl Into<String>, place: AssemblyName, pulls: Vec<Pull>) -> StepBuilder {
    step(name, place, &[], Action::Demold(pulls))
}

/// Liquid to pour or spray.
///
/// ```
/// use fabkit_designs::chain_builder::{Liquid, ROOM_24_H, free_surface};
/// use fabkit_geometry::{Action, Mix, Vector3};
/// fabkit_designs::bodies! {
///     CUP "cup" "mold of the gel";
///     GEL "gel" "is pressed";
/// }
/// let parts = [("silicone A", 1.0), ("silicone B", 1.0)];
/// let by_mass = parts.map(|(name, share)| (name.to_owned(), share)).to_vec();
/// let mix = Mix { by_mass, density_g_per_cm3: 1.07, pot_life_h: Some(0.75), degas: true };
/// let up = Vector3::z();
/// let poured = Liquid { mix, waste: 0.3, cure: ROOM_24_H }.fills(
///     &[CUP],
///     GEL,
///     up,
///     vec![free_surface(10.0, 5.0, up)],
/// );
/// assert!(matches!(poured, Action::Pour(pour) if pour.layer == "gel" && pour.walls == ["cup"]));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Liquid {
    /// Components and their ratio.
    pub mix: Mix,
    /// Surplus to mix, as a fraction of the layer's mass.
    pub waste: f64,
    /// Time and temperature of the cure.
    pub cure: Cure,
}

/// Returns the liquid of a material with a surplus `waste`, cured as its maker specifies.
pub fn liquid(material: &Castable, waste: f64) -> Liquid {
    Liquid { mix: mix(material), waste, cure: cure(material) }
}

impl Liquid {
    /// Replaces the cure.
    #[must_use]
    pub fn with_cure(self, cure: Cure) -> Self {
        Self { cure, ..self }
    }

    /// Returns the action that pours the liquid into the space between `walls`, where it becomes `layer`.
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

    /// Returns the action that sprays the liquid onto bodies, where it becomes `layer`.
    pub fn coats(self, onto: &[Name], layer: Name) -> Action {
        let Self { mix, waste, cure } = self;
        Action::Spray(Spray { layer: layer.into(), onto: names(onto), mix, waste, cure })
    }
}

/// Returns the mix that a layer of this material is made from.
pub fn mix(material: &Castable) -> Mix {
    material.mix()
}

/// Returns the cure of a layer of this material.
pub fn cure(material: &Castable) -> Cure {
    material.cure()
}

/// Returns the linear shrinkage of a material on curing, as a fraction.
pub fn shrinkage(material: &Castable) -> f64 {
    material.shrinkage()
}

/// Returns the removal of a rigid mold part in a direction.
pub fn rigid(body: Name, direction: Vector3<f64>) -> Pull {
    Pull { body: body.into(), direction, strain_limit: None }
}

/// Returns the removal of a body in a direction during which a soft material stretches: the body's own, or that of the
/// casting. The stretch is limited by the material's breaking strain.
///
/// ```
/// use fabkit_designs::chain_builder::{peel, rigid};
/// use fabkit_geometry::Vector3;
/// fabkit_designs::bodies! { MOLD "mold" "mold of the gel"; }
/// let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let design = fabkit_designs::load("rtac0.yaml", yaml, &[], &["fixtures"])?;
/// let is_it = |name: &str| name == "Smooth-On Ecoflex 00-30";
/// let ecoflex = design.materials.iter().find(|one| is_it(one)).ok_or("another material")?;
/// // Ecoflex 00-30 stretches by 900 % before it tears; a printed part does not stretch at all.
/// assert_eq!(peel(MOLD, Vector3::z(), ecoflex).strain_limit, Some(9.0));
/// assert_eq!(rigid(MOLD, Vector3::z()).strain_limit, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn peel(body: Name, direction: Vector3<f64>, material: &Castable) -> Pull {
    Pull { strain_limit: material.breaking_strain(), ..rigid(body, direction) }
}

/// Returns the open top of a pour, a disc of `radius_mm` around the z axis at a height; `up` points out of the liquid.
pub fn free_surface(radius_mm: f64, z_mm: f64, up: Vector3<f64>) -> Opening {
    let point = Point3::new(0.0, 0.0, z_mm);
    Opening { name: "free surface".into(), point, axis: up, radius_mm }
}

/// Returns an opening of a layer at a pose whose z axis points out of the layer.
pub fn opening(name: impl Into<String>, out: &Pose, radius_mm: f64) -> Opening {
    let (point, axis) = (out.point(Point3::origin()), out.vector(Vector3::z()));
    Opening { name: name.into(), point, axis, radius_mm }
}
