//! Mapping between pixels and rays, framed to fit the scene.

use fabkit_geometry::{Point3, Pose, Ray, Vector3};

use super::{RenderError, View, ViewProjection};

/// A view with its scale: the ray of each position in the image.
///
/// ```
/// use fabkit_depth::{Actor, View, render_with_framing};
/// use fabkit_geometry::{CompiledSolid, Point3, Solid};
///
/// // A ball of radius 5 mm from the front: its centre is in the middle; right of it is +x, above it +z.
/// let ball = Actor::new(CompiledSolid::new(&Solid::sphere(5.0))?, [200; 3]);
/// let (_, framing) = render_with_framing(&[ball], &View::front(200, 200), &|_, _| {})?;
/// let [centre, right, above] =
///     [[0.0; 3], [5.0, 0.0, 0.0], [0.0, 0.0, 5.0]].map(|at| framing.project(&Point3::from(at)));
/// assert!((centre[0] - 100.0).abs() < 1.0 && (centre[1] - 100.0).abs() < 1.0);
/// assert!(right[0] > 180.0 && (right[1] - centre[1]).abs() < 1e-9 && above[1] < 20.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Framing {
    /// Image axes and viewing direction in the scene frame, unit length.
    pub(super) right: Vector3<f64>,
    pub(super) up: Vector3<f64>,
    pub(super) forward: Vector3<f64>,
    perspective: bool,
    /// Origin of all rays in perspective; a point in front of all bodies in orthographic projection.
    eye: Point3<f64>,
    /// Position of the image's top left corner on the image plane: mm across the viewing direction in orthographic
    /// projection, tangents of angles from it in perspective.
    left: f64,
    top: f64,
    /// Image plane units per pixel.
    pub(super) per_px: f64,
}

impl Framing {
    /// Fits points into a validated view.
    pub(super) fn fit(view: &View, points: &[Point3<f64>]) -> Result<Self, RenderError> {
        let forward = view.looking.normalize();
        let mut right = forward.cross(&Vector3::z());
        // Looking along z: y takes the place of up.
        if right.norm() < 1e-9 {
            right = forward.cross(&Vector3::y());
        }
        let right = right.normalize();
        let up = right.cross(&forward);

        let (min, max) = extremes(points.iter().map(|point| point.coords));
        let centre = Point3::from((min + max) / 2.0);
        // A single point still needs a frame around it.
        let radius_mm =
            points.iter().map(|p| (p - centre).norm()).fold(1e-6, |a: f64, b: f64| a.max(b));
        let (perspective, distance_mm) = match view.projection {
            ViewProjection::Orthographic => (false, 2.0 * radius_mm),
            ViewProjection::Perspective { field_of_view } => {
                // The bounding ball just fills the field of view.
                (true, radius_mm / (field_of_view.rad() / 2.0).sin())
            }
        };
        let eye = centre - forward * distance_mm;
        let (low, high) = extremes(points.iter().map(|point| {
            let offset = point - eye;
            let depth = if perspective { offset.dot(&forward) } else { 1.0 };
            Vector3::new(offset.dot(&right) / depth, offset.dot(&up) / depth, 0.0)
        }));
        if !(low.iter().chain(high.iter()).all(|v| v.is_finite()) && radius_mm.is_finite()) {
            return Err(RenderError::NothingToDraw);
        }
        let (left, top, per_px) = (0.0, 0.0, 0.0);
        let mut framing = Self { right, up, forward, perspective, eye, left, top, per_px };
        framing.fit_rectangle(view, low, high);
        Ok(framing)
    }

    /// Zooms the same view to the part of the image between two corners, px.
    pub(super) fn zoomed(&self, view: &View, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> Self {
        let on_plane = |x_px, y_px| Vector3::new(self.plane_x(x_px), self.plane_y(y_px), 0.0);
        let mut framing = self.clone();
        framing.fit_rectangle(view, on_plane(x0, y1), on_plane(x1, y0));
        framing
    }

    /// Scales and shifts so that a rectangle of the image plane is centred within the margins.
    fn fit_rectangle(&mut self, view: &View, low: Vector3<f64>, high: Vector3<f64>) {
        let (width, height) = (f64::from(view.width_px), f64::from(view.height_px));
        let border = 2.0 * view.margin * width.min(height);
        let size = high - low;
        let per_px = (size.x / (width - border)).max(size.y / (height - border));
        // A scene that projects to a point still needs a frame around it.
        self.per_px = per_px.max(1e-9);
        let middle = (low + high) / 2.0;
        self.left = middle.x - self.per_px * width / 2.0;
        self.top = middle.y + self.per_px * height / 2.0;
    }

    fn plane_x(&self, x_px: f64) -> f64 {
        self.left + x_px * self.per_px
    }

    fn plane_y(&self, y_px: f64) -> f64 {
        self.top - y_px * self.per_px
    }

    /// Returns the ray through a position in the image, px.
    pub(super) fn ray(&self, x_px: f64, y_px: f64) -> Ray {
        let across = self.right * self.plane_x(x_px) + self.up * self.plane_y(y_px);
        if self.perspective {
            Ray { origin: self.eye, direction: (self.forward + across).normalize() }
        } else {
            Ray { origin: self.eye + across, direction: self.forward }
        }
    }

    /// Projects a point of the scene, mm, into the image, px. The result is meaningless for points behind a perspective
    /// viewer.
    pub fn project(&self, point: &Point3<f64>) -> [f64; 2] {
        let offset = point - self.eye;
        let depth = if self.perspective { offset.dot(&self.forward) } else { 1.0 };
        let on_plane = [offset.dot(&self.right) / depth, offset.dot(&self.up) / depth];
        [(on_plane[0] - self.left) / self.per_px, (self.top - on_plane[1]) / self.per_px]
    }

    /// Takes the image axes of a camera, which only orient the lights.
    pub(super) fn from_camera(scene_from_camera: &Pose) -> Self {
        let axis = |x, y, z| scene_from_camera.vector(Vector3::new(x, y, z));
        Self {
            right: axis(1.0, 0.0, 0.0),
            up: axis(0.0, -1.0, 0.0),
            forward: axis(0.0, 0.0, 1.0),
            perspective: true,
            eye: scene_from_camera.point(Point3::origin()),
            left: 0.0,
            top: 0.0,
            per_px: 1.0,
        }
    }

    /// Returns the direction of the ray that meets a point.
    pub(super) fn direction_to(&self, point: &Point3<f64>) -> Vector3<f64> {
        if self.perspective { (point - self.eye).normalize() } else { self.forward }
    }
}

fn extremes(vectors: impl Iterator<Item = Vector3<f64>>) -> (Vector3<f64>, Vector3<f64>) {
    let inf = Vector3::repeat(f64::INFINITY);
    vectors.fold((inf, -inf), |(min, max), v| (min.inf(&v), max.sup(&v)))
}
