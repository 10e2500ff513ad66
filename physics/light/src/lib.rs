//! Light model of tactile sensors: from layers and light sources to the intensities that a camera inside the sensor
//! records.
//!
//! The crate knows no particular sensor: paths, points and thicknesses come in, intensities go out. Everything is a
//! model, and its results are simulated.
//!
//! # Conventions
//!
//! - Lengths are millimetres, `f64`, in the sensor's frame. Irradiance is relative: 1 is the mean over what the camera
//!   sees at rest.
//! - Intensities run from 0 to 255, whatever the bit depth of the image, and are rounded at the end.
//! - Same input, same bits, on any number of threads.
//!
//! # Model
//!
//! A *translucent layer on black* ([`TwoStream`]) reflects more light the thicker it is. A press makes it thinner and
//! the image darker; gel that is pushed aside makes it thicker and the image brighter. *Light sources* ([`Emitters`])
//! are the emitting faces of the drawn bodies. Each point of the layer receives direct light from all of them that no
//! opaque body hides, by cosines and distance, and a uniform amount for multiple reflections. Light scatters sideways
//! in the layer ([`LayerBlur`]). The *image sensor* ([`ImageSensorNoise`]) adds noise. `fit` determines constants.
//!
//! ```
//! use fabkit_light::{ImageSensorNoise, TwoStream};
//!
//! // A gel that sends back half of what comes in at 2 mm.
//! let gel = TwoStream { scatter_per_mm: 0.5 };
//! assert_eq!(gel.reflectance(2.0), 0.5);
//! // Pressed to half of its thickness it is darker by less than half.
//! assert!((gel.reflectance(1.0) - 1.0 / 3.0).abs() < 1e-15);
//! let chip = ImageSensorNoise { read_noise: 0.0, shot_noise: 0.0 };
//! assert_eq!(chip.add_noise(100.4, 7, 0), 100.4);
//! ```

#![forbid(unsafe_code)]

mod coat;
mod defocus;
mod fit;
mod fluorescence;
mod image_sensor_noise;
mod layer_blur;
mod light_sources;
mod planes;
mod raised_marker;
mod translucent_layer;

pub use coat::Coat;
pub use defocus::{Defocus, blur_diameter_px};
pub use fit::{fit_positive, linear_fit};
pub use fluorescence::fluorescence;
pub use image_sensor_noise::{ImageSensorNoise, draw_drift, draw_normal};
pub use layer_blur::LayerBlur;
pub use light_sources::{
    DEFAULT_TRANSMITTANCE, Emitter, Emitters, LightingError, diffuse_path_ratio,
};
pub use planes::{Arrival, Planes};
pub use raised_marker::{RaisedMarker, RaisedMarkerHit};
pub use translucent_layer::TwoStream;
