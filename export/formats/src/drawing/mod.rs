//! Plane drawings for laser cutters and board makers: closed outlines and lettering.
//!
//! Drawings have their origin in the lower left corner, x to the right and y upwards, mm.

mod kerf;
pub(crate) mod lettering;
mod nest;

pub use kerf::widen_for_kerf;
pub(crate) use kerf::{bulge, sweep};
pub use nest::{NestedSheet, Piece, nest};

use fabkit_geometry::{Path, Profile};

/// What the machine does along a line. In the order in which a machine should do it: a piece that
/// is cut out may shift, so its holes come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Operation {
    /// Names of pieces, drawn beside them on the waste: no optical face is marked.
    Label,
    /// Boundaries of dark areas, even-odd: what is engraved is between them.
    Engrave,
    /// Boundaries of holes.
    CutInner,
    /// Outer boundaries.
    CutOuter,
}

impl Operation {
    /// All of them, in order.
    pub const ALL: [Self; 4] = [Self::Label, Self::Engrave, Self::CutInner, Self::CutOuter];

    /// Layer in a DXF file, group in an SVG file.
    pub fn layer(self) -> &'static str {
        match self {
            Self::Label => "LABEL",
            Self::Engrave => "ENGRAVE",
            Self::CutInner => "CUT_INNER",
            Self::CutOuter => "CUT_OUTER",
        }
    }

    /// AutoCAD colour index: green, white (black on paper), blue, red.
    pub(crate) fn color_index(self) -> u8 {
        match self {
            Self::Label => 3,
            Self::Engrave => 7,
            Self::CutInner => 5,
            Self::CutOuter => 1,
        }
    }

    /// The same colours in CSS; laser software tells operations apart by them.
    pub(crate) fn color_css(self) -> &'static str {
        match self {
            Self::Label => "#00ff00",
            Self::Engrave => "#000000",
            Self::CutInner => "#0000ff",
            Self::CutOuter => "#ff0000",
        }
    }
}

/// Outlines and strokes on a plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Width and height, mm: the piece's box, or the whole stock.
    pub size_mm: [f64; 2],
    /// Closed outlines, in the order in which they should be cut.
    pub contours: Vec<(Operation, Path)>,
    /// Open polylines on the layer of labels, mm.
    pub strokes: Vec<Vec<[f64; 2]>>,
}

impl Drawing {
    /// One piece in the corner of its own drawing, without a label.
    pub fn of_piece(profile: &Profile) -> Self {
        let [min, max] = profile.bounds_mm();
        let mut drawing = Self { size_mm: [max[0] - min[0], max[1] - min[1]], ..Self::default() };
        drawing.add(&profile.shifted([-min[0], -min[1]]));
        drawing
    }

    fn add(&mut self, profile: &Profile) {
        let holes = profile.holes.iter().map(|hole| (Operation::CutInner, hole.clone()));
        self.contours.extend(holes);
        self.contours.push((Operation::CutOuter, profile.outer.clone()));
    }
}
