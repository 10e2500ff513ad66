//! Surfaces as level sets of functions, and the test whether two bodies share one, as they must to touch without
//! overlapping.

use nalgebra::{Point3, Vector2, Vector3};

use crate::{PlacedPrimitive, Pose, Solid};

/// Distance below which two surfaces count as one, mm: far above rounding, far below what counts as an overlap
/// ([`crate::measure::overlap_volume`]).
pub(super) const SAME_MM: f64 = 1e-10;

/// Difference of unit directions below which they count as parallel; over the size of a part this stays below
/// [`SAME_MM`].
const PARALLEL: f64 = 1e-12;

/// Scalar function of space. Each of its levels divides space into below and above.
#[derive(Clone, Debug)]
pub(super) enum Family<'a> {
    /// Distance along a direction.
    Plane { normal: Vector3<f64> },
    /// Distance from a point.
    Round { centre: Point3<f64> },
    /// Distance from an axis; `point` is the point of the axis nearest to the origin.
    Pipe { point: Vector3<f64>, axis: Vector3<f64> },
    /// Distance from an axis minus `slope` times the coordinate along the axis.
    Cone { point: Vector3<f64>, axis: Vector3<f64>, slope: f64 },
    /// Distance from a circle.
    Ring { centre: Point3<f64>, axis: Vector3<f64>, radius_mm: f64 },
    /// Distance from an ellipsoid of revolution.
    Spheroid { centre: Point3<f64>, axis: Vector3<f64>, half_axes_mm: [f64; 2] },
    /// Function that is negative inside a primitive and positive outside; nothing else is known about it.
    Primitive { leaf: &'a PlacedPrimitive },
}

/// Level set of a family; `below` is true if the solid lies below the level.
#[derive(Clone, Debug)]
pub(super) struct LocalSurface<'a> {
    pub(super) family: Family<'a>,
    pub(super) level: f64,
    pub(super) below: bool,
}

impl<'a> LocalSurface<'a> {
    pub(super) fn primitive(leaf: &'a PlacedPrimitive) -> Self {
        Self { family: Family::Primitive { leaf }, level: 0.0, below: true }
    }

    /// Returns the half-space behind a plane through a point.
    pub(super) fn plane(pose: &Pose, point: Vector3<f64>, outward: Vector3<f64>) -> Self {
        let normal = pose.vector(outward);
        let level = normal.dot(&pose.point(point.into()).coords);
        Self { family: Family::Plane { normal }, level, below: true }
    }

    /// Returns the ball around a point of the z axis.
    pub(super) fn round(pose: &Pose, z_mm: f64, radius_mm: f64, below: bool) -> Self {
        let centre = pose.point(Point3::new(0.0, 0.0, z_mm));
        Self { family: Family::Round { centre }, level: radius_mm, below }
    }

    /// Returns the infinite cylinder along z around a point.
    pub(super) fn pipe(pose: &Pose, at: Vector2<f64>, radius_mm: f64, below: bool) -> Self {
        let (point, axis) = axis_of(pose, at);
        Self { family: Family::Pipe { point, axis }, level: radius_mm, below }
    }

    /// Returns the torus around the z axis; `centre` is the tube's centre as (distance from z, z).
    pub(super) fn ring(pose: &Pose, centre: Vector2<f64>, tube_mm: f64, below: bool) -> Self {
        let family = Family::Ring {
            centre: pose.point(Point3::new(0.0, 0.0, centre.y)),
            axis: pose.vector(Vector3::z()),
            radius_mm: centre.x,
        };
        Self { family, level: tube_mm, below }
    }

    /// Returns the points within `offset_mm` of an ellipsoid of revolution around a point of the z axis.
    pub(super) fn spheroid(
        pose: &Pose,
        z_mm: f64,
        half_axes_mm: [f64; 2],
        offset_mm: f64,
        below: bool,
    ) -> Self {
        if half_axes_mm[0] == half_axes_mm[1] {
            return Self::round(pose, z_mm, half_axes_mm[0] + offset_mm, below);
        }
        let family = Family::Spheroid {
            centre: pose.point(Point3::new(0.0, 0.0, z_mm)),
            axis: pose.vector(Vector3::z()),
            half_axes_mm,
        };
        Self { family, level: offset_mm, below }
    }

