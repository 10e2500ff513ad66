//! Quadrics: the surfaces of nearly all faces that light passes.

use std::ops::Neg;

use fabkit_geometry::{Aabb, Point3, Pose, Ray, Vector3};
use nalgebra::Matrix4;

use super::trim::Trim;

/// Quadric `a (x^2 + y^2) + b z^2 + l . p + d = 0`: planes of any orientation, spheres anywhere, and cylinders, cones
/// and ellipsoids of revolution along z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quadric {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) l: Vector3<f64>,
    pub(super) d: f64,
}

impl Neg for Quadric {
    type Output = Self;

    fn neg(self) -> Self {
        Self { a: -self.a, b: -self.b, l: -self.l, d: -self.d }
    }
}

/// Quadric in the sensor's frame or in a frame of its own.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    quadric: Quadric,
    /// Pose of its own frame, boxed because very few surfaces have one.
    own_from_sensor: Option<Box<Pose>>,
}

impl From<Quadric> for Surface {
    fn from(quadric: Quadric) -> Self {
        Self { quadric, own_from_sensor: None }
    }
}

impl Surface {
    /// Returns the surface with its quadric understood in another frame.
    pub(super) fn in_frame(&self, own_from_sensor: Pose) -> Self {
        Self { quadric: self.quadric, own_from_sensor: Some(Box::new(own_from_sensor)) }
    }

    /// Transforms a ray to its own frame.
    #[inline]
    fn to_own_frame(&self, ray: &Ray) -> Ray {
        match &self.own_from_sensor {
            None => *ray,
            Some(pose) => {
                Ray { origin: pose.point(ray.origin), direction: pose.vector(ray.direction) }
            }
        }
    }

    /// Transforms a point to its own frame.
    fn own_point(&self, point: &Point3<f64>) -> Point3<f64> {
        self.own_from_sensor.as_ref().map_or(*point, |pose| pose.point(*point))
    }

    /// Returns the frame in which its axis is along z, if that is not the sensor's.
    pub(super) fn frame(&self) -> Option<&Pose> {
        self.own_from_sensor.as_deref()
    }

    /// Returns the quadric in that frame.
    pub(super) fn quadric(&self) -> &Quadric {
        &self.quadric
    }

    /// Returns the distance at which a line passes it while the function grows (or falls), mm; NaN if there is none.
    pub(super) fn pass_mm(&self, ray: &Ray, grows: bool) -> f64 {
        self.quadric.find_passage(&self.to_own_frame(ray), grows).t_mm
    }

    /// Returns a unit normal at a point of the surface; its sign is arbitrary.
    pub(super) fn normal(&self, point: &Point3<f64>) -> Vector3<f64> {
        let across = self.quadric.gradient(&self.own_point(point).coords);
        let turned = self.own_from_sensor.as_ref().map(|pose| pose.rotation().tr_mul(&across));
        turned.unwrap_or(across).normalize()
    }

    /// Returns whether the function grows along a line. See [`Quadric::grows`].
    pub(super) fn grows(&self, ray: &Ray, t_mm: f64) -> bool {
        self.quadric.grows(&self.to_own_frame(ray), t_mm)
    }

    /// Returns the possible intersections with the straight way between two points.
    pub(super) fn meetings(&self, from: &Point3<f64>, to: &Point3<f64>) -> Intersections {
        let (own_from, own_to) = (self.own_point(from), self.own_point(to));
        match self.quadric.meetings(&own_from, &own_to) {
            None => Intersections::Unclear,
            Some(shares) => {
                Intersections::At(shares.map(|share| share.map(|share| from + share * (to - from))))
            }
        }
    }

    /// Returns whether it is a plane.
    pub(super) fn is_flat(&self) -> bool {
        self.quadric.is_flat()
    }

    /// Returns whether a box certainly lies on one side of the surface. Always false for surfaces in a frame of their
    /// own.
    pub(super) fn misses_box(&self, bounds: &Aabb) -> bool {
        self.own_from_sensor.is_none() && self.quadric.misses_box(bounds)
    }

