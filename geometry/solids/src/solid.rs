//! Tree of exact primitives that describes a part.
//!
//! Faces are numbered within each primitive as its documentation says; leaves are numbered in the order in which
//! [`Solid::leaves`] walks the tree. Meshes, ray crossings and STEP faces all use these two numbers, so a feature keeps
//! its name from the parameter to the triangle.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Angle, Pose, Profile};

/// Ball around the origin. Face 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Radius, mm, above 0.
    pub radius_mm: f64,
}

/// Ellipsoid around the origin with its axes along x, y and z. Face 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ellipsoid {
    /// Half axes, mm, above 0.
    pub semi_axes_mm: [f64; 3],
}

/// Cylinder around z from z = 0 upwards. Faces: 0 side, 1 bottom, 2 top.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Radius, mm, above 0.
    pub radius_mm: f64,
    /// Height, mm, above 0.
    pub height_mm: f64,
}

/// Cone or frustum around z from z = 0 upwards. Faces: 0 side, 1 bottom, 2 top.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cone {
    /// Radius at z = 0, mm; one of the two radii may be 0.
    pub bottom_radius_mm: f64,
    /// Radius at the top, mm.
    pub top_radius_mm: f64,
    /// Height, mm, above 0.
    pub height_mm: f64,
}

/// Box centred on the z axis, from z = 0 upwards. Faces: 0 at -x, 1 at +x, 2 at -y, 3 at +y, 4 bottom, 5 top.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cuboid {
    /// Edge lengths along x, y, z, mm, above 0.
    pub size_mm: [f64; 3],
}

/// Torus around z, centred on the origin. Face 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Torus {
    /// Radius of the tube's centre line, mm; larger than the tube's (no self-contact).
    pub ring_radius_mm: f64,
    /// Radius of the tube, mm, above 0.
    pub tube_radius_mm: f64,
}

/// Half-space z <= 0. Only as operand of intersections and as cutting tool. Face 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HalfSpace {}

/// Extrusion of a profile in the xy plane, from z = 0 upwards. Faces: 0 bottom, 1 top, 2 + k the wall over segment k
/// (outer path first, then the holes).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extrusion {
    /// Region in x and y; lines and circular arcs only.
    pub profile: Profile,
    /// Height, mm, above 0.
    pub height_mm: f64,
}

/// Revolution around z of a profile in the (distance from the axis, z) half plane. Faces: k is swept by segment k
/// (outer path first, then the holes).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Revolution {
    /// Region; its first coordinate is the distance from the axis and nowhere negative.
    pub profile: Profile,
}

/// Solid bounded by a parallel surface of an ellipsoid of revolution around z (which is not an ellipsoid): all points
/// within `offset_mm` of the ellipsoid or, for a negative offset, at least that deep inside. Face 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidOffset {
    /// Half axis of the ellipsoid across z, mm, above 0.
    pub equatorial_mm: f64,
    /// Half axis of the ellipsoid along z, mm, above 0.
    pub polar_mm: f64,
    /// Distance of the parallel surface, mm. Negative values are limited by the ellipsoid's
    /// smallest radius of curvature, where the surface would grow an edge.
    pub offset_mm: f64,
}

impl EllipsoidOffset {
    /// Returns the surface point with the outward normal at the angle `polar` from z: distance from z and height over
    /// the centre, mm.
    ///
    /// On an ellipse with half axes a and b the normal at (a sin e, b cos e) is (b sin e, a cos e).
    pub fn meridian_point(&self, polar: Angle) -> [f64; 2] {
        let Self { equatorial_mm, polar_mm, offset_mm } = *self;
        let (sin, cos) = polar.rad().sin_cos();
        // The point is the normal scaled by the squared half axes, up to its length.
        let scale = (equatorial_mm * sin).hypot(polar_mm * cos);
        [
            equatorial_mm * equatorial_mm * sin / scale + offset_mm * sin,
            polar_mm * polar_mm * cos / scale + offset_mm * cos,
        ]
    }
}

