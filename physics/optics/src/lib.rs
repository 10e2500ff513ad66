//! Ray tracing between a camera and the surface that it views, through the bodies of a sensor.
//!
//! # Model
//!
//! A camera sees along rays that leave its pupil. Where a ray passes from one medium into another, it is refracted by
//! Snell's law at the exact intersection with the drawn surface. Where it meets a body that does not let it pass, it
//! ends. The bodies are the sensor's own: the same solids that are printed and cast.
//!
//! - A body that is [`Clear`](fabkit_geometry::OpticalClarity::Clear) is a medium with a refractive index. Between bodies
//!   there is air.
//! - The *skin* shows the touch: it consists of the bodies that the camera is meant to see, and of cast opaque or
//!   translucent layers. A ray that meets skin sees the *surface* if it reaches the sensing surface through skin alone.
//!   It is not refracted there, because it shows the point where it met the skin.
//! - Markers, whose positions a lighting shows, end a ray: whoever sees one does not see the surface behind it.
//! - Any other body ends a ray. Bodies around the nominal pupil belong to the camera and are not seen by it.
//! - Light that is totally reflected ends there: a mirror image is no ground truth.
//!
//! A [`CameraView`] is a camera at its place: it maps pixels to paths, and points back to pixels. Of several rays to one
//! point, it finds the one closest to the straight line; [`CameraView::project_all`] finds all of them.
//!
//! # Conventions
//!
//! Coordinates are in the sensor frame, mm. Rays have unit directions and run from the pupil outwards, against the
//! light. A path is a chain of straight pieces; its *lead* is the length of all but the last. Refractive indices are
//! relative to vacuum, and air counts as 1 (1.0003 changes no direction by more than a thousandth of a degree).
//!
//! ```
//! use fabkit_geometry::{Angle, Assembly, Body, OpticalClarity, NominalCamera, Placement, Point3, Pose, Ray};
//! use fabkit_geometry::{Sensor, Solid, MaterialProperties, Vector3};
//! use fabkit_optics::{OpticalStack, RayEnd, Tracer};
//!
//! let mut pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
//!     .with_clarity(OpticalClarity::Clear)
//!     .placed([Placement::in_place(Assembly::sensor())]);
//! pane.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
//! let camera = NominalCamera {
//!     sensor_from_camera: Pose::identity(),
//!     width_px: 640,
//!     height_px: 480,
//!     field_of_view: Angle::from_deg(90.0).unwrap(),
//!     lens: Default::default(),
//! };
//! let sensor = Sensor::new("window", "A window", "", camera, [pane]);
//! let stack = OpticalStack::from_sensor(&sensor)?;
//! let ray = Ray { origin: Point3::origin(), direction: Vector3::new(0.6, 0.0, 0.8) };
//! let path = Tracer::new(&stack).follow(&ray);
//! // Two bends; behind them it runs parallel to how it came.
//! assert_eq!((path.bends, path.end), (2, RayEnd::Nothing));
//! assert!((path.last.direction - ray.direction).norm() < 1e-12);
//! # Ok::<(), fabkit_optics::InvalidStack>(())
//! ```

mod error;
mod hollow;
mod interface;
mod inverse;
mod last_face;
mod sensing;
mod snell;
mod stack;
mod tile_tracing;
mod trace;
mod viewer;
mod visibility;

pub use error::InvalidStack;
pub use interface::FirstInterface;
pub use inverse::{SightLine, SightLineSolver, ViewStacks};
pub use sensing::{START_TOLERANCE_MM, SensingSurface};
pub use snell::refract;
pub use stack::{MAX_NAMES, OpticalRole, OpticalStack};
pub use tile_tracing::{TILE, TileTracer, TileTracing};
pub use trace::{LightPath, RayEnd, Refraction, Tracer};
pub use viewer::{CameraView, PointProjection, ProjectionError};
pub use visibility::{InvisibleReason, OUTSIDE_IMAGE, REFRACTION, describe_losses};
