//! A laid-out board: what is etched, drilled, opened and printed.

use fabkit_geometry::{BoardPlace, BoardSide, CircuitKind, CircuitPart};

use crate::BoardShape;
use crate::shapes::{Point, Shape};

/// Both sides, upper first.
pub const SIDES: [BoardSide; 2] = [BoardSide::Top, BoardSide::Bottom];

/// A part in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedPart {
    /// As in the circuit.
    pub designator: String,
    /// As in the circuit.
    pub kind: CircuitKind,
    /// What to order.
    pub value: String,
    /// The package.
    pub package: String,
    /// Where.
    pub place: BoardPlace,
    /// What it takes of the board, lands included.
    pub outline: Shape,
}

/// Copper of a pin.
#[derive(Clone, Debug, PartialEq)]
pub struct Pad {
    /// The part's designator.
    pub part: String,
    /// Its pin.
    pub pin: String,
    /// Which side it is on.
    pub side: BoardSide,
    /// Its copper.
    pub shape: Shape,
    /// The net that it should be on, as an index; `None` for a pin that nothing is connected to.
    pub net: Option<usize>,
}

/// A straight piece of track.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Which side it is on.
    pub side: BoardSide,
    /// Its ends, mm.
    pub ends: [Point; 2],
    /// mm.
    pub width_mm: f64,
    /// The net that it was laid for.
    pub net: usize,
}

impl Track {
    /// Its copper.
    pub fn shape(&self) -> Shape {
        Shape::track(self.ends[0], self.ends[1], self.width_mm)
    }
}

/// A plated hole between both sides, covered by the mask.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Via {
    /// mm.
    pub at_mm: Point,
    /// mm.
    pub drill_mm: f64,
    /// Of its copper, mm.
    pub diameter_mm: f64,
    /// The net that it was laid for.
    pub net: usize,
}

impl Via {
    /// Its copper, the same on both sides.
    pub fn shape(&self) -> Shape {
        Shape::disc(self.at_mm, self.diameter_mm)
    }
}

/// A hole that is drilled and not plated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drill {
    /// mm.
    pub at_mm: Point,
    /// mm.
    pub diameter_mm: f64,
}

/// A printed line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SilkLine {
    /// Which side it is on.
    pub side: BoardSide,
    /// Its ends, mm.
    pub ends: [Point; 2],
    /// mm.
    pub width_mm: f64,
}

impl SilkLine {
    /// Its ink.
    pub fn shape(&self) -> Shape {
        Shape::track(self.ends[0], self.ends[1], self.width_mm)
    }
}

/// Everything that is made of a board.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Its outline.
    pub board: BoardShape,
    /// Names of nets.
    pub nets: Vec<String>,
    /// What is soldered to it.
    pub parts: Vec<PlacedPart>,
    /// Their pads.
    pub pads: Vec<Pad>,
    /// Tracks.
    pub tracks: Vec<Track>,
    /// Vias.
    pub vias: Vec<Via>,
    /// Holes that are drilled.
    pub drills: Vec<Drill>,
    /// Openings of the mask: one for each pad.
    pub openings: Vec<(BoardSide, Shape)>,
    /// What is printed.
    pub silk: Vec<SilkLine>,
    /// Test points that found no room, by designator.
    pub left_out: Vec<String>,
}

/// Holes up to this are drilled, mm; larger ones are milled with the outline.
pub const LARGEST_DRILL_MM: f64 = 3.0;

/// A land where its part stands.
pub fn land_shape(place: &BoardPlace, land: &fabkit_geometry::Land) -> Shape {
    let [x, y] = land.at_mm;
    if land.is_round {
        return Shape::disc(place.point([x, y]), land.size_mm[0]);
    }
    let [a, b] = [land.size_mm[0] / 2.0, land.size_mm[1] / 2.0];
    let corners = [[x - a, y - b], [x + a, y - b], [x + a, y + b], [x - a, y + b]];
    Shape::polygon(corners.map(|corner| place.point(corner)).to_vec())
}

/// What a part takes of its board: the box around body and lands, in its own axes.
pub fn part_outline(place: &BoardPlace, part: &CircuitPart) -> Shape {
    let half = [0, 1].map(|axis| part.size_mm[axis] / 2.0);
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
