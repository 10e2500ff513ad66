//! Data model of a sensor: parts, cast layers, bought components, landmarks.

use std::fmt;

use nalgebra::{Point3, Vector3};

use crate::{MaterialProperties, Pose, SliceAdvice, Solid, ToolAccess};

/// Manufacturing process of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Process {
    /// Filament printing.
    Fdm,
    /// Resin printing.
    Sla,
    /// Resin jetting, several materials in one piece.
    PolyJet,
    /// Laser cutting from a sheet.
    Laser,
    /// Machining.
    Cnc,
    /// Casting: poured into a mold and cured.
    Cast,
    /// Printed circuit board, made from its outline.
    Pcb,
}

impl fmt::Display for Process {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fdm => "fdm",
            Self::Sla => "sla",
            Self::PolyJet => "polyjet",
            Self::Laser => "laser",
            Self::Cnc => "cnc",
            Self::Cast => "cast",
            Self::Pcb => "pcb",
        })
    }
}

/// Colour for renderings and 3MF files, sRGB.
pub type Color = [u8; 3];

/// Named reference point with an axis: a pin tip, a bolt axis, a seat.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// Name, for example `hole 17`.
    pub name: String,
    /// Position, mm, in the frame of the solid it belongs to.
    pub point: Point3<f64>,
    /// Unit direction.
    pub axis: Vector3<f64>,
}

impl Landmark {
    /// Creates a landmark from the origin and the z axis of a pose.
    pub fn at(name: impl Into<String>, pose: &Pose) -> Self {
        let (point, axis) = (pose.point(Point3::origin()), pose.vector(Vector3::z()));
        Self { name: name.into(), point, axis }
    }
}

/// Set of bodies that are together in one frame: the sensor itself, or one set of tools.
///
/// Bodies of one assembly must not overlap.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Assembly(pub String);

impl Assembly {
    /// Returns the assembly of the finished sensor.
    pub fn sensor() -> Self {
        Self("sensor".into())
    }
}

/// Placement of a body in one assembly. A body may have several: a lid has one in each mold it closes.
///
/// ```
/// use fabkit_geometry::{Assembly, Placement, Pose, Vector3};
/// let raised = Placement::at(Assembly::sensor(), Pose::translation(0.0, 0.0, 12.0)).lifted(30.0);
/// assert_eq!(raised.assembly_from_body, Pose::translation(0.0, 0.0, 12.0)); // stays in place
/// assert_eq!(raised.explode_mm, Vector3::new(0.0, 0.0, 30.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Assembly that the body is placed in.
    pub assembly: Assembly,
    /// Pose that maps the body's own frame to the assembly's, mm.
    pub assembly_from_body: Pose,
    /// Displacement in the exploded view, assembly frame, mm.
    pub explode_mm: Vector3<f64>,
}

impl Placement {
    /// Creates a placement at the origin of the assembly's frame.
    pub fn in_place(assembly: Assembly) -> Self {
        Self::at(assembly, Pose::identity())
    }

    /// Creates a placement at a pose.
    pub fn at(assembly: Assembly, assembly_from_body: Pose) -> Self {
        Self { assembly, assembly_from_body, explode_mm: Vector3::zeros() }
    }

    /// Adds a displacement along the assembly's z in the exploded view.
    #[must_use]
    pub fn lifted(self, z_mm: f64) -> Self {
        self.moved_apart(Vector3::new(0.0, 0.0, z_mm))
    }

    /// Adds a displacement in the exploded view.
    #[must_use]
    pub fn moved_apart(mut self, explode_mm: Vector3<f64>) -> Self {
        self.explode_mm += explode_mm;
        self
    }
}

/// Number of closed surfaces that bound a body, as counted by its author; the mesh must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shells {
    /// Number of outer surfaces, one per separate piece.
    pub pieces: usize,
    /// Number of inner surfaces: cavities without an opening.
    pub voids: usize,
}

impl Shells {
    /// One piece without a cavity, the usual case.
    pub const ONE: Self = Self { pieces: 1, voids: 0 };

    /// Creates the count of several pieces without cavities.
    pub const fn pieces(pieces: usize) -> Self {
        Self { pieces, voids: 0 }
    }
}

/// Change that a cut feature makes to a body.
///
/// ```
/// use fabkit_geometry::{Body, CutFeature, Process, Solid};
/// let bore =
///     CutFeature { tools: vec![Solid::rod(1.5, [-0.1, 2.1])], handles: 1, ..CutFeature::default() };
/// let plate = Body::made("plate", "holds the board", Process::Laser, Solid::cuboid(20.0, 20.0, 2.0));
/// let plate = plate.cut(bore);
/// assert_eq!((plate.solid.leaves().len(), plate.genus), (2, Some(1)));
/// ```
#[derive(Clone, Debug, Default)]
pub struct CutFeature {
    /// Solids to subtract, in the frame of the body.
    pub tools: Vec<Solid>,
    /// Landmarks that the feature adds, in the frame of the body.
    pub landmarks: Vec<Landmark>,
    /// Number of through holes and handles that the feature adds.
    pub handles: i32,
}

