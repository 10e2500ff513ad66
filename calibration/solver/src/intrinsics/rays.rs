//! Uncertainty of rays, which is what matters for the use of a camera.
//!
//! Parameters compensate each other. A double sphere of which only the middle was observed has a focal length and a xi
//! that cannot be separated, and its rays are right all the same. A common rotation of all rays is no error either: it
//! turns the camera's frame, and every pose with it. The uncertainty is therefore that of rays relative to each other:
//! the common rotation that fits best over the observed corners is removed from each parameter's effect.

use fabkit_camera::{Camera, Point2, Point3, Vector3};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX};

use super::bundle::State;
use super::{BoardView, points};
use crate::information::ScaledCholesky;

/// Numbers of columns and rows of cells into which the image is divided for the map of the uncertainty.
pub const GRID: [u32; 2] = [32, 24];
/// Largest distance between a cell's centre and a corner, as a fraction of the image's longer side, for which the cell
/// counts as observed.
const OBSERVED_RADIUS: f64 = 1.0 / 16.0;
/// Largest number of corners examined: enough for a median and a maximum.
const MAX_CORNERS: usize = 2000;
/// Step on both sides of the axis for differentiating the scale on it: derivatives are good to 1e-10, which correlated
/// parameters need.
const BESIDE_AXIS: f64 = 1e-5;

/// Standard deviation of a ray relative to the others, both directions together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaySigma {
    /// Standard deviation of the ray's angle, rad.
    pub angle_rad: f64,
    /// Standard deviation of the pixel of a point on the ray, px.
    pub px: f64,
}

/// Uncertainty of rays over a part of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaySigmas {
    /// Median.
    pub typical: RaySigma,
    /// Maximum.
    pub worst: RaySigma,
}

/// Uncertainty of a camera's rays, provided that its lens model is right.
#[derive(Clone, Debug, PartialEq)]
pub struct RayUncertainty {
    /// Uncertainty at the observed corners.
    pub observed: RaySigmas,
    /// Uncertainty in the rest of the image, where the model extrapolates; `None` if there is no rest.
    pub extrapolated: Option<RaySigmas>,
    /// Uncertainty at the centre of each cell of [`GRID`], row by row from the top; `None` for pixels outside the
    /// lens's image.
    pub cells: Vec<Option<RaySigma>>,
}

/// Pixel's ray with the effect of each parameter on it.
struct RayEffects {
    direction: Vector3<f64>,
    /// Derivative of the direction by each parameter, at a fixed pixel.
    by_parameters: Matrix3xX<f64>,
    /// Derivative of the pixel by the direction.
    by_direction: nalgebra::Matrix2x3<f64>,
}

impl RayEffects {
    /// Computes the ray of a pixel; `None` outside the lens's image.
    fn new(camera: &Camera, pixel: &Point2<f64>) -> Option<Self> {
        let direction = camera.unproject(pixel).ok()?.direction;
        let there = camera.project_with_jacobians(&Point3::from(direction)).ok()?;
        // The conditions for the change of the direction: the pixel stays, and so does the length.
        let mut system = Matrix3::zeros();
        system.fixed_rows_mut::<2>(0).copy_from(&there.by_point);
        system.set_row(2, &direction.transpose());
        let inverse = system.try_inverse()?;
        let effects =
            there.by_parameters.iter().map(|by| inverse * Vector3::new(-by.x, -by.y, 0.0));
        let by_parameters = Matrix3xX::from_columns(&effects.collect::<Vec<_>>());
        Some(Self { direction, by_parameters, by_direction: there.by_point })
    }

    fn without_rotation(mut self, turns: &Matrix3xX<f64>) -> Self {
        for (mut effect, turn) in self.by_parameters.column_iter_mut().zip(turns.column_iter()) {
            effect -= turn.into_owned().cross(&self.direction);
        }
        self
    }

    /// Propagates the information of the parameters to the ray.
    fn sigma(&self, information: &ScaledCholesky, scale: f64) -> RaySigma {
        let rows = |matrix: &DMatrix<f64>| -> f64 {
            let squares = matrix.row_iter().map(|row| information.variance(&row.transpose()));
            scale * squares.sum::<f64>().sqrt()
        };
        let of_ray =
            DMatrix::from_fn(3, self.by_parameters.ncols(), |r, c| self.by_parameters[(r, c)]);
        let of_pixel = self.by_direction * &self.by_parameters;
        let of_pixel = DMatrix::from_fn(2, of_pixel.ncols(), |r, c| of_pixel[(r, c)]);
        // The direction has unit length, so that its change is an angle.
        RaySigma { angle_rad: rows(&of_ray), px: rows(&of_pixel) }
    }
}