    /// Returns whether both are the same surface, regardless of sign.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        let (a, b) = (self.matrix(), other.matrix());
        let (scale_a, scale_b) = (a.amax(), b.amax());
        // The matrices may differ in sign.
        let turned = if a.dot(&b) < 0.0 { -1.0 } else { 1.0 };
        (a / scale_a - turned * b / scale_b).amax() <= COEFFICIENT_TOLERANCE
    }

    /// Returns the matrix M of the function `p^T M p` for points p = (x, y, z, 1) in the sensor's frame.
    fn matrix(&self) -> Matrix4<f64> {
        let Quadric { a, b, l, d } = self.quadric;
        let mut matrix = Matrix4::from_diagonal(&[a, a, b, d].into());
        for axis in 0..3 {
            matrix[(axis, 3)] = 0.5 * l[axis];
            matrix[(3, axis)] = 0.5 * l[axis];
        }
        match &self.own_from_sensor {
            None => matrix,
            Some(pose) => {
                let mut motion = Matrix4::identity();
                motion.fixed_view_mut::<3, 3>(0, 0).copy_from(pose.rotation());
                motion.fixed_view_mut::<3, 1>(0, 3).copy_from(pose.translation_mm());
                motion.tr_mul(&(matrix * motion))
            }
        }
    }
}

/// Possible intersections of a straight way with a surface.
pub(super) enum Intersections {
    /// These points and no others.
    At([Option<Point3<f64>>; 2]),
    /// Unknown, because the way grazes the surface and rounding decides.
    Unclear,
}

impl Intersections {
    /// Returns the box around all intersections; `None` if some are unclear.
    pub(super) fn box_around(meetings: impl Iterator<Item = Self>) -> Option<Aabb> {
        let mut bounds = Aabb::nothing();
        for meetings in meetings {
            let Self::At(places) = meetings else { return None };
            for place in places.into_iter().flatten() {
                bounds = bounds.hull(&Aabb { min: place, max: place });
            }
        }
        Some(bounds)
    }

    /// Returns whether the intersections certainly lie outside a face of the surface.
    pub(super) fn miss_face(&self, trim: &Trim) -> bool {
        match self {
            Self::At(places) => places.iter().flatten().all(|at| trim.misses(at)),
            Self::Unclear => false,
        }
    }
}

/// Intersections of a line with a quadric, by direction of passage.
#[derive(Clone, Copy, Debug)]
pub(super) struct QuadricPassage {
    /// Distance of the passage in the requested direction, mm.
    pub(super) t_mm: f64,
    /// Distance of the passage in the other direction, mm; any value if there is none.
    pub(super) opposite_mm: f64,
}

/// Tolerance within which function values, which scale as lengths in mm, may be zero but for rounding.
pub(super) const ZERO_TOLERANCE: f64 = 1e-9;

/// Relative tolerance of the coefficients of equal surfaces, with respect to the largest.
const COEFFICIENT_TOLERANCE: f64 = 1e-10;

impl Quadric {
    /// Creates the plane through a point.
    pub(super) fn plane(normal: Vector3<f64>, point: Vector3<f64>) -> Self {
        Self { a: 0.0, b: 0.0, l: normal, d: -normal.dot(&point) }
    }

    /// Returns whether it is a plane.
    pub(super) fn is_flat(&self) -> bool {
        self.a == 0.0 && self.b == 0.0
    }

    /// Bounds the function over the box: its value at the centre, plus or minus the gradient's and the squares' largest
    /// contributions.
    fn misses_box(&self, bounds: &Aabb) -> bool {
        let Self { a, b, l, d } = self;
        let half = 0.5 * (bounds.max - bounds.min);
        let p = bounds.min.coords + half;
        let value = a * (p.x * p.x + p.y * p.y) + b * p.z * p.z + l.dot(&p) + d;
        let slope = self.gradient(&p).abs().dot(&half);
        let (flat, tall) = (a * (half.x * half.x + half.y * half.y), b * half.z * half.z);
        let above = value - slope + flat.min(0.0) + tall.min(0.0);
        let below = value + slope + flat.max(0.0) + tall.max(0.0);
        above > ZERO_TOLERANCE || below < -ZERO_TOLERANCE
    }

    /// Creates an ellipsoid of revolution along z from its semi-axes across and along it.
    pub(super) fn ellipsoid(centre: Vector3<f64>, across_mm: f64, along_mm: f64) -> Self {
        // Scaled so that function values are of the order of lengths, as for the other surfaces.
        let (a, b) = (1.0 / across_mm, across_mm / (along_mm * along_mm));
        let scale = Vector3::new(a, a, b);
        let d = centre.component_mul(&scale).dot(&centre) - across_mm;
        Self { a, b, l: -2.0 * centre.component_mul(&scale), d }
    }

