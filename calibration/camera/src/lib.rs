//! Camera models: exact maps from points to pixels and back, with derivatives.
//!
//! # Conventions
//!
//! - Camera frame as in OpenCV: origin at the lens's centre of projection, +z forward, +x right
//!   (growing column), +y down (growing row). Lengths in mm, angles in radians.
//! - Pixels are `(column, row)`; the centre of the first pixel is `(0, 0)`, so that an image of
//!   width `w` spans columns `-0.5` to `w - 0.5`.
//! - A [`Lens`] is central: it maps *directions* to pixels. An *incidence angle* is the angle
//!   between a direction in front of the lens and +z. Each lens knows its largest incidence angle,
//!   [`Lens::angle_limit_rad`], up to which direction and pixel determine each other. Beyond it
//!   every function returns [`OutsideDomain`], never a number.
//! - An [`Interface`] is the refracting surface between lens and scene, such as the window or the gel of a
//!   tactile sensor. Points are then points *behind* it, in the last medium, and [`ViewRay`]s start on it.
//! - Parameters have a fixed order: first the lens's, then the interface's. [`Camera::parameters`] names them
//!   with their units. Jacobians and covariances follow that order.
//!
//! ```
//! use fabkit_camera::{Camera, Interface, Intrinsics, KannalaBrandt, Lens, Point3};
//!
//! let intrinsics = Intrinsics { fx_px: 286.0, fy_px: 286.0, cx_px: 319.5, cy_px: 239.5 };
//! let lens = Lens::KannalaBrandt(KannalaBrandt::new(intrinsics, [0.02, -0.003, 0.0, 0.0])?);
//! let camera = Camera::new(640, 480, lens, Interface::None)?;
//!
//! // A point level with the lens, 90 degrees off its axis, is an ordinary point.
//! let pixel = camera.project(&Point3::new(10.0, 0.0, 0.0))?;
//! let ray = camera.unproject(&pixel)?;
//! assert!((ray.direction - fabkit_camera::Vector3::x()).norm() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod camera;
mod error;
mod estimate;
pub mod files;
mod interface;
mod joint;
mod lens;
mod plausibility;
mod roots;
mod view_ray;

pub use camera::{
    Camera, MAX_PARAMETERS, MAX_PIXELS, ParameterDerivatives, Projection, image_centre_px,
};
pub use error::{InvalidCamera, OutsideDomain, ParameterViolation};
pub use estimate::{CameraEstimate, InvalidCovariance};
pub use interface::{FlatInterface, Interface, SphericalInterface};
pub use joint::{CovarianceCoverage, JointEstimate, POSE_PARAMETER_COUNT, POSE_PARAMETERS};
pub use lens::*;
pub use nalgebra::{DMatrix, Matrix2x3, Point2, Point3, Vector2, Vector3};
pub use plausibility::{CameraFinding, plausibility};
pub use view_ray::ViewRay;