/// Computes the uncertainty of a camera's rays. `information` is that of its parameters for a residual scale of 1.
pub(super) fn rays(
    views: &[BoardView],
    state: &State,
    information: &ScaledCholesky,
    scale: f64,
) -> Option<RayUncertainty> {
    let camera = &state.camera;
    let corners: Vec<Point2<f64>> = points(views, state)
        .map(|(corner, _)| corner.pixel)
        .filter(|p| camera.is_in_image(p))
        .collect();
    // Evenly spaced corners are enough, and keep the run time bounded.
    let every = corners.len().div_ceil(MAX_CORNERS).max(1);
    let seen: Vec<RayEffects> =
        corners.iter().step_by(every).filter_map(|pixel| RayEffects::new(camera, pixel)).collect();
    let turns = find_common_rotations(&seen)?;
    let near_px = OBSERVED_RADIUS * f64::from(camera.width_px().max(camera.height_px()));
    let [columns, rows] = GRID;
    let at = |i: u32, count: u32, size_px: u32| {
        (f64::from(i) + 0.5) / f64::from(count) * f64::from(size_px) - 0.5
    };
    let pixels = (0..rows).flat_map(|r| (0..columns).map(move |c| (c, r))).map(|(c, r)| {
        Point2::new(at(c, columns, camera.width_px()), at(r, rows, camera.height_px()))
    });
    let sigma = |place: RayEffects| place.without_rotation(&turns).sigma(information, scale);
    let (mut beyond, mut cells) = (Vec::new(), Vec::new());
    for pixel in pixels {
        let known = RayEffects::new(camera, &pixel).map(sigma);
        cells.push(known);
        let is_far = corners.iter().all(|corner| (corner - pixel).norm() > near_px);
        beyond.extend(known.filter(|_| is_far));
    }
    Some(RayUncertainty {
        observed: summarise(seen.into_iter().map(sigma).collect())?,
        extrapolated: summarise(beyond),
        cells,
    })
}

/// Finds, for each parameter, the common rotation that best reproduces its effect on the rays.
fn find_common_rotations(places: &[RayEffects]) -> Option<Matrix3xX<f64>> {
    let mut normal = Matrix3::zeros();
    let mut right = Matrix3xX::zeros(places.first()?.by_parameters.ncols());
    for RayEffects { direction, by_parameters, .. } in places {
        // Normal equations of a rotation `w` with `w x direction` closest to the parameter's effect.
        normal += Matrix3::identity() - direction * direction.transpose();
        right += direction.cross_matrix() * by_parameters;
    }
    Some(normal.try_inverse()? * right)
}

fn summarise(mut sigmas: Vec<RaySigma>) -> Option<RaySigmas> {
    sigmas.sort_by(|a, b| a.px.total_cmp(&b.px));
    let worst = sigmas.last()?;
    let largest = sigmas.iter().map(|sigma| sigma.angle_rad).fold(0.0, f64::max);
    let typical = sigmas[sigmas.len() / 2];
    Some(RaySigmas { typical, worst: RaySigma { angle_rad: largest, px: worst.px } })
}

/// Computes the image scale on the axis, columns per radian, and its standard deviation, which are comparable between
/// models with different parameters.
pub(super) fn focal(camera: &Camera, information: &ScaledCholesky, scale: f64) -> [f64; 2] {
    let by_parameters = |x: f64| {
        let projected = camera.project_with_jacobians(&Point3::new(x, 0.0, 1.0)).ok()?;
        Some(DVector::from_iterator(
            projected.by_parameters.len(),
            projected.by_parameters.iter().map(|by| by.x),
        ))
    };
    let on_axis = camera.project_with_jacobians(&Point3::new(0.0, 0.0, 1.0));
    let focal_px = on_axis.map_or(f64::NAN, |projected| projected.by_point[(0, 0)]);
    let sigma =
        by_parameters(BESIDE_AXIS).zip(by_parameters(-BESIDE_AXIS)).map(|(after, before)| {
            scale * information.variance(&((after - before) / (2.0 * BESIDE_AXIS))).sqrt()
        });
    [focal_px, sigma.unwrap_or(f64::NAN)]
}
