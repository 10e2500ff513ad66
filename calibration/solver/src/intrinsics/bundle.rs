//! Bundle adjustment: Levenberg-Marquardt method over one camera and the poses of all views.
//!
//! The poses are eliminated from each step (Schur complement). The system that is solved has the size of the camera's
//! parameters, whatever the number of views, and at the end it is the information of all views about the camera.

use fabkit_camera::{Camera, Point2, Point3};
use fabkit_geometry::Pose;
use nalgebra::{
    Cholesky, DMatrix, DVector, Matrix2x3, Matrix6, Rotation3, SMatrix, Vector2, Vector3, Vector6,
};

use super::BoardView;
use crate::information::ScaledCholesky;

/// Largest number of iterations for one scale of the residuals.
const MAX_ITERATIONS: usize = 200;
/// Largest number of times that the scale of the residuals is estimated again.
const MAX_ROUNDS: usize = 6;
/// Relative decrease of the cost below which the iteration ends.
const COST_TOLERANCE: f64 = 1e-12;
/// Damping of the first step, as a fraction of the normal matrix's diagonal.
const START_DAMPING: f64 = 1e-4;
/// Damping at which the iteration ends.
const MAX_DAMPING: f64 = 1e10;
/// Threshold of the Huber loss, in standard deviations: longer residuals count by their length (Huber 1964).
const HUBER: f64 = 3.0;
/// Median length of a normally distributed residual of two coordinates, in standard deviations of one: sqrt(2 ln 2).
const MEDIAN_LENGTH: f64 = 1.177_410_022_515_474_7;
/// Damping when a view is held out, in squared sines: combinations of parameters that nothing determines stay
/// unchanged.
const HELD_OUT_DAMPING: f64 = 1e-9;

/// Camera, and its pose relative to the board in each view.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub camera: Camera,
    pub cameras_from_board: Vec<Pose>,
}

/// Result of a bundle adjustment.
#[derive(Clone, Debug)]
pub(super) struct BundleSolution {
    pub state: State,
    /// Ratio of the residuals' standard deviation to that stated by the views.
    pub scale: f64,
    /// Robust sum of squares, in standard deviations that the views state.
    pub cost: f64,
    /// Information of each view about the free parameters, with its own pose unknown; for `scale` 1.
    pub informations: Vec<DMatrix<f64>>,
    /// Cost of each view as if it had been held out, with its own pose fixed: to first order, and infinite if the
    /// others do not determine the camera.
    pub held_out: Vec<f64>,
}

/// Computes observed minus projected, px; `None` outside the lens's domain.
pub(super) fn residual(
    camera: &Camera,
    pose: &Pose,
    in_board_mm: &Point2<f64>,
    pixel: &Point2<f64>,
) -> Option<Vector2<f64>> {
    let point = pose.point(Point3::new(in_board_mm.x, in_board_mm.y, 0.0));
    Some(pixel - camera.project(&point).ok()?)
}

/// Fits the camera's parameters marked as `free`, and all poses. `None` if the start is not within the lens's domain,
/// or if there are no more coordinates than unknowns.
pub(super) fn fit(views: &[BoardView], start: State, free: &[bool]) -> Option<BundleSolution> {
    let mut state = start;
    let mut scale = robust_scale(views, &state)?;
    for _ in 0..MAX_ROUNDS {
        state = minimise(views, state, free, scale)?;
        let next = robust_scale(views, &state)?;
        // The scale decides which residuals count by their length, and these decide the scale.
        let settled = (next - scale).abs() <= 1e-3 * scale;
        scale = next;
        if settled {
            break;
        }
    }
    let normal = NormalEquations::build(views, &state, free, scale)?;
    let observations: usize = views.iter().map(|view| view.corners.len()).sum();
    let unknowns = free.iter().filter(|f| **f).count() + 6 * views.len();
    let freedom = (2 * observations).checked_sub(unknowns).filter(|n| *n > 0)? as f64;
    let informations: Vec<_> = normal.views.iter().map(|view| view.camera_information()).collect();
    let held_out = held_out_costs(&normal.views, &informations);
    let scale = (normal.cost / freedom).sqrt();
    Some(BundleSolution { state, scale, cost: normal.cost, informations, held_out })
}