impl CutFeature {
    /// Adds to the number of handles.
    #[must_use]
    pub fn with_handles(self, handles: i32) -> Self {
        Self { handles: self.handles + handles, ..self }
    }

    /// Removes the landmarks.
    #[must_use]
    pub fn without_landmarks(self) -> Self {
        Self { landmarks: Vec::new(), ..self }
    }
}

/// Kind of a body: made, cast or bought.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BodyKind {
    /// Made from a file: printed, cut or etched.
    Made(Process),
    /// Poured, sprayed or otherwise formed in place.
    Cast,
    /// Bought; its solid serves for checking fits.
    Bought,
}

impl BodyKind {
    /// Returns the word used in files and on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Made(_) => "part",
            Self::Cast => "layer",
            Self::Bought => "component",
        }
    }

    /// Returns the manufacturing process; `None` for bought bodies.
    pub fn process(self) -> Option<Process> {
        match self {
            Self::Made(process) => Some(process),
            Self::Cast => Some(Process::Cast),
            Self::Bought => None,
        }
    }
}

/// Machine that a part is made on. Properties that are not stated are those usual for the part's process.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Machine {
    /// Name given by the machine's owner.
    pub name: String,
    /// Minimum wall thickness, mm.
    pub wall_mm: Option<f64>,
    /// Minimum hole diameter, mm.
    pub hole_mm: Option<f64>,
    /// Build volume: width, depth, height, mm.
    pub bed_mm: [Option<f64>; 3],
    /// Steepest overhang printed without support, from the vertical, degrees.
    pub overhang_deg: Option<f64>,
    /// Widest gap bridged without support, mm.
    pub bridge_mm: Option<f64>,
    /// Slicer settings for all parts made on the machine.
    pub slicing: SliceAdvice,
    /// Remark on differences from the usual way of making the part, for its maker.
    pub note: String,
}

/// Mechanical role of a bought body in the finished sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum MechanicalRole {
    /// Ordinary body that supports others and is held in place like made parts.
    #[default]
    Ordinary,
    /// Fastener for the bodies it goes through or around: a screw, a pin, a tie.
    Fastener,
    /// Body with a thread that screws engage: a nut, an insert, a threaded spacer.
    Threaded,
    /// Small body that is soldered, stuck or plugged onto the body it touches and holds nothing itself: an LED.
    Attached,
}

/// Optical clarity of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum OpticalClarity {
    /// Transparent.
    Clear,
    /// Lets light in and scatters it.
    Translucent,
    /// Blocks light.
    Opaque,
}

/// Body of a sensor: a part that a lab makes, a layer that it casts or a component that it buys.
///
/// Constructors take what is specific to the body; everything else starts with the usual value.
///
/// ```
/// use fabkit_geometry::{Body, Process, Shells, Solid};
/// let lid = Solid::cylinder(12.0, 2.0).minus(Solid::cylinder(1.0, 4.0).at(8.0, 0.0, -1.0));
/// let lid = Body::made("lid", "closes the mold", Process::Fdm, lid)
///     .with_material("PLA")
///     .with_handles(1)
///     .note("flat side down");
/// assert_eq!((lid.quantity, lid.genus, lid.shells), (1, Some(1), Some(Shells::ONE)));
/// ```
#[derive(Clone, Debug)]
pub struct Body {
    /// Name, `[a-z0-9-]{1,64}`, unique within the sensor; also the file name.
    pub name: String,
    /// Description in one line; for bought bodies, the specification to order.
    pub summary: String,
    /// Kind: made, cast or bought.
    pub kind: BodyKind,
    /// Trade name of the material; empty for bought bodies.
    pub material: String,
    /// Material of a bought body, by name; `None` if it is of several, as a camera is.
    pub stock: Option<&'static str>,
    /// Shape, mm, in the sensor frame unless the placements say otherwise.
    pub solid: Solid,
    /// Placements in the assemblies in which it is made and used.
    pub placements: Vec<Placement>,
    /// Number of copies that one sensor needs.
    pub quantity: u32,
    /// Landmarks that other bodies rely on, in the frame of `solid`.
    pub landmarks: Vec<Landmark>,
    /// Colour in renderings.
    pub color: Color,
    /// Opacity in renderings, 0 to 1.
    pub opacity: f64,
    /// Optical clarity, if it differs from the rendered opacity: see [`Body::clarity`].
    pub optics: Option<OpticalClarity>,
    /// True if light may pass it, so that its material decides how: see [`Body::as_window`].
    pub is_window: bool,
    /// Part of the body that emits light, in the frame of `solid`; `None` if it is no light source.
    pub light_source: Option<Solid>,
    /// Properties of the material, as far as they are known.
    pub substance: MaterialProperties,
    /// Word for the sealing of its surface that the corresponding step must contain: `varnish`, `lacquer`, `bake`.
    pub sealed_by: Option<&'static str>,
    /// True if the body deforms with the touched surface although its kind does not suggest it: it is made, not cast,
    /// or it is ink that moves with the gel it is printed on.
    pub is_deformable: bool,
    /// Rotation that puts a part into its orientation on the printer's bed; the exporter chooses the position there.
    pub bed_from_body: Pose,
    /// Remarks for the person who makes it.
    pub notes: Vec<String>,
    /// Slicer settings, in addition to those that follow from the part's purpose.
    pub slicing: SliceAdvice,
    /// Machine that it is made on, if that is not any machine for its process.
    pub machine: Option<Machine>,
    /// Linear shrinkage of the material that is cast in it, 0 for everything but molds. Only exported copies are
    /// enlarged, by 1 / (1 - shrinkage).
    pub shrinkage: f64,
    /// Number of through holes and handles (genus), counted as they are cut; the mesh must agree. `None` for bought
    /// bodies.
    pub genus: Option<i32>,
    /// Number of pieces and enclosed cavities, counted like `genus`.
    pub shells: Option<Shells>,
    /// Space that hands and tools need to insert it or to work on it in place.
    pub reach: Vec<ToolAccess>,
    /// Deformation that it tolerates while it is brought to its place, mm: a rubber ring that is stretched over a
    /// flange, a wire that is bent aside. 0 for rigid bodies.
    pub assembly_compliance_mm: f64,
    /// Mechanical role of a bought body.
    pub duty: MechanicalRole,
    /// Order for a bought body.
    pub order: Option<crate::Order>,
}

