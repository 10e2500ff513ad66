//! Uncertainty of ground truth, from the joint covariance of camera and pose, and from the printer.
//!
//! A pixel's range is where its ray, `o + t d` in the sensor frame, meets a surface. A small change of parameters
//! changes the ray by `do` and `dd`, and the range and the point that the pixel shows by
//!
//! ```text
//! dt = -n . (do + t dd) / (n . d)          dP = do + t dd + d dt
//! ```
//!
//! because the ray then meets the tangent plane elsewhere: the point slides along the surface. Behind refracting media,
//! o and d belong to the ray's last segment, and their changes are found by tracing the ray again, shifted and turned
//! slightly where it leaves the camera. A range begins at the last refraction, so that it may err by far more than the
//! point at its end does. An indentation is the difference of two ranges along one ray, which err together. A normal
//! turns by as much as the surface does between the point that is shown and the correct one; the neighbouring pixels
//! supply that derivative.
//!
//! The variance is the covariance multiplied by the row of such derivatives from both sides. Errors of the shape itself
//! act along the normal, so that a ray sees them divided by `|n . d|`. The shapes of indenter and surface err
//! independently, and shape errors do not enter normals. All of it is of first order: it holds where the surface is
//! smooth over the extent of the error, not at creases, and grows without bound at grazing incidence. The error of the
//! contact model is not included.

use fabkit_camera::{Camera, DMatrix, JointEstimate, POSE_PARAMETER_COUNT};
use fabkit_geometry::{Matrix3, Ray, Vector3};
use rayon::prelude::*;

use super::PixelRays;
use super::map::{DepthMap, NO_LABEL, SURFACE_LABEL};
use super::tiles::TILE_PX;
use super::transfer::Change;

/// Step of central differences in units of a parameter, or of its value where that is above 1. Rays are accurate to
/// 1e-15 and nearly linear over the step, so that derivatives are accurate to 1e-8.
const STEP: f64 = 1e-6;

/// Known errors of camera, pose and shape.
///
/// ```
/// # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path};
/// # let grip = FixtureGrip {
/// #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
/// #     key: None, threads: Vec::new(),
/// # };
/// # let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
/// # let touch = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 2.0, grip }.into();
/// use fabkit_camera::Camera;
/// use fabkit_depth::ground_truth::{PixelRays, PlacedIndenter, ReferenceSurface, Uncertainty};
/// use fabkit_geometry::{Pose, Solid};
///
/// // A printer that errs by 0.03 mm, and nothing else; a ball reaches into a dome, in whose centre the camera is.
/// let rays = PixelRays::new(&Camera::equidistant(61, 61, 2.0)?, &Pose::identity());
/// let surface = ReferenceSurface::cast(&touch, &rays)?;
/// let ball = PlacedIndenter::new("ball", &Solid::sphere(3.0), Pose::translation(0.0, 0.0, 12.5))?;
/// let map = surface.map_with_indenters(&[ball]);
/// let sigmas = map.compute_standard_deviations(&Uncertainty { joint: None, shape_mm: 0.03 });
/// let middle = 30 * 61 + 30;
/// // The range depends on the ball alone, the indentation on the dome too. They err independently.
/// assert!((sigmas.range_mm().nth(middle).unwrap() - 0.03).abs() < 1e-9);
/// assert!((sigmas.indentation_mm().nth(middle).unwrap() - 0.03 * 2_f64.sqrt()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// Joint estimate of pose and camera; `None` if nothing is known. Its camera must be the one of the rays.
    pub joint: Option<JointEstimate>,
    /// Standard deviation of surfaces along their normals, mm.
    pub shape_mm: f64,
}

/// Standard deviations pixel by pixel, row by row; `NaN` where no surface is seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StandardDeviations(Vec<PixelDeviations>);

/// Standard deviations of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PixelDeviations {
    range_mm: f64,
    point_mm: f64,
    indentation_mm: f64,
    normal_rad: f64,
}

impl PixelDeviations {
    const NOTHING: Self = Self {
        range_mm: f64::NAN,
        point_mm: f64::NAN,
        indentation_mm: f64::NAN,
        normal_rad: f64::NAN,
    };
}

impl StandardDeviations {
    /// Standard deviation of the range, mm.
    pub fn range_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|sigma| sigma.range_mm)
    }

    /// Standard deviation of the point that a pixel shows, sensor frame, root of the sum of squares over the axes, mm.
    pub fn point_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|sigma| sigma.point_mm)
    }

    /// Standard deviation of the indentation, mm: 0 where nothing has moved.
    pub fn indentation_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|sigma| sigma.indentation_mm)
    }

    /// Standard deviation of the normal, root of the sum of squares over both rotations, rad; `NaN` also where no
    /// neighbouring pixel sees the same body.
    pub fn normal_rad(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|sigma| sigma.normal_rad)
    }
}