/// Solid: a primitive, a boolean of solids, a placed solid or a named one.
///
/// JSON has one key, the kind in kebab-case: `{"cylinder": {"radius_mm": 1.0, "height_mm": 2.0}}`, `{"difference":
/// {"of": .., "minus": [..]}}`.
///
/// Booleans must not be empty: a union without operands is an error, not an empty solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Solid {
    /// See [`Sphere`].
    Sphere(Sphere),
    /// See [`Ellipsoid`].
    Ellipsoid(Ellipsoid),
    /// See [`Cylinder`].
    Cylinder(Cylinder),
    /// See [`Cone`].
    Cone(Cone),
    /// See [`Cuboid`].
    Cuboid(Cuboid),
    /// See [`Torus`].
    Torus(Torus),
    /// See [`HalfSpace`].
    HalfSpace(HalfSpace),
    /// See [`Extrusion`].
    Extrusion(Extrusion),
    /// See [`Revolution`].
    Revolution(Revolution),
    /// See [`EllipsoidOffset`].
    EllipsoidOffset(EllipsoidOffset),
    /// Union of all operands.
    Union(Vec<Solid>),
    /// Intersection of all operands.
    Intersection(Vec<Solid>),
    /// Points of `of` outside all of `minus`.
    Difference {
        /// Solid that is cut.
        of: Box<Solid>,
        /// Tools that are cut away.
        minus: Vec<Solid>,
    },
    /// Solid at a pose.
    Placed {
        /// Maps the inner solid's frame to this one's.
        pose: Pose,
        /// Solid that is moved.
        of: Box<Solid>,
    },
    /// Named feature: all faces below belong to it, unless a deeper name says otherwise.
    Feature {
        /// Name, for example `hole 17`.
        name: String,
        /// Solid that is named.
        of: Box<Solid>,
    },
}

/// Primitive with its pose and the name of the innermost feature around it.
#[derive(Clone, Debug)]
pub struct Leaf<'a> {
    /// Primitive; always one of the primitive variants.
    pub primitive: &'a Solid,
    /// Maps the primitive's frame to that of the whole tree.
    pub root_from_leaf: Pose,
    /// Name of the innermost feature; empty if there is none.
    pub feature: &'a str,
}

impl Solid {
    /// Creates a ball around the origin.
    pub fn sphere(radius_mm: f64) -> Self {
        Self::Sphere(Sphere { radius_mm })
    }

    /// Creates an ellipsoid around the origin.
    pub fn ellipsoid(semi_axes_mm: [f64; 3]) -> Self {
        Self::Ellipsoid(Ellipsoid { semi_axes_mm })
    }

    /// Creates a cylinder standing on z = 0.
    pub fn cylinder(radius_mm: f64, height_mm: f64) -> Self {
        Self::Cylinder(Cylinder { radius_mm, height_mm })
    }

    /// Creates a cone or frustum standing on z = 0.
    pub fn cone(bottom_radius_mm: f64, top_radius_mm: f64, height_mm: f64) -> Self {
        Self::Cone(Cone { bottom_radius_mm, top_radius_mm, height_mm })
    }

    /// Creates a box standing on z = 0, centred on the z axis.
    pub fn cuboid(x_mm: f64, y_mm: f64, z_mm: f64) -> Self {
        Self::Cuboid(Cuboid { size_mm: [x_mm, y_mm, z_mm] })
    }

    /// Creates the box between two corners.
    pub fn cuboid_between(min_mm: [f64; 3], max_mm: [f64; 3]) -> Self {
        let size: [f64; 3] = std::array::from_fn(|i| max_mm[i] - min_mm[i]);
        let centre = |i: usize| (min_mm[i] + max_mm[i]) / 2.0;
        Self::cuboid(size[0], size[1], size[2]).at(centre(0), centre(1), min_mm[2])
    }

    /// Creates a torus around z.
    pub fn torus(ring_radius_mm: f64, tube_radius_mm: f64) -> Self {
        Self::Torus(Torus { ring_radius_mm, tube_radius_mm })
    }

    /// Creates the half-space at or below the plane z = `z_mm`.
    pub fn below(z_mm: f64) -> Self {
        Self::HalfSpace(HalfSpace {}).at(0.0, 0.0, z_mm)
    }

    /// Creates the half-space on the side of the plane through `point` that `outward` points away from.
    pub fn behind(point: Point3<f64>, outward: Vector3<f64>) -> Self {
        Self::HalfSpace(HalfSpace {}).placed(Pose::z_to(outward, point))
    }

    /// Creates the extrusion of a profile in xy, from z = 0 upwards.
    pub fn extrusion(profile: impl Into<Profile>, height_mm: f64) -> Self {
        Self::Extrusion(Extrusion { profile: profile.into(), height_mm })
    }

    /// Creates the extrusion of a profile between two heights, mm.
    pub fn prism(profile: impl Into<Profile>, [bottom_mm, top_mm]: [f64; 2]) -> Self {
        Self::extrusion(profile, top_mm - bottom_mm).at_z(bottom_mm)
    }

    /// Creates a cylinder between two heights, mm.
    pub fn rod(radius_mm: f64, [bottom_mm, top_mm]: [f64; 2]) -> Self {
        Self::cylinder(radius_mm, top_mm - bottom_mm).at_z(bottom_mm)
    }

