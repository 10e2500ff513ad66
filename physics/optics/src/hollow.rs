//! Room that a body surely leaves free, though the box around the body holds it: what is cast around the camera
//! is looked into only where light leaves that.

use fabkit_geometry::{EllipsoidOffset, Point3, Pose, Ray, Solid, Vector3};

/// Hollows are taken to be smaller by this share, for rounding.
const SLACK: f64 = 1e-9;

/// An ellipsoid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hollow {
    own_from_sensor: Pose,
    /// One over its half axes, 1/mm.
    per_mm: Vector3<f64>,
}

impl Hollow {
    /// Those of a solid: within what is cut out of all of it.
    pub(crate) fn of(solid: &Solid, sensor_from_solid: &Pose) -> Vec<Self> {
        match solid {
            Solid::Placed { pose, of } => Self::of(of, &sensor_from_solid.then_in(*pose)),
            Solid::Feature { of, .. } => Self::of(of, sensor_from_solid),
            Solid::Difference { of, minus } => {
                let within = minus.iter().flat_map(|tool| Self::within(tool, sensor_from_solid));
                Self::of(of, sensor_from_solid).into_iter().chain(within).collect()
            }
            Solid::Intersection(solids) => {
                let of = solids.iter().flat_map(|solid| Self::of(solid, sensor_from_solid));
                of.collect()
            }
            _ => Vec::new(),
        }
    }

    /// Ellipsoids within a solid.
    fn within(solid: &Solid, sensor_from_solid: &Pose) -> Vec<Self> {
        let half_axes_mm = match solid {
            Solid::Placed { pose, of } => {
                return Self::within(of, &sensor_from_solid.then_in(*pose));
            }
            Solid::Feature { of, .. } => return Self::within(of, sensor_from_solid),
            Solid::Union(solids) => {
                let within = solids.iter().flat_map(|solid| Self::within(solid, sensor_from_solid));
                return within.collect();
            }
            Solid::Sphere(sphere) => [sphere.radius_mm; 3],
            Solid::Ellipsoid(ellipsoid) => ellipsoid.semi_axes_mm,
            Solid::EllipsoidOffset(EllipsoidOffset { equatorial_mm, polar_mm, offset_mm }) => {
                // Minkowski: the sum of the ellipsoid and a ball holds the ellipsoid of the summed half axes;
                // the ellipsoid is the sum of two that are like it, of which the one that is as high as the
                // offset where it is lowest holds a ball of that.
                let scale = 1.0 + offset_mm.min(0.0) / equatorial_mm.min(*polar_mm);
                let by_mm = offset_mm.max(0.0);
                let across_mm = equatorial_mm * scale + by_mm;
                [across_mm, across_mm, polar_mm * scale + by_mm]
            }
            _ => return Vec::new(),
        };
        let per_mm = Vector3::from(half_axes_mm).map(|half_mm| 1.0 / (half_mm * (1.0 - SLACK)));
        vec![Self { own_from_sensor: sensor_from_solid.inverse(), per_mm }]
    }

    /// Whether a point lies in it.
    pub(crate) fn holds(&self, point: &Point3<f64>) -> bool {
        let own = self.own_from_sensor.point(*point).coords.component_mul(&self.per_mm);
        own.norm_squared() < 1.0
    }

    /// Where a ray that starts in it leaves it, mm; 0 for one that does not.
    pub(crate) fn exit_mm(&self, ray: &Ray) -> f64 {
        let origin = self.own_from_sensor.point(ray.origin).coords.component_mul(&self.per_mm);
        let c = 1.0 - origin.norm_squared();
        if c <= 0.0 {
            return 0.0;
        }
        let direction = self.own_from_sensor.vector(ray.direction).component_mul(&self.per_mm);
        let (a, b) = (direction.norm_squared(), origin.dot(&direction));
        let root = (b * b + a * c).sqrt();
        // Of two forms, the one without cancellation.
        if b > 0.0 { c / (root + b) } else { (root - b) / a }
    }
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::CompiledSolid;

    use super::*;

    /// No point of a ray before its exit is in the body, and for a ball's room all of it is used.
    #[test]
    fn a_hollow_is_free() {
        for (offset_mm, is_tight) in [(-2.4, false), (0.0, true), (1.5, false)] {
            let room = Solid::ellipsoid_offset(9.0, 24.0, offset_mm).at(0.0, 0.0, 1.0);
            let body = Solid::cylinder(30.0, 80.0).at(0.0, 0.0, -40.0).minus(room);
            let solid = CompiledSolid::new(&body).unwrap();
            let [hollow] = Hollow::of(&body, &Pose::identity())[..] else { panic!("{offset_mm}") };
            for number in 0..500 {
                let (sin, cos) = (f64::from(number) * 2.4).sin_cos();
                let up = f64::from(number) / 250.0 - 1.0;
                let out = (1.0 - up * up).sqrt();
                let direction = Vector3::new(out * cos, out * sin, up);
                let ray = Ray { origin: Point3::new(0.5, -1.0, 3.0), direction };
                let exit_mm = hollow.exit_mm(&ray);
                let entry_mm = solid.crossings(&ray).iter().find(|c| c.t > 0.0).unwrap().t;
                assert!(0.0 < exit_mm && exit_mm <= entry_mm, "{exit_mm} {entry_mm}");
                assert!(!is_tight || entry_mm - exit_mm < 1e-6, "{exit_mm} {entry_mm}");
                let outside = Ray { origin: ray.at(entry_mm), direction };
                assert_eq!(hollow.exit_mm(&outside), 0.0);
                assert!(hollow.holds(&ray.origin) && !hollow.holds(&outside.origin));
            }
        }
    }
}
