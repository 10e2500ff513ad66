//! What a sensor consists of: parts, cast layers, bought components, landmarks, camera.

use std::fmt;

use nalgebra::{Point3, Vector3};

use crate::{Angle, Pose, Solid, Step, TouchSurface};

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

/// Something a lab makes from a file: printed, cut or etched.
#[derive(Clone, Debug)]
pub struct Part {
    /// `[a-z0-9-]{1,64}`; the file name.
    pub name: String,
    /// One line for people.
    pub summary: String,
    /// Its shape, mm; in the sensor frame unless its placements say otherwise.
    pub solid: Solid,
    /// Where it is used.
    pub placements: Vec<Placement>,
    /// How it is made.
    pub process: Process,
    /// From what.
    pub material: String,
    /// How many a lab needs.
    pub quantity: u32,
    /// Points others rely on, in the frame of `solid`.
    pub landmarks: Vec<Landmark>,
    /// For pictures.
    pub color: Color,
    /// Turns the part as it should lie on the printer's bed; where it lies there is up to the
    /// exporter.
    pub bed_from_part: Pose,
    /// What to mind when making it.
    pub print_notes: Vec<String>,
    /// Linear shrinkage of what is cast in it, 0 for everything but molds: exported copies, and only
    /// those, are larger by 1 / (1 - shrinkage).
    pub shrinkage: f64,
    /// Through holes and handles, counted where they are cut; the mesh must agree.
    pub genus: i32,
    /// As for `genus`, in how many pieces it comes and which cavities it encloses.
    pub shells: Shells,
}

/// Parts of several materials that leave the printer as one piece.
///
/// Their solids are in one frame and touch without overlap; their files share their coordinates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PrintGroup {
    /// `[a-z0-9-]{1,64}`; the name of the file that holds them all.
    pub name: String,
    /// The parts by name. The first says how the piece lies on the bed.
    pub parts: Vec<String>,
}

/// A body that is poured, sprayed or otherwise formed in place.
#[derive(Clone, Debug)]
pub struct Layer {
    /// `[a-z0-9-]{1,64}`.
    pub name: String,
    /// One line for people.
    pub summary: String,
    /// Its shape, mm; in the sensor frame unless its placements say otherwise.
    pub solid: Solid,
    /// Where it is poured, and where it is used.
    pub placements: Vec<Placement>,
    /// Trade name.
    pub material: String,
    /// For pictures.
    pub color: Color,
    /// Opacity in pictures, 0 to 1.
    pub opacity: f64,
    /// As for a part.
    pub genus: i32,
    /// As for a part.
    pub shells: Shells,
}

/// Something bought; its solid is there so that fits can be checked.
#[derive(Clone, Debug)]
pub struct Component {
    /// `[a-z0-9-]{1,64}`.
    pub name: String,
    /// What to order.
    pub specification: String,
    /// Its shape in its own frame, mm.
    pub solid: Solid,
    /// Where each one sits.
    pub placements: Vec<Placement>,
    /// How many a lab needs.
    pub quantity: u32,
    /// For pictures.
    pub color: Color,
    /// Opacity in pictures, 0 to 1.
    pub opacity: f64,
}

/// Two bodies that are meant to overlap: a press fit, a thread that cuts its own way.
#[derive(Clone, Debug, PartialEq)]
pub struct PressFit {
    /// The one that is pressed in.
    pub inner: String,
    /// The one that holds it.
    pub outer: String,
    /// Largest overlap that is meant, mm, measured across the fit's surface (per side).
    pub interference_mm: f64,
    /// Why.
    pub reason: String,
}

/// The camera as the design intends it, before any calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct NominalCamera {
    /// Camera frame (+z forward, +x right, +y down) to sensor frame, mm.
    pub sensor_from_camera: Pose,
    /// Image width, px.
    pub width_px: u32,
    /// Image height, px.
    pub height_px: u32,
    /// Full angle of view over the image's diagonal, as makers of small cameras state it.
    pub field_of_view: Angle,
}

/// A whole sensor, ready for export, pictures and checks.
///
/// Sensor frame: origin at the centre of the sensing surface's base circle, +z toward the tip.
#[derive(Clone, Debug)]
pub struct Sensor {
    /// `[a-z0-9-]{1,64}`.
    pub name: String,
    /// For people.
    pub title: String,
    /// The paper.
    pub reference: String,
    /// What is made.
    pub parts: Vec<Part>,
    /// What is poured.
    pub layers: Vec<Layer>,
    /// What is bought.
    pub components: Vec<Component>,
    /// How it is built, step by step.
    pub chain: Vec<Step>,
    /// Parts that are printed as one piece.
    pub print_groups: Vec<PrintGroup>,
    /// Overlaps that are meant.
    pub press_fits: Vec<PressFit>,
    /// The camera as designed.
    pub camera: NominalCamera,
    /// The curved surface that touches things; `None` for flat sensors.
    pub touch: Option<TouchSurface>,
}
