//! Point clouds as binary PLY (Turk, "The PLY Polygon File Format", Stanford 1994).

/// One point of a cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPoint {
    /// Position, mm.
    pub position_mm: [f64; 3],
    /// Unit normal.
    pub normal: [f64; 3],
    /// Colour, sRGB.
    pub color: [u8; 3],
    /// Label of the surface that the point lies on.
    pub label: u16,
}

/// A point cloud to which points are added one by one.
///
/// Coordinates are 64-bit, so that a cloud is as precise as the map it comes from.
///
/// ```
/// use fabkit_export::{PointCloud, CloudPoint};
/// let point =
///     CloudPoint { position_mm: [1.0, 2.0, 3.0], normal: [0.0, 0.0, 1.0], color: [9; 3], label: 1 };
/// let mut cloud = PointCloud::new("sensor frame, mm");
/// cloud.push(&point);
/// assert!(cloud.finish().starts_with(b"ply\nformat binary_little_endian 1.0\n"));
/// ```
#[derive(Clone, Debug)]
pub struct PointCloud {
    /// Header before and after the number of points.
    header: [String; 2],
    /// Reserved room for the header, then the points.
    bytes: Vec<u8>,
    count: usize,
}

/// Number of digits of the largest number of points.
const MOST_DIGITS: usize = 20;

impl PointCloud {
    /// Creates a cloud without points; `comment` is one line about frame and labels.
    pub fn new(comment: &str) -> Self {
        // A line break would end the comment and start another header line.
        let comment: String =
            comment.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let properties =
            ["x", "y", "z", "nx", "ny", "nz"].map(|name| format!("property double {name}\n"));
        let colors = ["red", "green", "blue"].map(|name| format!("property uchar {name}\n"));
        let header = [
            format!("ply\nformat binary_little_endian 1.0\ncomment {comment}\nelement vertex "),
            format!(
                "\n{}{}property ushort label\nend_header\n",
                properties.concat(),
                colors.concat()
            ),
        ];
        let room = header[0].len() + MOST_DIGITS + header[1].len();
        Self { header, bytes: vec![0; room], count: 0 }
    }

    /// Adds a point.
    pub fn push(&mut self, point: &CloudPoint) {
        let numbers = point.position_mm.iter().chain(&point.normal);
        numbers.for_each(|number| self.bytes.extend(number.to_le_bytes()));
        self.bytes.extend(point.color);
        self.bytes.extend(point.label.to_le_bytes());
        self.count += 1;
    }

    /// Returns the file.
    pub fn finish(mut self) -> Vec<u8> {
        // The header is written last, at the end of its reserved room, and the unused bytes before it are dropped.
        let [before, after] = &self.header;
        let header = format!("{before}{}{after}", self.count);
        let room = before.len() + MOST_DIGITS + after.len();
        let start = room - header.len();
        self.bytes[start..room].copy_from_slice(header.as_bytes());
        self.bytes.drain(..start);
        self.bytes
    }
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
        let mut cloud = PointCloud::new("a\nb");
        [1.0, 2.0].iter().for_each(|x| cloud.push(&point(*x)));
        let bytes = cloud.finish();
        assert!(bytes.starts_with(b"ply\nformat"));
        let text = String::from_utf8_lossy(&bytes);
        let header = text.find("end_header\n").unwrap() + "end_header\n".len();
        assert!(text[..header].contains("comment a b\nelement vertex 2\n"));
        assert_eq!(bytes.len(), header + 2 * (6 * 8 + 3 + 2));
        assert_eq!(bytes[header + 53..header + 61], 2f64.to_le_bytes());
        assert_eq!(bytes[bytes.len() - 5..], [1, 2, 3, 7, 0]);
    }
}
