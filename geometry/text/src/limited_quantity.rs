//! Numbers with units for which limits can be stated.

use std::fmt::Display;

use fabkit_geometry::{Angle, Length};

/// Number with a unit for which limits can be stated.
pub trait LimitedQuantity: Copy + Display {
    /// Text behind the number, such as ` mm`.
    const UNIT: &'static str;
    /// Steps per unit: recommended values are whole multiples of 1 / `STEPS_PER_UNIT`.
    const STEPS_PER_UNIT: f64;

    /// Returns the number in that unit.
    fn value(self) -> f64;
}

impl LimitedQuantity for Length {
    const UNIT: &'static str = " mm";
    const STEPS_PER_UNIT: f64 = 1e3;

    fn value(self) -> f64 {
        self.mm()
    }
}

impl LimitedQuantity for Angle {
    const UNIT: &'static str = " deg";
    const STEPS_PER_UNIT: f64 = 10.0;

    fn value(self) -> f64 {
        self.deg()
    }
}

impl LimitedQuantity for u32 {
    const UNIT: &'static str = "";
    const STEPS_PER_UNIT: f64 = 1.0;

    fn value(self) -> f64 {
        self.into()
    }
}

impl LimitedQuantity for f64 {
    const UNIT: &'static str = "";
    const STEPS_PER_UNIT: f64 = 1e3;

    fn value(self) -> f64 {
        self
    }
}
