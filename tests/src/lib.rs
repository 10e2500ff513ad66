//! What the end-to-end tests share: the real binary, and the built-in designs and their fixtures.

mod command;
pub mod contract;
mod designs;

pub use command::{Run, binary, command, contents, fabkit};
pub use designs::{built, builtin_designs, builtin_fixtures, sampled};

/// A camera's file as OpenCV writes it: that of R-Tac0's published unit, calibrated in air, as its authors state it.
pub const OPENCV_CAMERA: &str = "\
%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 299.97297618, 0., 325.24480754, 0., 299.81689507, 264.89790698, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.25971254, 0.08700416, -1.4873e-05, -2.28895e-04, -0.01535192 ]
";
