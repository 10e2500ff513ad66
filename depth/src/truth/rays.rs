//! One ray for each pixel of a calibrated camera.

use fabkit_camera::{Camera, Point2};
use fabkit_geometry::{Point3, Pose, Ray};
use rayon::prelude::*;

/// The rays of all pixels in the sensor frame, computed once and used for every press.
#[derive(Clone, Debug)]
pub struct PixelRays {
    width_px: u32,
    height_px: u32,
    camera: Camera,
    /// Rays along each side of a pixel.
    samples: u32,
    /// Row by row; `None` where the lens does not reach.
    rays: Vec<Option<Ray>>,
    camera_from_sensor: Pose,
}

impl PixelRays {
    /// The rays through the centres of all pixels.
    pub fn new(camera: &Camera, sensor_from_camera: &Pose) -> Self {
        Self::with_samples(camera, sensor_from_camera, 1)
    }

    /// The rays of an image whose pixels are split into `samples` x `samples`: `samples` times as
    /// wide and as high.
    pub fn with_samples(camera: &Camera, sensor_from_camera: &Pose, samples: u32) -> Self {
        let samples = samples.max(1);
        let (width_px, height_px) = (camera.width_px() * samples, camera.height_px() * samples);
        let ray = |column: u32, row: u32| {
            let at_px = Point2::new(middle(column, samples), middle(row, samples));
            let ray = camera.unproject(&at_px).ok()?;
            Some(Ray {
                origin: sensor_from_camera.point(ray.origin_in_camera),
                direction: sensor_from_camera.vector(ray.direction),
            })
        };
        let row = |row: u32| (0..width_px).map(move |column| ray(column, row));
        let rays = (0..height_px).into_par_iter().flat_map_iter(row).collect();
        let (camera, camera_from_sensor) = (*camera, sensor_from_camera.inverse());
        Self { width_px, height_px, camera, samples, rays, camera_from_sensor }
    }

    /// Columns.
    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    /// Rows.
    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// How many there are, those outside the lens included.
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    /// Whether there are none; a camera has at least one pixel.
    pub fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// The camera whose rays these are.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Sensor frame to camera frame, mm.
    pub fn camera_from_sensor(&self) -> &Pose {
        &self.camera_from_sensor
    }

    /// Where in the camera's image a ray starts, column and row, px; by its place in the list.
    pub fn at_px(&self, pixel: usize) -> Point2<f64> {
        let (column, row) = (pixel as u32 % self.width_px, pixel as u32 / self.width_px);
        Point2::new(middle(column, self.samples), middle(row, self.samples))
    }

    /// The ray of a pixel by its place in the list: `row * width + column`.
    #[inline]
    pub fn ray(&self, pixel: usize) -> Option<&Ray> {
        self.rays[pixel].as_ref()
    }

    /// The third coordinate in the camera frame of a point in the sensor frame, mm.
    #[inline]
    pub fn z_mm(&self, point_in_sensor: &Point3<f64>) -> f64 {
        self.camera_from_sensor.point(*point_in_sensor).z
    }
}

/// Of the i-th sample along a side. The middle of the first of n lies half a sample inside the
/// first pixel's edge.
fn middle(i: u32, samples: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(samples) - 0.5
}
