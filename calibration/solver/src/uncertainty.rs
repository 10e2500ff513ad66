//! Uncertainty of ground truth: propagates the covariance of a fit to pixels and to depth.

use fabkit_geometry::{Point3, Vector3};
use nalgebra::{DMatrix, Matrix3, RowDVector};

use crate::model::{Contact, FitParameter, Model};

/// Standard deviations at one place of a surface, caused by the uncertainty of a calibration.
///
/// ```
/// use fabkit_calibration::model::{FitParameter, Model};
/// use fabkit_calibration::uncertainty::surface_sigma;
/// use fabkit_camera::{Camera, DMatrix};
/// use fabkit_geometry::{Point3, Pose, Vector3};
/// let model = Model::new(Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// // The distance is known to 0.1 mm, everything else exactly.
/// let mut covariance = DMatrix::zeros(6, 6);
/// covariance[(5, 5)] = 0.01;
/// let (tip, up) = (Point3::new(0.0, 0.0, 15.0), Vector3::z());
/// let sigma = surface_sigma(&model, &FitParameter::POSE, &covariance, tip, up).unwrap();
/// // On the axis that is 0.1 mm of depth, and the pixel stays where it is.
/// assert!((sigma.depth_z_mm - 0.1).abs() < 1e-12 && sigma.pixel_px < 1e-12);
/// // The pixel shows the same point of the surface.
/// assert!(sigma.point_mm < 1e-12);
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSigma {
    /// Standard deviation of the place's pixel, px, root of the sum of squares over both coordinates.
    pub pixel_px: f64,
    /// Standard deviation of the surface's depth at the place's pixel, along the camera's z axis, mm.
    pub depth_z_mm: f64,
    /// Standard deviation of that depth along the line from the camera's centre, mm.
    pub depth_range_mm: f64,
    /// Standard deviation of the surface point that the place's pixel shows, relative to the surface, mm, root of the
    /// sum of squares over the axes.
    pub point_mm: f64,
}

/// Derivatives of one place of a surface, and of what its pixel shows, by a set of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceDerivatives {
    /// Derivative of the place's pixel, px.
    pub pixel: DMatrix<f64>,
    /// Derivative of the surface's third coordinate at the place's pixel, camera frame, mm.
    pub depth_z: RowDVector<f64>,
    /// Derivative of the distance at the place's pixel along the line from the camera's centre, mm.
    pub depth_range: RowDVector<f64>,
    /// Derivative of the surface point that the place's pixel shows, relative to the surface, mm, in axes parallel to
    /// the camera's.
    pub point_mm_by_parameters: DMatrix<f64>,
}