/// Parameter that changes the ray of a pixel.
enum RayParameter {
    /// Pose parameter, by its index.
    Pose(usize),
    /// Camera parameter.
    Camera(Box<SteppedCamera>),
}

/// Cameras a step before and after a parameter's value.
struct SteppedCamera {
    before: Camera,
    after: Camera,
    width: f64,
}

impl DepthMap<'_> {
    /// Computes the standard deviations of all pixels.
    pub fn compute_standard_deviations(&self, uncertainty: &Uncertainty) -> StandardDeviations {
        self.compute_standard_deviations_where(uncertainty, |_| true)
    }

    /// Computes the standard deviations of the pixels for which `is_wanted` returns true; `NaN` elsewhere. A pixel
    /// costs as much as it does among all.
    ///
    /// ```
    /// # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path};
    /// # let grip = FixtureGrip {
    /// #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
    /// #     key: None, threads: Vec::new(),
    /// # };
    /// # let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
    /// # let touch = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 2.0, grip }.into();
    /// use fabkit_camera::Camera;
    /// use fabkit_depth::ground_truth::{PixelRays, ReferenceSurface, Uncertainty};
    /// use fabkit_geometry::Pose;
    ///
    /// // Three pixels of a dome whose camera is in its centre, of which the middle one is asked for.
    /// let rays = PixelRays::new(&Camera::equidistant(3, 1, 2.0)?, &Pose::identity());
    /// let surface = ReferenceSurface::cast(&touch, &rays)?;
    /// let printer = Uncertainty { joint: None, shape_mm: 0.03 };
    /// let map = surface.map_without_contact();
    /// let sigmas = map.compute_standard_deviations_where(&printer, |pixel| pixel == 1);
    /// let range_mm: Vec<f64> = sigmas.range_mm().collect();
    /// assert!(range_mm[0].is_nan() && (range_mm[1] - 0.03).abs() < 1e-9);
    /// // Without a press there is no indentation to err in.
    /// assert_eq!(sigmas.indentation_mm().nth(1), Some(0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn compute_standard_deviations_where(
        &self,
        uncertainty: &Uncertainty,
        is_wanted: impl Fn(usize) -> bool + Sync,
    ) -> StandardDeviations {
        let rays = self.surface.rays();
        let (causes, covariance) = match &uncertainty.joint {
            Some(joint) => find_free_parameters(rays.camera(), joint),
            None => (Vec::new(), DMatrix::zeros(0, 0)),
        };
        let (at_rest, normals) = (self.surface.normal_in_sensor(), self.normal_in_sensor());
        let shown = ShownSurface { map: self, normals: &normals };
        let transfer = if causes.is_empty() { None } else { rays.transfer() };
        let pixel = |pixel: usize| -> Option<PixelDeviations> {
            let is_seen = self.label[pixel] != NO_LABEL && is_wanted(pixel);
            let ray = rays.ray(pixel).filter(|_| is_seen)?;
            let leaving = if transfer.is_some() { rays.camera_ray(pixel)? } else { ray };
            let entered = rays.traced_start(&leaving);
            let change = |cause: &RayParameter| {
                let change = camera_ray_change(rays, pixel, &leaving, cause)?;
                Some(
                    transfer
                        .map_or(change, |t| t.apply(pixel, [&leaving, &entered, &ray], &change)),
                )
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
                    let (range, point) = now.range_and_point_change(change);
                    let indentation = before.range_and_point_change(change).0 - range;
                    [point.x, point.y, point.z, range, indentation]
                })
                .collect();
            let spread = propagate_covariance(&by, &covariance);
            let shape = |end: &End<'_>| uncertainty.shape_mm / end.cosine();
            // Without contact at the pixel the same surface errs alike in both ranges.
            let of_indentation = if is_pressed {
                shape(&before).hypot(shape(&now))
            } else {
                shape(&before) - shape(&now)
            };
            let points = Matrix3::from_fn(|r, c| spread[r][c]);
            let turned = shown.normal_by_point(pixel);
            let of_normal = turned.map(|by| (by * points * by.transpose()).trace());
            let with_shape = |variance: f64, shape: f64| (variance + shape * shape).max(0.0).sqrt();
            Some(PixelDeviations {
                range_mm: with_shape(spread[3][3], shape(&now)),
                point_mm: with_shape(points.trace(), shape(&now)),
                indentation_mm: with_shape(spread[4][4], of_indentation),
                normal_rad: of_normal.map_or(f64::NAN, |variance| variance.max(0.0).sqrt()),
            })
        };
        let all = (0..rays.len()).into_par_iter();
        let all = all.map(|at| pixel(at).unwrap_or(PixelDeviations::NOTHING));
        StandardDeviations(all.collect())
    }
}

