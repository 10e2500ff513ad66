//! Common interface of all primitives, each in its own frame.

use nalgebra::Vector3;

use super::{extrusion::Prism, revolution::RevolutionShape};
use crate::{
    Cone, Cuboid, Cylinder, Ellipsoid, EllipsoidOffset, HalfSpace, Pose, Solid, Sphere, Torus,
};

/// Line in a primitive's frame, with its origin moved to the point nearest the primitive's centre. So coefficients stay
/// of the primitive's size however far away the ray started.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalRay {
    pub(crate) origin: Vector3<f64>,
    /// Unit direction.
    pub(crate) direction: Vector3<f64>,
    /// Half length of the parameter range `-reach_mm..reach_mm` outside of which the line misses the primitive, mm.
    pub(crate) reach_mm: f64,
}

impl LocalRay {
    pub(crate) fn at(&self, t_mm: f64) -> Vector3<f64> {
        self.origin + t_mm * self.direction
    }
}

/// Stretch of a line inside a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chord {
    /// Start and end, mm along the ray.
    pub(crate) t_mm: [f64; 2],
    /// Faces crossed at the start and the end.
    pub(crate) face: [u32; 2],
}

impl Chord {
    /// The whole line.
    pub(crate) const WHOLE: Self = Self { t_mm: [f64::NEG_INFINITY, f64::INFINITY], face: [0, 0] };

    /// Returns the chord between two parameters, both on one face.
    pub(crate) fn on_face(face: u32, enter_mm: f64, exit_mm: f64) -> Self {
        Self { t_mm: [enter_mm, exit_mm], face: [face; 2] }
    }

    /// Returns the common part of two chords; `None` if there is none.
    pub(crate) fn meet(self, other: Self) -> Option<Self> {
        let enter = if self.t_mm[0] >= other.t_mm[0] { self } else { other };
        let exit = if self.t_mm[1] <= other.t_mm[1] { self } else { other };
        let chord =
            Self { t_mm: [enter.t_mm[0], exit.t_mm[1]], face: [enter.face[0], exit.face[1]] };
        (chord.t_mm[0] < chord.t_mm[1]).then_some(chord)
    }

    /// Returns the stretch where `origin + t direction` lies between `low` and `high`, in one coordinate.
    pub(crate) fn slab(origin: f64, direction: f64, low: Wall, high: Wall) -> Option<Self> {
        if direction == 0.0 {
            return (low.at < origin && origin < high.at).then_some(Self::WHOLE);
        }
        let (first, second) = if direction > 0.0 { (low, high) } else { (high, low) };
        Some(Self {
            t_mm: [(first.at - origin) / direction, (second.at - origin) / direction],
            face: [first.face, second.face],
        })
    }
}

/// Boundary of a slab: coordinate and face number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall {
    pub(crate) at: f64,
    pub(crate) face: u32,
}

/// Parameter at which a line may change between inside and outside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) t_mm: f64,
    pub(crate) face: u32,
}

/// Buffers that are reused from ray to ray.
#[derive(Clone, Debug, Default)]
pub(crate) struct CastBuffers {
    pub(crate) chords: Vec<Chord>,
    pub(crate) candidates: Vec<Candidate>,
}

/// Distance below which two candidates count as one, mm. A line through a vertex finds it on both edges, and the
/// stretch between the two is rounding.
const SAME_MM: f64 = 1e-11;

impl CastBuffers {
    /// Turns candidates into chords: sorts them, calls `inside` once between each two neighbours, and keeps those where
    /// the result changes.
    ///
    /// A surplus candidate costs time but never correctness. So edges may accept with a tolerance, and no vertex,
    /// tangent or seam needs special treatment.
    pub(crate) fn candidates_to_chords(&mut self, inside: impl Fn(f64) -> bool) {
        let Self { chords, candidates } = self;
        candidates.sort_unstable_by(|a, b| a.t_mm.total_cmp(&b.t_mm).then(a.face.cmp(&b.face)));
        // Sorted by face too, so that the survivor of equal candidates is always the same.
        candidates.dedup_by(|next, kept| next.t_mm - kept.t_mm <= SAME_MM);
        let mut entered: Option<Candidate> = None;
        for (i, &here) in candidates.iter().enumerate() {
            let inside_next =
                candidates.get(i + 1).is_some_and(|next| inside(0.5 * (here.t_mm + next.t_mm)));
            match entered {
                None if inside_next => entered = Some(here),
                Some(enter) if !inside_next => {
                    chords.push(Chord {
                        t_mm: [enter.t_mm, here.t_mm],
                        face: [enter.face, here.face],
                    });
                    entered = None;
                }
                _ => {}
            }
        }
        candidates.clear();
    }
}

