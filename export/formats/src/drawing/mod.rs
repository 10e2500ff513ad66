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

/// Operation of the machine along a line, in the order of execution: a piece that is cut out may shift, so its holes
/// come first.
///
/// ```
/// use fabkit_export::Operation;
///
/// assert!(Operation::CutInner < Operation::CutOuter);
/// assert_eq!(Operation::ALL.map(Operation::layer), ["LABEL", "ENGRAVE", "CUT_INNER", "CUT_OUTER"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Operation {
    /// Names of pieces, beside them on the waste, so that no optical face is marked.
    Label,
    /// Boundaries of engraved areas, by the even-odd rule.
    Engrave,
    /// Boundaries of holes.
    CutInner,
    /// Outer boundaries of pieces.
    CutOuter,
}

impl Operation {
    /// All operations, in order.
    pub const ALL: [Self; 4] = [Self::Label, Self::Engrave, Self::CutInner, Self::CutOuter];

    /// Name of the layer in a DXF file and of the group in an SVG file.
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

    /// The same colours in CSS, by which laser software tells operations apart.
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
    /// Width and height, mm: of the piece's bounding box, or of the whole stock.
    pub size_mm: [f64; 2],
    /// Closed outlines, in the order of cutting.
    pub contours: Vec<(Operation, Path)>,
    /// Open polylines on the label layer, mm.
    pub strokes: Vec<Vec<[f64; 2]>>,
}

impl Drawing {
    /// Creates a drawing of one piece in its lower left corner, without a label.
    ///
    /// ```
    /// use fabkit_export::{Drawing, Operation};
    /// use fabkit_geometry::{Path, Profile};
    ///
    /// let plate = Profile::new(Path::rectangle([50.0, -3.0], [20.0, 10.0], 0.0));
    /// let drawing = Drawing::from_piece(&plate.with_hole(Path::circle([50.0, -3.0], 2.0)));
    /// assert_eq!(drawing.size_mm, [20.0, 10.0]);
    /// let [(first, hole), (last, _)] = &drawing.contours[..] else { panic!("there are two outlines") };
    /// assert_eq!((*first, *last), (Operation::CutInner, Operation::CutOuter));
    /// // The plate's corner has moved to the origin, and its centre to (10, 5).
    /// assert_eq!(hole.start, [12.0, 5.0]);
    /// ```
    pub fn from_piece(profile: &Profile) -> Self {
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
