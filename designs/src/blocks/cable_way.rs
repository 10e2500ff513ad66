//! Ways out for cables and wires: slots through a floor, notches and windows through a wall.

use fabkit_geometry::{CUT_OVERLAP_MM, Cut, Length, Path, Solid};

use super::holes;
use crate::parameters::Report;

/// A slot with round ends through a floor.
#[derive(Clone, Copy, Debug)]
pub struct FloorSlot {
    /// From end to end.
    pub length: Length,
    /// Its shorter side.
    pub width: Length,
    /// What it lies along: 0 for x, 1 for y.
    pub along: usize,
    /// Its middle, mm.
    pub at: [f64; 2],
}

/// How much longer than wide a slot is, mm.
const LONGER_MM: f64 = 0.5;

impl FloorSlot {
    /// The middles of its round ends, mm.
    pub fn ends(&self) -> [[f64; 2]; 2] {
        self.beside_middle().map(|[x, y]| [self.at[0] + x, self.at[1] + y])
    }

    fn beside_middle(&self) -> [[f64; 2]; 2] {
        let half = (self.length.mm() - self.width.mm()) / 2.0;
        [-half, half].map(|out| {
            let mut end = [0.0; 2];
            end[self.along] = out;
            end
        })
    }

    /// What a floor between two heights gets.
    pub fn cut(&self, name: &str, [bottom, top]: [f64; 2]) -> Cut {
        let [from, to] = self.beside_middle();
        let path = Path::slot(from, to, self.width.mm() / 2.0);
        let slot = Solid::extrusion(path, top - bottom + 2.0 * CUT_OVERLAP_MM).at(
            self.at[0],
            self.at[1],
            bottom - CUT_OVERLAP_MM,
        );
        holes([slot.named(name)]).with_handles(1)
    }

    /// Reports a slot, of which the parameter `path` is the width, that is hardly longer than wide.
    pub fn check(&self, path: &str, report: &mut Report) {
        let most = self.length.mm() - LONGER_MM;
        report.at_most(path, self.width, most, "the slot's width is its shorter side");
    }
}

/// The side of a housing that something leaves by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// At +x.
    Right,
    /// At -y.
    Front,
}

/// A way through the wall on one side, `width_mm` wide, between two distances from the axis and two
/// heights, mm.
pub fn wall_way(side: Side, width_mm: f64, [from, to]: [f64; 2], [bottom, top]: [f64; 2]) -> Solid {
    let half = width_mm / 2.0;
    match side {
        Side::Right => Solid::cuboid_between([from, -half, bottom], [to, half, top]),
        Side::Front => Solid::cuboid_between([-half, -to, bottom], [half, -from, top]),
    }
}
