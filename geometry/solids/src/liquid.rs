//! Soft skin with liquid channels; columns of liquid outside the touched area indicate how far each channel is
//! squeezed.

use crate::{Solid, TouchSurface};

/// Soft skin over a window, with liquid channels in it.
#[derive(Clone, Debug)]
pub struct LiquidSkin {
    /// Touched surface. It differs from [`crate::Sensor::touch`] because a skin on a box has no known outline that a
    /// fixture could go around.
    pub touch: TouchSurface,
    /// Width of the window along x and y, centred on the z axis, mm. The window's edge holds the skin; there is nothing
    /// below it.
    pub window_mm: [f64; 2],
    /// Heights of the material boundaries from the skin's underside to the touched surface, sensor frame, mm.
    pub levels_mm: Vec<f64>,
    /// Liquid channels.
    pub channels: Vec<LiquidChannel>,
}

/// Channel of a [`LiquidSkin`], and the column of liquid that it moves.
#[derive(Clone, Debug)]
pub struct LiquidChannel {
    /// Name in the drawing: `left 3`.
    pub name: String,
    /// Liquid in the channel, sensor frame, mm.
    pub liquid: Solid,
    /// Width, mm.
    pub width_mm: f64,
    /// Height, mm.
    pub height_mm: f64,
    /// Thickness of the skin above the channel, mm.
    pub cover_mm: f64,
    /// Cross-section of the column that the channel moves, mm2.
    pub column_mm2: f64,
    /// Length of that column at rest, mm: the limit to which it can be drawn back.
    pub column_mm: f64,
    /// Volume of air enclosed ahead of the column at rest, mm3.
    pub air_mm3: f64,
}
