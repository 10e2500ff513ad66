//! How sure the rays are: what a camera is for.
//!
//! Parameters trade against each other. A Double Sphere of which only the middle was seen has a
//! focal length and a xi that nobody can tell apart, and rays that are right all the same. And a
//! turn of all rays together is no error: it turns the camera's frame, and every pose with it. So
//! what is told is how well rays are known among each other: the common turn that fits best over
//! the corners that were seen is taken out of each parameter's effect.

use fabkit_camera::{Camera, Point2, Point3, Vector3};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX};

use super::bundle::State;
use super::{BoardView, points};
use crate::information::ScaledCholesky;

/// Columns and rows of cells into which the image is divided, to see how well rays are known everywhere.
pub const GRID: [u32; 2] = [32, 24];
/// Farther from every corner than this part of the image's longer side nothing was seen.
const NEAR: f64 = 1.0 / 16.0;
/// Most corners that are looked at: enough for a median and a worst.
const MOST_CORNERS: usize = 2000;
/// Off the axis on both sides, where the scale on it is differentiated: derivatives are good to
/// 1e-10, which correlated parameters need.
const BESIDE_AXIS: f64 = 1e-5;

/// Standard deviation of a ray against the others, both directions together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaySigma {
    /// Of its angle, rad.
    pub angle_rad: f64,
    /// Of where the camera sees a thing there, px.
    pub px: f64,
}

/// Over a part of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaySigmas {
    /// The median.
    pub typical: RaySigma,
    /// The largest.
    pub worst: RaySigma,
}

/// How well a camera's rays are known, as far as its lens model holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Rays {
    /// Where corners were seen.
    pub seen: RaySigmas,
    /// In the rest of the image, where the model extrapolates; `None` where there is no rest.
    pub beyond: Option<RaySigmas>,
    /// In the middle of each cell of [`GRID`], row by row from the top; `None` where the lens shows
    /// nothing.
    pub cells: Vec<Option<RaySigma>>,
}

/// A place in the image with the effect of each parameter on its ray.
struct Place {
    direction: Vector3<f64>,
    /// Of the direction, for a step of each parameter.
    by_parameters: Matrix3xX<f64>,
    /// Pixels by the direction.
    by_direction: nalgebra::Matrix2x3<f64>,
}

impl Place {
    /// `None` where the lens shows nothing.
    fn new(camera: &Camera, pixel: &Point2<f64>) -> Option<Self> {
        let direction = camera.unproject(pixel).ok()?.direction;
        let there = camera.project_with_jacobians(&Point3::from(direction)).ok()?;
        // The pixel stays, and so does the ray's length.
        let mut system = Matrix3::zeros();
        system.fixed_rows_mut::<2>(0).copy_from(&there.by_point);
        system.set_row(2, &direction.transpose());
        let inverse = system.try_inverse()?;
        let effects =
            there.by_parameters.iter().map(|by| inverse * Vector3::new(-by.x, -by.y, 0.0));
        let by_parameters = Matrix3xX::from_columns(&effects.collect::<Vec<_>>());
        Some(Self { direction, by_parameters, by_direction: there.by_point })
    }

    fn without_turn(mut self, turns: &Matrix3xX<f64>) -> Self {
        for (mut effect, turn) in self.by_parameters.column_iter_mut().zip(turns.column_iter()) {
            effect -= turn.into_owned().cross(&self.direction);
        }
        self
    }

    fn sigma(&self, information: &ScaledCholesky, scale: f64) -> RaySigma {
        let rows = |matrix: &DMatrix<f64>| -> f64 {
            let squares = matrix.row_iter().map(|row| information.variance(&row.transpose()));
            scale * squares.sum::<f64>().sqrt()
        };
        let of_ray =
            DMatrix::from_fn(3, self.by_parameters.ncols(), |r, c| self.by_parameters[(r, c)]);
        let of_pixel = self.by_direction * &self.by_parameters;
        let of_pixel = DMatrix::from_fn(2, of_pixel.ncols(), |r, c| of_pixel[(r, c)]);
        RaySigma { angle_rad: rows(&of_ray), px: rows(&of_pixel) }
    }
}

/// Of a camera whose parameters have this information for residuals of a scale of 1.
pub(super) fn rays(
    views: &[BoardView],
    state: &State,
    information: &ScaledCholesky,
    scale: f64,
) -> Option<Rays> {
    let camera = &state.camera;
    let corners: Vec<Point2<f64>> =
        points(views, state).map(|(corner, _)| corner.pixel).filter(|p| camera.sees(p)).collect();
    let every = corners.len().div_ceil(MOST_CORNERS).max(1);
    let seen: Vec<Place> =
        corners.iter().step_by(every).filter_map(|pixel| Place::new(camera, pixel)).collect();
    let turns = common_turns(&seen)?;
    let near_px = NEAR * f64::from(camera.width_px().max(camera.height_px()));
    let [columns, rows] = GRID;
    let at = |i: u32, count: u32, size_px: u32| {
        (f64::from(i) + 0.5) / f64::from(count) * f64::from(size_px) - 0.5
    };
    let pixels = (0..rows).flat_map(|r| (0..columns).map(move |c| (c, r))).map(|(c, r)| {
        Point2::new(at(c, columns, camera.width_px()), at(r, rows, camera.height_px()))
    });
    let sigma = |place: Place| place.without_turn(&turns).sigma(information, scale);
    let (mut beyond, mut cells) = (Vec::new(), Vec::new());
    for pixel in pixels {
        let known = Place::new(camera, &pixel).map(sigma);
        cells.push(known);
        let is_far = corners.iter().all(|corner| (corner - pixel).norm() > near_px);
        beyond.extend(known.filter(|_| is_far));
    }
    Some(Rays { seen: over(seen.into_iter().map(sigma).collect())?, beyond: over(beyond), cells })
}

/// For each parameter, the turn that does most nearly what the parameter does.
fn common_turns(places: &[Place]) -> Option<Matrix3xX<f64>> {
    let mut normal = Matrix3::zeros();
    let mut right = Matrix3xX::zeros(places.first()?.by_parameters.ncols());
    for Place { direction, by_parameters, .. } in places {
        normal += Matrix3::identity() - direction * direction.transpose();
        right += direction.cross_matrix() * by_parameters;
    }
    Some(normal.try_inverse()? * right)
}

fn over(mut sigmas: Vec<RaySigma>) -> Option<RaySigmas> {
    sigmas.sort_by(|a, b| a.px.total_cmp(&b.px));
    let worst = sigmas.last()?;
    let largest = sigmas.iter().map(|sigma| sigma.angle_rad).fold(0.0, f64::max);
    let typical = sigmas[sigmas.len() / 2];
    Some(RaySigmas { typical, worst: RaySigma { angle_rad: largest, px: worst.px } })
}

/// Columns per radian on the axis, and the standard deviation: what models with different parameters
/// have in common.
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
