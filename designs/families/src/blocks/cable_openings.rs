//! Openings for cables and wires: slots through a floor, notches and windows through a wall.

use fabkit_geometry::{Angle, CUT_OVERLAP_MM, CutFeature, Length, Path, Solid, Vector3};

use super::holes;
use crate::choices;
use crate::parameters::RuleReport;

/// Slot with round ends through a floor.
///
/// ```
/// use fabkit_designs::blocks::cable_openings::FloorSlot;
/// use fabkit_geometry::{Angle, Length};
/// let mm = |mm| Length::from_mm(mm).ok_or("not finite");
/// let turn = Angle::from_deg(0.0).ok_or("not finite")?;
/// let slot = FloorSlot { length: mm(10.0)?, width: mm(4.0)?, along: 0, at: [5.0, 0.0], turn };
/// // The round ends have a radius of 2 mm, so their centres are 2 mm inside of 0 and 10 mm.
/// assert_eq!(slot.ends(), [[2.0, 0.0], [8.0, 0.0]]);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct FloorSlot {
    /// Length from end to end.
    pub length: Length,
    /// Width, its shorter side.
    pub width: Length,
    /// Axis that it lies along: 0 for x, 1 for y.
    pub along: usize,
    /// Middle, mm.
    pub at: [f64; 2],
    /// Turn around its middle, from the axis.
    pub turn: Angle,
}

/// Smallest excess of a slot's length over its width, mm.
const LONGER_MM: f64 = 0.5;

impl FloorSlot {
    /// Returns the centres of its round ends, mm.
    pub fn ends(&self) -> [[f64; 2]; 2] {
        self.beside_middle().map(|[x, y]| [self.at[0] + x, self.at[1] + y])
    }

    /// Returns the centres of the round ends relative to the middle, mm.
    fn beside_middle(&self) -> [[f64; 2]; 2] {
        let half = (self.length.mm() - self.width.mm()) / 2.0;
        [-half, half].map(|out| {
            let mut end = [0.0; 2];
            end[self.along] = out;
            match self.turn.rad() {
                // An exact identity: a rotation by 0 could change the last digits.
                0.0 => end,
                turn => {
                    let (sin, cos) = turn.sin_cos();
                    [end[0] * cos - end[1] * sin, end[0] * sin + end[1] * cos]
                }
            }
        })
    }

    /// Returns the cut through a floor between two heights.
    pub fn cut(&self, name: &str, [bottom, top]: [f64; 2]) -> CutFeature {
        let [from, to] = self.beside_middle();
        let path = Path::slot(from, to, self.width.mm() / 2.0);
        let slot = Solid::extrusion(path, top - bottom + 2.0 * CUT_OVERLAP_MM).at(
            self.at[0],
            self.at[1],
            bottom - CUT_OVERLAP_MM,
        );
        holes([slot.named(name)]).with_handles(1)
    }

    /// Reports a slot that is not longer than wide; the parameter `path` is its width.
    pub fn check(&self, path: &str, report: &mut RuleReport) {
        let most = self.length.mm() - LONGER_MM;
        report.at_most(path, self.width, most, "the slot's width is its shorter side");
    }
}

choices! {
    /// Side of a housing through which a cable or plug leaves.
    pub enum HousingSide {
        /// Side at +x.
        Right = "right",
        /// Side at -x.
        Left = "left",
        /// Side at -y.
        Front = "front",
        /// Side at +y.
        Back = "back",
    }
}

impl HousingSide {
    /// Returns the axis that the side faces along: 0 for x, 1 for y.
    pub fn axis(self) -> usize {
        match self {
            Self::Right | Self::Left => 0,
            Self::Front | Self::Back => 1,
        }
    }

    /// Returns the number of quarter turns from +x, counter-clockwise seen from above.
    pub fn quarters(self) -> u32 {
        match self {
            Self::Right => 0,
            Self::Back => 1,
            Self::Left => 2,
            Self::Front => 3,
        }
    }

    /// Returns the direction that the side faces, as an angle around z from +x, in (-180, 180] degrees.
    ///
    /// ```
    /// use fabkit_designs::blocks::cable_openings::HousingSide;
    /// assert!((HousingSide::Back.angle().deg() - 90.0).abs() < 1e-12);
    /// assert!((HousingSide::Front.angle().deg() + 90.0).abs() < 1e-12);
    /// ```
    pub fn angle(self) -> Angle {
        let deg = 90.0 * f64::from(self.quarters());
        Angle::from_deg(if deg > 180.0 { deg - 360.0 } else { deg }).expect("finite")
    }

    /// Returns the outward unit normal.
    pub fn out(self) -> Vector3<f64> {
        match self {
            Self::Right => Vector3::x(),
            Self::Left => -Vector3::x(),
            Self::Front => -Vector3::y(),
            Self::Back => Vector3::y(),
        }
    }
}

/// Returns an opening through the wall on one side, `width_mm` wide, between two distances from the axis and two
/// heights, mm.
pub fn wall_opening(
    side: HousingSide,
    width_mm: f64,
    [from, to]: [f64; 2],
    [bottom, top]: [f64; 2],
) -> Solid {
    let half = width_mm / 2.0;
    match side {
        HousingSide::Right => Solid::cuboid_between([from, -half, bottom], [to, half, top]),
        HousingSide::Left => Solid::cuboid_between([-to, -half, bottom], [-from, half, top]),
        HousingSide::Front => Solid::cuboid_between([-half, -to, bottom], [half, -from, top]),
        HousingSide::Back => Solid::cuboid_between([-half, from, bottom], [half, to, top]),
    }
}
