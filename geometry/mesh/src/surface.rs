//! Exact surfaces of faces, continued beyond the faces' edges.

use fabkit_geometry::{Path, Point3, Pose, Segment, Solid, Vector3};

/// Surface of one face of a placed primitive.
#[derive(Clone, Debug)]
pub(crate) struct LeafSurface {
    root_from_leaf: Pose,
    leaf_from_root: Pose,
    shape: Shape,
}

#[derive(Clone, Debug)]
enum Shape {
    /// Plane perpendicular to an axis: number of the axis, and coordinate.
    Plane(usize, f64),
    /// Surface of revolution: curve of the (distance from the axis, z) half plane, rotated around z.
    Revolution(Curve),
    /// Cylindrical surface: curve of the xy plane, extruded along z.
    Extrusion(Curve),
    /// Ellipsoid with any three half axes, mm.
    Ellipsoid([f64; 3]),
}

/// Line, circle or parallel curve of an ellipse, mm.
#[derive(Clone, Debug)]
enum Curve {
    Line { through: [f64; 2], normal: [f64; 2] },
    Circle { centre: [f64; 2], radius_mm: f64 },
    Ellipse { centre: [f64; 2], semi_axes_mm: [f64; 2], offset_mm: f64 },
}

/// Signed distance of a point from a surface, mm, and the unit normal there. The sign convention depends only on the
/// surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SignedDistance {
    pub distance_mm: f64,
    pub normal: Vector3<f64>,
}

impl LeafSurface {
    /// Creates the surface of a face of a primitive; `None` if there is no such face.
    pub fn new(primitive: &Solid, face: u32, root_from_leaf: Pose) -> Option<Self> {
        let shape = Shape::new(primitive, face)?;
        Some(Self { root_from_leaf, leaf_from_root: root_from_leaf.inverse(), shape })
    }

    /// Computes the signed distance of a point near the surface. It is exact except on ellipsoids with three half axes,
    /// where it is correct to second order in the distance.
    pub fn offset(&self, point: [f64; 3]) -> SignedDistance {
        let local = self.leaf_from_root.point(Point3::from(point)).coords;
        let (distance_mm, normal) = self.shape.offset(local);
        SignedDistance { distance_mm, normal: self.root_from_leaf.vector(normal) }
    }
}

impl Shape {
    fn new(primitive: &Solid, face: u32) -> Option<Self> {
        let ball = |semi_axes_mm, offset_mm| {
            Self::Revolution(Curve::Ellipse { centre: [0.0; 2], semi_axes_mm, offset_mm })
        };
        Some(match (primitive, face) {
            (Solid::Sphere(s), _) => {
                Self::Revolution(Curve::Circle { centre: [0.0; 2], radius_mm: s.radius_mm })
            }
            (Solid::Ellipsoid(s), _) => Self::Ellipsoid(s.semi_axes_mm),
            (Solid::EllipsoidOffset(s), _) => ball([s.equatorial_mm, s.polar_mm], s.offset_mm),
            (Solid::Torus(s), _) => Self::Revolution(Curve::Circle {
                centre: [s.ring_radius_mm, 0.0],
                radius_mm: s.tube_radius_mm,
            }),
            (Solid::HalfSpace(_), _) | (Solid::Cylinder(_) | Solid::Cone(_), 1) => {
                Self::Plane(2, 0.0)
            }
            (Solid::Cylinder(s), 2) => Self::Plane(2, s.height_mm),
            (Solid::Cone(s), 2) => Self::Plane(2, s.height_mm),
            (Solid::Cylinder(s), _) => {
                Self::Revolution(Curve::line([s.radius_mm, 0.0], [s.radius_mm, s.height_mm])?)
            }
            (Solid::Cone(s), _) => Self::Revolution(Curve::line(
                [s.bottom_radius_mm, 0.0],
                [s.top_radius_mm, s.height_mm],
            )?),
            (Solid::Cuboid(s), 0..4) => {
                let half_mm = s.size_mm[face as usize / 2] / 2.0;
                Self::Plane(
                    face as usize / 2,
                    if face.is_multiple_of(2) { -half_mm } else { half_mm },
                )
            }
            (Solid::Cuboid(_), 4) | (Solid::Extrusion(_), 0) => Self::Plane(2, 0.0),
            (Solid::Cuboid(s), _) => Self::Plane(2, s.size_mm[2]),
            (Solid::Extrusion(s), 1) => Self::Plane(2, s.height_mm),
            (Solid::Extrusion(s), _) => {
                Self::Extrusion(Curve::from_segment(s.profile.paths(), face - 2)?)
            }
            (Solid::Revolution(s), _) => {
                Self::Revolution(Curve::from_segment(s.profile.paths(), face)?)
            }
            _ => return None,
        })
    }

