//! Camera calibration: from images of pins and boards to cameras and poses with their uncertainty.
//!
//! # Conventions
//!
//! - Millimetres and radians, `f64`. Names carry unit and frame: `contact_in_sensor_mm`.
//! - Sensor frame: origin at the centre of the sensing surface's base circle, +z towards the tip.
//! - Camera frame as in OpenCV: +z forward, +x right, +y down; pixel centres lie at integers.
//! - A pose named `camera_from_sensor` maps sensor coordinates to camera coordinates.
//! - A pin's axis points in the direction in which the pin is pushed: into the sensor.

#![forbid(unsafe_code)]

pub mod assignment;
pub mod board;
pub mod captures;
pub mod drawn_interface;
pub mod extrinsics;
pub mod image;
mod information;
pub mod intrinsics;
pub mod landmarks;
pub mod model;
pub mod observability;
pub mod pin_captures;
pub mod pin_detection;
pub mod planning;
pub mod report;
pub mod synthetic;
pub mod uncertainty;
