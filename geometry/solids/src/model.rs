//! What a sensor consists of: parts, cast layers, bought components, landmarks.

use std::fmt;

use nalgebra::{Point3, Vector3};

use crate::{Pose, Reach, SliceAdvice, Solid, Substance};

/// How a part is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Process {
    /// Filament printing.
    Fdm,
    /// Resin printing.
    Sla,
    /// Jetted resin, several materials in one piece.
    PolyJet,
    /// Cut from a sheet with a laser.
    Laser,
    /// Machined.
    Cnc,
    /// Poured into a mold and cured.
    Cast,
    /// A printed circuit board from its outline.
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

/// Colour for pictures and 3MF, sRGB.
pub type Color = [u8; 3];

/// A named point and axis that others rely on: a pin tip, a bolt axis, a seat.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// Name, for example `hole 17`.
    pub name: String,
    /// Where, mm, in the frame of the solid it belongs to.
    pub point: Point3<f64>,
    /// Unit direction.
    pub axis: Vector3<f64>,
}

impl Landmark {
    /// The origin and the z axis of a pose.
    pub fn at(name: impl Into<String>, pose: &Pose) -> Self {
        let (point, axis) = (pose.point(Point3::origin()), pose.vector(Vector3::z()));
        Self { name: name.into(), point, axis }
    }
}

/// Which bodies stand together in one frame: the sensor itself, or one set of tools.
///
/// Bodies of one assembly must not overlap.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Assembly(pub String);

impl Assembly {
    /// The sensor in use.
    pub fn sensor() -> Self {
        Self("sensor".into())
    }
}

/// Where a body stands in one assembly. A lid stands in each mold it closes.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Which assembly.
    pub assembly: Assembly,
    /// Maps the body's own frame to the assembly's, mm.
    pub assembly_from_body: Pose,
    /// How far it moves in the exploded picture, assembly frame, mm.
    pub explode_mm: Vector3<f64>,
}

impl Placement {
    /// In the assembly's own frame.
    pub fn in_place(assembly: Assembly) -> Self {
        Self::at(assembly, Pose::identity())
    }

    /// At a pose.
    pub fn at(assembly: Assembly, assembly_from_body: Pose) -> Self {
        Self { assembly, assembly_from_body, explode_mm: Vector3::zeros() }
    }

    /// The same placement, lifted along the assembly's z in the exploded picture.
    #[must_use]
    pub fn lifted(self, z_mm: f64) -> Self {
        self.moved_apart(Vector3::new(0.0, 0.0, z_mm))
    }

    /// The same placement, moved further in the exploded picture.
    #[must_use]
    pub fn moved_apart(mut self, explode_mm: Vector3<f64>) -> Self {
        self.explode_mm += explode_mm;
        self
    }
}

/// How many closed surfaces bound a body, counted by its author; the mesh must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shells {
    /// Outer ones: what falls apart.
    pub pieces: usize,
    /// Inner ones: cavities without a way out.
    pub voids: usize,
}

impl Shells {
    /// One piece without a cavity, as nearly all bodies are.
    pub const ONE: Self = Self { pieces: 1, voids: 0 };

    /// Several pieces without cavities.
    pub const fn pieces(pieces: usize) -> Self {
        Self { pieces, voids: 0 }
    }
}

/// What a feature does to the body that it is cut into.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    /// What is cut away, in the frame of the body.
    pub tools: Vec<Solid>,
    /// Points that others rely on, in the frame of the body.
    pub landmarks: Vec<Landmark>,
    /// Through holes and handles that it adds.
    pub handles: i32,
}

impl Cut {
    /// So many handles more.
    #[must_use]
    pub fn with_handles(self, handles: i32) -> Self {
        Self { handles: self.handles + handles, ..self }
    }

    /// Without points that others rely on.
    #[must_use]
    pub fn unmarked(self) -> Self {
        Self { landmarks: Vec::new(), ..self }
    }
}

/// What a lab does to have a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Makes it from a file: prints, cuts or etches it.
    Made(Process),
    /// Pours, sprays or otherwise forms it in place.
    Cast,
    /// Buys it; its solid is there so that fits can be checked.
    Bought,
}