impl Body {
    fn new(
        name: impl Into<String>,
        summary: impl Into<String>,
        kind: BodyKind,
        solid: Solid,
    ) -> Self {
        // Models of bought bodies are only good enough for fits, so their topology is not checked.
        let is_counted = kind != BodyKind::Bought;
        Self {
            name: name.into(),
            summary: summary.into(),
            kind,
            material: String::new(),
            stock: None,
            solid,
            placements: Vec::new(),
            quantity: 1,
            landmarks: Vec::new(),
            color: [255, 255, 255],
            opacity: 1.0,
            optics: None,
            is_window: false,
            light_source: None,
            substance: MaterialProperties::default(),
            sealed_by: None,
            is_deformable: false,
            bed_from_body: Pose::identity(),
            notes: Vec::new(),
            slicing: SliceAdvice::default(),
            machine: None,
            shrinkage: 0.0,
            genus: is_counted.then_some(0),
            shells: is_counted.then_some(Shells::ONE),
            reach: Vec::new(),
            assembly_compliance_mm: 0.0,
            duty: MechanicalRole::Ordinary,
            order: None,
        }
    }

    /// Creates a part: one piece without handles whose own frame is its orientation on the bed.
    pub fn made(
        name: impl Into<String>,
        summary: impl Into<String>,
        process: Process,
        solid: Solid,
    ) -> Self {
        Self::new(name, summary, BodyKind::Made(process), solid)
    }

    /// Creates a layer: one piece without handles.
    pub fn cast(name: impl Into<String>, summary: impl Into<String>, solid: Solid) -> Self {
        Self::new(name, summary, BodyKind::Cast, solid)
    }

    /// Creates a component with the specification to order.
    pub fn bought(name: impl Into<String>, specification: impl Into<String>, solid: Solid) -> Self {
        Self::new(name, specification, BodyKind::Bought, solid)
    }

    /// Sets the material.
    #[must_use]
    pub fn with_material(self, material: impl Into<String>) -> Self {
        Self { material: material.into(), ..self }
    }

    /// Sets what a bought body is made of, by the name of a material.
    #[must_use]
    pub fn made_of(self, stock: &'static str) -> Self {
        Self { stock: Some(stock), ..self }
    }

    /// Changes the manufacturing process.
    #[must_use]
    pub fn made_by(self, process: Process) -> Self {
        Self { kind: BodyKind::Made(process), ..self }
    }

    /// Adds placements.
    #[must_use]
    pub fn placed(mut self, placements: impl IntoIterator<Item = Placement>) -> Self {
        self.placements.extend(placements);
        self
    }

    /// Sets the colour in renderings.
    #[must_use]
    pub fn colored(self, color: Color) -> Self {
        Self { color, ..self }
    }

