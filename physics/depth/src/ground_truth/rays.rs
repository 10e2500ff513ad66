//! One ray for each pixel of a calibrated camera.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use fabkit_camera::{Camera, Interface, Point2};
use fabkit_geometry::{Point3, Pose, Ray, Vector3};
use fabkit_optics::{LightPath, OpticalStack, RayEnd, TILE, TileTracer, TileTracing, ViewStacks};
use rayon::prelude::*;

use super::tiles::{Tile, tiles};
use super::transfer::Transfer;

/// Rays of all pixels in the sensor frame, computed once and used for every press.
///
/// ```
/// use fabkit_camera::Camera;
/// use fabkit_depth::ground_truth::PixelRays;
/// use fabkit_geometry::{Point3, Pose, Vector3};
///
/// // 61 x 61 pixels, from 5 mm below the sensor's origin straight up. Pixels are counted row by row.
/// let camera = Camera::equidistant(61, 61, 2.0)?;
/// let rays = PixelRays::new(&camera, &Pose::translation(0.0, 0.0, -5.0));
/// let middle = rays.ray(30 * 61 + 30).unwrap();
/// assert_eq!(middle.origin, Point3::new(0.0, 0.0, -5.0));
/// assert!((middle.direction - Vector3::z()).norm() < 1e-12);
/// // z in the camera frame is no range: it is the same for all points of a plane across the optical axis.
/// assert_eq!(rays.z_mm(&Point3::new(7.0, 0.0, 0.0)), 5.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PixelRays {
    width_px: u32,
    height_px: u32,
    /// Row of the image that the first row of rays belongs to.
    top: u32,
    camera: Camera,
    /// Number of rays along each side of a pixel.
    samples: u32,
    /// Unit directions, row by row; NaN outside the lens.
    directions: Vec<Vector3<f64>>,
    origins: Origins,
    camera_from_sensor: Pose,
    tiles: Vec<Tile>,
    /// Code of what each ray sees in the sensor's bodies; empty if the rays were not traced through them.
    seen_by: Vec<u8>,
    /// Names of these codes.
    seen_by_names: Vec<String>,
    /// Media that refract the rays, if anything but the camera's own interface does.
    media: Option<Arc<ViewStacks>>,
    /// Derivatives by the rays that leave the camera, computed on first use.
    transfer: OnceLock<Arc<Transfer>>,
}

/// Code in [`PixelRays::seen_by`] of a ray without direction, or one that leaves the sensor.
pub(super) const SEES_NOTHING: u8 = 0;
/// Code of the sensing surface.
pub(super) const SEES_SURFACE: u8 = 1;
/// Code of the first body.
const FIRST_BODY: u8 = 2;

/// Origins of the rays, sensor frame. Most cameras have a single centre; loading an origin for each ray would take
/// longer than casting the ray.
#[derive(Clone, Debug)]
enum Origins {
    Common(Point3<f64>),
    /// One origin per ray: behind an interface each leaves it at its own point.
    Individual(Vec<Point3<f64>>),
}

impl PixelRays {
    /// Creates the rays through the centres of all pixels.
    pub fn new(camera: &Camera, sensor_from_camera: &Pose) -> Self {
        Self::with_samples(camera, sensor_from_camera, 1)
    }

