//! From layers and lamps to grey values: what a camera inside a sensor records of its light.
//!
//! Nothing here knows which sensor it is: paths, places and thicknesses come in, grey values go out. All of it is a
//! model, and what it yields is simulated.
//!
//! # Conventions
//!
//! - Millimetres, `f64`, the sensor's frame. Irradiance is relative: 1 is the mean over what the camera sees at rest.
//! - Grey values run from 0 to 255 whatever the depth of the picture is; they are rounded at the end.
//! - Same input, same bits, on any number of threads.
//!
//! # Model
//!
//! A *translucent layer over black* ([`TwoStream`]) sends back the more light the thicker it is: a press makes it
//! thinner and the picture darker, gel that is pushed aside makes it thicker and the picture brighter. *Lamps*
//! ([`Emitters`]) are what shines of the drawn bodies: each place of the layer gets light from all of them that no opaque
//! body hides, by cosine and distance, and the same from everywhere for what bounces on. Light goes sideways in the layer
//! ([`Spread`]). The *chip* ([`Chip`]) adds noise. [`fit`] finds constants.
//!
//! ```
//! use fabkit_light::{Chip, TwoStream};
//!
//! // A gel that sends back half of what comes in at 2 mm.
//! let gel = TwoStream { scatter_per_mm: 0.5 };
//! assert_eq!(gel.reflectance(2.0), 0.5);
//! // Pressed to half of its thickness it is darker by less than half.
//! assert!((gel.reflectance(1.0) - 1.0 / 3.0).abs() < 1e-15);
//! let chip = Chip { read_noise: 0.0, shot_noise: 0.0 };
//! assert_eq!(chip.records(100.4, 7, 0), 100.4);
//! ```

#![forbid(unsafe_code)]

mod chip;
mod coat;
mod defocus;
mod fit;
mod glow;
mod lamp;
mod layer;
mod peg;
mod planes;
mod spread;

pub use chip::{Chip, drift, normal};
pub use coat::Coat;
pub use defocus::{Defocus, circle_px};
pub use fit::{fit, linear_fit};
pub use glow::glow;
pub use lamp::{Emitter, Emitters, NoLight, diffuse_slant};
pub use layer::TwoStream;
pub use peg::{Peg, PegHit};
pub use planes::{Arrival, Planes};
pub use spread::Spread;
