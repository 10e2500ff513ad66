//! Rounded outer edges of a housing, which hands touch.

use fabkit_geometry::Path;

/// Tangent points closer than this are treated as one, mm.
const SAME_MM: f64 = 1e-12;

/// Returns a closed polygon whose corners are rounded by a radius each, mm; 0 for a sharp corner. The first corner is
/// always sharp.
///
/// ```
/// use fabkit_designs::blocks::edge::rounded;
/// use std::f64::consts::FRAC_PI_4;
/// // A square of 10 mm whose upper right corner is rounded by 2 mm.
/// let corners = [([0.0, 0.0], 0.0), ([10.0, 0.0], 0.0), ([10.0, 10.0], 2.0), ([0.0, 10.0], 0.0)];
/// let area_mm2 = rounded(&corners).signed_area_mm2();
/// assert!((area_mm2 - (100.0 - (1.0 - FRAC_PI_4) * 2.0 * 2.0)).abs() < 1e-9);
/// ```
pub fn rounded(corners: &[([f64; 2], f64)]) -> Path {
    let count = corners.len();
    let start = corners.first().map_or([0.0; 2], |(at, _)| *at);
    let to = |path: Path, at: [f64; 2]| {
        let end = path.end();
        if (at[0] - end[0]).hypot(at[1] - end[1]) < SAME_MM { path } else { path.line(at) }
    };
    let path = corners.iter().enumerate().skip(1).fold(Path::from(start), |path, (i, corner)| {
        let (at, radius) = *corner;
        if radius == 0.0 {
            return to(path, at);
        }
        let [back, on] = [i - 1, (i + 1) % count].map(|other| direction(at, corners[other].0));
        let (cos, sin) = (back[0] * on[0] + back[1] * on[1], on[0] * back[1] - on[1] * back[0]);
        // Tangent points, and the centre on the bisector of the corner.
        let reach = radius * (1.0 + cos) / sin.abs();
        let along = |way: [f64; 2]| [at[0] + reach * way[0], at[1] + reach * way[1]];
        let off = radius / sin.abs();
        let centre = [0, 1].map(|axis| at[axis] + off * (back[axis] + on[axis]));
        to(path, along(back)).arc(along(on), centre, sin > 0.0)
    });
    path.close()
}

/// Returns the unit vector from one point to another.
fn direction(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = way[0].hypot(way[1]);
    way.map(|part| part / length)
}

/// Returns the largest radius of an edge between two perpendicular faces that leaves a point untouched which lies at
/// the given distances (mm) behind them: the larger one of the two circles through it that touch both faces.
pub fn max_radius_sparing_mm(behind_mm: [f64; 2]) -> f64 {
    let [a, b] = behind_mm.map(|mm| mm.max(0.0));
    // Larger root of (r - a)^2 + (r - b)^2 = r^2.
    a + b + (2.0 * a * b).sqrt()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_4, PI};

    use super::*;

    #[test]
    fn rounded_corner_removes_the_expected_area() {
        // At a right angle (1 - pi/4) r^2; of 135 degrees r^2 (tan 22.5 - pi/8).
        let (r, s) = (1.5, 0.8);
        let square = [([0.0; 2], 0.0), ([9.0, 0.0], r), ([9.0, 7.0], 0.0), ([0.0, 7.0], s)];
        let area = rounded(&square).signed_area_mm2();
        assert!((area - (63.0 - (1.0 - FRAC_PI_4) * (r * r + s * s))).abs() < 1e-12, "{area}");
        let cut = [([0.0; 2], 0.0), ([0.0, 5.0], 0.0), ([4.0, 5.0], r), ([7.0, 2.0], 0.0)];
        let sharp = Path::polygon(&cut.map(|(at, _)| at)).signed_area_mm2();
        let lacks = r * r * ((PI / 8.0).tan() - PI / 8.0);
        let area = rounded(&cut).signed_area_mm2();
        assert!(sharp < 0.0 && (area - sharp - lacks).abs() < 1e-12, "{area} {sharp}");
    }

    #[test]
    fn the_largest_edge_that_spares_a_point_runs_through_it() {
        for at in [[1.0, 2.0], [0.3, 0.3], [4.0, 0.1]] {
            let r = max_radius_sparing_mm(at);
            let off = (r - at[0]).hypot(r - at[1]);
            assert!((off - r).abs() < 1e-12 && r > at[0] && r > at[1], "{at:?}");
        }
        assert_eq!(max_radius_sparing_mm([2.0, -1.0]), 2.0);
    }
}