impl Kind {
    /// The word used in files and on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Made(_) => "part",
            Self::Cast => "layer",
            Self::Bought => "component",
        }
    }

    /// How it is made; nothing for what is bought.
    pub fn process(self) -> Option<Process> {
        match self {
            Self::Made(process) => Some(process),
            Self::Cast => Some(Process::Cast),
            Self::Bought => None,
        }
    }
}

/// The machine that a part is made on, where somebody says so; what it does not say is as usual for the
/// part's process.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Machine {
    /// As its owner calls it.
    pub name: String,
    /// Thinnest wall that it makes, mm.
    pub wall_mm: Option<f64>,
    /// Smallest diameter of a hole that it makes, mm.
    pub hole_mm: Option<f64>,
    /// Room for a part: width, depth, height, mm.
    pub bed_mm: [Option<f64>; 3],
    /// Steepest overhang that it makes without support, from the vertical, degrees.
    pub overhang_deg: Option<f64>,
    /// Widest gap that it spans without support, mm.
    pub bridge_mm: Option<f64>,
    /// What its owner tells the slicer of all parts made on it.
    pub slicing: SliceAdvice,
    /// What differs from how the part is usually made, for whoever makes it.
    pub note: String,
}

/// What a bought body does for its neighbours in the finished sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Duty {
    /// It stands, holds and is held as what is made.
    #[default]
    Stands,
    /// It fastens what it goes through or around: a screw, a pin, a tie.
    Fastens,
    /// It has a thread in which screws hold: a nut, an insert, a threaded spacer.
    Threads,
    /// It is small, soldered, stuck or plugged onto what it touches, and holds nothing itself: an LED.
    Sticks,
}

/// What light does in a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Clarity {
    /// It is seen through.
    Clear,
    /// It lets light in and spreads it.
    Translucent,
    /// It stops light.
    Opaque,
}

/// A part that a lab makes, a layer that it casts or a component that it buys.
///
/// Stated by what is special about it; everything else is as for nearly all bodies.
///
/// ```
/// use fabkit_geometry::{Body, Process, Shells, Solid};
/// let lid = Solid::cylinder(12.0, 2.0).minus(Solid::cylinder(1.0, 4.0).at(8.0, 0.0, -1.0));
/// let lid = Body::made("lid", "closes the mold", Process::Fdm, lid)
///     .from("PLA")
///     .with_handles(1)
///     .note("flat side down");
/// assert_eq!((lid.quantity, lid.genus, lid.shells), (1, Some(1), Some(Shells::ONE)));
/// ```
#[derive(Clone, Debug)]
pub struct Body {
    /// `[a-z0-9-]{1,64}`, unique within the sensor; the file name.
    pub name: String,
    /// One line for people; for what is bought, what to order.
    pub summary: String,
    /// What a lab does to have it.
    pub kind: Kind,
    /// From what: trade name. Empty for what is bought.
    pub material: String,
    /// Its shape, mm; in the sensor frame unless its placements say otherwise.
    pub solid: Solid,
    /// Where it is made and where it is used.
    pub placements: Vec<Placement>,
    /// How many a lab needs.
    pub quantity: u32,
    /// Points others rely on, in the frame of `solid`.
    pub landmarks: Vec<Landmark>,
    /// For pictures.
    pub color: Color,
    /// Opacity in pictures, 0 to 1.
    pub opacity: f64,
    /// What light does in it, if that is not as it is drawn: see [`Body::clarity`].
    pub optics: Option<Clarity>,
    /// What of it shines, in the frame of `solid`; nothing of what is no lamp.
    pub lamp: Option<Solid>,
    /// What it is made from, as far as it is known.
    pub substance: Substance,
    /// What seals its surface, as the step that does it says: `varnish`, `lacquer`, `bake`.
    pub sealed_by: Option<&'static str>,
    /// Whether it gives way when it is touched although nobody would think so: it is made, not cast, or it is
    /// ink that moves with the gel that it is on.
    pub gives_way: bool,
    /// Turns a part as it should lie on the printer's bed; where it lies there is up to the exporter.
    pub bed_from_body: Pose,
    /// What to mind when making it.
    pub notes: Vec<String>,
    /// What its slicer is told, beside what follows from what it is for.
    pub slicing: SliceAdvice,
    /// What it is made on, if that is not just any machine for its process.
    pub machine: Option<Machine>,
    /// Linear shrinkage of what is cast in it, 0 for everything but molds: exported copies, and only
    /// those, are larger by 1 / (1 - shrinkage).
    pub shrinkage: f64,
    /// Through holes and handles, counted where they are cut; the mesh must agree. Nobody counts
    /// those of what is bought.
    pub genus: Option<i32>,
    /// As for `genus`, in how many pieces it comes and which cavities it encloses.
    pub shells: Option<Shells>,
    /// Room that hands and tools need to put it in, or to work on it in its place.
    pub reach: Vec<Reach>,
    /// How far it gives way, mm, to what it passes while it is brought to its place: a rubber ring that
    /// is stretched over a flange, a wire that is bent aside. 0 for what is rigid.
    pub gives_mm: f64,
    /// What it does for what it touches, where it is bought.
    pub duty: Duty,
    /// What to ask a shop for, where it is bought.
    pub order: Option<crate::Order>,
}