    /// Creates the rays of an image whose pixels are split into `samples` x `samples`: `samples` times as wide and as
    /// high.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Point2};
    /// use fabkit_depth::ground_truth::PixelRays;
    /// use fabkit_geometry::Pose;
    ///
    /// // Two rays across each pixel, a quarter of it from its centre.
    /// let rays = PixelRays::with_samples(&Camera::equidistant(64, 48, 2.0)?, &Pose::identity(), 2);
    /// assert_eq!((rays.width_px(), rays.height_px()), (128, 96));
    /// assert_eq!((rays.at_px(0), rays.at_px(1)), (Point2::new(-0.25, -0.25), Point2::new(0.25, -0.25)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_samples(camera: &Camera, sensor_from_camera: &Pose, samples: u32) -> Self {
        Self::from_rows(camera, sensor_from_camera, samples, 0..camera.height_px() * samples.max(1))
    }

    /// Creates some rows of [`PixelRays::with_samples`]: an image as high as there are rows, each ray the same as in
    /// the whole. It serves to work in pieces where the whole needs too much memory. Rows below the image are left out.
    ///
    /// ```
    /// use fabkit_camera::Camera;
    /// use fabkit_depth::ground_truth::PixelRays;
    /// use fabkit_geometry::Pose;
    ///
    /// // Rows 10 to 19 of an image of 64 x 48: their first ray is that of the whole image's row 10.
    /// let (camera, pose) = (Camera::equidistant(64, 48, 2.0)?, Pose::identity());
    /// let (whole, rows) = (PixelRays::new(&camera, &pose), PixelRays::from_rows(&camera, &pose, 1, 10..20));
    /// assert_eq!(rows.height_px(), 10);
    /// assert_eq!(rows.ray(0).unwrap().direction, whole.ray(10 * 64).unwrap().direction);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_rows(
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
        // Only an interface of the camera's own gives each ray its own origin.
        let (origins, directions) = match camera.interface() {
            Interface::None | Interface::FromDrawing => {
                let centre = sensor_from_camera.point(Point3::origin());
                (Origins::Common(centre), pixels.map(|pixel| ray(pixel).1).collect())
            }
            _ => {
                let (origins, directions) = pixels.map(ray).unzip();
                (Origins::Individual(origins), directions)
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

    /// Traces the rays through the media of a sensor. Each then starts at its last refraction, and rays that miss the
    /// sensing surface record what they see instead.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, NominalCamera, Placement, Pose, Sensor, Solid};
    /// # let nominal = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 60, height_px: 60,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_camera::Camera;
    /// use fabkit_depth::ground_truth::PixelRays;
    /// use fabkit_optics::{OpticalStack, ViewStacks};
    ///
    /// // An opaque disc of radius 2 mm, 10 mm before the camera, hides what is behind it.
    /// let disc = Body::bought("disc", "steel", Solid::cylinder(2.0, 1.0).at_z(10.0))
    ///     .placed([Placement::in_place(Assembly::sensor())]);
    /// let stack = OpticalStack::from_sensor(&Sensor::new("box", "A box", "", nominal, [disc]))?;
    /// let rays = PixelRays::new(&Camera::equidistant(60, 60, 2.0)?, &Pose::identity());
    /// let rays = rays.traced_through(&ViewStacks::new(stack).into());
    /// let seen_at = |pixel: usize| &rays.seen_by_names()[usize::from(rays.seen_by()[pixel])];
    /// assert_eq!([seen_at(30 * 60 + 30), seen_at(0)], ["disc", "nothing"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn traced_through(mut self, sights: &Arc<ViewStacks>) -> Self {
        let stack = sights.stack();
        let width = self.width_px as usize;
        let pupil = self.camera_from_sensor.inverse().point(Point3::origin());
        let common = match &self.origins {
            Origins::Common(origin) => Some(*origin),
            Origins::Individual(_) => None,
        };
        let mut origins = match self.origins {
            Origins::Individual(origins) => origins,
            Origins::Common(origin) => vec![origin; self.directions.len()],
        };
        let mut seen_by = vec![SEES_NOTHING; self.directions.len()];
        // A camera with an interface of its own starts its rays there; what lies before it can still hide them.
        let hiding = common.is_none().then_some(&pupil);
        trace_all(stack, width, &mut origins, &mut self.directions, &mut seen_by, hiding);
        // Nothing was refracted: keep the single origin.
        self.origins = match common {
            Some(origin) if origins.iter().all(|own| *own == origin) => Origins::Common(origin),
            _ => Origins::Individual(origins),
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

    /// Returns the derivatives of the rays by those that leave the camera; `None` if nothing refracts them.
    pub(super) fn transfer(&self) -> Option<&Transfer> {
        let media = self.media.as_ref()?;
        if self.transfer.get().is_none() {
            // Not computed inside the lock's initialiser: a thread that waits for its parallel parts may take up other
            // work, and call this again.
            let _ = self.transfer.set(Arc::new(Transfer::compute(self, media)));
        }
        self.transfer.get().map(Arc::as_ref)
    }

    /// Returns a pixel's ray as it leaves the camera, sensor frame; `None` outside the lens.
    pub(super) fn camera_ray(&self, pixel: usize) -> Option<Ray> {
        let ray = self.camera.unproject(&self.at_px(pixel)).ok()?;
        let sensor_from_camera = self.camera_from_sensor.inverse();
        let origin = sensor_from_camera.point(ray.origin_in_camera);
        Some(Ray { origin, direction: sensor_from_camera.vector(ray.direction) })
    }

    /// Returns the ray from which a ray that leaves the camera is traced.
    pub(super) fn traced_start(&self, leaving: &Ray) -> Ray {
        self.media.as_ref().map_or(*leaving, |media| media.stack().enter(leaving))
    }

    /// Code of what each ray sees, an index into [`PixelRays::seen_by_names`], row by row; empty if the rays were not
    /// traced through a sensor's bodies.
    pub fn seen_by(&self) -> &[u8] {
        &self.seen_by
    }

    /// Names of the codes: `nothing`, `surface`, then the bodies, and `total reflection`.
    pub fn seen_by_names(&self) -> &[String] {
        &self.seen_by_names
    }

    /// Returns the ray of a pixel unless it is known not to reach the sensing surface.
    #[inline]
    pub(super) fn free_ray(&self, pixel: usize) -> Option<Ray> {
        let is_free = self.seen_by.get(pixel).is_none_or(|by| *by == SEES_SURFACE);
        if is_free { self.ray(pixel) } else { None }
    }

    /// Number of columns.
    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    /// Number of rows.
    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// Number of rays, including those outside the lens.
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// Returns whether there are no rays; a whole image has at least one.
    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
    }

    /// Returns the camera of these rays.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Transform from the sensor frame to the camera frame, mm.
    pub fn camera_from_sensor(&self) -> &Pose {
        &self.camera_from_sensor
    }

    /// Returns the position in the camera's image, column and row, px, of a ray by its index.
    pub fn at_px(&self, pixel: usize) -> Point2<f64> {
        let (column, row) = (pixel as u32 % self.width_px, pixel as u32 / self.width_px);
        let row = self.top + row;
        Point2::new(middle(column, self.samples), middle(row, self.samples))
    }

    /// Returns the ray of a pixel by its index `row * width + column`; `None` outside the lens.
    #[inline]
    pub fn ray(&self, pixel: usize) -> Option<Ray> {
        let direction = self.directions[pixel];
        let origin = match &self.origins {
            Origins::Common(origin) => *origin,
            Origins::Individual(origins) => origins[pixel],
        };
        (!direction.x.is_nan()).then_some(Ray { origin, direction })
    }

    /// Third coordinate in the camera frame of a point in the sensor frame, mm.
    #[inline]
    pub fn z_mm(&self, point_in_sensor: &Point3<f64>) -> f64 {
        self.camera_from_sensor.point(*point_in_sensor).z
    }

    /// Tiles of neighbouring rays.
    pub(super) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }
}

