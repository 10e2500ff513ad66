//! Camera calibration: from images of pins and boards to cameras and poses with their uncertainty.
//!
//! # Conventions
//!
//! - Millimetres and radians, `f64`. Names carry unit and frame: `contact_in_sensor_mm`.
//! - Sensor frame: origin at the centre of the sensing surface's base circle, +z towards the tip.
//! - Camera frame as in OpenCV: +z forward, +x right, +y down; pixel centres lie at integers.
//! - A pose named `camera_from_sensor` maps sensor coordinates to camera coordinates.
//! - A pin's axis points in the direction in which the pin is pushed: into the sensor.
//!
//! ```
//! use fabkit_calibration::extrinsics::{Loss, solve_pose};
//! use fabkit_calibration::landmarks::PinLandmarks;
//! use fabkit_calibration::model::Model;
//! use fabkit_calibration::synthetic::SyntheticSensor;
//! use fabkit_camera::Camera;
//! use fabkit_geometry::Pose;
//!
//! // Pins touch at seven places of a dome of 15 mm. The camera is 7.6 mm below its base, a little aside.
//! let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
//!     "5": [0, -12, 9], "6": [12, 0, 9], "7": [-12, 0, 9]}"#;
//! let landmarks = PinLandmarks::from_json(map)?;
//! let camera = Camera::equidistant(640, 480, 2.8)?;
//! let truth = Model::new(camera, Pose::translation(0.4, -0.3, 7.6));
//! let captures = [landmarks.pins.iter().collect()];
//! let observations = SyntheticSensor::new(truth.clone(), 1).observe(&captures, 0.1)?;
//!
//! let found = solve_pose(&camera, &observations, None, Loss::Squares)?.model.camera_from_sensor;
//! let off_mm = found.translation_mm() - truth.camera_from_sensor.translation_mm();
//! assert!(off_mm.norm() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
pub mod significance;
pub mod synthetic;
pub mod uncertainty;