/// Computes the costs of held-out views. At the minimum a view's gradient balances the sum of the others'. Without the
/// view the camera moves by the step that this gradient gives, and the view's cost grows as its own normal equations
/// predict.
fn held_out_costs(views: &[ViewNormal], informations: &[DMatrix<f64>]) -> Vec<f64> {
    let total: DMatrix<f64> = informations.iter().sum();
    let one = |(view, information): (&ViewNormal, &DMatrix<f64>)| {
        let others = ScaledCholesky::damped(&(&total - information), HELD_OUT_DAMPING);
        let Some((others, gradient)) = others.zip(view.gradient()) else {
            return f64::INFINITY;
        };
        let away = others.solve(&gradient);
        view.cost + 2.0 * gradient.dot(&away) + away.dot(&(information * &away))
    };
    views.iter().zip(informations).map(one).collect()
}

/// Estimates the residuals' standard deviation relative to the stated one, from the median, which outliers hardly
/// affect.
fn robust_scale(views: &[BoardView], state: &State) -> Option<f64> {
    let mut lengths = Vec::new();
    for (view, pose) in views.iter().zip(&state.cameras_from_board) {
        for corner in &view.corners {
            let residual = residual(&state.camera, pose, &corner.in_board_mm, &corner.pixel)?;
            lengths.push(residual.norm() / corner.sigma_px);
        }
    }
    let middle = lengths.len() / 2;
    let (_, median, _) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
    // Perfect data have residuals of rounding only.
    Some((*median / MEDIAN_LENGTH).max(1e-9))
}

/// Minimises the cost for a fixed scale of the residuals.
fn minimise(views: &[BoardView], start: State, free: &[bool], scale: f64) -> Option<State> {
    let mut state = start;
    let mut normal = NormalEquations::build(views, &state, free, scale)?;
    let mut damping = START_DAMPING;
    for _ in 0..MAX_ITERATIONS {
        let tried = normal.step(damping).and_then(|step| step.apply(&state, free));
        let next = tried.and_then(|tried| {
            let next = NormalEquations::build(views, &tried, free, scale)?;
            (next.cost <= normal.cost).then_some((tried, next))
        });
        match next {
            Some((tried, next)) => {
                let gain = normal.cost - next.cost;
                let done = gain <= COST_TOLERANCE * normal.cost;
                (state, normal) = (tried, next);
                damping = (damping * 0.1).max(1e-12);
                if done {
                    break;
                }
            }
            // No shorter step helps either: the cost is as low as rounding allows.
            None if damping > MAX_DAMPING => break,
            None => damping *= 10.0,
        }
    }
    Some(state)
}

/// Part of the normal equations of one view.
struct ViewNormal {
    /// Block of the camera's parameters.
    camera: DMatrix<f64>,
    /// Block of the camera's parameters and the pose.
    mixed: DMatrix<f64>,
    pose: Matrix6<f64>,
    camera_gradient: DVector<f64>,
    pose_gradient: Vector6<f64>,
    cost: f64,
}

impl ViewNormal {
    /// Computes the gradient by the camera if the pose is eliminated.
    fn gradient(&self) -> Option<DVector<f64>> {
        let pose = Cholesky::new(self.pose)?;
        Some(&self.camera_gradient - &self.mixed * pose.solve(&self.pose_gradient))
    }

    /// Computes the information about the camera with the pose unknown.
    fn camera_information(&self) -> DMatrix<f64> {
        match Cholesky::new(self.pose) {
            Some(pose) => &self.camera - &self.mixed * pose.solve(&self.mixed.transpose()),
            None => DMatrix::zeros(self.camera.nrows(), self.camera.nrows()),
        }
    }
}

struct NormalEquations {
    views: Vec<ViewNormal>,
    cost: f64,
}

/// Step of the camera's free parameters and of each pose (a turn and a shift, camera frame).
struct Step {
    camera: DVector<f64>,
    poses: Vec<Vector6<f64>>,
}

