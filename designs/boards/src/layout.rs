//! Laid-out board: everything that is etched, drilled, opened and printed.

use fabkit_geometry::{BoardPlacement, BoardSide, CircuitKind, CircuitPart};

use crate::BoardShape;
use crate::shapes::{Point, Shape};

/// Both sides, upper side first.
pub const SIDES: [BoardSide; 2] = [BoardSide::Top, BoardSide::Bottom];

/// Part at its place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedPart {
    /// Designator, as in the circuit.
    pub designator: String,
    /// Kind, as in the circuit.
    pub kind: CircuitKind,
    /// Value to order.
    pub value: String,
    /// Package.
    pub package: String,
    /// Place on the board.
    pub place: BoardPlacement,
    /// Area that the part takes on the board, lands included.
    pub outline: Shape,
}

/// Copper of one pin.
#[derive(Clone, Debug, PartialEq)]
pub struct Pad {
    /// Designator of the part.
    pub part: String,
    /// Pin of the part.
    pub pin: String,
    /// Side of the board.
    pub side: BoardSide,
    /// Shape of the copper.
    pub shape: Shape,
    /// Index of the net that the circuit assigns to the pin; `None` if nothing is connected to it.
    pub net: Option<usize>,
}

/// Straight piece of track.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Side of the board.
    pub side: BoardSide,
    /// Ends, mm.
    pub ends: [Point; 2],
    /// Width, mm.
    pub width_mm: f64,
    /// Index of the net for which it was laid.
    pub net: usize,
}

impl Track {
    /// Shape of its copper.
    pub fn shape(&self) -> Shape {
        Shape::track(self.ends[0], self.ends[1], self.width_mm)
    }
}

/// Plated hole between both sides, covered by the mask.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Via {
    /// Centre, mm.
    pub at_mm: Point,
    /// Diameter of the drill, mm.
    pub drill_mm: f64,
    /// Diameter of the copper, mm.
    pub diameter_mm: f64,
    /// Index of the net for which it was laid.
    pub net: usize,
}

impl Via {
    /// Shape of its copper, the same on both sides.
    pub fn shape(&self) -> Shape {
        Shape::disc(self.at_mm, self.diameter_mm)
    }
}

/// Drilled hole without plating.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drill {
    /// Centre, mm.
    pub at_mm: Point,
    /// Diameter, mm.
    pub diameter_mm: f64,
}

/// Printed line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SilkLine {
    /// Side of the board.
    pub side: BoardSide,
    /// Ends, mm.
    pub ends: [Point; 2],
    /// Width, mm.
    pub width_mm: f64,
}

impl SilkLine {
    /// Shape of its ink.
    pub fn shape(&self) -> Shape {
        Shape::track(self.ends[0], self.ends[1], self.width_mm)
    }
}

/// Complete layout of a board.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardLayout {
    /// Outline of the board.
    pub board: BoardShape,
    /// Names of nets.
    pub nets: Vec<String>,
    /// Parts soldered to the board.
    pub parts: Vec<PlacedPart>,
    /// Pads of the parts.
    pub pads: Vec<Pad>,
    /// Tracks.
    pub tracks: Vec<Track>,
    /// Vias.
    pub vias: Vec<Via>,
    /// Unplated holes that are drilled.
    pub drills: Vec<Drill>,
    /// Openings of the mask, one for each pad.
    pub openings: Vec<(BoardSide, Shape)>,
    /// Printed lines.
    pub silk: Vec<SilkLine>,
    /// Designators of the test points for which there was no room.
    pub unplaced_test_points: Vec<String>,
}

/// Largest diameter of drilled holes, mm. Larger holes are milled with the outline.
pub const MAX_DRILL_MM: f64 = 3.0;

/// Returns the shape of a land at its part's place.
pub fn land_shape(place: &BoardPlacement, land: &fabkit_geometry::Land) -> Shape {
    let [x, y] = land.at_mm;
    if land.is_round {
        return Shape::disc(place.point([x, y]), land.size_mm[0]);
    }
    let [a, b] = [land.size_mm[0] / 2.0, land.size_mm[1] / 2.0];
    let corners = [[x - a, y - b], [x + a, y - b], [x + a, y + b], [x - a, y + b]];
    Shape::polygon(corners.map(|corner| place.point(corner)).to_vec())
}

/// Returns the area that a part takes on its board: the bounding box of body and lands in the part's own axes.
pub fn part_outline(place: &BoardPlacement, part: &CircuitPart) -> Shape {
    let half = [0, 1].map(|axis| part.size_mm[axis] / 2.0);
    // Starts with the body; lands may stand out of it.
    let (mut low, mut high) = ([-half[0], -half[1]], half);
    for land in &part.lands {
        for axis in 0..2 {
            let half = if land.is_round { land.size_mm[0] } else { land.size_mm[axis] } / 2.0;
            low[axis] = low[axis].min(land.at_mm[axis] - half);
            high[axis] = high[axis].max(land.at_mm[axis] + half);
        }
    }
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]]];
    Shape::polygon(corners.map(|corner| place.point(corner)).to_vec())
}
