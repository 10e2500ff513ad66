//! One ray for each pixel of a calibrated camera.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use fabkit_camera::{Camera, Interface, Point2};
use fabkit_geometry::{Point3, Pose, Ray, Vector3};
use fabkit_optics::{Bundles, End, LightPath, Sights, Stack, TILE, TileTracer};
use rayon::prelude::*;

use super::tiles::{Tile, tiles};
use super::transfer::Transfer;

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
    /// What each sees in a sensor's bodies; empty if it was not followed through them.
    seen_by: Vec<u8>,
    /// What the numbers in that mean.
    seen_by_names: Vec<String>,
    /// What bent them, if anything did but the camera's own interface.
    media: Option<Arc<Sights>>,
    /// How they change with the rays that leave the camera, once somebody asks.
    transfer: OnceLock<Arc<Transfer>>,
}

/// What a ray sees that has no direction or leaves the sensor, in [`PixelRays::seen_by`].
pub(super) const SEES_NOTHING: u8 = 0;
/// The sensing surface, in the same.
pub(super) const SEES_SURFACE: u8 = 1;
/// The first body.
const FIRST_BODY: u8 = 2;

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
            Interface::None | Interface::Drawn => {
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
            seen_by: Vec::new(),
            seen_by_names: Vec::new(),
            media: None,
            transfer: OnceLock::new(),
        };
        rays.tiles = tiles(&rays);
        rays
    }

    /// The same rays behind the media of a sensor: each starts where it was bent last, and those that do not
    /// reach the sensing surface know what they see instead.
    #[must_use]
    pub fn through(mut self, sights: &Arc<Sights>) -> Self {
        let stack = sights.stack();
        let width = self.width_px as usize;
        let pupil = self.camera_from_sensor.inverse().point(Point3::origin());
        let common = match &self.origins {
            Origins::Common(origin) => Some(*origin),
            Origins::Own(_) => None,
        };
        let mut origins = match self.origins {
            Origins::Own(origins) => origins,
            Origins::Common(origin) => vec![origin; self.directions.len()],
        };
        let mut seen_by = vec![SEES_NOTHING; self.directions.len()];
        let hiding = common.is_none().then_some(&pupil);
        follow_all(stack, width, &mut origins, &mut self.directions, &mut seen_by, hiding);
        self.origins = match common {
            Some(origin) if origins.iter().all(|own| *own == origin) => Origins::Common(origin),
            _ => Origins::Own(origins),
        };
        self.seen_by = seen_by;
        let words =
            |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let bodies = stack.names().iter().cloned();
        let names = words(&["nothing", "surface"]).into_iter().chain(bodies);
        self.seen_by_names = names.chain(words(&["total reflection"])).collect();
        self.media = sights.bends().then(|| Arc::clone(sights));
        self.transfer = OnceLock::new();
        self.tiles = tiles(&self);
        self
    }

    /// How they change with the rays that leave the camera; nothing where those go straight on.
    pub(super) fn transfer(&self) -> Option<&Transfer> {
        let media = self.media.as_ref()?;
        if self.transfer.get().is_none() {
            // Not within the lock: a thread that waits for its parts may take up other work, and ask for this again.
            let _ = self.transfer.set(Arc::new(Transfer::of(self, media)));
        }
        self.transfer.get().map(Arc::as_ref)
    }

    /// A pixel's ray as it leaves the camera, sensor frame; `None` where the lens does not reach.
    pub(super) fn leaving(&self, pixel: usize) -> Option<Ray> {
        let ray = self.camera.unproject(&self.at_px(pixel)).ok()?;
        let sensor_from_camera = self.camera_from_sensor.inverse();
        let origin = sensor_from_camera.point(ray.origin_in_camera);
        Some(Ray { origin, direction: sensor_from_camera.vector(ray.direction) })
    }

    /// Where a ray that leaves the camera is followed from.
    pub(super) fn entered(&self, leaving: &Ray) -> Ray {
        self.media.as_ref().map_or(*leaving, |media| media.stack().entered(leaving))
    }

    /// What each ray sees: an index into [`PixelRays::seen_by_names`], row by row; empty if the rays were
    /// not followed through a sensor's bodies.
    pub fn seen_by(&self) -> &[u8] {
        &self.seen_by
    }

    /// `nothing`, `surface`, then bodies, and `total reflection`.
    pub fn seen_by_names(&self) -> &[String] {
        &self.seen_by_names
    }

    /// The ray of a pixel that nothing keeps from the sensing surface, as far as that is known.
    #[inline]
    pub(super) fn free_ray(&self, pixel: usize) -> Option<Ray> {
        let is_free = self.seen_by.get(pixel).is_none_or(|by| *by == SEES_SURFACE);
        if is_free { self.ray(pixel) } else { None }
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

/// Follows rays, row by row, each as its origin and its direction, of which nothing is known yet; where they start behind an
/// interface of the camera's own, what hides that from the pupil ends them.
pub(super) fn follow_all(
    stack: &Stack,
    width: usize,
    origins: &mut [Point3<f64>],
    directions: &mut [Vector3<f64>],
    seen_by: &mut [u8],
    hiding: Option<&Point3<f64>>,
) {
    let bodies = stack.names().len() as u8;
    let bundles = Bundles::new(stack);
    // Strips as high as a tile: each belongs to one thread. Bands of rows begin where strips do, so that
    // bundles are the same in a band as in the whole.
    let strip = TILE as usize * width;
    let strips = origins.par_chunks_mut(strip).zip(directions.par_chunks_mut(strip));
    strips.zip(seen_by.par_chunks_mut(strip)).for_each_init(
        || bundles.tracer(),
        |tracer, ((origins, directions), seen_by)| {
            let mut strip = Strip { stack, width, origins, directions, seen_by, bodies };
            if let Some(pupil) = hiding {
                strip.look_for_what_hides(tracer, pupil);
            }
            strip.follow(tracer);
        },
    );
}

/// Rows of rays that one thread follows.
struct Strip<'a> {
    stack: &'a Stack,
    width: usize,
    origins: &'a mut [Point3<f64>],
    directions: &'a mut [Vector3<f64>],
    seen_by: &'a mut [u8],
    /// How many kinds of bodies there are.
    bodies: u8,
}

