//! Nominal camera of a design.

use crate::lens::NominalLens;
use crate::{Angle, Pose};

/// Nominal camera of a design, before any calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct NominalCamera {
    /// Pose of the camera frame (+z forward, +x right, +y down) in the sensor frame, mm.
    pub sensor_from_camera: Pose,
    /// Image width, px.
    pub width_px: u32,
    /// Image height, px.
    pub height_px: u32,
    /// Full angle of view across the image diagonal, as manufacturers of small cameras state it.
    pub field_of_view: Angle,
    /// Nominal lens: projection law and tolerances.
    pub lens: NominalLens,
}

impl NominalCamera {
    /// Computes the focal length, px, such that the angle of view spans the image diagonal.
    ///
    /// ```
    /// use fabkit_geometry::{Angle, NominalCamera, NominalLens, Pose};
    /// let camera = NominalCamera {
    ///     sensor_from_camera: Pose::identity(),
    ///     width_px: 640,
    ///     height_px: 480,
    ///     field_of_view: Angle::from_deg(160.0).unwrap(),
    ///     lens: NominalLens::default(), // equidistant: r = f a
    /// };
    /// // Half the diagonal is 400 px and lies 80 degrees off the axis.
    /// assert!((camera.focal_px() - 400.0 / 80f64.to_radians()).abs() < 1e-9);
    /// ```
    pub fn focal_px(&self) -> f64 {
        let half_px = f64::from(self.width_px).hypot(f64::from(self.height_px)) / 2.0;
        half_px / self.lens.projection.radius(self.field_of_view.rad() / 2.0)
    }
}
