//! Cylindrical pins with round ends that stand out of a coat.

use fabkit_geometry::{Point3, Vector3};

/// Cylinder that ends in a hemisphere.
///
/// ```
/// use fabkit_geometry::{Point3, Vector3};
/// use fabkit_light::RaisedMarker;
///
/// // A pin that hangs down from a coat above: its round end of radius 0.5 mm is around z = 4 mm.
/// let pin = RaisedMarker { centre: Point3::new(0.0, 0.0, 4.0), axis: -Vector3::z(), radius_mm: 0.5 };
/// let tip = pin.entry(&Point3::origin(), &Vector3::z()).unwrap();
/// assert_eq!((tip.at_mm, tip.normal), (3.5, -Vector3::z()));
/// // Above the round end there is the cylinder, which has no upper end.
/// let side = pin.entry(&Point3::new(-2.0, 0.0, 9.0), &Vector3::x()).unwrap();
/// assert_eq!((side.at_mm, side.normal), (1.5, -Vector3::x()));
/// assert_eq!(pin.entry(&Point3::new(0.6, 0.0, 0.0), &Vector3::z()), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaisedMarker {
    /// Centre of the hemisphere, mm.
    pub centre: Point3<f64>,
    /// Direction from root to tip, unit.
    pub axis: Vector3<f64>,
    /// Radius of cylinder and hemisphere, mm.
    pub radius_mm: f64,
}

/// Intersection of a line with a [`RaisedMarker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaisedMarkerHit {
    /// Distance along the line, mm.
    pub at_mm: f64,
    /// Outward normal of the peg, unit.
    pub normal: Vector3<f64>,
}

impl RaisedMarker {
    /// Finds the first point where a ray of unit direction enters the hemisphere, or the cylinder behind it. The
    /// cylinder has no other end.
    pub fn entry(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<RaisedMarkerHit> {
        let from = origin - self.centre;
        let along = |vector: &Vector3<f64>| vector.dot(&self.axis);
        let mut nearest: Option<RaisedMarkerHit> = None;
        let mut consider = |at_mm: f64, normal: Vector3<f64>| {
            if at_mm > 0.0 && nearest.is_none_or(|hit| at_mm < hit.at_mm) {
                nearest = Some(RaisedMarkerHit { at_mm, normal });
            }
        };
        // The sphere, where it lies beyond the end of the cylinder.
        let half = from.dot(direction);
        let beside = half * half - from.norm_squared() + self.radius_mm * self.radius_mm;
        if beside >= 0.0 {
            let at_mm = -half - beside.sqrt();
            let place = from + at_mm * direction;
            if along(&place) >= 0.0 {
                consider(at_mm, place / self.radius_mm);
            }
        }
        // The cylinder, where it lies behind its end.
        let across = |vector: &Vector3<f64>| vector - along(vector) * self.axis;
        let (from_axis, way) = (across(&from), across(direction));
        let a = way.norm_squared();
        // A ray along the axis can enter through the hemisphere only.
        if a > 1e-18 {
            let b = from_axis.dot(&way);
            let c = from_axis.norm_squared() - self.radius_mm * self.radius_mm;
            let beside = b * b - a * c;
            if beside >= 0.0 {
                let at_mm = (-b - beside.sqrt()) / a;
                let place = from + at_mm * direction;
                if along(&place) < 0.0 {
                    consider(at_mm, across(&place) / self.radius_mm);
                }
            }
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::{CompiledSolid, Ray, Solid};

    use super::*;

    #[test]
    fn intersections_equal_those_of_the_solid() {
        // The same shape as a solid: a cylinder of radius 0.5 up to z = 2, with a ball there.
        let drawn = Solid::union([
            Solid::cylinder(0.5, 40.0).at_z(-38.0),
            Solid::ellipsoid([0.5; 3]).at_z(2.0),
        ]);
        let drawn = CompiledSolid::new(&drawn).unwrap();
        let peg =
            RaisedMarker { centre: Point3::new(0.0, 0.0, 2.0), axis: Vector3::z(), radius_mm: 0.5 };
        let mut hits = 0;
        for i in 0..2_000 {
            let angle = f64::from(i) * 0.7;
            let origin = Point3::new(5.0 * angle.cos(), 5.0 * angle.sin(), f64::from(i % 61) * 0.1);
            let aim = Point3::new(0.0, 0.3 * (angle * 3.1).sin(), 1.0 + (angle * 1.7).sin() * 1.6);
            let direction = (aim - origin).normalize();
            let first = drawn.crossings(&Ray { origin, direction }).first().copied();
            let found = peg.entry(&origin, &direction);
            assert_eq!(first.is_some(), found.is_some(), "{i}");
            if let (Some(first), Some(found)) = (first, found) {
                assert!((first.t - found.at_mm).abs() < 1e-9, "{i}");
                assert!((first.normal - found.normal).norm() < 1e-6, "{i}");
                hits += 1;
            }
        }
        assert!(hits > 1_000, "{hits}");
    }
}