impl Body {
    fn new(name: impl Into<String>, summary: impl Into<String>, kind: Kind, solid: Solid) -> Self {
        let is_counted = kind != Kind::Bought;
        Self {
            name: name.into(),
            summary: summary.into(),
            kind,
            material: String::new(),
            solid,
            placements: Vec::new(),
            quantity: 1,
            landmarks: Vec::new(),
            color: [255, 255, 255],
            opacity: 1.0,
            optics: None,
            lamp: None,
            substance: Substance::default(),
            sealed_by: None,
            gives_way: false,
            bed_from_body: Pose::identity(),
            notes: Vec::new(),
            slicing: SliceAdvice::default(),
            machine: None,
            shrinkage: 0.0,
            genus: is_counted.then_some(0),
            shells: is_counted.then_some(Shells::ONE),
            reach: Vec::new(),
            gives_mm: 0.0,
            duty: Duty::Stands,
            order: None,
        }
    }

    /// A part: one piece without handles that lies on the bed as it stands.
    pub fn made(
        name: impl Into<String>,
        summary: impl Into<String>,
        process: Process,
        solid: Solid,
    ) -> Self {
        Self::new(name, summary, Kind::Made(process), solid)
    }

    /// A layer: one piece without handles.
    pub fn cast(name: impl Into<String>, summary: impl Into<String>, solid: Solid) -> Self {
        Self::new(name, summary, Kind::Cast, solid)
    }

    /// A component, and what to order.
    pub fn bought(name: impl Into<String>, specification: impl Into<String>, solid: Solid) -> Self {
        Self::new(name, specification, Kind::Bought, solid)
    }

    /// Its material.
    #[must_use]
    pub fn from(self, material: impl Into<String>) -> Self {
        Self { material: material.into(), ..self }
    }

    /// Made by another process.
    #[must_use]
    pub fn made_by(self, process: Process) -> Self {
        Self { kind: Kind::Made(process), ..self }
    }

    /// Where it stands, in one assembly after the other.
    #[must_use]
    pub fn placed(mut self, placements: impl IntoIterator<Item = Placement>) -> Self {
        self.placements.extend(placements);
        self
    }

    /// How it looks.
    #[must_use]
    pub fn colored(self, color: Color) -> Self {
        Self { color, ..self }
    }

