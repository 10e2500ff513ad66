//! Shared code of the end-to-end tests: the real binary, and the built-in designs and their fixtures.

mod command;
pub mod contract;
mod designs;
mod rules;

pub use command::{Run, binary, command, fabkit, read_folder};
pub use designs::{
    build_design, builtin_designs, builtin_fixtures, is_full, sample_bodies, sample_cases,
    sampled_sensors, slowness, tested_sensors,
};
pub use rules::{check, find_findings, motions};

/// Camera file in OpenCV's format: R-Tac0's published unit, calibrated in air, as stated by its authors.
pub const OPENCV_CAMERA: &str = include_str!("../data/rtac0_opencv_camera.yaml");
