//! Lines with a direction.

use nalgebra::{Point3, Vector3};

use crate::Aabb;

/// Infinite line with a direction. The parameter `t` is measured in lengths of `direction` and may be negative.
///
/// ```
/// use fabkit_geometry::{Point3, Ray, Vector3};
/// let ray = Ray { origin: Point3::new(0.0, 0.0, 1.0), direction: Vector3::new(0.0, 0.0, 2.0) };
/// assert_eq!(ray.at(3.0), Point3::new(0.0, 0.0, 7.0)); // 3 lengths of 2 mm
/// assert_eq!(ray.at(-0.5), Point3::origin()); // a line, not a half line
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Point at t = 0, mm.
    pub origin: Point3<f64>,
    /// Direction; need not be of unit length, must not be zero.
    pub direction: Vector3<f64>,
}

impl Ray {
    /// Returns the point at a parameter, mm.
    pub fn at(&self, t: f64) -> Point3<f64> {
        self.origin + t * self.direction
    }

    /// Returns the parameters between which the line lies in a closed box; `None` if it passes beside it. They are
    /// negative behind the line's origin, and infinite where the box is unbounded.
    ///
    /// Whoever divides by a component of a direction has to say what a component of 0 means; it is said here once.
    ///
    /// ```
    /// use fabkit_geometry::{Aabb, Point3, Ray, Vector3};
    /// let lid = Aabb { min: Point3::new(0.0, 0.0, 5.0), max: Point3::new(4.0, 4.0, 6.0) };
    /// let up = |x: f64, y: f64| Ray { origin: Point3::new(x, y, 0.0), direction: Vector3::z() };
    /// // A line along z between the sides across x and y never leaves through them.
    /// assert_eq!(up(1.0, 2.0).range_in(&lid), Some([5.0, 6.0]));
    /// assert_eq!(up(0.0, 2.0).range_in(&lid), Some([5.0, 6.0])); // within a side
    /// assert_eq!(up(-1.0, 2.0).range_in(&lid), None);
    /// ```
    #[inline]
    pub fn range_in(&self, bounds: &Aabb) -> Option<[f64; 2]> {
        // The slab method of Kay and Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986.
        let (mut entry, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (origin, direction) = (self.origin[axis], self.direction[axis]);
            let (min, max) = (bounds.min[axis], bounds.max[axis]);
            // Parallel to two sides: between them all the way, or never. A quotient would be infinite or NaN.
            if direction == 0.0 {
                if origin < min || origin > max {
                    return None;
                }
                continue;
            }
            let (near, far) = if direction > 0.0 { (min, max) } else { (max, min) };
            entry = entry.max((near - origin) / direction);
            exit = exit.min((far - origin) / direction);
        }
        (entry <= exit).then_some([entry, exit])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a line lie in the box where its range says so, with components of 0 of either sign, and origins
    /// before, on, between and behind the sides.
    #[test]
    fn a_line_is_in_the_box_within_its_range_only() {
        let bounds = Aabb { min: Point3::new(-1.0, 0.0, 2.0), max: Point3::new(1.0, 3.0, 4.0) };
        let parts = [-1.0, -0.0, 0.0, 0.5];
        let directions =
            (0..64).map(|i| Vector3::new(parts[i % 4], parts[i / 4 % 4], parts[i / 16]));
        let mut met = [0, 0];
        for direction in directions.filter(|direction| direction.norm() > 0.0) {
            for place in 0..216 {
                let at = |k: i32| f64::from(place / k % 6) - 2.0;
                let line = Ray { origin: Point3::new(at(1), at(6), at(36) + 1.0), direction };
                let range = line.range_in(&bounds);
                met[usize::from(range.is_some())] += 1;
                // Steps between the quarters at which a line may cross a side.
                for step in -79..80 {
                    let t = f64::from(step) / 8.0 + 1.0 / 16.0;
                    let is_in = range.is_some_and(|[entry, exit]| entry <= t && t <= exit);
                    assert_eq!(bounds.contains(&line.at(t)), is_in, "{line:?} {t} {range:?}");
                }
            }
        }
        assert!(met.iter().all(|count| *count > 1_000), "{met:?}");
        let line = Ray { origin: Point3::origin(), direction: Vector3::x() };
        assert_eq!(line.range_in(&Aabb::nothing()), None);
        let all = Some([f64::NEG_INFINITY, f64::INFINITY]);
        assert_eq!(line.range_in(&Aabb::everything()), all);
    }
}
