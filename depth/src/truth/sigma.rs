//! How sure ground truth is: from the joint covariance of camera and pose, and from the printer.
//!
//! A pixel's range is where its ray, `o + t d` in the camera frame, meets a surface that moves with
//! the pose. If parameters change by a little, the ray changes by `do` and `dd`, a point of the
//! surface by `dx`, and the range by
//!
//! ```text
//! dt = n . (dx - do - t dd) / (n . d)
//! ```
//!
//! because the ray then meets the moved tangent plane. Behind media that bend it, o and d are those of its
//! last piece, and their changes are found by following it again from a pupil and in a direction a step to
//! either side. A row of such derivatives on both sides of a
//! covariance is the variance. Errors of the shape itself act along the normal, so that a ray sees
//! them divided by `|n . d|`. All of it is of first order: it holds where the surface is smooth over
//! the width of the error, not at creases, and grows without bound where a ray only grazes.

use fabkit_camera::{Camera, DMatrix, JointEstimate, POSE_COUNT, Point2};
use fabkit_geometry::{Point3, Pose, Ray, Vector3};
use fabkit_optics::{Sights, Tracer};
use rayon::prelude::*;

use super::PixelRays;
use super::map::{DepthMap, NO_LABEL};

/// Step of central differences in units of a parameter, or of its value where that is above 1.
/// Rays are good to 1e-15 and bend little over it, so that derivatives are good to 1e-8.
const STEP: f64 = 1e-6;

/// A step moves the start of a last piece by far less than that, unless it leads through another face, mm.
const NEIGHBOUR_MM: f64 = 1e-3;

/// What is known about the errors of camera, pose and shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// Of pose and camera, together; `None` if nothing is known. Its camera is the one that looks.
    pub joint: Option<JointEstimate>,
    /// Standard deviation of surfaces along their normals, mm.
    pub shape_mm: f64,
}

/// What moves the range at a pixel.
enum Cause {
    /// One of the pose's parameters, by its place among them.
    Pose(usize),
    /// A parameter of the camera.
    Camera(Box<Stepped>),
}

/// A parameter's influence on the rays: cameras a step before and after it.
struct Stepped {
    before: Camera,
    after: Camera,
    width: f64,
}

impl DepthMap<'_> {
    /// Standard deviation of each pixel's range, mm; `NaN` where no surface is seen.
    pub fn sigma_mm(&self, uncertainty: &Uncertainty) -> Vec<f64> {
        let rays = self.surface.rays();
        let (causes, covariance) = match &uncertainty.joint {
            Some(joint) => causes(rays.camera(), joint),
            None => (Vec::new(), DMatrix::zeros(0, 0)),
        };
        let normals = self.normal_in_sensor();
        let pixel = |tracer: &mut Option<Tracer>, pixel: usize| -> f64 {
            let (Some(ray), true) = (rays.ray(pixel), self.label[pixel] != NO_LABEL) else {
                return f64::NAN;
            };
            let camera_from_sensor = rays.camera_from_sensor();
            let seen = Seen::new(camera_from_sensor, &ray, self.range_mm[pixel], &normals[pixel]);
            let at = rays.at_px(pixel);
            let row: Vec<f64> = match tracer {
                Some(tracer) => {
                    let bent = Bent { rays, at, ray, tangent: normals[pixel] };
                    causes.iter().map(|by| bent.by(by, self.range_mm[pixel], tracer)).collect()
                }
                None => {
                    let by_pose = seen.by_pose(camera_from_sensor);
                    let by = |cause: &Cause| match cause {
                        Cause::Pose(i) => by_pose[*i],
                        Cause::Camera(stepped) => seen.by_camera(stepped, &at),
                    };
                    causes.iter().map(by).collect()
                }
            };
            let variance = (uncertainty.shape_mm / seen.cosine).powi(2)
                + quadratic(&row, |r, c| covariance[(r, c)]);
            variance.max(0.0).sqrt()
        };
        let tracer = || rays.media().map(Sights::media_tracer);
        (0..rays.len()).into_par_iter().map_init(tracer, pixel).collect()
    }
}

/// A pixel whose ray was bent on its way.
struct Bent<'a> {
    rays: &'a PixelRays,
    at: Point2<f64>,
    /// Its last piece, sensor frame.
    ray: Ray,
    /// Normal of what it ends at, sensor frame.
    tangent: Vector3<f64>,
}