    /// Returns the solid behind the surface that a line of the (distance from z, z) half plane sweeps around z.
    pub(super) fn swept(pose: &Pose, point: Vector2<f64>, outward: Vector2<f64>) -> Self {
        let out = outward.normalize();
        if out.x == 0.0 {
            return Self::plane(pose, Vector3::new(0.0, 0.0, point.y), Vector3::z() * out.y);
        }
        if out.y == 0.0 {
            return Self::pipe(pose, Vector2::zeros(), point.x, out.x > 0.0);
        }
        // The level of r + (out.y / out.x) z at the point, with z counted from the root's origin.
        let slope = -out.y / out.x;
        let (foot, axis) = axis_of(pose, Vector2::zeros());
        let start = axis.dot(pose.translation_mm());
        Self {
            family: Family::Cone { point: foot, axis, slope },
            level: point.x - slope * (point.y + start),
            below: out.x > 0.0,
        }
    }
}

/// Returns the line along z through a point: its point nearest to the root's origin, and its direction.
fn axis_of(pose: &Pose, at: Vector2<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let axis = pose.vector(Vector3::z());
    let on_it = pose.point(Point3::new(at.x, at.y, 0.0)).coords;
    (on_it - axis.dot(&on_it) * axis, axis)
}

impl Family<'_> {
    /// Returns whether the function may grow, and whether it may shrink, along a unit direction within a box given by
    /// its centre and half edges.
    pub(super) fn changes(
        &self,
        centre: &Point3<f64>,
        half: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> [bool; 2] {
        // Range of a linear function in the box.
        let range = |point: &Vector3<f64>, along: &Vector3<f64>| {
            let middle = (centre.coords - point).dot(along);
            let reach = along.abs().dot(half);
            [middle - reach, middle + reach]
        };
        let either = |[low, high]: [f64; 2]| [high > SAME_MM, low < -SAME_MM];
        let radial = |point: &Vector3<f64>, axis: &Vector3<f64>| {
            either(range(point, &(direction - axis.dot(direction) * axis)))
        };
        let is_along = |axis: &Vector3<f64>| axis.dot(direction).abs() > 1.0 - PARALLEL;
        let is_across = |axis: &Vector3<f64>| axis.dot(direction).abs() < PARALLEL;
        match self {
            Self::Plane { normal } => {
                let slope = normal.dot(direction);
                [slope > PARALLEL, slope < -PARALLEL]
            }
            Self::Round { centre: point } => either(range(&point.coords, direction)),
            Self::Pipe { point, axis } => {
                if is_along(axis) {
                    [false; 2]
                } else {
                    radial(point, axis)
                }
            }
            Self::Cone { point, axis, slope } => {
                if is_along(axis) {
                    let growth = -slope * axis.dot(direction);
                    [growth > 0.0, growth < 0.0]
                } else if is_across(axis) {
                    radial(point, axis)
                } else {
                    [true; 2]
                }
            }
            // Along the axis, the height above the centre decides; across it, an ellipsoid of revolution behaves like a
            // ball.
            Self::Ring { centre: point, axis, .. } | Self::Spheroid { centre: point, axis, .. }
                if is_along(axis) =>
            {
                either(range(&point.coords, direction))
            }
            Self::Spheroid { centre: point, axis, .. } if is_across(axis) => {
                radial(&point.coords, axis)
            }
            Self::Ring { .. } | Self::Spheroid { .. } | Self::Primitive { .. } => [true; 2],
        }
    }
}

/// One side of a level of a registered family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Literal {
    pub(super) family: u32,
    pub(super) level: f64,
    pub(super) below: bool,
}

impl Literal {
    pub(super) fn negated(self) -> Self {
        Self { below: !self.below, ..self }
    }

    /// Returns whether no point can be on both sides.
    pub(super) fn excludes(&self, other: &Self) -> bool {
        if self.family != other.family || self.below == other.below {
            return false;
        }
        let (below, above) = if self.below { (self, other) } else { (other, self) };
        above.level >= below.level - SAME_MM
    }
}

