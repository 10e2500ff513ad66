//! Point clouds as PLY (Turk, "The PLY Polygon File Format", Stanford 1994), binary.

/// One point of a cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// Where, mm.
    pub position_mm: [f64; 3],
    /// Unit normal.
    pub normal: [f64; 3],
    /// sRGB.
    pub color: [u8; 3],
    /// What it belongs to.
    pub label: u16,
}

/// A point cloud; `comment` is one line about frame and labels.
///
/// Coordinates are 64-bit: a cloud loses nothing against the map it comes from.
///
/// ```
/// use fabkit_export::{CloudPoint, ply};
/// let point =
///     CloudPoint { position_mm: [1.0, 2.0, 3.0], normal: [0.0, 0.0, 1.0], color: [9; 3], label: 1 };
/// let bytes = ply("sensor frame, mm", &[point]);
/// assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
/// ```
pub fn ply(comment: &str, points: &[CloudPoint]) -> Vec<u8> {
    // A line break would end the comment and begin something else.
    let comment: String = comment.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let properties =
        ["x", "y", "z", "nx", "ny", "nz"].map(|name| format!("property double {name}\n"));
    let colors = ["red", "green", "blue"].map(|name| format!("property uchar {name}\n"));
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {comment}\nelement vertex {}\n{}{}property \
         ushort label\nend_header\n",
        points.len(),
        properties.concat(),
        colors.concat(),
    )
    .into_bytes();
    for point in points {
        let numbers = point.position_mm.iter().chain(&point.normal);
        bytes.extend(numbers.flat_map(|number| number.to_le_bytes()));
        bytes.extend(point.color);
        bytes.extend(point.label.to_le_bytes());
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_has_its_bytes_after_the_header() {
        let point = |x: f64| CloudPoint {
            position_mm: [x, 0.5, -1.0],
            normal: [0.0, 1.0, 0.0],
            color: [1, 2, 3],
            label: 7,
        };
        let bytes = ply("a\nb", &[point(1.0), point(2.0)]);
        let text = String::from_utf8_lossy(&bytes);
        let header = text.find("end_header\n").unwrap() + "end_header\n".len();
        assert!(text[..header].contains("comment a b\nelement vertex 2\n"));
        assert_eq!(bytes.len(), header + 2 * (6 * 8 + 3 + 2));
        assert_eq!(bytes[header + 53..header + 61], 2f64.to_le_bytes());
        assert_eq!(bytes[bytes.len() - 5..], [1, 2, 3, 7, 0]);
    }
}
