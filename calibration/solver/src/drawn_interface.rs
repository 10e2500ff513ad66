//! Interface that the design draws between lens and pins.
//!
//! The interface is fixed in the sensor, whatever the camera's pose is: relative to a tilted camera it is tilted. So a
//! fit does not solve for its place in the camera frame. The place follows from the pose, up to the tolerances of molds
//! and prints.

use fabkit_camera::{FlatInterface, Interface, SphericalInterface};
use fabkit_geometry::{Point3, Pose, Vector3};
use nalgebra::SMatrix;

/// Standard deviation of the interface's distance from its drawn place, mm: it is cast against a printed lid, which is
/// good to some tenths, in a shell that is printed too.
pub const PLACE_SIGMA_MM: f64 = 0.3;
/// Standard deviation of a medium's refractive index: silicones of one kind are sold with 1.40 to 1.43.
pub const INDEX_SIGMA: f64 = 0.01;

/// Largest number of parameters of an interface, as in [`fabkit_camera::Camera::parameters`].
pub(crate) const PARAMETERS: usize = 5;

/// Derivatives of an interface's parameters, in the order of [`fabkit_camera::Camera::parameters`], by the six
/// parameters of the pose and by the shift, in their units.
pub(crate) type InterfaceJacobian = SMatrix<f64, PARAMETERS, 7>;

/// Interface at its place in the sensor.
///
/// ```
/// use fabkit_calibration::drawn_interface::DrawnInterface;
/// use fabkit_camera::{FlatInterface, Interface};
/// use fabkit_geometry::Pose;
/// let gel = Interface::Flat(FlatInterface::bare_in_air(5.0, 1.41));
/// let drawn = DrawnInterface::new(&gel, &Pose::translation(0.0, 0.0, 7.0)).unwrap();
/// // The gel stays where it is in the sensor: for a camera 0.5 mm farther back, 0.5 mm farther away.
/// let farther_back = Pose::translation(0.0, 0.0, 7.5);
/// let seen = drawn.interface_at(&farther_back, 0.0, drawn.index_outside());
/// assert_eq!(seen, Interface::Flat(FlatInterface::bare_in_air(5.5, 1.41)));
/// assert!(DrawnInterface::new(&Interface::None, &farther_back).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnInterface {
    /// Interface relative to the camera at its designed pose.
    designed_interface: Interface,
    shape: Shape,
    index_outside: f64,
}

/// Shape of the interface, sensor frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// Plane through `point` of the first face, with the unit normal away from the lens.
    Flat { point: Point3<f64>, normal: Vector3<f64>, as_seen: FlatInterface },
    /// Sphere that shifts along `ahead`, the viewing direction of the camera at its designed pose.
    Sphere { centre: Point3<f64>, ahead: Vector3<f64>, as_seen: SphericalInterface },
}

impl DrawnInterface {
    /// Creates the interface from the one that a camera at `camera_from_sensor` has; `None` if that refracts no rays.
    pub fn new(seen: &Interface, camera_from_sensor: &Pose) -> Option<Self> {
        let sensor_from_camera = camera_from_sensor.inverse();
        let (shape, index_outside) = match seen {
            Interface::None | Interface::FromDrawing => return None,
            Interface::Flat(flat) => {
                let normal_in_camera = flat.normal();
                let point = Point3::from(normal_in_camera * flat.distance_mm);
                let shape = Shape::Flat {
                    point: sensor_from_camera.point(point),
                    normal: sensor_from_camera.vector(normal_in_camera),
                    as_seen: *flat,
                };
                (shape, flat.index_outside)
            }
            Interface::Sphere(sphere) => {
                let shape = Shape::Sphere {
                    centre: sensor_from_camera.point(sphere.centre_in_camera),
                    ahead: sensor_from_camera.vector(Vector3::z()),
                    as_seen: *sphere,
                };
                (shape, sphere.index_outside)
            }
        };
        Some(Self { designed_interface: *seen, shape, index_outside })
    }

    /// Interface relative to the camera at its designed pose.
    pub fn designed_interface(&self) -> &Interface {
        &self.designed_interface
    }

    /// Refractive index behind the interface by design.
    pub fn index_outside(&self) -> f64 {
        self.index_outside
    }

    /// Computes the interface relative to a camera at another pose, if it lies `shift_mm` farther from the lens than
    /// drawn.
    #[must_use]
    pub fn interface_at(
        &self,
        camera_from_sensor: &Pose,
        shift_mm: f64,
        index_outside: f64,
    ) -> Interface {
        match self.shape {
            Shape::Flat { point, normal, as_seen } => {
                let n = camera_from_sensor.vector(normal);
                let distance_mm = n.dot(&camera_from_sensor.point(point).coords) + shift_mm;
                // Inverts `FlatInterface::normal`: (sin ty, -sin tx cos ty, cos tx cos ty).
                let (tilt_x_rad, tilt_y_rad) = ((-n.y).atan2(n.z), n.x.clamp(-1.0, 1.0).asin());
                let placed = FlatInterface { distance_mm, tilt_x_rad, tilt_y_rad, ..as_seen };
                Interface::Flat(FlatInterface { index_outside, ..placed })
            }
            Shape::Sphere { centre, ahead, as_seen } => {
                let centre_in_camera = camera_from_sensor.point(centre + ahead * shift_mm);
                Interface::Sphere(SphericalInterface { centre_in_camera, index_outside, ..as_seen })
            }
        }
    }