    /// Sets the opacity in renderings, 0 to 1.
    #[must_use]
    pub fn opaque(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// Makes the whole body a light source.
    #[must_use]
    pub fn as_light_source(self) -> Self {
        let lamp = Some(self.solid.clone());
        Self { light_source: lamp, ..self }
    }

    /// Makes part of the body a light source.
    #[must_use]
    pub fn with_light_source(self, lamp: Solid) -> Self {
        Self { light_source: Some(lamp), ..self }
    }

    /// Sets whether the material is dark, where a pigment matters more than the material's name.
    #[must_use]
    pub fn with_darkness(mut self, is_dark: Option<bool>) -> Self {
        self.substance.is_dark = is_dark;
        self
    }

    /// Marks the body as sealed against inhibiting the cure of silicone. A step must mention the sealing by the word
    /// `by`.
    #[must_use]
    pub fn sealed(self, by: &'static str) -> Self {
        Self { sealed_by: Some(by), ..self }
    }

    /// Marks a made body as soft, or ink as printed on something soft, so that it counts as touched.
    #[must_use]
    pub fn as_deformable(self) -> Self {
        Self { is_deformable: true, ..self }
    }

    /// Sets the number of copies that one sensor needs.
    #[must_use]
    pub fn with_quantity(self, quantity: u32) -> Self {
        Self { quantity, ..self }
    }

    /// Sets the number of copies to the number of placements.
    #[must_use]
    pub fn one_per_place(self) -> Self {
        Self { quantity: self.placements.len() as u32, ..self }
    }

    /// Adds landmarks.
    #[must_use]
    pub fn with_landmarks(mut self, landmarks: impl IntoIterator<Item = Landmark>) -> Self {
        self.landmarks.extend(landmarks);
        self
    }

    /// Cuts a feature into the body: subtracts its solids, adds its landmarks and handles.
    #[must_use]
    pub fn cut(mut self, cut: CutFeature) -> Self {
        self.solid = self.solid.minus_all(cut.tools);
        self.with_landmarks(cut.landmarks).with_handles(cut.handles)
    }

    /// Sets the orientation on the bed.
    #[must_use]
    pub fn with_bed_orientation(self, bed_from_body: Pose) -> Self {
        Self { bed_from_body, ..self }
    }

    /// Adds a remark for the person who makes it.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Adds several remarks.
    #[must_use]
    pub fn notes<N: Into<String>>(mut self, notes: impl IntoIterator<Item = N>) -> Self {
        self.notes.extend(notes.into_iter().map(Into::into));
        self
    }

    /// Sets the shrinkage of the material cast in it, for which exported copies are enlarged.
    #[must_use]
    pub fn for_shrinkage(self, shrinkage: f64) -> Self {
        Self { shrinkage, ..self }
    }

    /// Adds to the number of through holes and handles.
    #[must_use]
    pub fn with_handles(self, handles: i32) -> Self {
        Self { genus: Some(self.genus.unwrap_or(0) + handles), ..self }
    }

    /// Sets the number of pieces and cavities, if it is not one piece without a cavity.
    #[must_use]
    pub fn with_shells(self, shells: Shells) -> Self {
        Self { shells: Some(shells), ..self }
    }

    /// Sets the deformation that it tolerates while it is brought to its place, mm.
    #[must_use]
    pub fn with_assembly_compliance(self, gives_mm: f64) -> Self {
        Self { assembly_compliance_mm: gives_mm, ..self }
    }

    /// Marks the body as a fastener: a screw, a pin, a tie; of steel unless it is made of something else.
    #[must_use]
    pub fn as_fastener(self) -> Self {
        Self { duty: MechanicalRole::Fastener, stock: self.stock.or(Some("steel")), ..self }
    }

    /// Marks the body as threaded: a nut, an insert, a threaded spacer; of steel unless it is made of something else.
    #[must_use]
    pub fn threaded(self) -> Self {
        Self { duty: MechanicalRole::Threaded, stock: self.stock.or(Some("steel")), ..self }
    }

    /// Marks the body as soldered, stuck or plugged onto the body it touches, without holding anything itself.
    #[must_use]
    pub fn as_attached(self) -> Self {
        Self { duty: MechanicalRole::Attached, ..self }
    }

    /// Adds space for a hand or a tool.
    #[must_use]
    pub fn with_tool_access(mut self, reach: ToolAccess) -> Self {
        self.reach.push(reach);
        self
    }

    /// Returns whether the body is a made part.
    pub fn is_made(&self) -> bool {
        matches!(self.kind, BodyKind::Made(_))
    }

    /// Returns the manufacturing process; `None` for bought bodies.
    pub fn process(&self) -> Option<Process> {
        self.kind.process()
    }

    /// Returns the word for the manufacturing process, for example `fdm`; empty for bought bodies.
    pub fn process_word(&self) -> String {
        self.process().map(|process| process.to_string()).unwrap_or_default()
    }
}