/// Traces rays to their ends, row by row, where `seen_by` has no code yet, and replaces origins and directions by those
/// of the last segments. If the rays start at an interface of the camera, `hiding` is the pupil: bodies between pupil
/// and interface end the rays.
pub(super) fn trace_all(
    stack: &OpticalStack,
    width: usize,
    origins: &mut [Point3<f64>],
    directions: &mut [Vector3<f64>],
    seen_by: &mut [u8],
    hiding: Option<&Point3<f64>>,
) {
    let bodies = stack.names().len() as u8;
    let bundles = TileTracing::new(stack);
    // Strips are as high as a tile, and each belongs to one thread. Bands of rows begin where strips do, so that
    // bundles are the same in a band as in the whole.
    let strip = TILE as usize * width;
    let strips = origins.par_chunks_mut(strip).zip(directions.par_chunks_mut(strip));
    strips.zip(seen_by.par_chunks_mut(strip)).for_each_init(
        || bundles.tracer(),
        |tracer, ((origins, directions), seen_by)| {
            let mut strip = Strip { stack, width, origins, directions, seen_by, bodies };
            if let Some(pupil) = hiding {
                strip.find_occlusions(tracer, pupil);
            }
            strip.follow(tracer);
        },
    );
}

/// Rows of rays that one thread traces.
struct Strip<'a> {
    stack: &'a OpticalStack,
    width: usize,
    origins: &'a mut [Point3<f64>],
    directions: &'a mut [Vector3<f64>],
    seen_by: &'a mut [u8],
    /// Number of distinct bodies.
    bodies: u8,
}

impl Strip<'_> {
    /// Traces all rays without a code yet to their ends.
    fn follow(&mut self, tracer: &mut TileTracer) {
        for columns in self.tiles() {
            let mut paths = Vec::new();
            let ray = |column: u32, row: u32| {
                let at = row as usize * self.width + column as usize;
                let (origin, direction) = (self.origins[at], self.directions[at]);
                // Rays that are already hidden keep their code.
                let is_open = self.seen_by[at] == SEES_NOTHING && !direction.x.is_nan();
                is_open.then(|| self.stack.enter(&Ray { origin, direction }))
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

    /// Ends rays that are hidden between the pupil and the camera's own interface.
    fn find_occlusions(&mut self, tracer: &mut TileTracer, pupil: &Point3<f64>) {
        for columns in self.tiles() {
            let mut hidden = Vec::new();
            let ray = |column: u32, row: u32| {
                // A ray from the pupil to the point on the interface where the camera's ray starts.
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

    fn code(&self, end: RayEnd) -> u8 {
        match end {
            RayEnd::Nothing => SEES_NOTHING,
            RayEnd::Surface => SEES_SURFACE,
            RayEnd::Body(name) => FIRST_BODY + name,
            RayEnd::TotalReflection(_) => FIRST_BODY + self.bodies,
        }
    }
}

/// Returns the pixel coordinate of the i-th sample along a side. The first of n samples lies half a sample inside the
/// first pixel's edge.
fn middle(i: u32, samples: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(samples) - 0.5
}
