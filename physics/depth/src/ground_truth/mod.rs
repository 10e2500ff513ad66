//! Exact ground truth of what a camera inside a sensor sees of its surface, with or without a press.
//!
//! # Model
//!
//! The camera looks at the sensing surface from within. Without contact it sees the *reference* surface. A rigid
//! indenter displaces the gel, which follows it (`rigid` contact): each camera ray ends at whichever comes first, the
//! reference surface from inside or an indenter from outside. Both are exact crossings of exact solids; there is no
//! mesh, no z-buffer and no resampling. Rays traced [through](PixelRays::traced_through) a sensor's bodies are refracted by
//! clear ones and end at opaque ones.
//!
//! # Conventions
//!
//! - Points, normals and poses are in the sensor frame unless a name says otherwise; lengths are in mm.
//! - Normals point out of the gel: outwards on the reference surface, into the indenter on an indenter.
//! - *Range* is the distance along the ray from where it enters the gel: from its last refraction in the drawn bodies,
//!   or at the camera's own interface; from the lens's centre where nothing refracts it. *z* is the third coordinate in
//!   the camera frame. They are never mixed.
//! - *Indentation* is the range without contact minus the range with it, along the same ray.
//! - Pixels are stored row by row, the first one at the upper left; `NaN` marks pixels that see no sensing surface.
//! - The same input yields the same bits on any number of threads.
//!
//! ```
//! # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path};
//! # let grip = FixtureGrip {
//! #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
//! #     key: None, threads: Vec::new(),
//! # };
//! # let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
//! # let touch = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 2.0, grip }.into();
//! use fabkit_camera::Camera;
//! use fabkit_depth::ground_truth::{PixelRays, PlacedIndenter, ReferenceSurface};
//! use fabkit_geometry::{Pose, Solid};
//!
//! // The touch surface is a hemisphere of radius 10 mm around the origin, where a camera looks along +z.
//! let camera = Camera::equidistant(61, 61, 2.0)?;
//! let rays = PixelRays::new(&camera, &Pose::identity());
//! let surface = ReferenceSurface::cast(&touch, &rays)?;
//! // A ball of radius 3 mm comes from above; its lowest point is at z = 9.5 mm.
//! let ball = PlacedIndenter::new("ball", &Solid::sphere(3.0), Pose::translation(0.0, 0.0, 12.5))?;
//! let map = surface.map_with_indenters(&[ball]);
//! let middle = 30 * 61 + 30;
//! assert!((map.range_mm()[middle] - 9.5).abs() < 1e-9);
//! assert!((map.indentation_mm().nth(middle).unwrap() - 0.5).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ball;
mod cast;
mod deformed_surface;
mod false_color;
mod indenter;
mod map;
mod membrane;
mod rays;
mod reference;
mod stitch;
mod tiles;
mod transfer;
mod uncertainty;

pub use deformed_surface::SurfaceDisplacement;
pub use false_color::{false_color, scale_color};
pub use indenter::PlacedIndenter;
pub use map::{DepthMap, NO_LABEL, SURFACE_LABEL};
pub use rays::PixelRays;
pub use reference::ReferenceSurface;
pub use stitch::{Seam, Side};
pub use uncertainty::{StandardDeviations, Uncertainty};
