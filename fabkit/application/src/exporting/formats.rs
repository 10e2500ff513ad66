//! All kinds of files: a row for each, which everything else that is known of it follows from.

use fabkit_designs::Design;
use fabkit_export::{
    Document, Drawing, ExportError, SamplesDocument, TetraMesh, TreeDocument, dxf, msh, stl, svg,
    vtk,
};
use fabkit_files::progress::unwatched;

use self::Making::{Outlines, Part, Tetrahedra, Whole};
use self::Trait::{Compensated, Published};
use super::{ExportFailure, ExportOptions, Made, Meshed, boards, glb, light, object};
use crate::pictures::{self, Shot};

/// How pictures of single parts are taken.
const PART_SHOT: Shot = Shot { size_px: [800, 600], section: false, from: None };

/// What holds for some formats.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Trait {
    /// A package has it: what somebody builds from or looks at. The guide has pictures, and the rest is for whoever
    /// checks fabkit. Boards are in it where there are some: [`ExportOptions::for_sensor`].
    Published,
    /// It makes up for what making does to sizes. The others show the design.
    Compensated,
}

/// How the files of a format are made.
#[derive(Clone, Copy)]
pub(super) enum Making {
    /// One of each part.
    Part(fn(&PartFile) -> Result<Vec<u8>, ExportFailure>),
    /// One of each part that is cut from a sheet, and one of each stock sheet.
    Outlines(fn(Document, &Drawing) -> Result<Vec<u8>, ExportError>),
    /// Those of the whole design with this hash, whichever parts are asked for.
    Whole(fn(&Design, &str, &ExportOptions) -> Result<Vec<Made>, ExportFailure>),
    /// One of the soft layers, whichever parts are asked for.
    Tetrahedra(fn(&TetraMesh) -> Vec<u8>),
}

/// What is known of a format.
struct Facts {
    word: &'static str,
    ending: &'static str,
    traits: &'static [Trait],
    making: Making,
    summary: &'static str,
}

/// Declares all formats, in the order of the command's help: the word of each, what names of its files end in, what
/// holds for it, how it is made, and a line for people without a full stop.
macro_rules! formats {
    ($($name:ident: $word:literal, $ending:literal, $traits:expr, $making:expr, $summary:literal;)+) => {
        /// A kind of file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Format {
            $(#[doc = concat!($summary, ".")] $name,)+
        }

        impl Format {
            /// All of them.
            pub const ALL: [Self; [$($word),+].len()] = [$(Self::$name,)+];

            fn facts(self) -> Facts {
                let (word, ending, traits, making, summary): (_, _, &[Trait], _, _) = match self {
                    $(Self::$name => ($word, $ending, &$traits, $making, $summary),)+
                };
                Facts { word, ending, traits, making, summary }
            }
        }
    };
}

formats! {
    Stl: "stl", "stl", [Published, Compensated],
        Part(|part| part.written(stl(&part.meshed.body.name, &part.meshed.print))),
        "Binary STL";
    ThreeMf: "3mf", "3mf", [Published, Compensated],
        Part(three_mf),
        "3MF, one file per part and plates with all parts laid out";
    Dxf: "dxf", "dxf", [Published, Compensated],
        Outlines(dxf),
        "Outlines of laser-cut parts and boards, and stock sheets with all laser-cut parts laid out";
    Svg: "svg", "svg", [Published, Compensated],
        Outlines(svg),
        "Outlines and stock sheets as for dxf, as SVG";
    Png: "png", "png", [],
        Part(picture),
        "Rendered image of the part, 800 x 600 px";
    Tree: "tree", "tree.json", [],
        Part(tree),
        "The exact geometry as JSON";
    Samples: "samples", "samples.json", [],
        Part(samples),
        "Points where lines cross the exact surface, and its volume, area and inertia, as JSON";
    Light: "light", "light", [],
        Whole(|design, hash, _| Ok(vec![light::made(design, hash)?])),
        "Optical description of all bodies of the sensor, its camera and its surface, as JSON";
    Glb: "glb", "glb", [Published],
        Whole(|design, hash, options| Ok(vec![glb::made(design, hash, options)?])),
        "Finished sensor or fixture for 3D viewers, with colours and an animation of its disassembly";
    Gerber: "gerber", "gerber", [Published],
        Whole(|design, hash, _| boards::made(design, hash)),
        "Circuit boards for a fab: Gerber X2, drills, job file, placement and parts lists, a folder for each board";
    Msh: "msh", "msh", [],
        Tetrahedra(msh),
        "Tetrahedral meshes of the soft layers for other solvers: Gmsh's MSH 4.1, with materials and sets of faces";
    Vtk: "vtk", "vtk", [],
        Tetrahedra(vtk),
        "Tetrahedral meshes of the soft layers for VTK, in its legacy format";
}