impl NormalEquations {
    /// Builds the normal equations; `None` if a corner lies outside the lens's domain.
    fn build(views: &[BoardView], state: &State, free: &[bool], scale: f64) -> Option<Self> {
        let columns: Vec<usize> = (0..free.len()).filter(|i| free[*i]).collect();
        let count = columns.len();
        let mut cost = 0.0;
        let mut normals = Vec::with_capacity(views.len());
        for (view, pose) in views.iter().zip(&state.cameras_from_board) {
            let mut normal = ViewNormal {
                camera: DMatrix::zeros(count, count),
                mixed: DMatrix::zeros(count, 6),
                pose: Matrix6::zeros(),
                camera_gradient: DVector::zeros(count),
                pose_gradient: Vector6::zeros(),
                cost: 0.0,
            };
            for corner in &view.corners {
                let [x, y] = [corner.in_board_mm.x, corner.in_board_mm.y];
                let turned = pose.vector(Vector3::new(x, y, 0.0));
                let point = Point3::from(turned + pose.translation_mm());
                let projected = state.camera.project_with_jacobians(&point).ok()?;
                let residual = corner.pixel - projected.pixel;
                let length = residual.norm() / (corner.sigma_px * scale);
                // At a residual of 0 the ratio is infinite, and the weight 1.
                let weight = (HUBER / length).min(1.0);
                let precision = corner.sigma_px.powi(-2);
                normal.cost += precision
                    * if weight < 1.0 {
                        // Beyond the threshold the cost continues along the parabola's tangent.
                        residual.norm_squared() * weight * (2.0 - weight)
                    } else {
                        residual.norm_squared()
                    };
                let weight = weight * precision;
                let by_pose = pixel_by_pose(&projected.by_point, &turned);
                for (i, &column) in columns.iter().enumerate() {
                    let by_i = projected.by_parameters[column] * weight;
                    normal.camera_gradient[i] += by_i.dot(&residual);
                    for (j, &other) in columns[..=i].iter().enumerate() {
                        normal.camera[(i, j)] += by_i.dot(&projected.by_parameters[other]);
                    }
                    let mixed = by_i.transpose() * by_pose;
                    for j in 0..6 {
                        normal.mixed[(i, j)] += mixed[j];
                    }
                }
                normal.pose += by_pose.transpose() * by_pose * weight;
                normal.pose_gradient += by_pose.transpose() * residual * weight;
            }
            normal.camera.fill_upper_triangle_with_lower_triangle();
            cost += normal.cost;
            normals.push(normal);
        }
        Some(Self { views: normals, cost })
    }

    /// Solves for a damped step; `None` if the equations are singular.
    fn step(&self, damping: f64) -> Option<Step> {
        let count = self.views.first()?.camera_gradient.len();
        let mut camera = DMatrix::zeros(count, count);
        let mut gradient = DVector::zeros(count);
        let mut poses = Vec::with_capacity(self.views.len());
        for view in &self.views {
            // Each pose is damped and eliminated, then the camera's block is damped and solved.
            let mut pose = view.pose;
            for i in 0..6 {
                pose[(i, i)] *= 1.0 + damping;
            }
            let pose = Cholesky::new(pose)?;
            camera += &view.camera;
            for i in 0..count {
                camera[(i, i)] += damping * view.camera[(i, i)];
            }
            camera -= &view.mixed * pose.solve(&view.mixed.transpose());
            gradient += &view.camera_gradient - &view.mixed * pose.solve(&view.pose_gradient);
            poses.push(pose);
        }
        let step =
            if count > 0 { ScaledCholesky::new(&camera)?.solve(&gradient) } else { gradient };
        let of_pose = |(view, pose): (&ViewNormal, &Cholesky<f64, nalgebra::Const<6>>)| {
            // Back substitution of the camera's step.
            pose.solve(&(view.pose_gradient - view.mixed.transpose() * &step))
        };
        let poses = self.views.iter().zip(&poses).map(of_pose).collect();
        Some(Step { camera: step, poses })
    }
}

/// Computes the derivative of a pixel by a turn of the pose about the camera's axes and a shift along them.
fn pixel_by_pose(by_point: &Matrix2x3<f64>, turned: &Vector3<f64>) -> SMatrix<f64, 2, 6> {
    let by_turn = -by_point * turned.cross_matrix();
    let mut both = SMatrix::<f64, 2, 6>::zeros();
    both.fixed_columns_mut::<3>(0).copy_from(&by_turn);
    both.fixed_columns_mut::<3>(3).copy_from(by_point);
    both
}

impl Step {
    /// Applies the step; `None` if no such camera exists.
    fn apply(&self, state: &State, free: &[bool]) -> Option<State> {
        let mut values: Vec<f64> = state.camera.parameters().iter().map(|(_, v)| *v).collect();
        let mut steps = self.camera.iter();
        for (value, _) in values.iter_mut().zip(free).filter(|(_, free)| **free) {
            *value += steps.next()?;
        }
        let camera = state.camera.with_parameters(&values).ok()?;
        let moved = |(pose, step): (&Pose, &Vector6<f64>)| {
            let turn = Rotation3::from_scaled_axis(step.fixed_rows::<3>(0).into_owned());
            let shift = pose.translation_mm() + step.fixed_rows::<3>(3);
            Pose::new(turn.matrix() * pose.rotation(), shift)
        };
        let poses = state.cameras_from_board.iter().zip(&self.poses).map(moved);
        Some(State { camera, cameras_from_board: poses.collect::<Option<_>>()? })
    }
}
