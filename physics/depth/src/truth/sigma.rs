//! How sure ground truth is: from the joint covariance of camera and pose, and from the printer.
//!
//! A pixel's range is where its ray, `o + t d` in the sensor frame, meets a surface. If parameters change by a
//! little, the ray changes by `do` and `dd`, and the range and the point that the pixel shows by
//!
//! ```text
//! dt = -n . (do + t dd) / (n . d)          dP = do + t dd + d dt
//! ```
//!
//! because the ray then meets the tangent plane elsewhere: the point slides along the surface. Behind media that
//! bend it, o and d are those of its last piece, and their changes are found by following it again, moved and turned
//! a little where it leaves the camera. A range begins where its ray was bent last, so that it may err by far
//! more than the point at its end does. An indentation is the difference of two ranges along one ray, which
//! err together. A normal turns by as much as the surface does between the point that is shown and the one that
//! should be, which the pixels beside it tell.
//!
//! A row of such derivatives on both sides of a covariance is the variance. Errors of the shape itself act along the
//! normal, so that a ray sees them divided by `|n . d|`; what presses and what is pressed err apart, and a normal
//! knows nothing of them. All of it is of first order: it holds where the surface is smooth over
//! the width of the error, not at creases, and grows without bound where a ray only grazes. How the surface answers
//! to what presses is not in it: that is the error of a model.

use fabkit_camera::{Camera, DMatrix, JointEstimate, POSE_COUNT};
use fabkit_geometry::{Matrix3, Ray, Vector3};
use rayon::prelude::*;

use super::PixelRays;
use super::map::{DepthMap, NO_LABEL, SURFACE_LABEL};
use super::tiles::TILE_PX;
use super::transfer::Change;

/// Step of central differences in units of a parameter, or of its value where that is above 1.
/// Rays are good to 1e-15 and bend little over it, so that derivatives are good to 1e-8.
const STEP: f64 = 1e-6;

/// What is known about the errors of camera, pose and shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// Of pose and camera, together; `None` if nothing is known. Its camera is the one that looks.
    pub joint: Option<JointEstimate>,
    /// Standard deviation of surfaces along their normals, mm.
    pub shape_mm: f64,
}

/// Standard deviations pixel by pixel, row by row; `NaN` where no surface is seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sigmas(Vec<Sigma>);

/// Of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sigma {
    range_mm: f64,
    point_mm: f64,
    indentation_mm: f64,
    normal_rad: f64,
}

impl Sigma {
    const NOTHING: Self = Self {
        range_mm: f64::NAN,
        point_mm: f64::NAN,
        indentation_mm: f64::NAN,
        normal_rad: f64::NAN,
    };
}

impl Sigmas {
    /// Of the range, mm.
    pub fn range_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|sigma| sigma.range_mm)
    }

    /// Of the point that a pixel shows, sensor frame, root of the sum of squares over the axes, mm.
    pub fn point_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|sigma| sigma.point_mm)
    }

    /// Of the indentation, mm: 0 where nothing has moved.
    pub fn indentation_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|sigma| sigma.indentation_mm)
    }

    /// Of the normal, root of the sum of squares over both ways in which it turns, rad; `NaN` also where no pixel beside
    /// one sees the same.
    pub fn normal_rad(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|sigma| sigma.normal_rad)
    }
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
    /// How sure each pixel's truth is.
    pub fn sigmas(&self, uncertainty: &Uncertainty) -> Sigmas {
        self.sigmas_where(uncertainty, |_| true)
    }

    /// The same of some pixels alone, by their places; `NaN` elsewhere. What is asked costs what it would among all.
    pub fn sigmas_where(
        &self,
        uncertainty: &Uncertainty,
        is_wanted: impl Fn(usize) -> bool + Sync,
    ) -> Sigmas {
        let rays = self.surface.rays();
        let (causes, covariance) = match &uncertainty.joint {
            Some(joint) => causes(rays.camera(), joint),
            None => (Vec::new(), DMatrix::zeros(0, 0)),
        };
        let (at_rest, normals) = (self.surface.normal_in_sensor(), self.normal_in_sensor());
        let shown = Shown { map: self, normals: &normals };
        let transfer = if causes.is_empty() { None } else { rays.transfer() };
        let pixel = |pixel: usize| -> Option<Sigma> {
            let is_seen = self.label[pixel] != NO_LABEL && is_wanted(pixel);
            let ray = rays.ray(pixel).filter(|_| is_seen)?;
            let leaving = if transfer.is_some() { rays.leaving(pixel)? } else { ray };
            let entered = rays.entered(&leaving);
            let change =
                |cause: &Cause| {
                    let change = left(rays, pixel, &leaving, cause)?;
                    Some(transfer.map_or(change, |t| {
                        t.of_change(pixel, [&leaving, &entered, &ray], &change)
                    }))
                };
            let changes: Vec<Change> =
                causes.iter().map(|cause| change(cause).unwrap_or(Change::UNKNOWN)).collect();
            let now = End { ray: &ray, range_mm: self.range_mm[pixel], normal: &normals[pixel] };
            let before = self.surface.range_mm()[pixel];
            let before = End { ray: &ray, range_mm: before, normal: &at_rest[pixel] };
            let is_pressed = self.label[pixel] > SURFACE_LABEL;
            let by: Vec<[f64; 5]> = changes
                .iter()
                .map(|change| {
                    let (range, point) = now.by(change);
                    let indentation = before.by(change).0 - range;
                    [point.x, point.y, point.z, range, indentation]
                })
                .collect();
            let spread = spread(&by, &covariance);
            let shape = |end: &End<'_>| uncertainty.shape_mm / end.cosine();
            // The same surface errs alike with a press and without.
            let of_indentation = match is_pressed {
                true => shape(&before).hypot(shape(&now)),
                false => shape(&before) - shape(&now),
            };
            let points = Matrix3::from_fn(|r, c| spread[r][c]);
            let turned = shown.normal_by_point(pixel);
            let of_normal = turned.map(|by| (by * points * by.transpose()).trace());
            let with_shape = |variance: f64, shape: f64| (variance + shape * shape).max(0.0).sqrt();
            Some(Sigma {
                range_mm: with_shape(spread[3][3], shape(&now)),
                point_mm: with_shape(points.trace(), shape(&now)),
                indentation_mm: with_shape(spread[4][4], of_indentation),
                normal_rad: of_normal.map_or(f64::NAN, |variance| variance.max(0.0).sqrt()),
            })
        };
        let all = (0..rays.len()).into_par_iter();
        let all = all.map(|at| pixel(at).unwrap_or(Sigma::NOTHING));
        Sigmas(all.collect())
    }
}