    /// Computes the derivatives of [`DrawnInterface::interface_at`] by the pose and the shift.
    pub(crate) fn interface_by_pose(
        &self,
        camera_from_sensor: &Pose,
        shift_mm: f64,
    ) -> InterfaceJacobian {
        let mut by = InterfaceJacobian::zeros();
        let translation = *camera_from_sensor.translation_mm();
        match self.shape {
            Shape::Flat { normal, .. } => {
                // The distance is n . t plus a term that the pose does not change.
                let n = camera_from_sensor.vector(normal);
                let (across, along) = ((n.y * n.y + n.z * n.z), (1.0 - n.x * n.x).sqrt());
                for axis in 0..3 {
                    let turned = Vector3::ith(axis, 1.0).cross(&n);
                    by[(0, axis)] = turned.dot(&translation);
                    by[(1, axis)] = (n.y * turned.z - n.z * turned.y) / across;
                    by[(2, axis)] = turned.x / along;
                    by[(0, 3 + axis)] = n[axis];
                }
                by[(0, 6)] = 1.0;
            }
            Shape::Sphere { centre, ahead, .. } => {
                let from_origin = camera_from_sensor.vector((centre + ahead * shift_mm).coords);
                for axis in 0..3 {
                    let turned = Vector3::ith(axis, 1.0).cross(&from_origin);
                    by.fixed_view_mut::<3, 1>(0, axis).copy_from(&turned);
                    by[(axis, 3 + axis)] = 1.0;
                }
                by.fixed_view_mut::<3, 1>(0, 6).copy_from(&camera_from_sensor.vector(ahead));
            }
        }
        by
    }
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::Angle;

    use super::*;

    fn values(interface: &Interface) -> [f64; PARAMETERS] {
        match interface {
            Interface::None | Interface::FromDrawing => unreachable!("drawn"),
            Interface::Flat(f) => [f.distance_mm, f.tilt_x_rad, f.tilt_y_rad, f.index_outside, 0.0],
            Interface::Sphere(s) => {
                let c = s.centre_in_camera;
                [c.x, c.y, c.z, s.radius_mm, s.index_outside]
            }
        }
    }

    /// The pose with one of its parameters, or the shift, moved.
    fn moved(pose: &Pose, parameter: usize, step: f64) -> (Pose, f64) {
        let mut turn = Vector3::zeros();
        let mut shift = *pose.translation_mm();
        match parameter {
            0..3 => turn[parameter] = step,
            3..6 => shift[parameter - 3] += step,
            _ => return (*pose, step),
        }
        let rotation = nalgebra::Rotation3::new(turn).matrix() * pose.rotation();
        (Pose::new(rotation, shift).unwrap(), 0.0)
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let designed = Pose::translation(0.3, -0.2, 7.0);
        let askew = Pose::rotation_x(Angle::from_deg(7.0).unwrap())
            .then_in(Pose::rotation_y(Angle::from_deg(-4.0).unwrap()))
            .then_in(Pose::translation(0.5, 0.9, 6.0));
        let flat = FlatInterface {
            tilt_x_rad: 0.05,
            tilt_y_rad: -0.1,
            ..FlatInterface::bare_in_air(2.0, 1.41)
        };
        let sphere = SphericalInterface {
            centre_in_camera: Point3::new(0.4, 0.1, 3.0),
            radius_mm: 9.0,
            index_inside: 1.0,
            index_outside: 1.41,
            has_drawn_bodies_behind: false,
        };
        for seen in [Interface::Flat(flat), Interface::Sphere(sphere)] {
            let drawn = DrawnInterface::new(&seen, &designed).unwrap();
            let by = drawn.interface_by_pose(&askew, 0.0);
            for parameter in 0..7 {
                let at = |step| {
                    let (pose, shift_mm) = moved(&askew, parameter, step);
                    values(&drawn.interface_at(&pose, shift_mm, 1.41))
                };
                // Central differences of smooth functions of size 10: 1e-5 squared and rounding.
                let (more, less) = (at(1e-5), at(-1e-5));
                for row in 0..PARAMETERS {
                    let slope = (more[row] - less[row]) / 2e-5;
                    assert!((slope - by[(row, parameter)]).abs() < 1e-8, "{row} {parameter}");
                }
            }
            // From the original pose the interface is the original one.
            let again = values(&drawn.interface_at(&designed, 0.0, 1.41));
            for (a, b) in again.iter().zip(values(&seen)) {
                assert!((a - b).abs() < 1e-12);
            }
        }
    }
}
