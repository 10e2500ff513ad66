//! Tetrahedral meshes of the soft layers, for external finite-element solvers.
//!
//! The touched surface is divided into triangles whose corners lie on it exactly. Each triangle is extruded inwards
//! along the surface normals, through all layers, as a column of prisms; each prism is divided into three tetrahedra.
//! Interfaces between layers are shared faces whose nodes lie on them exactly. Diagonals start at the corner with the
//! lower number, so that neighbours agree.
//!
//! # Conventions
//!
//! Units are millimetres, in the sensor frame. Layers are counted inwards from the touched one, 0. The corners of a
//! tetrahedron are ordered for a positive volume: seen from the fourth, the first three run counter-clockwise. Same
//! input, same bytes.

#![forbid(unsafe_code)]

mod mesh;
mod outline;
mod prisms;
mod quality;
mod rings;

pub use mesh::{MeshLayer, TetraError, Tetrahedra};
pub use quality::Quality;
