//! Sphere, ellipsoid, cylinder and cone: quadrics intersected in closed form.

use nalgebra::Vector3;

use super::shape::{CastBuffers, Chord, LocalRay, Shape, Wall};
use crate::{Cone, Cylinder, Ellipsoid, Sphere, roots::quadratic};

const SIDE: u32 = 0;
const BOTTOM: u32 = 1;
const TOP: u32 = 2;

impl Shape for Sphere {
    fn support(&self, _u: &Vector3<f64>) -> f64 {
        self.radius_mm
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        p.norm_squared() < self.radius_mm * self.radius_mm
    }

    fn normal(&self, _face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        *p
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        // The discriminant is computed from the foot of the perpendicular, not as b^2 - c: Haines et al., "Precision
        // Improvements for Ray/Sphere Intersection", Ray Tracing Gems (2019).
        let b = ray.origin.dot(&ray.direction);
        let foot = ray.origin - b * ray.direction;
        let half_squared = self.radius_mm * self.radius_mm - foot.norm_squared();
        if half_squared > 0.0 {
            let half = half_squared.sqrt();
            work.chords.push(Chord::on_face(0, -b - half, -b + half));
        }
    }
}

impl Ellipsoid {
    fn to_unit_sphere(&self, p: &Vector3<f64>) -> Vector3<f64> {
        p.component_div(&Vector3::from(self.semi_axes_mm))
    }

    /// Returns the stretch of a line inside.
    pub(crate) fn chord(&self, ray: &LocalRay) -> Option<Chord> {
        // In coordinates scaled by the semi-axes it is a unit sphere.
        let (origin, direction) =
            (self.to_unit_sphere(&ray.origin), self.to_unit_sphere(&ray.direction));
        let a = direction.norm_squared();
        let b = origin.dot(&direction) / a;
        let foot = origin - b * direction;
        let half_squared = (1.0 - foot.norm_squared()) / a;
        (half_squared > 0.0).then(|| {
            let half = half_squared.sqrt();
            Chord::on_face(0, -b - half, -b + half)
        })
    }
}

impl Shape for Ellipsoid {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        u.component_mul(&Vector3::from(self.semi_axes_mm)).norm()
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        self.to_unit_sphere(p).norm_squared() < 1.0
    }

    fn normal(&self, _face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        self.to_unit_sphere(&self.to_unit_sphere(p))
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        work.chords.extend(self.chord(ray));
    }
}

/// Returns the stretch of the line with z between bottom and top.
fn between_ends(ray: &LocalRay, height_mm: f64) -> Option<Chord> {
    let (bottom, top) = (Wall { at: 0.0, face: BOTTOM }, Wall { at: height_mm, face: TOP });
    Chord::slab(ray.origin.z, ray.direction.z, bottom, top)
}

impl Cylinder {
    /// Returns the stretch of the line within the infinite cylinder.
    fn side(&self, ray: &LocalRay) -> Option<Chord> {
        let (o, d) = (ray.origin.xy(), ray.direction.xy());
        let a = d.norm_squared();
        if a == 0.0 {
            let inside = o.norm_squared() < self.radius_mm * self.radius_mm;
            return inside.then_some(Chord::WHOLE);
        }
        let b = o.dot(&d) / a;
        let cross = o.x * d.y - o.y * d.x;
        let half_squared = (self.radius_mm * self.radius_mm - cross * cross / a) / a;
        (half_squared > 0.0).then(|| {
            let half = half_squared.sqrt();
            Chord::on_face(SIDE, -b - half, -b + half)
        })
    }
}

impl Shape for Cylinder {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        self.radius_mm * u.x.hypot(u.y) + (self.height_mm * u.z).max(0.0)
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        let inside_side = p.xy().norm_squared() < self.radius_mm * self.radius_mm;
        inside_side && 0.0 < p.z && p.z < self.height_mm
    }

    fn normal(&self, face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        match face {
            BOTTOM => -Vector3::z(),
            TOP => Vector3::z(),
            _ => Vector3::new(p.x, p.y, 0.0),
        }
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        let ends = between_ends(ray, self.height_mm);
        work.chords.extend(ends.and_then(|ends| self.side(ray)?.meet(ends)));
    }
}

impl Cone {
    /// Returns the growth of the radius per mm of height.
    fn slope(&self) -> f64 {
        (self.top_radius_mm - self.bottom_radius_mm) / self.height_mm
    }

    /// Returns the radius at height z, computed from the nearer end so that it vanishes exactly at an apex.
    fn radius_at(&self, z: f64) -> f64 {
        if z < 0.5 * self.height_mm {
            self.bottom_radius_mm + self.slope() * z
        } else {
            self.top_radius_mm + self.slope() * (z - self.height_mm)
        }
    }
}

impl Shape for Cone {
    fn support(&self, u: &Vector3<f64>) -> f64 {
        let across = u.x.hypot(u.y);
        (self.bottom_radius_mm * across).max(self.top_radius_mm * across + self.height_mm * u.z)
    }

    fn contains(&self, p: &Vector3<f64>) -> bool {
        0.0 < p.z && p.z < self.height_mm && p.x.hypot(p.y) < self.radius_at(p.z)
    }

    fn normal(&self, face: u32, p: &Vector3<f64>) -> Vector3<f64> {
        match face {
            BOTTOM => -Vector3::z(),
            TOP => Vector3::z(),
            _ => {
                let across = p.x.hypot(p.y);
                // At the apex itself every direction is equally valid; the axis is one of them.
                let radial = if across > 0.0 { p.xy() / across } else { p.xy() };
                Vector3::new(radial.x, radial.y, -self.slope())
            }
        }
    }

    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers) {
        let Some(ends) = between_ends(ray, self.height_mm) else { return };
        let (o, d, slope) = (&ray.origin, &ray.direction, self.slope());
        let radius = self.radius_at(o.z);
        let a = d.xy().norm_squared() - slope * slope * d.z * d.z;
        let half_b = o.xy().dot(&d.xy()) - slope * d.z * radius;
        let c = o.xy().norm_squared() - radius * radius;
        let side = |enter, exit| Chord::on_face(SIDE, enter, exit).meet(ends);
        let inf = f64::INFINITY;
        let chord = match *quadratic(a, half_b, c).as_slice() {
            [t0, t1] if a > 0.0 => side(t0, t1),
            // The line is steeper than the side: inside before the first and after the second root, once in each nappe.
            // Only one nappe has height between the ends; the other may leave a sliver by rounding, which is dropped as
            // the shorter one.
            [t0, t1] => {
                let length = |c: &Chord| c.t_mm[1] - c.t_mm[0];
                let (before, after) = (side(-inf, t0), side(t1, inf));
                match (before, after) {
                    (Some(x), Some(y)) => Some(if length(&x) > length(&y) { x } else { y }),
                    (one, other) => one.or(other),
                }
            }
            // The line is parallel to a line of the side.
            [t] if a == 0.0 && half_b > 0.0 => side(-inf, t),
            [t] if a == 0.0 => side(t, inf),
            // The line never crosses the double cone's surface: wholly inside or wholly outside.
            _ => (a < 0.0 || (a == 0.0 && c < 0.0)).then_some(ends),
        };
        work.chords.extend(chord);
    }
}
