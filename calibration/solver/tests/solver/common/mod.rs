//! What the tests of this folder share.
#![allow(dead_code, reason = "`fabkit calibrate intrinsics` is tested with some of it")]

pub mod scene;