/// Geometric queries of a primitive. Points and directions are in its own frame.
pub(crate) trait Shape {
    /// Returns the support function for unit `u`: the signed distance from the origin of the farthest tangent plane
    /// with this normal.
    fn support(&self, u: &Vector3<f64>) -> f64;

    /// Returns whether the point lies inside.
    fn contains(&self, p: &Vector3<f64>) -> bool;

    /// Returns the outward normal of a face at a point on it; need not be of unit length.
    fn normal(&self, face: u32, p: &Vector3<f64>) -> Vector3<f64>;

    /// Appends the stretches of the line inside, in order.
    fn cast(&self, ray: &LocalRay, work: &mut CastBuffers);
}

/// Primitive prepared for line casting.
#[derive(Clone, Debug)]
pub(crate) enum Primitive {
    Sphere(Sphere),
    Ellipsoid(Ellipsoid),
    Cylinder(Cylinder),
    Cone(Cone),
    Cuboid(Cuboid),
    Torus(Torus),
    HalfSpace(HalfSpace),
    Extrusion(Prism),
    Revolution(RevolutionShape),
    EllipsoidOffset(EllipsoidOffset),
}

impl Primitive {
    /// Converts a valid primitive; `None` for booleans, placements and features.
    pub(crate) fn new(solid: &Solid) -> Option<Self> {
        Some(match solid {
            Solid::Sphere(s) => Self::Sphere(s.clone()),
            Solid::Ellipsoid(s) => Self::Ellipsoid(s.clone()),
            Solid::Cylinder(s) => Self::Cylinder(s.clone()),
            Solid::Cone(s) => Self::Cone(s.clone()),
            Solid::Cuboid(s) => Self::Cuboid(s.clone()),
            Solid::Torus(s) => Self::Torus(s.clone()),
            Solid::HalfSpace(s) => Self::HalfSpace(s.clone()),
            Solid::Extrusion(s) => Self::Extrusion(Prism::new(s)),
            Solid::Revolution(s) => Self::Revolution(RevolutionShape::new(s)),
            Solid::EllipsoidOffset(s) => Self::EllipsoidOffset(s.clone()),
            Solid::Union(_)
            | Solid::Intersection(_)
            | Solid::Difference { .. }
            | Solid::Placed { .. }
            | Solid::Feature { .. } => return None,
        })
    }

    pub(crate) fn shape(&self) -> &dyn Shape {
        match self {
            Self::Sphere(s) => s,
            Self::Ellipsoid(s) => s,
            Self::Cylinder(s) => s,
            Self::Cone(s) => s,
            Self::Cuboid(s) => s,
            Self::Torus(s) => s,
            Self::HalfSpace(s) => s,
            Self::Extrusion(s) => s,
            Self::Revolution(s) => s,
            Self::EllipsoidOffset(s) => s,
        }
    }

    /// Returns the smallest box around the placed primitive.
    pub(crate) fn bounds(&self, root_from_leaf: &Pose) -> crate::Aabb {
        let shape = self.shape();
        let mut bounds = crate::Aabb::everything();
        for axis in 0..3 {
            // The root axis in the leaf frame: a row of the rotation.
            let u = root_from_leaf.rotation().row(axis).transpose();
            let origin = root_from_leaf.translation_mm()[axis];
            bounds.max[axis] = origin + shape.support(&u);
            bounds.min[axis] = origin - shape.support(&-u);
        }
        bounds
    }
}
