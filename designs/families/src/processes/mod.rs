//! Processes: a user's own machines, and the parts that are made on them.
//!
//! A family states how each of its parts is usually made. Statements of files on processes change that for the parts
//! they name: fits, checks and instructions follow.

mod assignments;
mod part_processes;
mod workshop;

use fabkit_geometry::{Angle, Length, Machine, Process, SliceAdvice};

use crate::{Fit, choices, parameters};

pub(crate) use assignments::{PARTS, PROCESSES, Processes};
pub use part_processes::{FixtureProcesses, PartManufacture, ProcessAssignments};
pub use workshop::Workshop;
pub(crate) use workshop::{assign, names, report_unmatched};

choices! {
    /// Kind of process by which a part can be made.
    pub enum ProcessKind {
        /// Filament printing.
        Fdm = "fdm",
        /// Resin printing.
        Sla = "sla",
        /// Printing with jetted resin.
        PolyJet = "polyjet",
        /// Laser cutting of sheets.
        Laser = "laser",
        /// CNC machining.
        Cnc = "cnc",
    }
}

impl ProcessKind {
    /// All kinds.
    pub(crate) const ALL: [Self; 5] = [Self::Fdm, Self::Sla, Self::PolyJet, Self::Laser, Self::Cnc];

    /// Returns the process of the geometry crate.
    pub fn process(self) -> Process {
        match self {
            Self::Fdm => Process::Fdm,
            Self::Sla => Process::Sla,
            Self::PolyJet => Process::PolyJet,
            Self::Laser => Process::Laser,
            Self::Cnc => Process::Cnc,
        }
    }

    /// Returns the default material; `None` for processes that cut stock, which the family names.
    fn usual_material(self) -> Option<&'static str> {
        match self {
            Self::Fdm => Some("PLA"),
            Self::Sla => Some("resin"),
            Self::PolyJet => Some("jetted resin"),
            Self::Laser | Self::Cnc => None,
        }
    }
}

parameters! {
    /// Gaps per side between a hole and the part in it. Gaps not given are those usual for the process kind.
    pub struct Clearance {
        /// Gap of a press fit, which holds by itself; negative or zero.
        press: Option<Length> = -1.0..=0.0,
        /// Gap of a snug fit, which locates a part without noticeable play.
        snug: Option<Length> = 0.0..=2.0,
        /// Gap of a sliding fit, in which a part moves freely and stays centred.
        slide: Option<Length> = 0.0..=2.0,
        /// Gap of a free fit, in which the parts never touch.
        free: Option<Length> = 0.0..=4.0,
    }
}

parameters! {
    /// Build volume of a machine.
    pub struct Room {
        /// Build volume along the machine's x.
        width: Option<Length> = 10.0..=5000.0,
        /// Build volume along the machine's y.
        depth: Option<Length> = 10.0..=5000.0,
        /// Height of the build volume.
        height: Option<Length> = 10.0..=5000.0,
    }
}

parameters! {
    /// Machine on which parts are made. Values not given are those usual for its kind.
    pub struct ProcessFigures {
        /// Kind of process.
        kind: Option<ProcessKind>,
        /// Height of a printed layer.
        layer_height: Option<Length> = 0.005..=2.0,
        /// Width of a printed line; for a filament printer the nozzle's diameter.
        line_width: Option<Length> = 0.01..=5.0,
        /// Minimum thickness of walls that the machine can make; two lines for filament printers.
        wall: Option<Length> = 0.01..=20.0,
        /// Diameter of the smallest hole that the machine can make.
        hole: Option<Length> = 0.01..=50.0,
        /// Gaps per side between a hole and the part in it. Gaps not given are those usual for the process kind.
        clearance: Clearance,
        /// Steepest overhang that prints without support, measured from the vertical.
        overhang: Option<Angle> = 0.0..=90.0,
        /// Widest gap between two walls that the printer bridges without support.
        bridge: Option<Length> = 0.0..=200.0,
        /// Number of lines side by side along each outline, which is passed to the slicer.
        perimeters: Option<u32> = 1..=20,
        /// Filled fraction of the inside, for example 0.2 for a fifth, which is passed to the slicer.
        infill: Option<f64> = 0.0..=1.0,
        /// True to print parts with supports, whatever their overhangs, which is passed to the slicer.
        supports: Option<bool>,
        /// Width of the brim, 0 mm for none, which is passed to the slicer.
        brim: Option<Length> = 0.0..=50.0,
        /// Build volume of the machine.
        bed: Room,
        /// Source of these data.
        source: Option<String> = 0..=500,
        /// Advice on using the machine.
        note: Option<String> = 0..=500,
    }
}

/// Process that a file can assign to a part.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NamedProcess {
    /// Name of the process.
    pub name: String,
    /// Kind of the process.
    pub kind: ProcessKind,
    /// Figures that a file states; `None` for a kind without a section in any file.
    pub figures: Option<ProcessFigures>,
    /// Materials that the process takes; any if empty.
    pub materials: Vec<String>,
}

impl NamedProcess {
    /// Returns the gap per side of a fit, mm, if a file states one.
    fn clearance_mm(&self, fit: Fit) -> Option<f64> {
        let clearance = &self.figures.as_ref()?.clearance;
        let gap = match fit {
            Fit::Press => clearance.press,
            Fit::Snug => clearance.snug,
            Fit::Slide => clearance.slide,
            Fit::Free => clearance.free,
        };
        gap.map(Length::mm)
    }

    /// Returns the description of the machine that is stored with its parts.
    pub(crate) fn machine(&self) -> Machine {
        let Some(figures) = &self.figures else {
            return Machine { name: self.name.clone(), ..Machine::default() };
        };
        // The rule of two lines per wall holds for filament only.
        let lines = figures.line_width.filter(|_| self.kind == ProcessKind::Fdm);
        let room = &figures.bed;
        Machine {
            name: self.name.clone(),
            wall_mm: figures.wall.map(Length::mm).or(lines.map(|line| 2.0 * line.mm())),
            hole_mm: figures.hole.map(Length::mm),
            overhang_deg: figures.overhang.map(Angle::deg),
            bridge_mm: figures.bridge.map(Length::mm),
            bed_mm: [room.width, room.depth, room.height].map(|side| side.map(Length::mm)),
            slicing: SliceAdvice {
                layer_mm: figures.layer_height.map(Length::mm),
                line_mm: figures.line_width.map(Length::mm),
                perimeters: figures.perimeters,
                infill_percent: figures.infill.map(|share| 100.0 * share),
                supports: figures.supports,
                brim_mm: figures.brim.map(Length::mm),
            },
            note: String::new(),
        }
    }
}
