//! Exact geometry of parts as constructive solids (CSG), independent of meshes and rendered depth.
//!
//! # Conventions
//!
//! - Lengths are millimetres, angles radians, both `f64`. Names carry the unit: `radius_mm`.
//! - Frames are right-handed. A [`Pose`] called `to_from` maps points of `from` into `to`.
//! - Round solids (sphere, ellipsoid, torus, offset ellipsoid) are centred on their origin. Solids with a base
//!   (cylinder, cone, cuboid, extrusion) stand on the plane z = 0 and are centred on the z axis. A revolution keeps its
//!   profile's z. A [`Solid::Placed`] moves them.
//! - A [`Solid`] is a description. [`CompiledSolid`] is the same solid prepared for queries: bounds, containment and
//!   *all* crossings of a line with normals and faces.
//! - Booleans are regularised: a piece without volume does not exist. Cutting tools extend beyond the cut face by
//!   [`CUT_OVERLAP_MM`], so that no two faces of one tree coincide.
//!
//! ```
//! use fabkit_geometry::{CompiledSolid, Point3, Ray, Solid, Vector3};
//!
//! let washer = Solid::cylinder(5.0, 1.0).minus(Solid::cylinder(2.0, 3.0).at(0.0, 0.0, -1.0));
//! let body = CompiledSolid::new(&washer)?;
//! let along_x = Ray { origin: Point3::new(0.0, 0.0, 0.5), direction: Vector3::x() };
//! let x_mm: Vec<f64> = body.crossings(&along_x).iter().map(|c| c.t).collect();
//! assert_eq!(x_mm, [-5.0, -2.0, 2.0, 5.0]);
//! # Ok::<(), fabkit_geometry::InvalidSolid>(())
//! ```

mod body_advice;
mod bounds;
mod circuit;
mod compiled;
pub mod csv;
mod lens;
mod lettering;
mod lighting;
mod liquid;
mod manufacturing;
mod marker;
mod material_properties;
pub mod measure;
mod model;
mod motion;
mod nominal_camera;
mod order;
mod pattern;
mod pose;
mod profile;
mod profile_extent;
mod profile_validity;
pub mod proofs;
mod ray;
mod roots;
mod sensor;
pub mod sequences;
mod shape_key;
mod sheet;
mod slicing;
mod softness;
mod solid;
mod surface_points;
mod touch;
mod transparency;
mod units;
mod validate;

pub use bounds::Aabb;
pub use circuit::*;
pub use compiled::{CompiledSolid, Crossing, PlacedPrimitive, Scratch};
pub use lens::*;
pub use lettering::{LETTERING_FEATURES, has_lettering, without_lettering};
pub use lighting::{LightSourceGroup, Lighting, LiquidColumn, Rgb, VisibleEffect, WHITE};
pub use liquid::*;
pub use manufacturing::*;
pub use marker::{Marker, MarkerCarrier};
pub use material_properties::*;
pub use model::*;
pub use motion::{Motion, MotionLeg, Occasion, ToolAccess};
pub use nalgebra::{Matrix3, Point3, Vector3};
pub use nominal_camera::NominalCamera;
pub use order::{Order, Pack, QuantityUnit, UNSPECIFIED};
pub use pattern::{InvalidPattern, MAX_FEATURES, Pattern};
pub use pose::Pose;
pub use profile::{Path, Profile, Segment};
pub use ray::Ray;
pub use sensor::*;
pub use sheet::{NotASheet, Sheet};
pub use slicing::SliceAdvice;
pub use solid::*;
pub use surface_points::{DomePoints, PlanePoints, SurfacePoints};
pub use touch::{DomeSurface, FixtureGrip, PlaneSurface, TouchSurface};
pub use units::{Angle, Length, UnitError, format_rounded};
pub use validate::{InvalidSolid, Violation};

/// Length by which a cutting tool extends beyond the face it starts from, mm.
///
/// Coincident faces have no defined inside and outside: a tool that stops exactly on the face it cuts leaves that
/// decision to rounding.
pub const CUT_OVERLAP_MM: f64 = 0.1;
