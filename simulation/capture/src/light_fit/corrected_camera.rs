//! Projection of surface points to pixels in a unit's captures.

use fabkit_calibration::model::{Model, Observation};
use fabkit_camera::Point2;
use fabkit_geometry::{Point3, TouchSurface};
use fabkit_light::linear_fit;

/// Unit of radii in the fit, px: it keeps numbers near one.
const UNIT_PX: f64 = 100.0;

/// A camera model with corrections fitted to marks: a shift, and terms along the radius from the tip's pixel.
///
/// The model does not refract light at the sensor's bodies and misses marks by several pixels, more towards the rim,
/// where the radial scale would be wrong by a third. The marks determine the corrections well enough to measure
/// lengths.
#[derive(Clone, Copy, Debug)]
pub(super) struct CorrectedCamera<'a> {
    model: &'a Model,
    tip: Point2<f64>,
    /// Shift along x and y, and relative radial corrections by the powers 0, 2 and 4 of the radius.
    terms: [f64; 5],
}

impl<'a> CorrectedCamera<'a> {
    /// Fits the corrections to all marks of known holes; `None` if they do not suffice.
    pub(super) fn fit(
        model: &'a Model,
        touch: &TouchSurface,
        tip: &Point3<f64>,
        observations: &[Observation],
    ) -> Option<Self> {
        let plain = Self { model, tip: Point2::origin(), terms: [0.0; 5] };
        let tip = plain.project(tip)?;
        let (mut rows, mut wanted) = (Vec::new(), Vec::new());
        for observation in observations {
            let contact = observation.contact.contact_in_sensor_mm;
            let (depth_mm, outward) = touch.depth_mm(&contact);
            let Some(pixel) = plain.project(&(contact + depth_mm * outward)) else { continue };
            let (out, off) = (pixel - tip, observation.pixel - pixel);
            let square = out.norm_squared() / (UNIT_PX * UNIT_PX);
            for (axis, share) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                let powers = [1.0, square, square * square].map(|power| power * out[axis]);
                rows.push([share[0], share[1], powers[0], powers[1], powers[2]]);
                wanted.push(off[axis]);
            }
        }
        Some(Self { model, tip, terms: linear_fit(&rows, &wanted)? })
    }

    /// Returns the pixel of a surface point; `None` where the model maps none.
    pub(super) fn project(&self, place: &Point3<f64>) -> Option<Point2<f64>> {
        let in_camera = self.model.camera_from_sensor.point(*place);
        let pixel = self.model.camera.project(&in_camera).ok()?;
        let out = pixel - self.tip;
        let square = out.norm_squared() / (UNIT_PX * UNIT_PX);
        let [x, y, first, second, third] = self.terms;
        let radial = first + square * (second + square * third);
        Some(Point2::new(pixel.x + x + radial * out.x, pixel.y + y + radial * out.y))
    }
}
