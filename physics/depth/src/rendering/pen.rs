//! Widths of lines.

use super::view::View;

/// Number of rays along each side of a refined pixel.
pub(super) const SUBSAMPLES: i32 = 4;

/// Widths of lines, in subsamples beyond the two beside a discontinuity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen {
    pub(super) outline_reach: f64,
    pub(super) crease_reach: f64,
}

impl Pen {
    /// Chooses outlines of about 1.3 px and creases of 1 px; wider in images above 600 px, up to three times.
    pub fn from_view(view: &View) -> Self {
        let scale = (f64::from(view.width_px.min(view.height_px)) / 600.0).clamp(1.0, 3.0);
        Self { outline_reach: 2.24 * scale, crease_reach: scale }
    }

    /// Number of pixels around a tile from which lines may reach into it. It exceeds the reach, so that a line's
    /// neighbours are known too.
    pub(super) fn margin_px(&self) -> i32 {
        self.outline_reach as i32 / SUBSAMPLES + 1
    }
}
