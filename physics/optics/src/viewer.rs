//! A camera that looks through a sensor's bodies: from pixels to paths, and from places to pixels.

use fabkit_camera::{Camera, Interface, OutsideDomain, Point2};
use fabkit_geometry::{Point3, Pose, Ray};
use nalgebra::Matrix2x3;

use crate::inverse::{Seeker, Sight, Sights};
use crate::trace::{Bend, LightPath, Tracer};

/// A camera at its place; one per thread.
#[derive(Debug)]
pub struct Viewer<'a> {
    camera: Camera,
    sensor_from_camera: Pose,
    camera_from_sensor: Pose,
    seeker: Seeker<'a>,
    tracer: Tracer<'a>,
}

/// Why a place has no pixel.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unseen {
    /// No ray leads there: light from there is totally reflected, or bent past the pupil.
    #[error("no light from ({:.3}, {:.3}, {:.3}) mm reaches the pupil", .place_in_sensor.x, .place_in_sensor.y, .place_in_sensor.z)]
    NoLight {
        /// Sensor frame, mm.
        place_in_sensor: Point3<f64>,
    },
    /// The ray from there meets the lens where that maps nothing.
    #[error(transparent)]
    Lens(#[from] OutsideDomain),
}

/// Where a place appears.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Column and row, px; it may lie beside the picture, see [`Camera::sees`].
    pub pixel: Point2<f64>,
    /// The ray that leads there, and what is in its way.
    pub sight: Sight,
}

impl<'a> Viewer<'a> {
    /// A camera at its place among bodies: its lens alone, since the bodies are what bends its rays.
    pub fn new(camera: &Camera, sensor_from_camera: &Pose, sights: &'a Sights) -> Self {
        debug_assert!(
            matches!(camera.interface(), Interface::None | Interface::Drawn),
            "light would be bent twice"
        );
        Self {
            camera: *camera,
            sensor_from_camera: *sensor_from_camera,
            camera_from_sensor: sensor_from_camera.inverse(),
            seeker: sights.seeker(),
            tracer: Tracer::new(sights.stack()),
        }
    }

    /// Its lens.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The pupil, sensor frame, mm.
    pub fn pupil(&self) -> Point3<f64> {
        self.sensor_from_camera.point(Point3::origin())
    }

    /// The path of a pixel's ray to what it sees.
    ///
    /// # Errors
    /// A pixel that the lens does not reach.
    pub fn path(&mut self, pixel: &Point2<f64>) -> Result<LightPath, OutsideDomain> {
        let direction = self.camera.unproject(pixel)?.direction;
        let ray =
            Ray { origin: self.pupil(), direction: self.sensor_from_camera.vector(direction) };
        Ok(self.tracer.follow(&ray))
    }

    /// Where the last pixel's ray began and was bent, sensor frame, mm.
    pub fn corners(&self) -> &[Point3<f64>] {
        self.tracer.corners()
    }

    /// Where and how the last pixel's ray was bent, sensor frame.
    pub fn bends(&self) -> &[Bend] {
        self.tracer.bends()
    }

    /// The pixel at which a place is seen, or would be if nothing opaque hid it.
    ///
    /// # Errors
    /// [`Unseen`].
    pub fn look_at(&mut self, place_in_sensor: &Point3<f64>) -> Result<Look, Unseen> {
        let sight = self.seeker.seek(&self.pupil(), place_in_sensor);
        let sight = sight.ok_or(Unseen::NoLight { place_in_sensor: *place_in_sensor })?;
        let direction = self.camera_from_sensor.vector(sight.direction);
        Ok(Look { pixel: self.camera.project(&Point3::from(direction))?, sight })
    }

    /// All pixels at which a place is seen, or would be if nothing opaque hid it, by the length of the way
    /// there: see [`Seeker::every`]. Empty where no light leads from there to the pupil; rays that the lens
    /// does not map are left out.
    pub fn looks_at(&mut self, place_in_sensor: &Point3<f64>) -> Vec<Look> {
        let sights = self.seeker.every(&self.pupil(), place_in_sensor);
        let looks = sights.into_iter().filter_map(|sight| {
            let direction = self.camera_from_sensor.vector(sight.direction);
            Some(Look { pixel: self.camera.project(&Point3::from(direction)).ok()?, sight })
        });
        looks.collect()
    }

    /// Change of the pixel with the place, px per mm along the sensor's axes; `None` where the lens has no
    /// derivative, or a caustic lies.
    pub fn by_place(
        &mut self,
        place_in_sensor: &Point3<f64>,
        look: &Look,
    ) -> Option<Matrix2x3<f64>> {
        let direction = self.camera_from_sensor.vector(look.sight.direction);
        let lens = self.camera.project_with_jacobians(&Point3::from(direction)).ok()?;
        let by_place = self.seeker.by_place(&self.pupil(), place_in_sensor, &look.sight)?;
        let across = self.camera_from_sensor.rotation() * Sight::across(&look.sight.direction);
        Some(lens.by_point * across * by_place)
    }

    /// The straight pieces of the way to a place that was looked at, sensor frame, mm, from the pupil on.
    pub fn way(&mut self, place_in_sensor: &Point3<f64>, look: &Look) -> Vec<Point3<f64>> {
        self.seeker.way(&self.pupil(), place_in_sensor, &look.sight)
    }
}
