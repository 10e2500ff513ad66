//! Conversions of rotations.

use fabkit_geometry::{Matrix3, Vector3};

use super::RobotCamera;

/// Converts a rotation to roll, pitch and yaw about fixed axes, as in URDF and SDF, rad.
pub(super) fn roll_pitch_yaw(rotation: &Matrix3<f64>) -> [f64; 3] {
    let r = |row: usize, column: usize| rotation[(row, column)];
    // Cosine of the pitch.
    let level = r(0, 0).hypot(r(1, 0));
    let pitch = (-r(2, 0)).atan2(level);
    if level < 1e-9 {
        // Gimbal lock: pointing straight up or down, roll and yaw are the same rotation.
        return [0.0, pitch, (-r(0, 1)).atan2(r(1, 1))];
    }
    [r(2, 1).atan2(r(2, 2)), pitch, r(1, 0).atan2(r(0, 0))]
}

/// Converts a rotation to a unit quaternion: w, x, y, z.
pub(super) fn quaternion(r: &Matrix3<f64>) -> [f64; 4] {
    // The largest component is found by its square, which avoids dividing by small numbers (Shepperd 1978).
    let squares = [
        1.0 + r.trace(),
        1.0 + 2.0 * r[(0, 0)] - r.trace(),
        1.0 + 2.0 * r[(1, 1)] - r.trace(),
        1.0 + 2.0 * r[(2, 2)] - r.trace(),
    ];
    let largest = (0..4).max_by(|a, b| squares[*a].total_cmp(&squares[*b])).unwrap_or(0);
    let double = squares[largest].sqrt();
    let sum = |i: usize, j: usize| (r[(i, j)] + r[(j, i)]) / double / 2.0;
    let difference = |i: usize, j: usize| (r[(i, j)] - r[(j, i)]) / double / 2.0;
    let half = double / 2.0;
    match largest {
        0 => [half, difference(2, 1), difference(0, 2), difference(1, 0)],
        1 => [difference(2, 1), half, sum(0, 1), sum(0, 2)],
        2 => [difference(0, 2), sum(0, 1), half, sum(1, 2)],
        _ => [difference(1, 0), sum(0, 2), sum(1, 2), half],
    }
}

/// Returns the camera's rotation in the convention of OpenGL, MuJoCo and USD, in which cameras look along -z with y up.
pub(super) fn opengl_rotation(camera: &RobotCamera) -> Matrix3<f64> {
    camera.sensor_from_camera.rotation() * Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::{Angle, Pose};

    #[test]
    fn angles_make_the_rotation_again() {
        let deg = |deg: f64| Angle::from_deg(deg).unwrap();
        let [half, third] = [90.0, 33.0].map(deg);
        let (x, y, z) = (Pose::rotation_x, Pose::rotation_y, Pose::rotation_z);
        for pose in [
            Pose::identity(),
            x(third),
            z(third).then_in(y(third)).then_in(x(half)),
            z(third).then_in(y(half)).then_in(x(third)),
            x(deg(180.0)),
        ] {
            let [roll, pitch, yaw] =
                roll_pitch_yaw(pose.rotation()).map(|rad| Angle::from_rad(rad).unwrap());
            let again = z(yaw).then_in(y(pitch)).then_in(x(roll));
            assert!((again.rotation() - pose.rotation()).norm() < 1e-9, "{pose:?}");
            let [w, x, y, z] = quaternion(pose.rotation());
            assert!((w * w + x * x + y * y + z * z - 1.0).abs() < 1e-12);
            // How a quaternion turns x.
            let turned =
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)];
            assert!((pose.rotation().column(0) - Vector3::from(turned)).norm() < 1e-12);
        }
    }
}
