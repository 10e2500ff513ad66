//! Curvatures of faces.

use fabkit_geometry::{Path, PlacedPrimitive, Point3, Profile, Segment, Solid, Vector3};

/// Principal curvatures of a face at one of its points, 1/mm, unsigned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PrincipalCurvatures {
    /// Unit tangent around the primitive's axis, in the body's frame.
    around: Vector3<f64>,
    /// Unit tangent along the generatrix; around, along and the normal are right-handed.
    along: Vector3<f64>,
    around_per_mm: f64,
    along_per_mm: f64,
}

/// Smallest curvature assumed in a direction, as a fraction of the other one: edges along a cylinder need not be as
/// long as the cylinder.
const LEAST_SHARE: f64 = 0.02;

impl PrincipalCurvatures {
    /// Returns a point projected on the tangent plane, with axes scaled by the square roots of the curvatures. In these
    /// coordinates the deviation of a triangle is proportional to its squared circumradius in any orientation.
    pub fn scaled(&self, point: [f64; 3]) -> [f64; 2] {
        let [a, b] = [self.around_per_mm, self.along_per_mm];
        let least = LEAST_SHARE * a.max(b);
        let scales = if least > 0.0 { [a, b].map(|k| k.max(least).sqrt()) } else { [1.0; 2] };
        let point = Vector3::from(point);
        [scales[0] * self.around.dot(&point), scales[1] * self.along.dot(&point)]
    }
}

/// Computes the curvatures of a leaf's face at a point of the body with a known normal.
pub(super) fn compute_curvatures(
    leaf: &PlacedPrimitive,
    face: u32,
    at: Point3<f64>,
    normal: Vector3<f64>,
) -> PrincipalCurvatures {
    let leaf_from_body = leaf.body_from_leaf.inverse();
    let (at, normal) = (leaf_from_body.point(at), leaf_from_body.vector(normal));
    let [around_per_mm, along_per_mm] = curvatures(&leaf.primitive, face, at, normal);
    let tangent = Vector3::z().cross(&normal);
    let tangent = tangent.try_normalize(1e-9).unwrap_or_else(|| {
        // On a flat face across the axis, or at a pole, any direction serves.
        normal.cross(&Vector3::x()).normalize()
    });
    let [around, along] = [tangent, normal.cross(&tangent)].map(|t| leaf.body_from_leaf.vector(t));
    PrincipalCurvatures { around, along, around_per_mm, along_per_mm }
}

/// Computes the curvatures around the axis and along the generatrix.
fn curvatures(primitive: &Solid, face: u32, at: Point3<f64>, normal: Vector3<f64>) -> [f64; 2] {
    let across_mm = at.x.hypot(at.y);
    // Meusnier's theorem for a circle of radius r whose plane is inclined to the normal.
    let parallel = |along: f64| {
        let inclined = normal.x.hypot(normal.y);
        // At a pole both principal curvatures are equal.
        if across_mm > 1e-6 { inclined / across_mm } else { along }
    };
    let of_ellipse = |equatorial: f64, polar: f64, offset_mm: f64| {
        let [sine, cosine] = [normal.z, normal.x.hypot(normal.y)];
        let support = (equatorial * cosine).hypot(polar * sine);
        let along = 1.0 / ((equatorial * polar).powi(2) / support.powi(3) + offset_mm);
        [parallel(along), along]
    };
    match primitive {
        Solid::Sphere(s) => [1.0 / s.radius_mm; 2],
        Solid::Ellipsoid(s) => {
            // Upper bound over the whole ellipsoid: the exact directions are not needed here.
            let short = s.semi_axes_mm.into_iter().fold(f64::MAX, f64::min);
            let long = s.semi_axes_mm.into_iter().fold(0.0, f64::max);
            [long / (short * short); 2]
        }
        Solid::Cylinder(_) | Solid::Cone(_) if face == 0 => [parallel(0.0), 0.0],
        Solid::Torus(s) => [parallel(0.0), 1.0 / s.tube_radius_mm],
        Solid::EllipsoidOffset(s) => of_ellipse(s.equatorial_mm, s.polar_mm, s.offset_mm),
        Solid::Revolution(s) => match segment(&s.profile, face) {
            Some((from, Segment::Arc { centre, .. })) => {
                let along = 1.0 / (from[0] - centre[0]).hypot(from[1] - centre[1]);
                [parallel(along), along]
            }
            Some((_, Segment::EllipticArc { semi_axes_mm: [a, b], .. })) => of_ellipse(*a, *b, 0.0),
            _ => [parallel(0.0), 0.0],
        },
        Solid::Extrusion(s) => match face.checked_sub(2).and_then(|k| segment(&s.profile, k)) {
            Some((from, Segment::Arc { centre, .. })) => {
                [1.0 / (from[0] - centre[0]).hypot(from[1] - centre[1]), 0.0]
            }
            _ => [0.0; 2],
        },
        _ => [0.0; 2],
    }
}

/// Returns segment `number` of a profile and its start point.
fn segment(profile: &Profile, number: u32) -> Option<([f64; 2], &Segment)> {
    let with_start = |path: &'_ Path| {
        let ends = path.segments.iter().map(Segment::to);
        std::iter::once(path.start).chain(ends).collect::<Vec<_>>()
    };
    profile
        .paths()
        .flat_map(|path| with_start(path).into_iter().zip(&path.segments))
        .nth(number as usize)
}
