//! What several families are built from, each stated once.

mod joint;

use std::f64::consts::TAU;

use fabkit_geometry::{Angle, Color, Pose};

pub use joint::Joint;

/// Smallest gap between parts that must not touch, mm.
pub const APART_MM: f64 = 0.1;

/// Thinnest printed wall, mm: two lines of a 0.4 mm nozzle.
pub const PRINTED_WALL_MM: f64 = 0.8;

/// Steel, as pictures show it.
pub const STEEL: Color = [176, 180, 186];

/// Brass.
pub const BRASS: Color = [205, 170, 90];

/// The solder mask of a circuit board.
pub const MASK_GREEN: Color = [40, 120, 70];

/// Printed tools that are no molds.
pub const TOOL_GREY: Color = [180, 184, 190];

/// `index` out of `count` around the axis, from `offset` steps.
pub fn turn(index: u32, count: u32, offset: f64) -> Angle {
    let rad = TAU * (f64::from(index) + offset) / f64::from(count);
    Angle::from_rad(rad).expect("a fraction of a turn is finite")
}

/// `first` turned around the z axis to `count` places, from `offset` steps.
pub fn ring(count: u32, offset: f64, first: Pose) -> Vec<Pose> {
    (0..count).map(|i| Pose::rotation_z(turn(i, count, offset)).then_in(first)).collect()
}
