//! How wide lines are drawn.

use super::view::View;

/// A refined pixel is looked at with the square of this many rays.
pub(super) const SUBSAMPLES: i32 = 4;

/// How wide lines are, in subsamples beyond the two right beside a break.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen {
    pub(super) outline_reach: f64,
    pub(super) crease_reach: f64,
}

impl Pen {
    /// Outlines of about 1.3 px, creases of 1 px; wider in pictures above 600 px, up to three
    /// times.
    pub fn of(view: &View) -> Self {
        let scale = (f64::from(view.width_px.min(view.height_px)) / 600.0).clamp(1.0, 3.0);
        Self { outline_reach: 2.24 * scale, crease_reach: scale }
    }

    /// Pixels around a tile in which lines may reach into it: whole pixels, and more than the
    /// reach, so that a line's neighbours are known too.
    pub(super) fn margin_px(&self) -> i32 {
        self.outline_reach as i32 / SUBSAMPLES + 1
    }
}