/// `sum C_rc a_r a_c'` over rows of derivatives.
fn spread(by: &[[f64; 5]], covariance: &DMatrix<f64>) -> [[f64; 5]; 5] {
    let mut spread = [[0.0; 5]; 5];
    for (r, row) in by.iter().enumerate() {
        let mut weighted = [0.0; 5];
        for (c, other) in by.iter().enumerate() {
            for (sum, value) in weighted.iter_mut().zip(other) {
                *sum += covariance[(r, c)] * value;
            }
        }
        for (sums, value) in spread.iter_mut().zip(row) {
            for (sum, weighted) in sums.iter_mut().zip(&weighted) {
                *sum += value * weighted;
            }
        }
    }
    spread
}

/// Where a ray ends.
struct End<'a> {
    ray: &'a Ray,
    range_mm: f64,
    normal: &'a Vector3<f64>,
}

impl End<'_> {
    /// Between ray and normal.
    fn cosine(&self) -> f64 {
        self.ray.direction.dot(self.normal)
    }

    /// How range and point change with the ray.
    fn by(&self, change: &Change) -> (f64, Vector3<f64>) {
        let moved = change.origin + self.range_mm * change.direction;
        let range = -self.normal.dot(&moved) / self.cosine();
        (range, moved + range * self.ray.direction)
    }
}

/// What pixels show, and the normals there, sensor frame.
struct Shown<'a> {
    map: &'a DepthMap<'a>,
    normals: &'a [Vector3<f64>],
}

impl Shown<'_> {
    /// How the normal turns along what a pixel sees, by where that is; `None` where nothing beside it is the same.
    fn normal_by_point(&self, pixel: usize) -> Option<Matrix3<f64>> {
        let width = self.map.width_px() as usize;
        let (column, row) = (pixel % width, pixel / width);
        // In its row of tiles, so that the whole and its bands say the same.
        let (top, height) =
            (row / TILE_PX as usize * TILE_PX as usize, self.map.label.len() / width);
        let ends = [
            [(column > 0).then(|| pixel - 1), (column + 1 < width).then_some(pixel + 1)],
            [
                (row > top).then(|| pixel - width),
                (row + 1 < (top + TILE_PX as usize).min(height)).then_some(pixel + width),
            ],
        ];
        let here = self.map.label[pixel];
        let [across, down] = ends.map(|ends| {
            let [before, after] =
                ends.map(|end| end.filter(|&end| self.map.label[end] == here).unwrap_or(pixel));
            let step = self.point(after)? - self.point(before)?;
            Some((step, self.normals[after] - self.normals[before]))
        });
        let ((x, normal_x), (y, normal_y)) = across.zip(down)?;
        // The ways along the surface that go with each of the two steps alone.
        let [xx, xy, yy] = [x.dot(&x), x.dot(&y), y.dot(&y)];
        let determinant = xx * yy - xy * xy;
        if determinant <= 0.0 {
            return None;
        }
        let [to_x, to_y] = [(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant];
        Some(normal_x * to_x.transpose() + normal_y * to_y.transpose())
    }

    fn point(&self, pixel: usize) -> Option<Vector3<f64>> {
        let ray = self.map.surface.rays().ray(pixel)?;
        Some(ray.at(self.map.range_mm[pixel]).coords)
    }
}

/// How a ray changes as it leaves the camera.
fn left(rays: &PixelRays, pixel: usize, ray: &Ray, cause: &Cause) -> Option<Change> {
    let rotation = rays.camera_from_sensor().rotation();
    match cause {
        Cause::Pose(i) => {
            let by = Vector3::ith(i % 3, 1.0);
            let back = |v: Vector3<f64>| -rotation.tr_mul(&v);
            Some(match *i < 3 {
                true => {
                    let (from, way) = (rotation * ray.origin.coords, rotation * ray.direction);
                    Change { origin: back(by.cross(&from)), direction: back(by.cross(&way)) }
                }
                false => Change { origin: back(by), direction: Vector3::zeros() },
            })
        }
        Cause::Camera(stepped) => {
            let at = rays.at_px(pixel);
            let (before, after) =
                (stepped.before.unproject(&at).ok()?, stepped.after.unproject(&at).ok()?);
            let along = |by: Vector3<f64>| rotation.tr_mul(&by) / stepped.width;
            Some(Change {
                origin: along(after.origin_in_camera - before.origin_in_camera),
                direction: along(after.direction - before.direction),
            })
        }
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
