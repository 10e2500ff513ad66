//! fabkit as a library: a sensor's description in, files out.
//!
//! The crates below are re-exported; this one adds what ties them together: [`bodies`] (parts,
//! layers and components as one list), [`identity`] (which design a file belongs to),
//! [`exporting`] (a design to the bytes of all its files), [`pictures`], and [`staging`], the only
//! place that writes files. The `fabkit` command is a thin shell around them.

pub use fabkit_depth as depth;
pub use fabkit_designs as designs;
pub use fabkit_export as export;
pub use fabkit_geometry as geometry;
pub use fabkit_mesh as mesh;

pub mod bodies;
pub mod exporting;
pub mod identity;
pub mod pictures;
pub mod staging;