    /// Creates a cone or a cylinder along z from its radius at the height of a point on its axis, and the growth of the
    /// radius with height.
    pub(super) fn cone(on_axis: Vector3<f64>, radius_mm: f64, growth: f64) -> Self {
        let [x, y, z]: [f64; 3] = on_axis.into();
        // Radius at z = 0.
        let foot_mm = radius_mm - growth * z;
        Self {
            a: 1.0,
            b: -growth * growth,
            l: Vector3::new(-2.0 * x, -2.0 * y, -2.0 * growth * foot_mm),
            d: x * x + y * y - foot_mm * foot_mm,
        }
    }

    /// Returns the gradient: a vector across the surface, not normalized.
    #[inline]
    pub(super) fn gradient(&self, p: &Vector3<f64>) -> Vector3<f64> {
        let Self { a, b, l, .. } = self;
        Vector3::new(2.0 * a * p.x + l.x, 2.0 * a * p.y + l.y, 2.0 * b * p.z + l.z)
    }

    /// Returns whether the function grows along a line at a point.
    pub(super) fn grows(&self, ray: &Ray, t_mm: f64) -> bool {
        self.gradient(&ray.at(t_mm).coords).dot(&ray.direction) > 0.0
    }

    /// Returns `[h, m, c]` of the function `h t^2 + 2 m t + c` along a line.
    #[inline]
    fn along_line(&self, ray: &Ray) -> [f64; 3] {
        let Self { a, b, l, d } = self;
        let (p, v) = (&ray.origin, &ray.direction);
        let h = a * (v.x * v.x + v.y * v.y) + b * v.z * v.z;
        let m = a * (p.x * v.x + p.y * v.y) + b * p.z * v.z + 0.5 * l.dot(v);
        let c = a * (p.x * p.x + p.y * p.y) + b * p.z * p.z + l.dot(&p.coords) + d;
        [h, m, c]
    }

    /// Finds the zero of the function along a line where it grows, or falls; NaN if there is none.
    #[inline]
    pub(super) fn find_passage(&self, ray: &Ray, grows: bool) -> QuadricPassage {
        let [h, m, c] = self.along_line(ray);
        let root = (m * m - h * c).sqrt();
        // The derivative at the zeros of h t^2 + 2 m t + c is 2 root or -2 root. Of the two algebraic forms, the one
        // without cancellation is used.
        let up = if m >= 0.0 { -c / (root + m) } else { (root - m) / h };
        let down = if m <= 0.0 { c / (root - m) } else { -(root + m) / h };
        if grows {
            QuadricPassage { t_mm: up, opposite_mm: down }
        } else {
            QuadricPassage { t_mm: down, opposite_mm: up }
        }
    }

    /// Finds the possible intersections with the straight way between two points, as shares of it; `None` if it grazes
    /// the surface or nearly does, so that rounding decides.
    fn meetings(&self, from: &Point3<f64>, to: &Point3<f64>) -> Option<[Option<f64>; 2]> {
        // Shares of the way, with a margin for rounding at both ends.
        let ray = Ray { origin: *from, direction: to - from };
        if self.misses_line(&ray) {
            return Some([None; 2]);
        }
        let QuadricPassage { t_mm, opposite_mm: back_mm } = self.find_passage(&ray, true);
        let is_between = |share: &f64| (-1e-6..=1.0 + 1e-6).contains(share);
        let is_plain = !(t_mm.is_nan() || back_mm.is_nan() || (t_mm - back_mm).abs() < 1e-6);
        is_plain.then(|| [t_mm, back_mm].map(|share| Some(share).filter(is_between)))
    }

