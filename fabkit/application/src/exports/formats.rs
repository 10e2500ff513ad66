//! Table of the export formats. Each row holds all that the code needs to know of a format.

use fabkit_designs::Design;
use fabkit_export::{
    DocumentInfo, Drawing, ExportError, SamplesDocument, TetraMesh, TreeDocument, dxf, msh, stl,
    svg, vtk,
};
use fabkit_files::progress::ignore_progress;

use self::FormatTrait::{Compensated, Published};
use self::FormatWriter::{Outlines, Part, Tetrahedra, Whole};
use super::{ExportOptions, ExportRunError, MadeFile, MeshedPart, boards, glb, light, object};
use crate::images::{self, ImageView};

/// View of a single part's image.
const PART_SHOT: ImageView = ImageView { size_px: [800, 600], is_section: false, from: None };

/// Property of some formats.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FormatTrait {
    /// Included in packages: files to build from or to look at. Images are part of the guide instead, and the remaining
    /// formats serve to verify fabkit. Boards are included where a design has some, see [`ExportOptions::for_sensor`].
    Published,
    /// Compensated for shrinkage, kerf and printer errors. The other formats show the nominal design.
    Compensated,
}

/// Function that makes the files of a format, by their number.
#[derive(Clone, Copy)]
pub(super) enum FormatWriter {
    /// One file for each part.
    Part(fn(&PartFile) -> Result<Vec<u8>, ExportRunError>),
    /// One file for each part cut from a sheet, and one for each stock sheet.
    Outlines(fn(DocumentInfo, &Drawing) -> Result<Vec<u8>, ExportError>),
    /// Files of the whole design, independent of the requested parts. The second argument is the design hash.
    Whole(fn(&Design, &str, &ExportOptions) -> Result<Vec<MadeFile>, ExportRunError>),
    /// One file of the soft layers, independent of the requested parts.
    Tetrahedra(fn(&TetraMesh) -> Vec<u8>),
}

/// Properties of a format.
struct FormatProperties {
    word: &'static str,
    ending: &'static str,
    traits: &'static [FormatTrait],
    making: FormatWriter,
    summary: &'static str,
}

/// Declares all formats in the order of the command's help: word, file name ending, traits, maker, and a summary
/// without a full stop.
macro_rules! formats {
    ($($name:ident: $word:literal, $ending:literal, $traits:expr, $making:expr, $summary:literal;)+) => {
        /// Export file format.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Format {
            $(#[doc = concat!($summary, ".")] $name,)+
        }

        impl Format {
            /// All formats, in the order of the command's help.
            pub const ALL: [Self; [$($word),+].len()] = [$(Self::$name,)+];

            fn properties(self) -> FormatProperties {
                let (word, ending, traits, making, summary): (_, _, &[FormatTrait], _, _) = match self {
                    $(Self::$name => ($word, $ending, &$traits, $making, $summary),)+
                };
                FormatProperties { word, ending, traits, making, summary }
            }
        }
    };
}

formats! {
    Stl: "stl", "stl", [Published, Compensated],
        Part(|part| part.wrap_result(stl(&part.meshed.body.name, &part.meshed.print))),
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
        Part(image),
        "Rendered image of the part, 800 x 600 px";
    Tree: "tree", "tree.json", [],
        Part(tree),
        "The exact geometry as JSON";
    Samples: "samples", "samples.json", [],
        Part(samples),
        "Points where lines cross the exact surface, and its volume, area and inertia, as JSON";
    Light: "light", "light", [],
        Whole(|design, hash, _| Ok(vec![light::make_file(design, hash)?])),
        "Optical description of all bodies of the sensor, its camera and its surface, as JSON";
    Glb: "glb", "glb", [Published],
        Whole(|design, hash, options| Ok(vec![glb::make_file(design, hash, options)?])),
        "Finished sensor or fixture for 3D viewers, with colours and an animation of its disassembly";
    Gerber: "gerber", "gerber", [Published],
        Whole(|design, hash, _| boards::make_files(design, hash)),
        "Circuit boards for a fab: Gerber X2, drills, job file, placement and parts lists, a folder for each board";
    Msh: "msh", "msh", [],
        Tetrahedra(msh),
        "Tetrahedral meshes of the soft layers for other solvers: Gmsh's MSH 4.1, with materials and sets of faces";
    Vtk: "vtk", "vtk", [],
        Tetrahedra(vtk),
        "Tetrahedral meshes of the soft layers for VTK, in its legacy format";
}

impl Format {
    /// Returns the formats of a package: files to build from or to look at.
    ///
    /// ```
    /// use fabkit_application::exports::Format;
    /// let published = Format::published();
    /// assert!(published.contains(&Format::Stl) && published.contains(&Format::Gerber));
    /// // The exact geometry is for programs that check it.
    /// assert!(!published.contains(&Format::Tree));
    /// assert_eq!(Format::ThreeMf.word(), "3mf");
    /// ```
    pub fn published() -> Vec<Self> {
        Self::ALL
            .into_iter()
            .filter(|format| format.properties().traits.contains(&Published))
            .collect()
    }

    /// Returns the format's word in the manifest and on the command line.
    pub fn word(self) -> &'static str {
        self.properties().word
    }

    /// Returns a one-line summary without a full stop.
    pub fn summary(self) -> &'static str {
        self.properties().summary
    }

    pub(super) fn making(self) -> FormatWriter {
        self.properties().making
    }

    /// Returns whether the format holds outlines, which only parts cut from sheets have.
    pub(super) fn is_drawing(self) -> bool {
        matches!(self.making(), Outlines(_))
    }

    /// Returns whether the format is compensated for shrinkage, kerf and printer errors.
    pub(super) fn is_compensated(self) -> bool {
        self.properties().traits.contains(&Compensated)
    }

    pub(super) fn file_name(self, part: &str) -> String {
        format!("{part}.{}", self.properties().ending)
    }
}

/// Input of the writer of one part's file.
pub(super) struct PartFile<'a> {
    pub name: String,
    pub document: DocumentInfo<'a>,
    pub design: &'a Design,
    pub options: &'a ExportOptions,
    pub meshed: &'a MeshedPart<'a>,
}

impl PartFile<'_> {
    /// Wraps a writer's result; errors name the file.
    pub(super) fn wrap_result(
        &self,
        bytes: Result<Vec<u8>, ExportError>,
    ) -> Result<Vec<u8>, ExportRunError> {
        bytes.map_err(|source| ExportRunError::Write { file: self.name.clone(), source })
    }
}

fn three_mf(part: &PartFile) -> Result<Vec<u8>, ExportRunError> {
    let objects = [object(part.meshed, &part.meshed.print)];
    part.wrap_result(fabkit_export::three_mf(part.document, &objects))
}

fn image(part: &PartFile) -> Result<Vec<u8>, ExportRunError> {
    let body = part.meshed.body;
    images::draw_body(body, PART_SHOT, &ignore_progress)
        .map_err(|source| ExportRunError::Image { part: body.name.clone(), source })
}

fn tree(part: &PartFile) -> Result<Vec<u8>, ExportRunError> {
    let body = part.meshed.body;
    let process = body.process_word();
    part.wrap_result(fabkit_export::tree(&TreeDocument {
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

fn samples(part: &PartFile) -> Result<Vec<u8>, ExportRunError> {
    let body = part.meshed.body;
    part.wrap_result(fabkit_export::samples(&SamplesDocument {
        design_hash: part.document.design_hash,
        sensor: &part.design.sensor.name,
        name: &body.name,
        solid: &body.solid,
        landmarks: &body.landmarks,
    }))
}
