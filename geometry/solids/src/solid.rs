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
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Path, Point3, Ray, Solid, Vector3};
/// let square = Path::polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]);
/// let post = CompiledSolid::new(&Solid::extrusion(square, 5.0))?;
/// let faces_along = |direction| -> Vec<u32> {
///     let ray = Ray { origin: Point3::new(0.0, 0.0, 2.0), direction };
///     post.crossings(&ray).iter().map(|crossing| crossing.face).collect()
/// };
/// assert_eq!(faces_along(Vector3::z()), [0, 1]); // bottom and top
/// assert_eq!(faces_along(Vector3::x()), [5, 3]); // over segment 3 at x = -1, over segment 1 at x = 1
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
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
    ///
    /// ```
    /// use fabkit_geometry::{Angle, EllipsoidOffset};
    /// let dome = EllipsoidOffset { equatorial_mm: 12.0, polar_mm: 15.0, offset_mm: 0.5 };
    /// let [tip, equator] = [0.0, 90.0].map(|deg| dome.meridian_point(Angle::from_deg(deg).unwrap()));
    /// assert_eq!(tip, [0.0, 15.5]);
    /// assert!((equator[0] - 12.5).abs() < 1e-12 && equator[1].abs() < 1e-12);
    /// ```
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
///
/// ```
/// use fabkit_geometry::Solid;
/// let read: Solid = serde_json::from_str(r#"{"cylinder": {"radius_mm": 1.0, "height_mm": 2.0}}"#)?;
/// assert_eq!(read, Solid::cylinder(1.0, 2.0));
/// // A misspelt key is refused, not ignored.
/// assert!(serde_json::from_str::<Solid>(r#"{"sphere": {"radius": 1.0}}"#).is_err());
/// # Ok::<(), serde_json::Error>(())
/// ```
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
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Ray, Solid, Vector3};
    /// let frustum = CompiledSolid::new(&Solid::cone(4.0, 2.0, 10.0))?;
    /// // Halfway up, its radius is halfway between the two.
    /// let ray = Ray { origin: Point3::new(0.0, 0.0, 5.0), direction: Vector3::x() };
    /// assert!((frustum.crossings(&ray)[1].t - 3.0).abs() < 1e-12);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn cone(bottom_radius_mm: f64, top_radius_mm: f64, height_mm: f64) -> Self {
        Self::Cone(Cone { bottom_radius_mm, top_radius_mm, height_mm })
    }

    /// Creates a box standing on z = 0, centred on the z axis.
    pub fn cuboid(x_mm: f64, y_mm: f64, z_mm: f64) -> Self {
        Self::Cuboid(Cuboid { size_mm: [x_mm, y_mm, z_mm] })
    }

    /// Creates the box between two corners.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Solid};
    /// let block = CompiledSolid::new(&Solid::cuboid_between([1.0, 2.0, 3.0], [5.0, 4.0, 8.0]))?;
    /// assert_eq!(block.bounds().min, Point3::new(1.0, 2.0, 3.0));
    /// assert_eq!(block.bounds().size_mm(), [4.0, 2.0, 5.0]);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn cuboid_between(min_mm: [f64; 3], max_mm: [f64; 3]) -> Self {
        let size: [f64; 3] = std::array::from_fn(|i| max_mm[i] - min_mm[i]);
        let centre = |i: usize| (min_mm[i] + max_mm[i]) / 2.0;
        Self::cuboid(size[0], size[1], size[2]).at(centre(0), centre(1), min_mm[2])
    }

    /// Creates a torus around z.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Solid};
    /// let ring = CompiledSolid::new(&Solid::torus(10.0, 2.0))?;
    /// assert!(ring.contains(&Point3::new(11.9, 0.0, 0.0)) && !ring.contains(&Point3::origin()));
    /// assert_eq!(ring.bounds().size_mm(), [24.0, 24.0, 4.0]);
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn torus(ring_radius_mm: f64, tube_radius_mm: f64) -> Self {
        Self::Torus(Torus { ring_radius_mm, tube_radius_mm })
    }

    /// Creates the half-space at or below the plane z = `z_mm`.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Solid};
    /// let dome = CompiledSolid::new(&Solid::sphere(10.0).minus(Solid::below(4.0)))?;
    /// assert!(dome.contains(&Point3::new(0.0, 0.0, 4.1)));
    /// assert!(!dome.contains(&Point3::new(0.0, 0.0, 3.9)));
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn below(z_mm: f64) -> Self {
        Self::HalfSpace(HalfSpace {}).at(0.0, 0.0, z_mm)
    }

    /// Creates the half-space on the side of the plane through `point` that `outward` points away from.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Solid, Vector3};
    /// // A pin with a flat at x = 3.
    /// let flat = Solid::behind(Point3::new(3.0, 0.0, 0.0), Vector3::x());
    /// let pin = CompiledSolid::new(&Solid::cylinder(4.0, 20.0).and(flat))?;
    /// assert!(pin.contains(&Point3::new(2.9, 0.0, 10.0)) && !pin.contains(&Point3::new(3.1, 0.0, 10.0)));
    /// assert!(pin.contains(&Point3::new(-3.9, 0.0, 10.0)));
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn behind(point: Point3<f64>, outward: Vector3<f64>) -> Self {
        Self::HalfSpace(HalfSpace {}).placed(Pose::z_to(outward, point))
    }

    /// Creates the extrusion of a profile in xy, from z = 0 upwards.
    pub fn extrusion(profile: impl Into<Profile>, height_mm: f64) -> Self {
        Self::Extrusion(Extrusion { profile: profile.into(), height_mm })
    }

    /// Creates the extrusion of a profile between two heights, mm.
    ///
    /// ```
    /// use fabkit_geometry::{Path, Solid};
    /// let plate = Path::rectangle([0.0, 0.0], [20.0, 10.0], 2.0);
    /// let lifted = Solid::extrusion(plate.clone(), 3.0).at_z(4.0);
    /// assert_eq!(Solid::prism(plate, [4.0, 7.0]), lifted);
    /// ```
    pub fn prism(profile: impl Into<Profile>, [bottom_mm, top_mm]: [f64; 2]) -> Self {
        Self::extrusion(profile, top_mm - bottom_mm).at_z(bottom_mm)
    }

    /// Creates a cylinder between two heights, mm.
    ///
    /// ```
    /// use fabkit_geometry::{CUT_OVERLAP_MM, CompiledSolid, Point3, Ray, Solid, Vector3};
    /// // A blind hole, 3 mm deep, that is cut from a little above the top.
    /// let hole = Solid::rod(1.0, [2.0, 5.0 + CUT_OVERLAP_MM]);
    /// let block = CompiledSolid::new(&Solid::cuboid(8.0, 8.0, 5.0).minus(hole))?;
    /// let from_above = Ray { origin: Point3::new(0.0, 0.0, 9.0), direction: -Vector3::z() };
    /// assert_eq!(block.crossings(&from_above)[0].t, 7.0); // 4 mm to the top, 3 mm down the hole
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn rod(radius_mm: f64, [bottom_mm, top_mm]: [f64; 2]) -> Self {
        Self::cylinder(radius_mm, top_mm - bottom_mm).at_z(bottom_mm)
    }

    /// Creates the revolution around z of a profile in (distance from axis, z).
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Path, Point3, Solid};
    /// // A rectangle from 8 to 10 mm off the axis becomes a tube that stands where the profile's z says.
    /// let wall = Path::rectangle([9.0, 6.0], [2.0, 4.0], 0.0);
    /// let tube = CompiledSolid::new(&Solid::revolution(wall))?;
    /// assert!(tube.contains(&Point3::new(0.0, -9.0, 7.9)) && !tube.contains(&Point3::new(0.0, 0.0, 6.0)));
    /// assert_eq!((tube.bounds().min.z, tube.bounds().max.z), (4.0, 8.0));
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    pub fn revolution(profile: impl Into<Profile>) -> Self {
        Self::Revolution(Revolution { profile: profile.into() })
    }

    /// Creates a solid bounded by a parallel surface of an ellipsoid of revolution around z.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Point3, Solid};
    /// let inner = CompiledSolid::new(&Solid::ellipsoid_offset(12.0, 15.0, -1.0))?;
    /// // 1 mm inside the ellipsoid, at its tip as at its equator.
    /// assert!(
    ///     inner.contains(&Point3::new(0.0, 0.0, 13.99)) && !inner.contains(&Point3::new(0.0, 0.0, 14.01))
    /// );
    /// assert!(
    ///     inner.contains(&Point3::new(10.99, 0.0, 0.0)) && !inner.contains(&Point3::new(11.01, 0.0, 0.0))
    /// );
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
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
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// let plate = Solid::cuboid(30.0, 30.0, 2.0);
    /// let holes = [-10.0, 0.0, 10.0].map(|x_mm| Solid::rod(1.5, [-0.1, 2.1]).at(x_mm, 0.0, 0.0));
    /// let drilled = plate.clone().minus_all(holes);
    /// assert_eq!(drilled.leaves().len(), 4);
    /// assert_eq!(plate.clone().minus_all([]), plate);
    /// ```
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
    ///
    /// ```
    /// use fabkit_geometry::{Angle, Point3, Solid};
    /// let quarter = Angle::from_deg(90.0).unwrap();
    /// let centre = |solid: Solid| solid.leaves()[0].root_from_leaf.point(Point3::origin());
    /// // What is written last happens last.
    /// let moved_then_turned = Solid::sphere(1.0).at(5.0, 0.0, 0.0).turned_z(quarter);
    /// assert_eq!(centre(moved_then_turned), Point3::new(0.0, 5.0, 0.0));
    /// let turned_then_moved = Solid::sphere(1.0).turned_z(quarter).at(5.0, 0.0, 0.0);
    /// assert_eq!(centre(turned_then_moved), Point3::new(5.0, 0.0, 0.0));
    /// ```
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
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// let vent = Solid::cylinder(0.5, 9.0).named("vent");
    /// let solid = Solid::cylinder(5.0, 8.0).minus(vent).named("mold");
    /// let names: Vec<&str> = solid.leaves().iter().map(|leaf| leaf.feature).collect();
    /// assert_eq!(names, ["mold", "vent"]);
    /// ```
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
    ///
    /// ```
    /// use fabkit_geometry::{Point3, Solid};
    /// let eye = Solid::sphere(1.0).at(2.0, 0.0, 0.0).named("eye");
    /// let face = Solid::cylinder(5.0, 3.0).plus(eye).at_z(10.0);
    /// let leaves = face.leaves();
    /// assert_eq!(leaves[1].primitive, &Solid::sphere(1.0));
    /// assert_eq!(leaves[1].root_from_leaf.point(Point3::origin()), Point3::new(2.0, 0.0, 10.0));
    /// assert_eq!((leaves[0].feature, leaves[1].feature), ("", "eye"));
    /// ```
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
