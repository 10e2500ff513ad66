//! Hollows: ellipsoids that a body certainly leaves free within its bounding box. A body that is cast around the camera
//! is intersected only where a ray leaves its hollow.

use fabkit_geometry::{EllipsoidOffset, Point3, Pose, Ray, Solid, Vector3};

/// Relative amount by which hollows are shrunk, for rounding.
const SLACK: f64 = 1e-9;

/// Free ellipsoid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hollow {
    own_from_sensor: Pose,
    /// Reciprocal semi-axes, 1/mm.
    per_mm: Vector3<f64>,
}

impl Hollow {
    /// Finds the hollows of a solid: ellipsoids within what is cut out of all of it.
    pub(crate) fn from_solid(solid: &Solid, sensor_from_solid: &Pose) -> Vec<Self> {
        match solid {
            Solid::Placed { pose, of } => Self::from_solid(of, &sensor_from_solid.then_in(*pose)),
            Solid::Feature { of, .. } => Self::from_solid(of, sensor_from_solid),
            Solid::Difference { of, minus } => {
                let within = minus
                    .iter()
                    .flat_map(|tool| Self::inscribed_ellipsoids(tool, sensor_from_solid));
                Self::from_solid(of, sensor_from_solid).into_iter().chain(within).collect()
            }
            Solid::Intersection(solids) => {
                let of = solids.iter().flat_map(|solid| Self::from_solid(solid, sensor_from_solid));
                of.collect()
            }
            _ => Vec::new(),
        }
    }

    /// Finds ellipsoids that lie within a solid.
    fn inscribed_ellipsoids(solid: &Solid, sensor_from_solid: &Pose) -> Vec<Self> {
        let half_axes_mm = match solid {
            Solid::Placed { pose, of } => {
                return Self::inscribed_ellipsoids(of, &sensor_from_solid.then_in(*pose));
            }
            Solid::Feature { of, .. } => return Self::inscribed_ellipsoids(of, sensor_from_solid),
            Solid::Union(solids) => {
                let within = solids
                    .iter()
                    .flat_map(|solid| Self::inscribed_ellipsoids(solid, sensor_from_solid));
                return within.collect();
            }
            Solid::Sphere(sphere) => [sphere.radius_mm; 3],
            Solid::Ellipsoid(ellipsoid) => ellipsoid.semi_axes_mm,
            Solid::EllipsoidOffset(EllipsoidOffset { equatorial_mm, polar_mm, offset_mm }) => {
                // Positive offset: the Minkowski sum of an ellipsoid and a ball contains the ellipsoid with the summed
                // semi-axes. Negative offset: the ellipsoid is the sum of two scaled copies of itself. If the smaller
                // one has the offset as its least semi-axis, it contains a ball of that radius, so the larger one
                // remains free.
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

    /// Returns whether a point lies in the hollow.
    pub(crate) fn contains(&self, point: &Point3<f64>) -> bool {
        let own = self.own_from_sensor.point(*point).coords.component_mul(&self.per_mm);
        own.norm_squared() < 1.0
    }

    /// Returns the distance at which a ray that starts inside leaves the hollow, mm; 0 for other rays.
    pub(crate) fn exit_mm(&self, ray: &Ray) -> f64 {
        let origin = self.own_from_sensor.point(ray.origin).coords.component_mul(&self.per_mm);
        let c = 1.0 - origin.norm_squared();
        if c <= 0.0 {
            return 0.0;
        }
        let direction = self.own_from_sensor.vector(ray.direction).component_mul(&self.per_mm);
        let (a, b) = (direction.norm_squared(), origin.dot(&direction));
        let root = (b * b + a * c).sqrt();
        // Of the two algebraic forms, the one without cancellation is used.
        if b > 0.0 { c / (root + b) } else { (root - b) / a }
    }
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::CompiledSolid;

    use super::*;

    /// Before its exit a ray meets nothing of the body, and a hollow without offset is used fully.
    #[test]
    fn a_hollow_is_free() {
        for (offset_mm, is_tight) in [(-2.4, false), (0.0, true), (1.5, false)] {
            let room = Solid::ellipsoid_offset(9.0, 24.0, offset_mm).at(0.0, 0.0, 1.0);
            let body = Solid::cylinder(30.0, 80.0).at(0.0, 0.0, -40.0).minus(room);
            let solid = CompiledSolid::new(&body).unwrap();
            let [hollow] = Hollow::from_solid(&body, &Pose::identity())[..] else {
                panic!("{offset_mm}")
            };
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
                assert!(hollow.contains(&ray.origin) && !hollow.contains(&outside.origin));
            }
        }
    }
}
