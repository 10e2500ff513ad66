//! One ray for each pixel of a calibrated camera.

use fabkit_camera::{Camera, Point2};
use fabkit_geometry::{Point3, Pose, Ray};
use rayon::prelude::*;

/// The rays of all pixels in the sensor frame, computed once and used for every press.
#[derive(Clone, Debug)]
pub struct PixelRays {
    width_px: u32,
    height_px: u32,
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
        // The middle of the first of n samples lies half a sample inside the pixel's edge.
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(samples) - 0.5;
        let ray = |column: u32, row: u32| {
            let ray = camera.unproject(&Point2::new(at(column), at(row))).ok()?;
            Some(Ray {
                origin: sensor_from_camera.point(ray.origin_in_camera),
                direction: sensor_from_camera.vector(ray.direction),
            })
        };
        let row = |row: u32| (0..width_px).map(move |column| ray(column, row));
        let rays = (0..height_px).into_par_iter().flat_map_iter(row).collect();
        Self { width_px, height_px, rays, camera_from_sensor: sensor_from_camera.inverse() }
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
