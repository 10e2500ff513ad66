//! Application layer of fabkit: from the description of a sensor to files.
//!
//! The `fabkit` command, the Python package and other programs use fabkit through this crate. It loads designs
//! ([`source`]), makes all their files ([`exports`], [`images`]), casts ground truth ([`scene`],
//! [`ground_truth`]), presses soft layers ([`press_simulation`]), makes data sets and sweeps ([`dataset`], [`sweep_runs`]; their
//! folders survive a killed process: [`resumable`]), calibrates ([`calibration_runs`]), compares with other geometry
//! kernels ([`verifier`]) and verifies its own folders ([`verify_folder`]). [`staging`] is the only place that writes
//! files, [`reading`] the only one that reads files of other origin. Failures are an [`Error`], typed down to their
//! values. Options, exit codes and terminals are unknown here. The crates below are re-exported.
//!
//! ```
//! use fabkit_application::exports::{ExportOptions, Format, export};
//! use fabkit_application::designs::{builtin_yaml, load};
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
pub use fabkit_guide as guide;
pub use fabkit_image as image;
pub use fabkit_mesh as mesh;
pub use fabkit_network as network;
pub use fabkit_sweep as sweep;
pub use fabkit_text as text;

pub use fabkit_capture as capturing;
pub use fabkit_capture::{light_fit, live};
pub use fabkit_dataset as dataset;
pub use fabkit_files::{
    Error, ErrorKind, ErrorSubject, Explained, UnknownName, diagnostics, memory, problem_json,
    progress, reading, resumable, staging,
};
pub use fabkit_reconstruct as reconstructing;
pub use fabkit_robots as robots;
pub use fabkit_scene as scene;
pub use fabkit_scene::{ground_truth, press_simulation};

pub mod benchmark;
pub mod bodies;
pub mod calibration_runs;
pub mod camera_view;
pub mod design_difference;
pub mod documents;
pub mod edited_files;
pub mod exports;
pub mod gel_profile;
pub mod guides;
pub mod images;
pub mod materials;
pub mod model_view;
pub mod packaging;
mod programs;
pub mod slicing;
pub mod source;
pub mod sweep_runs;
pub mod verifier;
pub mod verify_folder;
