//! The camera as a design intends it.

use crate::lens::NominalLens;
use crate::{Angle, Pose};

/// The camera as the design intends it, before any calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct NominalCamera {
    /// Camera frame (+z forward, +x right, +y down) to sensor frame, mm.
    pub sensor_from_camera: Pose,
    /// Image width, px.
    pub width_px: u32,
    /// Image height, px.
    pub height_px: u32,
    /// Full angle of view over the image's diagonal, as makers of small cameras state it.
    pub field_of_view: Angle,
    /// How its lens lays angles onto the picture, and how well that is known.
    pub lens: NominalLens,
}

impl NominalCamera {
    /// Focal length, px: what a radian on the axis is long, so that the angle of view spans the diagonal.
    pub fn focal_px(&self) -> f64 {
        let half_px = f64::from(self.width_px).hypot(f64::from(self.height_px)) / 2.0;
        half_px / self.lens.projection.radius(self.field_of_view.rad() / 2.0)
    }
}