impl Strip<'_> {
    /// Follows all rays of which nothing is known yet to their ends.
    fn follow(&mut self, tracer: &mut TileTracer) {
        for columns in self.tiles() {
            let mut paths = Vec::new();
            let ray = |column: u32, row: u32| {
                let at = row as usize * self.width + column as usize;
                let (origin, direction) = (self.origins[at], self.directions[at]);
                let is_open = self.seen_by[at] == SEES_NOTHING && !direction.x.is_nan();
                is_open.then(|| self.stack.entered(&Ray { origin, direction }))
            };
            tracer.cast(columns, 0..self.rows(), &ray, &mut |column, row, path| {
                paths.push((row as usize * self.width + column as usize, path));
            });
            for (at, path) in paths {
                (self.origins[at], self.directions[at]) = (path.last.origin, path.last.direction);
                self.seen_by[at] = self.code(path.end);
            }
        }
    }

    /// Between the pupil and where rays start, for a camera with an interface of its own.
    fn look_for_what_hides(&mut self, tracer: &mut TileTracer, pupil: &Point3<f64>) {
        for columns in self.tiles() {
            let mut hidden = Vec::new();
            let ray = |column: u32, row: u32| {
                let to = self.origins[row as usize * self.width + column as usize] - pupil;
                Some(Ray { origin: *pupil, direction: to.try_normalize(0.0)? })
            };
            tracer.cast(columns, 0..self.rows(), &ray, &mut |column, row, path: LightPath| {
                let at = row as usize * self.width + column as usize;
                if path.lead_mm + path.end_mm < (self.origins[at] - pupil).norm() {
                    hidden.push((at, path.end));
                }
            });
            for (at, end) in hidden {
                self.seen_by[at] = self.code(end);
            }
        }
    }

    fn rows(&self) -> u32 {
        (self.seen_by.len() / self.width) as u32
    }

    fn tiles(&self) -> impl Iterator<Item = Range<u32>> + use<> {
        let width = self.width as u32;
        (0..width).step_by(TILE as usize).map(move |left| left..(left + TILE).min(width))
    }

    fn code(&self, end: End) -> u8 {
        match end {
            End::Nothing => SEES_NOTHING,
            End::Surface => SEES_SURFACE,
            End::Body(name) => FIRST_BODY + name,
            End::Mirror(_) => FIRST_BODY + self.bodies,
        }
    }
}

/// Of the i-th sample along a side. The middle of the first of n lies half a sample inside the
/// first pixel's edge.
fn middle(i: u32, samples: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(samples) - 0.5
}