    /// Returns whether a line certainly lies on one side: its extreme value has the sign that it has far away.
    fn misses_line(&self, ray: &Ray) -> bool {
        let [h, m, c] = self.along_line(ray);
        // For h = 0, as for planes, this is minus infinity or NaN, hence false.
        (c - m * m / h) * h.signum() > ZERO_TOLERANCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray() -> Ray {
        let direction = Vector3::new(0.3, -0.5, 0.8).normalize();
        Ray { origin: Point3::new(0.4, 0.2, -0.7), direction }
    }

    /// Each surface by its own formula.
    #[test]
    fn a_pass_lies_on_the_surface_and_goes_the_right_way() {
        let centre = Vector3::new(0.5, -0.3, 0.2);
        type Formula = Box<dyn Fn(Point3<f64>) -> f64>;
        let cases: [(Quadric, Formula); 4] = [
            (
                Quadric::ellipsoid(centre, 3.0, 3.0),
                Box::new(move |p| (p.coords - centre).norm() - 3.0),
            ),
            (
                Quadric::ellipsoid(centre, 3.0, 5.0),
                Box::new(move |p| {
                    let q = p.coords - centre;
                    (q.xy().norm_squared() / 9.0 + q.z * q.z / 25.0).sqrt() - 1.0
                }),
            ),
            (
                Quadric::cone(centre, 2.0, 0.25),
                Box::new(move |p| {
                    let q = p.coords - centre;
                    q.xy().norm() - 2.0 - 0.25 * q.z
                }),
            ),
            (
                Quadric::plane(Vector3::new(0.0, 0.6, 0.8), centre),
                Box::new(move |p| (p.coords - centre).dot(&Vector3::new(0.0, 0.6, 0.8))),
            ),
        ];
        for (quadric, formula) in cases {
            let pass = quadric.find_passage(&ray(), true);
            assert!(formula(ray().at(pass.t_mm)).abs() < 1e-12, "{quadric:?} {pass:?}");
            assert!(formula(ray().at(pass.t_mm + 1e-3)) > 0.0 && quadric.grows(&ray(), pass.t_mm));
            if pass.opposite_mm.is_finite() {
                assert!(formula(ray().at(pass.opposite_mm)).abs() < 1e-12, "{quadric:?} {pass:?}");
                assert!(!quadric.grows(&ray(), pass.opposite_mm));
            }
        }
    }

    /// A surface that misses a box has one sign at all points of the box.
    #[test]
    fn a_surface_misses_boxes_beside_it() {
        let centre = Vector3::new(0.5, -0.3, 0.2);
        let quadrics = [
            Quadric::ellipsoid(centre, 3.0, 5.0),
            Quadric::cone(centre, 2.0, 0.25),
            Quadric::plane(Vector3::new(0.0, 0.6, 0.8), centre),
        ];
        let (mut missed, mut met) = (0, 0);
        for number in 0..3_000 {
            let at = |k: i32| (f64::from(number * 7 + k * 13) * 0.618).fract() * 8.0 - 4.0;
            let min = Point3::new(at(1), at(2), at(3));
            let bounds = Aabb { min, max: min + Vector3::new(0.9, 0.4, 0.7) };
            for quadric in &quadrics {
                let corner = |i: usize| {
                    let pick =
                        |axis: usize| f64::from((i / 3_usize.pow(axis as u32) % 3) as u8) / 2.0;
                    let share = Vector3::new(pick(0), pick(1), pick(2));
                    min + (bounds.max - min).component_mul(&share)
                };
                let signs: Vec<bool> = (0..27)
                    .map(|i| {
                        let ray = Ray { origin: corner(i), direction: Vector3::z() };
                        quadric.along_line(&ray)[2] > 0.0
                    })
                    .collect();
                if quadric.misses_box(&bounds) {
                    missed += 1;
                    assert!(signs.iter().all(|sign| *sign == signs[0]), "{quadric:?} {bounds:?}");
                } else {
                    met += 1;
                }
            }
        }
        assert!(missed > 3_000 && met > 500, "{missed} {met}");
    }

    #[test]
    fn a_surface_is_itself_from_both_sides() {
        let plane =
            |z: f64, up: f64| Quadric::plane(Vector3::new(0.0, 0.0, up), Vector3::new(3.0, 1.0, z));
        let plane = |z, up| Surface::from(plane(z, up));
        assert!(plane(2.0, 1.0).is_same(&plane(2.0, -1.0)));
        assert!(!plane(2.0, 1.0).is_same(&plane(2.001, 1.0)));
        assert!(!plane(2.0, 1.0).is_same(&Quadric::cone(Vector3::zeros(), 2.0, 0.0).into()));
        // Upright in another frame.
        let lifted = Surface::from(Quadric::plane(Vector3::z(), Vector3::zeros()))
            .in_frame(Pose::translation(1.0, 0.0, -2.0));
        assert!(lifted.is_same(&plane(2.0, 1.0)));
    }
}
