//! What the three formats have in common.

use fabkit_geometry::{Matrix3, Pose, Vector3};

/// Millimetres in a metre.
pub(super) const MM_PER_M: f64 = 1000.0;

/// To nine digits, in the fewest characters.
pub(super) fn number(value: f64) -> String {
    // What was written to nine digits reads as a number.
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    if rounded == 0.0 { "0".to_owned() } else { rounded.to_string() }
}

pub(super) fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(number).collect::<Vec<_>>().join(" ")
}

/// Metres.
pub(super) fn place(pose: &Pose) -> String {
    numbers(pose.translation_mm().iter().map(|mm| mm / MM_PER_M))
}

pub(super) fn vector(vector: &Vector3<f64>) -> String {
    numbers(vector.iter().copied())
}

/// Roll, pitch and yaw about fixed axes, as URDF and SDF have them, rad.
pub(super) fn roll_pitch_yaw(rotation: &Matrix3<f64>) -> [f64; 3] {
    let r = |row: usize, column: usize| rotation[(row, column)];
    let level = r(0, 0).hypot(r(1, 0));
    let pitch = (-r(2, 0)).atan2(level);
    if level < 1e-9 {
        // Straight up or down, roll and yaw are one.
        return [0.0, pitch, (-r(0, 1)).atan2(r(1, 1))];
    }
    [r(2, 1).atan2(r(2, 2)), pitch, r(1, 0).atan2(r(0, 0))]
}

/// Text in an attribute or between tags.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            other => escaped.push(other),
        }
    }
    escaped
}

/// A comment may not hold two hyphens in a row.
pub(super) fn comment(text: &str) -> String {
    format!("<!-- {} -->", text.replace("--", "- -"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::Angle;

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
        }
    }

    #[test]
    fn numbers_are_short_and_exact_enough() {
        assert_eq!(numbers([0.0, -0.0, 0.1, 1e-9 / 3.0]), "0 0 0.1 0.000000000333333333");
    }
}