impl Format {
    /// What a package holds: what somebody builds from or looks at.
    pub fn published() -> Vec<Self> {
        Self::ALL.into_iter().filter(|format| format.facts().traits.contains(&Published)).collect()
    }

    /// The word used in the manifest and on the command line.
    pub fn word(self) -> &'static str {
        self.facts().word
    }

    /// One line for people, without a full stop.
    pub fn summary(self) -> &'static str {
        self.facts().summary
    }

    pub(super) fn making(self) -> Making {
        self.facts().making
    }

    /// Whether it holds outlines, which only parts cut from sheets have.
    pub(super) fn is_drawing(self) -> bool {
        matches!(self.making(), Outlines(_))
    }

    /// Whether it makes up for what making does to sizes.
    pub(super) fn is_compensated(self) -> bool {
        self.facts().traits.contains(&Compensated)
    }

    pub(super) fn file_name(self, part: &str) -> String {
        format!("{part}.{}", self.facts().ending)
    }
}

/// A file of one part, to be written.
pub(super) struct PartFile<'a> {
    pub name: String,
    pub document: Document<'a>,
    pub design: &'a Design,
    pub options: &'a ExportOptions,
    pub meshed: &'a Meshed<'a>,
}

impl PartFile<'_> {
    /// What a writer made of it; its refusal names the file.
    pub(super) fn written(
        &self,
        bytes: Result<Vec<u8>, ExportError>,
    ) -> Result<Vec<u8>, ExportFailure> {
        bytes.map_err(|source| ExportFailure::Write { file: self.name.clone(), source })
    }
}

fn three_mf(part: &PartFile) -> Result<Vec<u8>, ExportFailure> {
    let objects = [object(part.meshed, &part.meshed.print)];
    part.written(fabkit_export::three_mf(part.document, &objects))
}

fn picture(part: &PartFile) -> Result<Vec<u8>, ExportFailure> {
    let body = part.meshed.body;
    pictures::picture_of_body(body, PART_SHOT, &unwatched)
        .map_err(|source| ExportFailure::Picture { part: body.name.clone(), source })
}

fn tree(part: &PartFile) -> Result<Vec<u8>, ExportFailure> {
    let body = part.meshed.body;
    let process = body.process_word();
    part.written(fabkit_export::tree(&TreeDocument {
        design_hash: part.document.design_hash,
        sensor: &part.design.sensor.name,
        name: &body.name,
        kind: body.kind.word(),
        summary: &body.summary,
        process: &process,
        material: &body.material,
        quantity: body.quantity,
        color: body.color,
        opacity: body.opacity,
        solid: &body.solid,
        landmarks: &body.landmarks,
        placements: &body.placements,
        mesh: part.meshed.nominal_figures(part.options)?,
    }))
}

fn samples(part: &PartFile) -> Result<Vec<u8>, ExportFailure> {
    let body = part.meshed.body;
    part.written(fabkit_export::samples(&SamplesDocument {
        design_hash: part.document.design_hash,
        sensor: &part.design.sensor.name,
        name: &body.name,
        solid: &body.solid,
        landmarks: &body.landmarks,
    }))
}
