//! How sure ground truth is: from the covariance of a fit to pixels and to depth.

use fabkit_geometry::{Point3, Vector3};
use nalgebra::{DMatrix, Matrix3, RowDVector};

use crate::model::{Contact, FitParameter, Model};

/// What the uncertainty of a calibration does to one place of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSigma {
    /// Standard deviation of where the place is seen, px, root of the sum of squares over both
    /// coordinates.
    pub pixel_px: f64,
    /// Standard deviation of the depth that the surface has at the place's pixel, along the
    /// camera's z, mm.
    pub depth_z_mm: f64,
    /// The same along the line from the camera's centre, mm.
    pub depth_range_mm: f64,
    /// The same of the point that the place's pixel shows, as it lies on the surface, mm: root of the sum of squares over the
    /// axes.
    pub point_mm: f64,
}

/// How a place of a surface, as a pixel shows it, changes with each of some parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceDerivatives {
    /// Where the place is seen, px.
    pub pixel: DMatrix<f64>,
    /// The surface's third coordinate at the place's pixel, camera frame, mm.
    pub depth_z: RowDVector<f64>,
    /// The same along the line from the camera's centre, mm.
    pub depth_range: RowDVector<f64>,
    /// The point of the surface that the place's pixel shows, as it lies on the surface, mm: turned as the camera is.
    pub point: DMatrix<f64>,
}

/// How one place of a surface changes with `parameters`.
///
/// Depth belongs to a pixel, not to a place. If the parameters move by `dp`, the surface moves
/// with the pose, and another of its places comes to lie on the pixel: the point that the pixel
/// shows moves by the `dX` for which the pixel stays, `P_X dX + P_p dp = 0`, and that stays in the
/// moved tangent plane, `n . (dX - X_p dp) = 0`. Here `P_X` and `P_p` are the derivatives of the
/// projection by the point and by the camera's parameters alone, and `X_p dp` is what the pose does
/// to the place. Depth is that of the undisplaced surface: seating, lean and the dome's seat belong
/// to pins, not to it.
///
/// The place and its unit normal are in the sensor frame. `None` where the place cannot be seen, or
/// is seen edge on, so that its pixel has no depth of first order.
pub fn surface_derivatives(
    model: &Model,
    parameters: &[FitParameter],
    place_in_sensor: Point3<f64>,
    normal_in_sensor: Vector3<f64>,
) -> Option<SurfaceDerivatives> {
    let contact = Contact {
        // A capture of its own, in which no dome is seated.
        capture: usize::MAX,
        hole: 0,
        contact_in_sensor_mm: place_in_sensor,
        axis_in_sensor: None,
    };
    let bare = Model { seating_offset_mm: 0.0, lean_mm: 0.0, ..model.clone() };
    let mut columns = vec![nalgebra::Vector2::zeros(); parameters.len()];
    bare.differentiate(&contact, parameters, &mut columns).ok()?;
    let place = bare.camera_from_sensor.point(place_in_sensor);
    let normal = bare.camera_from_sensor.vector(normal_in_sensor);
    let by_place = bare.camera.project_with_jacobians(&place).ok()?.by_point;
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
        // What the place's own motion in the camera frame does not explain; a pose moves a drawn interface too.
        let of_camera = columns[i] - by_place * of_pose;
        let moved = inverse * Vector3::new(-of_camera.x, -of_camera.y, normal.dot(&of_pose));
        by_z[i] = moved.z;
        by_range[i] = moved.dot(&along);
        by_pixel.set_column(i, &columns[i]);
        // The place itself goes with the pose.
        by_point.set_column(i, &(moved - of_pose));
    }
    Some(SurfaceDerivatives {
        pixel: by_pixel,
        depth_z: by_z,
        depth_range: by_range,
        point: by_point,
    })
}

/// Propagates the covariance of `parameters` to one place of a surface: see [`surface_derivatives`].
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
        point_mm: of(&by.point).sqrt(),
    })
}