impl Bent<'_> {
    /// Range by a cause; NaN where a step leads through other faces on both sides, as at an edge.
    fn by(&self, cause: &Cause, range_mm: f64, tracer: &mut Tracer) -> f64 {
        let here = (self.ray.origin.coords, self.ray.direction);
        let width = match cause {
            Cause::Pose(_) => 2.0 * STEP,
            Cause::Camera(stepped) => stepped.width,
        };
        let mut side = |is_after: bool| {
            let path = tracer.follow(&self.moved(cause, is_after)?);
            // Rays of one kind begin their last piece near each other.
            let is_near = (path.last.origin.coords - here.0).norm() < NEIGHBOUR_MM;
            is_near.then_some((path.last.origin.coords, path.last.direction))
        };
        let (before, after, width) = match (side(false), side(true)) {
            (Some(before), Some(after)) => (before, after, width),
            (Some(before), None) => (before, here, 0.5 * width),
            (None, Some(after)) => (here, after, 0.5 * width),
            (None, None) => return f64::NAN,
        };
        let moved = (after.0 - before.0) + range_mm * (after.1 - before.1);
        -self.tangent.dot(&moved) / (width * self.tangent.dot(&self.ray.direction))
    }

    /// The ray from the pupil, sensor frame, after a step of a cause, or before it.
    fn moved(&self, cause: &Cause, is_after: bool) -> Option<Ray> {
        let camera_from_sensor = self.rays.camera_from_sensor();
        let (rotation, translation) =
            (camera_from_sensor.rotation(), camera_from_sensor.translation_mm());
        // Rotation of the camera by a small vector, and the translation.
        let (camera, turned, shifted) = match cause {
            Cause::Pose(i) => {
                let step = if is_after { STEP } else { -STEP };
                let by = Vector3::ith(i % 3, step);
                let none = Vector3::zeros();
                let (turned, shifted) = if *i < 3 { (by, none) } else { (none, by) };
                (self.rays.camera(), turned, shifted)
            }
            Cause::Camera(stepped) => {
                let camera = if is_after { &stepped.after } else { &stepped.before };
                (camera, Vector3::zeros(), Vector3::zeros())
            }
        };
        let direction = camera.unproject(&self.at).ok()?.direction;
        let back = |v: Vector3<f64>| rotation.tr_mul(&(v - turned.cross(&v)));
        // The translation is not turned with the rest.
        let pupil = -rotation.tr_mul(&(translation + shifted - turned.cross(translation)));
        Some(Ray { origin: Point3::from(pupil), direction: back(direction).normalize() })
    }
}

/// The parameters that have a variance, and the covariance of those.
fn causes(camera: &Camera, joint: &JointEstimate) -> (Vec<Cause>, DMatrix<f64>) {
    let cause = |i: usize| match i.checked_sub(POSE_COUNT) {
        None => Some((i, Cause::Pose(i))),
        Some(parameter) => Some((i, Cause::Camera(Box::new(stepped(camera, parameter)?)))),
    };
    let (free, causes): (Vec<usize>, Vec<Cause>) = joint.free().filter_map(cause).unzip();
    let matrix = joint.covariance();
    let covariance = DMatrix::from_fn(free.len(), free.len(), |r, c| matrix[(free[r], free[c])]);
    (causes, covariance)
}

/// A pixel's end, in the camera frame.
struct Seen {
    point: Point3<f64>,
    normal: Vector3<f64>,
    range_mm: f64,
    /// Between ray and normal.
    cosine: f64,
}

impl Seen {
    fn new(camera_from_sensor: &Pose, ray: &Ray, range_mm: f64, normal: &Vector3<f64>) -> Self {
        Self {
            point: camera_from_sensor.point(ray.at(range_mm)),
            normal: camera_from_sensor.vector(*normal),
            range_mm,
            cosine: ray.direction.dot(normal),
        }
    }

    /// Range by rotation and translation of the pose.
    fn by_pose(&self, camera_from_sensor: &Pose) -> [f64; 6] {
        // n . (w x r) = w . (r x n)
        let turned = (self.point.coords - camera_from_sensor.translation_mm()).cross(&self.normal);
        let n = self.normal;
        [turned.x, turned.y, turned.z, n.x, n.y, n.z].map(|by| by / self.cosine)
    }

    /// Range by one of the camera's parameters; NaN where a step leaves the lens's domain.
    fn by_camera(&self, stepped: &Stepped, at_px: &Point2<f64>) -> f64 {
        let (Ok(before), Ok(after)) =
            (stepped.before.unproject(at_px), stepped.after.unproject(at_px))
        else {
            return f64::NAN;
        };
        let moved = after.at(self.range_mm) - before.at(self.range_mm);
        -self.normal.dot(&moved) / (stepped.width * self.cosine)
    }
}

fn quadratic(row: &[f64], matrix: impl Fn(usize, usize) -> f64) -> f64 {
    let terms = row
        .iter()
        .enumerate()
        .map(|(r, x)| row.iter().enumerate().map(|(c, y)| x * matrix(r, c) * y).sum::<f64>());
    terms.sum()
}

/// One-sided where the camera itself is at a limit of its parameter; `None` where none exists on
/// either side.
fn stepped(camera: &Camera, parameter: usize) -> Option<Stepped> {
    let values: Vec<f64> = camera.parameters().into_iter().map(|(_, value)| value).collect();
    let step = STEP * values[parameter].abs().max(1.0);
    let moved = |by: f64| {
        let mut values = values.clone();
        values[parameter] += by;
        camera.with_parameters(&values).ok()
    };
    let (before, after) = (moved(-step), moved(step));
    let sides = f64::from(u8::from(before.is_some()) + u8::from(after.is_some()));
    (sides > 0.0).then(|| Stepped {
        before: before.unwrap_or(*camera),
        after: after.unwrap_or(*camera),
        width: sides * step,
    })
}