/// Computes the derivatives of one place of a surface by `parameters`.
///
/// Depth belongs to a pixel, not to a place. If the parameters move by `dp`, the surface moves with the pose, and
/// another of its places comes to lie on the pixel. The point that the pixel shows moves by the `dX` that keeps the
/// pixel, `P_X dX + P_p dp = 0`, and stays in the moved tangent plane, `n . (dX - X_p dp) = 0`. Here `P_X` and `P_p`
/// are the derivatives of the projection by the point and by the camera's parameters alone, and `X_p dp` is the motion
/// of the place with the pose. Depth is that of the undisplaced surface: seating, lean and the dome's seat move pins,
/// not the surface.
///
/// The place and its unit normal are in the sensor frame. `None` if the place cannot be seen, or is seen edge on, so
/// that its pixel has no depth of first order.
///
/// ```
/// use fabkit_calibration::model::{Axis, FitParameter, Model};
/// use fabkit_calibration::uncertainty::surface_derivatives;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::{Point3, Pose, Vector3};
/// let model = Model::new(Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// let sideways = [FitParameter::Translation(Axis::X)];
/// // A face on the axis that is 1 mm nearer for each millimetre to +x: if it moves by 1 mm to +x, the pixel
/// // shows a part of it that is 1 mm farther away.
/// let normal = Vector3::new(1.0, 0.0, 1.0).normalize();
/// let by = surface_derivatives(&model, &sideways, Point3::new(0.0, 0.0, 15.0), normal).unwrap();
/// assert!((by.depth_z[0] - 1.0).abs() < 1e-12);
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
pub fn surface_derivatives(
    model: &Model,
    parameters: &[FitParameter],
    place_in_sensor: Point3<f64>,
    normal_in_sensor: Vector3<f64>,
) -> Option<SurfaceDerivatives> {
    let contact = Contact {
        // An index without reseating: no dome moves the place.
        capture: usize::MAX,
        hole: 0,
        contact_in_sensor_mm: place_in_sensor,
        axis_in_sensor: None,
    };
    // Seating and lean move pins, not the surface.
    let bare = Model { seating_offset_mm: 0.0, lean_mm: 0.0, ..model.clone() };
    let mut columns = vec![nalgebra::Vector2::zeros(); parameters.len()];
    bare.differentiate(&contact, parameters, &mut columns).ok()?;
    let place = bare.camera_from_sensor.point(place_in_sensor);
    let normal = bare.camera_from_sensor.vector(normal_in_sensor);
    let by_place = bare.camera.project_with_jacobians(&place).ok()?.by_point;
    // Two conditions keep the pixel, the third keeps the point in the moved tangent plane.
    let system = Matrix3::from_rows(&[
        by_place.row(0).into_owned(),
        by_place.row(1).into_owned(),
        normal.transpose(),
    ]);
    let inverse = system.try_inverse()?;
    let turned = place - bare.camera_from_sensor.translation_mm();
    let count = parameters.len();
    let mut by_z = RowDVector::zeros(count);
    let mut by_range = RowDVector::zeros(count);
    let mut by_pixel = DMatrix::zeros(2, count);
    let mut by_point = DMatrix::zeros(3, count);
    let along = place.coords.normalize();
    for (i, parameter) in parameters.iter().enumerate() {
        let of_pose = match parameter {
            FitParameter::Rotation(axis) => axis.unit().cross(&turned.coords),
            FitParameter::Translation(axis) => axis.unit(),
            FitParameter::FocalScale | FitParameter::InterfaceShift | FitParameter::Camera(_) => {
                Vector3::zeros()
            }
            FitParameter::SeatingOffset
            | FitParameter::Lean
            | FitParameter::LayerScatter
            | FitParameter::LayerSpread
            | FitParameter::Reseating(..) => {
                continue;
            }
        };
        // The part that the place's own motion in the camera frame does not explain: the camera's parameters, and a
        // drawn interface that moves with the pose.
        let of_camera = columns[i] - by_place * of_pose;
        let moved = inverse * Vector3::new(-of_camera.x, -of_camera.y, normal.dot(&of_pose));
        by_z[i] = moved.z;
        by_range[i] = moved.dot(&along);
        by_pixel.set_column(i, &columns[i]);
        // Relative to the surface: the place itself moves with the pose.
        by_point.set_column(i, &(moved - of_pose));
    }
    Some(SurfaceDerivatives {
        pixel: by_pixel,
        depth_z: by_z,
        depth_range: by_range,
        point_mm_by_parameters: by_point,
    })
}

/// Propagates the covariance of `parameters` to one place of a surface; see [`surface_derivatives`].
pub fn surface_sigma(
    model: &Model,
    parameters: &[FitParameter],
    covariance: &DMatrix<f64>,
    place_in_sensor: Point3<f64>,
    normal_in_sensor: Vector3<f64>,
) -> Option<SurfaceSigma> {
    let by = surface_derivatives(model, parameters, place_in_sensor, normal_in_sensor)?;
    let variance = |row: &RowDVector<f64>| (row * covariance * row.transpose())[0].max(0.0);
    let of = |rows: &DMatrix<f64>| (rows * covariance * rows.transpose()).trace().max(0.0);
    Some(SurfaceSigma {
        pixel_px: of(&by.pixel).sqrt(),
        depth_z_mm: variance(&by.depth_z).sqrt(),
        depth_range_mm: variance(&by.depth_range).sqrt(),
        point_mm: of(&by.point_mm_by_parameters).sqrt(),
    })
}
