//! A soft skin with channels of liquid in it, which columns of liquid elsewhere tell how far they are squeezed.

use crate::{Solid, TouchSurface};

/// A soft skin over a window, with channels of liquid in it.
#[derive(Clone, Debug)]
pub struct LiquidSkin {
    /// What is touched. Not a [`crate::Sensor::touch`]: nothing that a fixture could go around is known of a skin
    /// on a box.
    pub touch: TouchSurface,
    /// Width of the window along x and y, mm, about the z axis: its edge holds the skin, nothing is below it.
    pub window_mm: [f64; 2],
    /// Heights at which what it consists of changes, from its underside to what is touched, sensor frame, mm.
    pub levels_mm: Vec<f64>,
    /// Its channels.
    pub channels: Vec<LiquidChannel>,
}

/// A channel of a [`LiquidSkin`], and the column of liquid that it moves.
#[derive(Clone, Debug)]
pub struct LiquidChannel {
    /// As the drawing calls it: `left 3`.
    pub name: String,
    /// The liquid in it, sensor frame, mm.
    pub liquid: Solid,
    /// Across it, mm.
    pub width_mm: f64,
    /// Its height, mm.
    pub height_mm: f64,
    /// Thickness of what covers it, mm.
    pub cover_mm: f64,
    /// Cross-section of the column that it moves, mm2.
    pub column_mm2: f64,
    /// Length of that column at rest, mm: so far it can be drawn back.
    pub column_mm: f64,
    /// Air that is shut in ahead of the column at rest, mm3.
    pub air_mm3: f64,
}