    /// Creates the revolution around z of a profile in (distance from axis, z).
    pub fn revolution(profile: impl Into<Profile>) -> Self {
        Self::Revolution(Revolution { profile: profile.into() })
    }

    /// Creates a solid bounded by a parallel surface of an ellipsoid of revolution around z.
    pub fn ellipsoid_offset(equatorial_mm: f64, polar_mm: f64, offset_mm: f64) -> Self {
        Self::EllipsoidOffset(EllipsoidOffset { equatorial_mm, polar_mm, offset_mm })
    }

    /// Creates the union of solids.
    pub fn union(of: impl IntoIterator<Item = Solid>) -> Self {
        Self::Union(of.into_iter().collect())
    }

    /// Creates the intersection of solids.
    pub fn intersection(of: impl IntoIterator<Item = Solid>) -> Self {
        Self::Intersection(of.into_iter().collect())
    }

    /// Unites with another solid; an existing union grows instead of nesting.
    #[must_use]
    pub fn plus(self, other: Solid) -> Self {
        match self {
            Self::Union(mut of) => {
                of.push(other);
                Self::Union(of)
            }
            one => Self::Union(vec![one, other]),
        }
    }

    /// Cuts one tool away; an existing difference grows instead of nesting.
    #[must_use]
    pub fn minus(self, tool: Solid) -> Self {
        self.minus_all([tool])
    }

    /// Cuts all tools away; without tools, nothing changes.
    #[must_use]
    pub fn minus_all(self, tools: impl IntoIterator<Item = Solid>) -> Self {
        let tools: Vec<Solid> = tools.into_iter().collect();
        match self {
            one if tools.is_empty() => one,
            Self::Difference { of, mut minus } => {
                minus.extend(tools);
                Self::Difference { of, minus }
            }
            one => Self::Difference { of: Box::new(one), minus: tools },
        }
    }

    /// Intersects with another solid.
    #[must_use]
    pub fn and(self, other: Solid) -> Self {
        Self::Intersection(vec![self, other])
    }

    /// Applies a pose.
    #[must_use]
    pub fn placed(self, pose: Pose) -> Self {
        match self {
            // Nested placements are merged, so that trees stay shallow.
            Self::Placed { pose: inner, of } => Self::Placed { pose: pose.then_in(inner), of },
            one => Self::Placed { pose, of: Box::new(one) },
        }
    }

    /// Translates, mm.
    #[must_use]
    pub fn at(self, x_mm: f64, y_mm: f64, z_mm: f64) -> Self {
        self.placed(Pose::translation(x_mm, y_mm, z_mm))
    }

    /// Translates along z, mm.
    #[must_use]
    pub fn at_z(self, z_mm: f64) -> Self {
        self.at(0.0, 0.0, z_mm)
    }

    /// Rotates about the x axis.
    #[must_use]
    pub fn turned_x(self, angle: Angle) -> Self {
        self.placed(Pose::rotation_x(angle))
    }

    /// Rotates about the y axis.
    #[must_use]
    pub fn turned_y(self, angle: Angle) -> Self {
        self.placed(Pose::rotation_y(angle))
    }

    /// Rotates about the z axis.
    #[must_use]
    pub fn turned_z(self, angle: Angle) -> Self {
        self.placed(Pose::rotation_z(angle))
    }

    /// Assigns a feature name to everything in it that has no name yet.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self::Feature { name: name.into(), of: Box::new(self) }
    }

    /// Returns the direct children of a boolean, placement or feature, in order; none for a primitive.
    pub fn children(&self) -> Vec<&Solid> {
        match self {
            Self::Union(of) | Self::Intersection(of) => of.iter().collect(),
            Self::Difference { of, minus } => std::iter::once(&**of).chain(minus).collect(),
            Self::Placed { of, .. } | Self::Feature { of, .. } => vec![of],
            _ => Vec::new(),
        }
    }

    /// Returns all primitives in the order of the tree: leaf numbers are indices into this list.
    pub fn leaves(&self) -> Vec<Leaf<'_>> {
        let mut leaves = Vec::new();
        self.walk_leaves(Pose::identity(), "", &mut leaves);
        leaves
    }

    fn walk_leaves<'a>(&'a self, pose: Pose, feature: &'a str, leaves: &mut Vec<Leaf<'a>>) {
        match self {
            Self::Placed { pose: inner, of } => {
                of.walk_leaves(pose.then_in(*inner), feature, leaves);
            }
            Self::Feature { name, of } => of.walk_leaves(pose, name, leaves),
            Self::Union(_) | Self::Intersection(_) | Self::Difference { .. } => {
                for child in self.children() {
                    child.walk_leaves(pose, feature, leaves);
                }
            }
            primitive => leaves.push(Leaf { primitive, root_from_leaf: pose, feature }),
        }
    }
}
