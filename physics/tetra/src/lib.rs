//! Soft layers as tetrahedra, for solvers that are not fabkit's.
//!
//! The touched surface is divided into triangles, whose corners lie on it exactly; each is carried inwards along the
//! surface's normals, through all layers, as a column of prisms; each prism is three tetrahedra. Interfaces between
//! layers are common faces, and their nodes lie on them exactly. Diagonals go from the corner of the lower number, so
//! that neighbours agree.
//!
//! # Conventions
//!
//! Millimetres, sensor frame. Layers are counted from the touched one, 0, inwards. Corners of a tetrahedron are in the
//! order of a positive volume: the fourth lies on that side of the first three from which they run counter-clockwise.
//! Same input, same bytes.

#![forbid(unsafe_code)]

mod mesh;
mod outline;
mod prisms;
mod quality;
mod rings;

pub use mesh::{Layer, TetraError, Tetrahedra};
pub use quality::Quality;
