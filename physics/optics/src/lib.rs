//! What light does between a camera and what it looks at.
//!
//! # Model
//!
//! A camera sees along rays that leave its pupil. Where a ray passes from one medium into another it is
//! bent by Snell's law at the exact crossing of the drawn surfaces; where it meets what does not let it
//! pass as it is, it ends. The bodies are the sensor's own: the same solids that are printed and cast.
//!
//! - What is [`Clear`](fabkit_geometry::Clarity::Clear) is a medium with a refractive index; between bodies
//!   there is air.
//! - The *skin* is what shows the touch: what the camera is there to see, and opaque or translucent layers
//!   that are cast. A ray that meets it sees the *surface* if it goes on to the sensing surface through
//!   skin alone; nothing bends it in there, since what it shows is where it met the skin.
//! - All else ends a ray. The bodies around the nominal pupil are the camera's own, and see themselves not.
//! - Light that is totally reflected ends where that happens: what a mirror shows is no ground truth.
//!
//! A [`Viewer`] is a camera in such a place: from pixels to paths, and back from places to pixels. Of
//! several rays to one place it finds the one next to the straight line; [`Viewer::looks_at`] finds them all.
//!
//! # Conventions
//!
//! Sensor frame, mm. Rays have unit directions and run from the pupil outwards, against the light. A path is
//! a chain of straight pieces; its *lead* is the length of all but the last. Indices are against vacuum; air
//! counts as 1 (1.0003 moves nothing by more than a thousandth of a degree).
//!
//! ```
//! use fabkit_geometry::{Angle, Assembly, Body, Clarity, NominalCamera, Placement, Point3, Pose, Ray};
//! use fabkit_geometry::{Sensor, Solid, Substance, Vector3};
//! use fabkit_optics::{End, Stack, Tracer};
//!
//! let mut pane = Body::bought("pane", "glass", Solid::cylinder(20.0, 2.0).at(0.0, 0.0, 5.0))
//!     .in_light(Clarity::Clear)
//!     .placed([Placement::in_place(Assembly::sensor())]);
//! pane.substance = Substance { refractive_index: Some(1.5), ..Substance::default() };
//! let camera = NominalCamera {
//!     sensor_from_camera: Pose::identity(),
//!     width_px: 640,
//!     height_px: 480,
//!     field_of_view: Angle::from_deg(90.0).unwrap(),
//!     lens: Default::default(),
//! };
//! let sensor = Sensor::new("window", "A window", "", camera, [pane]);
//! let stack = Stack::of(&sensor)?;
//! let ray = Ray { origin: Point3::origin(), direction: Vector3::new(0.6, 0.0, 0.8) };
//! let path = Tracer::new(&stack).follow(&ray);
//! // Two bends; behind them it runs parallel to how it came.
//! assert_eq!((path.bends, path.end), (2, End::Nothing));
//! assert!((path.last.direction - ray.direction).norm() < 1e-12);
//! # Ok::<(), fabkit_optics::InvalidStack>(())
//! ```

mod bundle;
mod error;
mod hollow;
mod interface;
mod inverse;
mod last_face;
mod lost;
mod sensing;
mod snell;
mod stack;
mod trace;
mod viewer;

pub use bundle::{Bundles, TILE, TileTracer};
pub use error::InvalidStack;
pub use interface::Window;
pub use inverse::{Seeker, Sight, Sights};
pub use lost::{BESIDE_PICTURE, Lost, REFRACTION, in_words};
pub use sensing::{START_MM, SensingSurface};
pub use snell::refract;
pub use stack::{MAX_NAMES, Part, Stack};
pub use trace::{Bend, End, LightPath, Tracer};
pub use viewer::{Look, Unseen, Viewer};