    fn offset(&self, p: Vector3<f64>) -> (f64, Vector3<f64>) {
        match self {
            Self::Plane(axis, at) => (p[*axis] - at, Vector3::ith(*axis, 1.0)),
            Self::Extrusion(curve) => {
                let (distance_mm, [x, y]) = curve.offset([p.x, p.y]);
                (distance_mm, Vector3::new(x, y, 0.0))
            }
            Self::Revolution(curve) => {
                let across_mm = p.x.hypot(p.y);
                let (distance_mm, [r, z]) = curve.offset([across_mm, p.z]);
                let [c, s] =
                    if across_mm > 0.0 { [p.x / across_mm, p.y / across_mm] } else { [1.0, 0.0] };
                (distance_mm, Vector3::new(r * c, r * s, z))
            }
            Self::Ellipsoid(axes_mm) => {
                // F = (|p / axes| - 1) / |grad|: its zeros are the surface, its slope there is 1.
                let scaled = Vector3::from_fn(|i, _| p[i] / axes_mm[i]);
                let length = scaled.norm().max(f64::MIN_POSITIVE);
                let slope = Vector3::from_fn(|i, _| scaled[i] / axes_mm[i]) / length;
                let steep = slope.norm().max(f64::MIN_POSITIVE);
                ((length - 1.0) / steep, slope / steep)
            }
        }
    }
}

impl Curve {
    fn line(from: [f64; 2], to: [f64; 2]) -> Option<Self> {
        let (x, y) = (to[0] - from[0], to[1] - from[1]);
        let length = x.hypot(y);
        let normal = [y / length, -x / length];
        (length > 0.0).then_some(Self::Line { through: from, normal })
    }

    /// Creates the curve of segment `number`, counted through all paths.
    fn from_segment<'a>(paths: impl Iterator<Item = &'a Path>, mut number: u32) -> Option<Self> {
        for path in paths {
            let count = path.segments.len() as u32;
            if number >= count {
                number -= count;
                continue;
            }
            let before = number.checked_sub(1).map(|before| path.segments[before as usize].to());
            let from = before.unwrap_or(path.start);
            return match &path.segments[number as usize] {
                Segment::Line { to } => Self::line(from, *to),
                Segment::Arc { to, centre, ccw } => {
                    // The radius is taken from the same end in both directions, so that shared arcs have equal radii.
                    let end = if *ccw { *to } else { from };
                    let radius_mm = (end[0] - centre[0]).hypot(end[1] - centre[1]);
                    Some(Self::Circle { centre: *centre, radius_mm })
                }
                Segment::EllipticArc { centre, semi_axes_mm, .. } => Some(Self::Ellipse {
                    centre: *centre,
                    semi_axes_mm: *semi_axes_mm,
                    offset_mm: 0.0,
                }),
            };
        }
        None
    }

    fn offset(&self, p: [f64; 2]) -> (f64, [f64; 2]) {
        match self {
            Self::Line { through, normal } => {
                ((p[0] - through[0]) * normal[0] + (p[1] - through[1]) * normal[1], *normal)
            }
            Self::Circle { centre, radius_mm } => {
                let (x, y) = (p[0] - centre[0], p[1] - centre[1]);
                let length = x.hypot(y);
                let normal = if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
                (length - radius_mm, normal)
            }
            Self::Ellipse { centre, semi_axes_mm, offset_mm } => {
                let (distance_mm, normal) =
                    from_ellipse(*semi_axes_mm, [p[0] - centre[0], p[1] - centre[1]]);
                (distance_mm - offset_mm, normal)
            }
        }
    }
}