/// Computes the covariance of the five results: the sum of `C_rc a_r a_c'` over rows of derivatives.
fn propagate_covariance(by: &[[f64; 5]], covariance: &DMatrix<f64>) -> [[f64; 5]; 5] {
    let mut spread = [[0.0; 5]; 5];
    for (r, row) in by.iter().enumerate() {
        // Row r of the covariance times all derivatives, then times the derivatives of parameter r.
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

/// End of a ray on a surface.
struct End<'a> {
    ray: &'a Ray,
    range_mm: f64,
    normal: &'a Vector3<f64>,
}

impl End<'_> {
    /// Cosine of the angle between ray and normal.
    fn cosine(&self) -> f64 {
        self.ray.direction.dot(self.normal)
    }

    /// Computes the changes of range and point by a change of the ray.
    fn range_and_point_change(&self, change: &Change) -> (f64, Vector3<f64>) {
        let moved = change.origin + self.range_mm * change.direction;
        let range = -self.normal.dot(&moved) / self.cosine();
        (range, moved + range * self.ray.direction)
    }
}

/// Points and normals of all pixels, sensor frame.
struct ShownSurface<'a> {
    map: &'a DepthMap<'a>,
    normals: &'a [Vector3<f64>],
}

impl ShownSurface<'_> {
    /// Computes the derivative of the normal by the point at a pixel; `None` where no neighbour sees the same body.
    fn normal_by_point(&self, pixel: usize) -> Option<Matrix3<f64>> {
        let width = self.map.width_px() as usize;
        let (column, row) = (pixel % width, pixel / width);
        // Neighbours are taken within the row of tiles, so that bands of an image yield the same values as the whole.
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
        // Dual basis of the two steps along the surface.
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

/// Computes the change of a ray, where it leaves the camera, by a unit change of a parameter.
fn camera_ray_change(
    rays: &PixelRays,
    pixel: usize,
    ray: &Ray,
    cause: &RayParameter,
) -> Option<Change> {
    let rotation = rays.camera_from_sensor().rotation();
    match cause {
        RayParameter::Pose(i) => {
            let by = Vector3::ith(i % 3, 1.0);
            // The pose maps sensor to camera, so a ray fixed in the camera moves the opposite way in the sensor frame.
            // Parameters 0 to 2 turn, 3 to 5 shift.
            let back = |v: Vector3<f64>| -rotation.tr_mul(&v);
            Some(if *i < 3 {
                let (from, way) = (rotation * ray.origin.coords, rotation * ray.direction);
                Change { origin: back(by.cross(&from)), direction: back(by.cross(&way)) }
            } else {
                Change { origin: back(by), direction: Vector3::zeros() }
            })
        }
        RayParameter::Camera(stepped) => {
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

/// Returns the parameters with a variance, and their covariance.
fn find_free_parameters(
    camera: &Camera,
    joint: &JointEstimate,
) -> (Vec<RayParameter>, DMatrix<f64>) {
    let cause = |i: usize| match i.checked_sub(POSE_PARAMETER_COUNT) {
        None => Some((i, RayParameter::Pose(i))),
        Some(parameter) => {
            Some((i, RayParameter::Camera(Box::new(step_camera(camera, parameter)?))))
        }
    };
    let (free, causes): (Vec<usize>, Vec<RayParameter>) =
        joint.free_parameters().filter_map(cause).unzip();
    let matrix = joint.covariance();
    let covariance = DMatrix::from_fn(free.len(), free.len(), |r, c| matrix[(free[r], free[c])]);
    (causes, covariance)
}

/// Steps a camera parameter to both sides: to one side where the other is out of its limits, `None` where both are.
fn step_camera(camera: &Camera, parameter: usize) -> Option<SteppedCamera> {
    let values: Vec<f64> = camera.parameters().into_iter().map(|(_, value)| value).collect();
    let step = STEP * values[parameter].abs().max(1.0);
    let moved = |by: f64| {
        let mut values = values.clone();
        values[parameter] += by;
        camera.with_parameters(&values).ok()
    };
    let (before, after) = (moved(-step), moved(step));
    let sides = f64::from(u8::from(before.is_some()) + u8::from(after.is_some()));
    (sides > 0.0).then(|| SteppedCamera {
        before: before.unwrap_or(*camera),
        after: after.unwrap_or(*camera),
        width: sides * step,
    })
}
