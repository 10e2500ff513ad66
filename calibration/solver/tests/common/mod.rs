//! What the tests of this folder share.
#![allow(dead_code)] // Each test file is a crate of its own and uses some of it.

pub mod scene;
