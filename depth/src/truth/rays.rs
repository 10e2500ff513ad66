//! One ray for each pixel of a calibrated camera.

use std::ops::Range;

use fabkit_camera::{Camera, Interface, Point2};
use fabkit_geometry::{Point3, Pose, Ray, Vector3};
use rayon::prelude::*;

use super::tiles::{Tile, tiles};

/// The rays of all pixels in the sensor frame, computed once and used for every press.
#[derive(Clone, Debug)]
pub struct PixelRays {
    width_px: u32,
    height_px: u32,
    /// The first row's place in the image.
    top: u32,
    camera: Camera,
    /// Rays along each side of a pixel.
    samples: u32,
    /// Unit, row by row; NaN where the lens does not reach.
    directions: Vec<Vector3<f64>>,
    origins: Origins,
    camera_from_sensor: Pose,
    tiles: Vec<Tile>,
}

/// Where rays start, sensor frame. Most cameras have one centre; reading it for each ray again
/// would take longer than casting the ray.
#[derive(Clone, Debug)]
enum Origins {
    Common(Point3<f64>),
    /// Behind an interface each ray leaves it at its own place.
    Own(Vec<Point3<f64>>),
}

impl PixelRays {
    /// The rays through the centres of all pixels.
    pub fn new(camera: &Camera, sensor_from_camera: &Pose) -> Self {
        Self::with_samples(camera, sensor_from_camera, 1)
    }

    /// The rays of an image whose pixels are split into `samples` x `samples`: `samples` times as
    /// wide and as high.
    pub fn with_samples(camera: &Camera, sensor_from_camera: &Pose, samples: u32) -> Self {
        Self::of_rows(camera, sensor_from_camera, samples, 0..camera.height_px() * samples.max(1))
    }

    /// Some rows of [`PixelRays::with_samples`]: an image as high as there are rows, each ray the same
    /// as in the whole. What needs too much memory at once is cast in pieces. Rows below the image are
    /// left out.
    pub fn of_rows(
        camera: &Camera,
        sensor_from_camera: &Pose,
        samples: u32,
        rows: Range<u32>,
    ) -> Self {
        let samples = samples.max(1);
        let width_px = camera.width_px() * samples;
        let top = rows.start;
        let height_px = rows.end.min(camera.height_px() * samples).saturating_sub(top);
        let ray = |pixel: usize| {
            let (column, row) = (pixel as u32 % width_px, top + pixel as u32 / width_px);
            let at_px = Point2::new(middle(column, samples), middle(row, samples));
            let Ok(ray) = camera.unproject(&at_px) else {
                return (Point3::origin(), Vector3::repeat(f64::NAN));
            };
            let origin = sensor_from_camera.point(ray.origin_in_camera);
            (origin, sensor_from_camera.vector(ray.direction))
        };
        let pixels = (0..width_px as usize * height_px as usize).into_par_iter();
        let (origins, directions) = match camera.interface() {
            Interface::None => {
                let centre = sensor_from_camera.point(Point3::origin());
                (Origins::Common(centre), pixels.map(|pixel| ray(pixel).1).collect())
            }
            _ => {
                let (origins, directions) = pixels.map(ray).unzip();
                (Origins::Own(origins), directions)
            }
        };
        let mut rays = Self {
            width_px,
            height_px,
            top,
            camera: *camera,
            samples,
            directions,
            origins,
            camera_from_sensor: sensor_from_camera.inverse(),
            tiles: Vec::new(),
        };
        rays.tiles = tiles(&rays);
        rays
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
        self.directions.len()
    }

    /// Whether there are none; a whole image has at least one pixel.
    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
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
        let row = self.top + row;
        Point2::new(middle(column, self.samples), middle(row, self.samples))
    }

    /// The ray of a pixel by its place in the list, `row * width + column`; `None` where the lens
    /// does not reach.
    #[inline]
    pub fn ray(&self, pixel: usize) -> Option<Ray> {
        let direction = self.directions[pixel];
        let origin = match &self.origins {
            Origins::Common(origin) => *origin,
            Origins::Own(origins) => origins[pixel],
        };
        (!direction.x.is_nan()).then_some(Ray { origin, direction })
    }

    /// The third coordinate in the camera frame of a point in the sensor frame, mm.
    #[inline]
    pub fn z_mm(&self, point_in_sensor: &Point3<f64>) -> f64 {
        self.camera_from_sensor.point(*point_in_sensor).z
    }

    /// Neighbouring rays together.
    pub(super) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }
}

/// Of the i-th sample along a side. The middle of the first of n lies half a sample inside the
/// first pixel's edge.
fn middle(i: u32, samples: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(samples) - 0.5
}