/// Computes the distance of a point from an ellipse around the origin, mm, positive outside, and the normal at the foot
/// of the perpendicular, by Newton's method.
fn from_ellipse([a, b]: [f64; 2], [x, y]: [f64; 2]) -> (f64, [f64; 2]) {
    // Start at the point of the ellipse on the ray from the centre.
    let mut t = (a * y).atan2(b * x);
    for _ in 0..20 {
        let (s, c) = t.sin_cos();
        let slope = (a * a - b * b) * s * c - a * x * s + b * y * c;
        let change = (a * a - b * b) * (c * c - s * s) - a * x * c - b * y * s;
        // Negative where the foot is nearest. Otherwise the point lies beyond the centre of curvature, and a fixed step
        // leads away from there.
        let step = if change < 0.0 { -slope / change } else { slope.signum() * 0.1 };
        // Limited steps keep Newton's method from jumping to another branch.
        t += step.clamp(-0.2, 0.2);
        if step.abs() < 1e-13 {
            break;
        }
    }
    let (s, c) = t.sin_cos();
    let length = (b * c).hypot(a * s);
    let normal = [b * c / length, a * s / length];
    ((x - a * c) * normal[0] + (y - b * s) * normal[1], normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate::{face_count, tessellate};
    use fabkit_geometry::{Path, Profile};

    #[test]
    fn every_face_of_every_primitive_has_its_own_triangles_on_it() {
        let slot = Path::slot([-3.0, 1.0], [4.0, 1.0], 2.0);
        let solids = [
            Solid::sphere(3.0),
            Solid::ellipsoid([3.0, 4.0, 5.0]),
            Solid::ellipsoid_offset(6.0, 9.0, -1.0),
            Solid::ellipsoid_offset(6.0, 4.0, 1.5),
            Solid::torus(5.0, 1.0),
            Solid::cylinder(2.0, 7.0),
            Solid::cone(2.0, 0.5, 3.0),
            Solid::cone(0.0, 2.0, 3.0),
            Solid::cuboid(1.0, 2.0, 3.0),
            Solid::extrusion(Profile::new(slot.clone()), 2.5),
            Solid::extrusion(
                Profile::new(Path::circle([0.0, 0.0], 9.0)).with_hole(slot.clone()),
                2.5,
            ),
            Solid::revolution(Profile::new(slot.shifted([9.0, 0.0]))),
            Solid::revolution(Profile::new(
                Path::from([0.0, -5.0])
                    .elliptic_arc([9.0, 0.0], [0.0, 0.0], [9.0, 5.0], true)
                    .line([0.0, 1.0])
                    .close(),
            )),
        ];
        let pose = Pose::z_to(Vector3::new(0.3, -0.5, 0.7), Point3::new(4.0, -3.0, 2.0));
        for solid in solids {
            let facets = tessellate(&solid, 0.01).unwrap();
            for face in 0..face_count(&solid) {
                let Some(surface) = LeafSurface::new(&solid, face, pose) else {
                    panic!("{solid:?} has no face {face}")
                };
                let on_face = facets.triangles.iter().zip(&facets.faces).filter(|t| *t.1 == face);
                for v in on_face.flat_map(|t| t.0) {
                    let point = pose.point(Point3::from(facets.vertices[*v as usize]));
                    let offset = surface.offset(point.into());
                    assert!(offset.distance_mm.abs() < 1e-12, "{solid:?}, face {face}: {offset:?}");
                    // The slope along the normal is 1.
                    let beside = surface.offset((point + 1e-4 * offset.normal).into());
                    assert!((beside.distance_mm - 1e-4).abs() < 1e-8, "{solid:?}, face {face}");
                }
            }
        }
    }
}
