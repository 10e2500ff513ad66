//! Reading of ChArUco markers between corners that are already known.

use fabkit_camera::Point2;
use nalgebra::Matrix3;

use super::Board;
use super::grid::sample;
use crate::image::GreyImage;

/// Smallest correlation between the sampled fields and a marker's pattern. It is 1 for a sharp marker; blur of half a
/// field, or two fields of 36 read wrong, leave about 0.85.
const LEAST_CORRELATION: f64 = 0.7;
/// Smallest lead in correlation of the best marker, in its best rotation, over any other. Two markers that differ in 4
/// of 36 fields correlate by 0.78.
const LEAST_LEAD: f64 = 0.08;
/// Distance of the four additional samples of a field from its centre, in fields along each axis.
const SPREAD: f64 = 0.2;

/// Markers of a board as patterns.
pub(super) struct MarkerReader {
    /// Number of fields along a side, including the dark border.
    fields: usize,
    /// Side of a marker, in squares.
    scale: f64,
    /// Square and pattern of each marker; patterns have zero mean and unit norm.
    patterns: Vec<([u32; 2], Vec<f64>)>,
}

impl MarkerReader {
    /// Prepares the patterns of a board's markers.
    pub(super) fn new(board: &Board) -> Self {
        let fields = board.markers.first().map_or(0, |marker| marker.bits.len()) + 2;
        let pattern = |bits: &[String]| {
            let field = |row: usize, column: usize| {
                let inner = row.checked_sub(1).zip(column.checked_sub(1));
                let bit = inner.and_then(|(r, c)| bits.get(r)?.as_bytes().get(c));
                f64::from(u8::from(bit == Some(&b'1')))
            };
            let all = (0..fields).flat_map(|row| (0..fields).map(move |column| (row, column)));
            normalised(all.map(|(row, column)| field(row, column)).collect())
        };
        let patterns = board.markers.iter();
        Self {
            fields,
            scale: board.marker_mm.unwrap_or(0.0) / board.square_mm,
            // A marker that is dark all over has no pattern and cannot be distinguished from a dark square.
            patterns: patterns
                .filter_map(|marker| Some((marker.square, pattern(&marker.bits)?)))
                .collect(),
        }
    }

    /// Reads the marker in a quadrilateral of corners. Returns the number of quarter turns that bring it upright, and
    /// its square on the board. The corners follow each other in the sense from x to y; after `n` turns the corner `n`
    /// places before the first is the upper left one.
    pub(super) fn read(
        &self,
        image: &GreyImage,
        mut corners: [Point2<f64>; 4],
    ) -> Option<(usize, [u32; 2])> {
        let (mut best, mut second, mut found) = (f64::MIN, f64::MIN, None);
        for quarters in 0..4 {
            // A marker that reaches out of the image is not read.
            let seen = self.fields(image, corners)?;
            for (square, pattern) in &self.patterns {
                let correlation = pattern.iter().zip(&seen).map(|(a, b)| a * b).sum();
                if correlation > best {
                    (best, second, found) = (correlation, best, Some((quarters, *square)));
                } else if correlation > second {
                    second = correlation;
                }
            }
            corners.rotate_right(1);
        }
        found.filter(|_| best >= LEAST_CORRELATION && best - second >= LEAST_LEAD)
    }

    /// Samples the fields of a marker that is upright in the quadrilateral, row by row, normalised.
    fn fields(&self, image: &GreyImage, corners: [Point2<f64>; 4]) -> Option<Vec<f64>> {
        let map = homography_from_unit_square(corners)?;
        let margin = 0.5 * (1.0 - self.scale);
        let step = self.scale / self.fields as f64;
        let offsets = [(0.0, 0.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
        let mut seen = Vec::with_capacity(self.fields * self.fields);
        for row in 0..self.fields {
            for column in 0..self.fields {
                let mut sum = 0.0;
                for (dx, dy) in offsets {
                    let x = margin + step * (column as f64 + 0.5 + SPREAD * dx);
                    let y = margin + step * (row as f64 + 0.5 + SPREAD * dy);
                    sum += sample(image, map.transform_point(&Point2::new(x, y)))?;
                }
                seen.push(sum);
            }
        }
        normalised(seen)
    }
}

/// Removes the mean and scales to unit norm; `None` if all values are the same.
fn normalised(mut values: Vec<f64>) -> Option<Vec<f64>> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter_mut().for_each(|v| *v -= mean);
    let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    values.iter_mut().for_each(|v| *v /= norm);
    (norm > 1e-6).then_some(values)
}

/// Computes the homography from the unit square (y down) to a quadrilateral, in closed form (P. Heckbert, "Fundamentals
/// of Texture Mapping and Image Warping", 1989).
fn homography_from_unit_square([a, b, c, d]: [Point2<f64>; 4]) -> Option<Matrix3<f64>> {
    let (p, q, s) = (b - c, d - c, (a - b) + (c - d));
    // Three corners on a line make this 0 and the map infinite, which is refused below.
    let area = p.x * q.y - p.y * q.x;
    let (g, h) = ((s.x * q.y - s.y * q.x) / area, (p.x * s.y - p.y * s.x) / area);
    let x = (b - a) + b.coords * g;
    let y = (d - a) + d.coords * h;
    let map = Matrix3::new(x.x, y.x, a.x, x.y, y.y, a.y, g, h, 1.0);
    map.iter().all(|v| v.is_finite()).then_some(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_square_is_mapped_to_the_quadrilateral() {
        let quad = [(10.0, 12.0), (41.0, 9.0), (46.0, 33.0), (8.0, 38.0)];
        let quad = quad.map(|(x, y)| Point2::new(x, y));
        let map = homography_from_unit_square(quad).unwrap();
        let unit = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        for ((x, y), expected) in unit.into_iter().zip(quad) {
            assert!((map.transform_point(&Point2::new(x, y)) - expected).norm() < 1e-12);
        }
        assert!(homography_from_unit_square([quad[0]; 4]).is_none());
    }
}