    /// How much of what is behind it pictures hide, 0 to 1.
    #[must_use]
    pub fn opaque(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// What light does in it, and with it whether pictures show what is behind.
    #[must_use]
    pub fn in_light(mut self, clarity: Clarity) -> Self {
        self.let_light(clarity);
        self
    }

    /// The same of a body that is there already.
    pub fn let_light(&mut self, clarity: Clarity) {
        self.opacity = match clarity {
            Clarity::Opaque => 1.0,
            _ if self.opacity < 1.0 => self.opacity,
            Clarity::Clear => 0.35,
            Clarity::Translucent => 0.7,
        };
        self.optics = Some(clarity);
    }

    /// What light does in it: what is drawn as clear is clear unless somebody has said otherwise.
    pub fn clarity(&self) -> Clarity {
        self.optics.unwrap_or(if self.opacity < 1.0 { Clarity::Clear } else { Clarity::Opaque })
    }

    /// A lamp, all of it.
    #[must_use]
    pub fn shining(self) -> Self {
        let lamp = Some(self.solid.clone());
        Self { lamp, ..self }
    }

    /// A lamp of which a part shines.
    #[must_use]
    pub fn shining_from(self, lamp: Solid) -> Self {
        Self { lamp: Some(lamp), ..self }
    }

    /// Whether it is dark, where a pigment says more than the material's name.
    #[must_use]
    pub fn shaded(mut self, is_dark: Option<bool>) -> Self {
        self.substance.is_dark = is_dark;
        self
    }

    /// Sealed against what would keep silicone from curing; a step must say so with that word.
    #[must_use]
    pub fn sealed(self, by: &'static str) -> Self {
        Self { sealed_by: Some(by), ..self }
    }

    /// Soft although it is made, or ink on what is soft: what is touched.
    #[must_use]
    pub fn giving_way(self) -> Self {
        Self { gives_way: true, ..self }
    }

    /// How many a lab needs, if not one.
    #[must_use]
    pub fn times(self, quantity: u32) -> Self {
        Self { quantity, ..self }
    }

    /// As many as it has places.
    #[must_use]
    pub fn one_per_place(self) -> Self {
        Self { quantity: self.placements.len() as u32, ..self }
    }

    /// Points others rely on.
    #[must_use]
    pub fn marked(mut self, landmarks: impl IntoIterator<Item = Landmark>) -> Self {
        self.landmarks.extend(landmarks);
        self
    }

    /// With a feature cut into it.
    #[must_use]
    pub fn cut(mut self, cut: Cut) -> Self {
        self.solid = self.solid.minus_all(cut.tools);
        self.marked(cut.landmarks).with_handles(cut.handles)
    }

    /// How it lies on the bed.
    #[must_use]
    pub fn lying(self, bed_from_body: Pose) -> Self {
        Self { bed_from_body, ..self }
    }

    /// Something to mind when making it.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Several of these.
    #[must_use]
    pub fn notes<N: Into<String>>(mut self, notes: impl IntoIterator<Item = N>) -> Self {
        self.notes.extend(notes.into_iter().map(Into::into));
        self
    }

    /// Larger by what is cast in it will shrink.
    #[must_use]
    pub fn for_shrinkage(self, shrinkage: f64) -> Self {
        Self { shrinkage, ..self }
    }

    /// So many through holes and handles more.
    #[must_use]
    pub fn with_handles(self, handles: i32) -> Self {
        Self { genus: Some(self.genus.unwrap_or(0) + handles), ..self }
    }

    /// Not one piece without a cavity.
    #[must_use]
    pub fn in_shells(self, shells: Shells) -> Self {
        Self { shells: Some(shells), ..self }
    }

    /// Giving way so far while it is brought to its place, mm.
    #[must_use]
    pub fn giving(self, gives_mm: f64) -> Self {
        Self { gives_mm, ..self }
    }

    /// A screw, a pin, a tie: it fastens what it goes through or around.
    #[must_use]
    pub fn fastening(self) -> Self {
        Self { duty: Duty::Fastens, ..self }
    }

    /// A nut, an insert, a threaded spacer: screws hold in it.
    #[must_use]
    pub fn threaded(self) -> Self {
        Self { duty: Duty::Threads, ..self }
    }

    /// Soldered, stuck or plugged onto what it touches; it holds nothing itself.
    #[must_use]
    pub fn sticking(self) -> Self {
        Self { duty: Duty::Sticks, ..self }
    }

    /// With room for a hand or a tool.
    #[must_use]
    pub fn reached(mut self, reach: Reach) -> Self {
        self.reach.push(reach);
        self
    }

    /// Whether it is a part.
    pub fn is_made(&self) -> bool {
        matches!(self.kind, Kind::Made(_))
    }

    /// How it is made; nothing for what is bought.
    pub fn process(&self) -> Option<Process> {
        self.kind.process()
    }

    /// How it is made, for example `fdm`; empty for what is bought.
    pub fn process_word(&self) -> String {
        self.process().map(|process| process.to_string()).unwrap_or_default()
    }
}
