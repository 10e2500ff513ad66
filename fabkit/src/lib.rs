//! fabkit as a library: a sensor's description in, files out.
//!
//! The crates below are re-exported; this one adds what ties them together: [`bodies`] (bodies
//! by name), [`identity`] (which design a file belongs to),
//! [`exporting`] (a design to the bytes of all its files), [`pictures`], [`sweeping`] (many variants
//! to tables), [`resumable`] (folders that runs fill which may be killed), [`verifier`] (the bridge to other kernels), and [`staging`], the only place that
//! writes files. What its users see is here too, because there are two doors to it, the `fabkit`
//! command and the Python package: [`source`] (which design a name or a path means), [`scene`]
//! (which camera looks at it), [`failure`] (codes, messages and hints), and [`commands`], the
//! command itself.
//!
//! ```
//! use fabkit::exporting::{ExportOptions, Format, export};
//! use fabkit::designs::{builtin_yaml, load};
//!
//! let yaml = builtin_yaml("rtac0").ok_or("no such sensor")?;
//! let design = load("rtac0.yaml", yaml, &["coat.thickness=0.1 mm".into()], &["fixtures"])?;
//! let options = ExportOptions {
//!     parts: vec!["base".into()],
//!     formats: vec![Format::Stl],
//!     ..ExportOptions::default()
//! };
//! let exported = export(&design, &options, &|part| println!("{part} is ready"))?;
//! let names: Vec<&str> = exported.files.iter().map(|file| file.name.as_str()).collect();
//! assert_eq!(names, ["base.stl", "manifest.json"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use fabkit_calibration as calibration;
pub use fabkit_camera as camera;
pub use fabkit_checks as checks;
pub use fabkit_depth as depth;
pub use fabkit_designs as designs;
pub use fabkit_export as export;
pub use fabkit_fixtures as fixtures;
pub use fabkit_geometry as geometry;
pub use fabkit_mesh as mesh;
pub use fabkit_sweep as sweep;
pub use fabkit_text as text;

// The command's files name the library as its other users do.
extern crate self as fabkit;

mod authored;
pub mod bodies;
mod cli;
pub mod commands;
pub mod dataset;
pub mod diagnostics;
pub mod exporting;
pub mod failure;
pub mod ground_truth;
pub mod identity;
mod interrupt;
pub mod memory;
pub mod pictures;
pub mod reading;
pub mod rereading;
pub mod resumable;
mod roles;
pub mod scene;
pub mod source;
pub mod staging;
pub mod sweeping;
mod table;
pub mod verifier;