/// Registry of all families met so far, each listed once.
#[derive(Debug, Default)]
pub(super) struct Families<'a> {
    known: Vec<Family<'a>>,
}

impl<'a> Families<'a> {
    /// Returns whether a line in this direction may leave a literal's side within a box.
    pub(super) fn may_leave(
        &self,
        literal: &Literal,
        centre: &Point3<f64>,
        half: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> bool {
        let [grows, shrinks] = self.known[literal.family as usize].changes(centre, half, direction);
        if literal.below { grows } else { shrinks }
    }

    pub(super) fn literal(&mut self, surface: LocalSurface<'a>) -> Literal {
        let LocalSurface { family, level, below } = surface;
        for (i, known) in self.known.iter().enumerate() {
            match compare_families(known, &family) {
                Some(false) => return Literal { family: i as u32, level, below },
                Some(true) => {
                    return Literal { family: i as u32, level: -level, below: !below };
                }
                None => {}
            }
        }
        self.known.push(family);
        Literal { family: self.known.len() as u32 - 1, level, below }
    }
}

fn near(a: &Vector3<f64>, b: &Vector3<f64>, tolerance: f64) -> bool {
    (a - b).amax() <= tolerance
}

/// Returns whether two axes have the same line, in either direction.
fn same_line(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    near(a, b, PARALLEL) || near(a, &-b, PARALLEL)
}

/// Compares two families: `Some(false)` if they are the same, `Some(true)` if the second is the first's negative,
/// `None` if they differ.
fn compare_families(a: &Family, b: &Family) -> Option<bool> {
    // A quarter of the tolerance: errors of point, level and radius may add up.
    let point = |a: &Vector3<f64>, b: &Vector3<f64>| near(a, b, SAME_MM / 4.0);
    match (a, b) {
        (Family::Plane { normal: a }, Family::Plane { normal: b }) => {
            if near(a, b, PARALLEL) {
                Some(false)
            } else {
                near(a, &-b, PARALLEL).then_some(true)
            }
        }
        (Family::Round { centre: a }, Family::Round { centre: b }) => {
            point(&a.coords, &b.coords).then_some(false)
        }
        (Family::Pipe { point: a, axis: u }, Family::Pipe { point: b, axis: v }) => {
            (point(a, b) && same_line(u, v)).then_some(false)
        }
        (
            Family::Cone { point: a, axis: u, slope: s },
            Family::Cone { point: b, axis: v, slope: t },
        ) => {
            let along = near(u, v, PARALLEL) && (s - t).abs() <= PARALLEL * s.abs();
            let against = near(u, &-v, PARALLEL) && (s + t).abs() <= PARALLEL * s.abs();
            (point(a, b) && (along || against)).then_some(false)
        }
        (
            Family::Ring { centre: a, axis: u, radius_mm: r },
            Family::Ring { centre: b, axis: v, radius_mm: s },
        ) => {
            let same = point(&a.coords, &b.coords) && same_line(u, v);
            // The level (tube radius) is not compared here: it distinguishes literals of one family.
            (same && (r - s).abs() <= SAME_MM / 4.0).then_some(false)
        }
        (
            Family::Spheroid { centre: a, axis: u, half_axes_mm: r },
            Family::Spheroid { centre: b, axis: v, half_axes_mm: s },
        ) => {
            let same = point(&a.coords, &b.coords) && same_line(u, v);
            (same && (0..2).all(|i| (r[i] - s[i]).abs() <= SAME_MM / 4.0)).then_some(false)
        }
        (Family::Primitive { leaf: a }, Family::Primitive { leaf: b }) => {
            let (p, q) = (&a.body_from_leaf, &b.body_from_leaf);
            let placed = (p.rotation() - q.rotation()).amax() <= PARALLEL
                && point(p.translation_mm(), q.translation_mm());
            (placed && is_same(&a.primitive, &b.primitive)).then_some(false)
        }
        _ => None,
    }
}

fn is_same(a: &Solid, b: &Solid) -> bool {
    std::mem::discriminant(a) == std::mem::discriminant(b) && a == b
}
