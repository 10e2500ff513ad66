//! Shared helpers of the tests in this folder.
#![allow(dead_code, reason = "`fabkit calibrate intrinsics` is tested with some of it")]

pub mod scene;
