//! Parallel pins that align parts which are taken apart again.

use fabkit_geometry::{Order, Solid};

/// Parallel pin, ISO 2338: hole and pin have the same nominal diameter.
///
/// ```
/// use fabkit_designs::Dowel;
/// let dowel = Dowel { diameter_mm: 3.0, length_mm: 10.0 };
/// assert_eq!(dowel.order().article_and_size(), "dowel pin ISO 2338 3 x 10 mm");
/// // The standard has no pin of 9 mm: it has to be cut.
/// let made = Dowel { length_mm: 9.0, ..dowel };
/// assert_eq!(made.order().article, "steel pin");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dowel {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Length, mm.
    pub length_mm: f64,
}

/// Table of ISO 2338: diameter, shortest and longest pin, mm.
const DOWELS: [[f64; 3]; 10] = [
    [1.0, 4.0, 10.0],
    [1.2, 4.0, 12.0],
    [1.5, 4.0, 16.0],
    [2.0, 6.0, 20.0],
    [2.5, 6.0, 24.0],
    [3.0, 8.0, 30.0],
    [4.0, 8.0, 40.0],
    [5.0, 10.0, 50.0],
    [6.0, 12.0, 60.0],
    [8.0, 14.0, 80.0],
];
/// Lengths up to 40 mm of ISO 2338, mm.
const DOWEL_LENGTHS_MM: [f64; 17] = [
    4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0, 26.0, 28.0, 30.0, 35.0,
    40.0,
];

impl Dowel {
    /// Returns whether the standard lists the pin.
    fn is_stocked(&self) -> bool {
        let Self { diameter_mm, length_mm } = *self;
        DOWELS.iter().any(|[diameter, shortest, longest]| {
            *diameter == diameter_mm && (*shortest..=*longest).contains(&length_mm)
        }) && DOWEL_LENGTHS_MM.contains(&length_mm)
    }

    /// Returns the order for a shop: a pin of the standard, or steel to be cut where the standard has none.
    pub fn order(&self) -> Order {
        let article = if self.is_stocked() { "dowel pin ISO 2338" } else { "steel pin" };
        Order::new(article, format!("{} x {} mm", self.diameter_mm, self.length_mm))
    }

    /// Returns the specification as text.
    pub fn specification(&self) -> String {
        let Self { diameter_mm, length_mm } = *self;
        if self.is_stocked() {
            format!("dowel pin ISO 2338, {diameter_mm} x {length_mm} mm")
        } else {
            format!("steel pin, {diameter_mm} x {length_mm} mm, to be made: no size of ISO 2338")
        }
    }

    /// Returns the solid of the pin, its middle at z = 0.
    pub fn solid(&self) -> Solid {
        let Self { diameter_mm, length_mm } = *self;
        Solid::cylinder(diameter_mm / 2.0, length_mm).at_z(-length_mm / 2.0)
    }
}
