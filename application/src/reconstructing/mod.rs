//! From pictures to depth without a network: how dark a layer has become says how thin it is, and so how far its surface is
//! pressed in.
//!
//! What it needs is the picture at rest and the drawn layers. The picture at rest says how much light there is at each
//! pixel; the law of the layer ([`TwoStream`](fabkit_light::TwoStream)) turns what is missing of it into thickness, and
//! what lies below gives way as an elastic press of a ball says. Of an endless layer's light `L`, ground `g` as a part
//! of it, scattering `s` and a path `p` in the layer,
//!
//! ```text
//! grey at rest = E L (R(p) + g)        R(p) = s p / (1 + s p)
//! darker       = E L (R(p) - R(p'))    depth = (1 - p' / p) thickness / thins / cosine
//! ```
//!
//! and `E L` is what the picture at rest has over `R(p) + g`. Light that goes sideways in the layer makes what is narrow
//! shallower; some of it is taken back.

mod error;
mod sharpen;
mod thickness;

use std::path::Path;
use std::time::Instant;

use fabkit_calibration::image::GreyImage;
use fabkit_export::{Array, Values, npz};

use crate::Error;
use crate::calibrating::pictures::read_grey;

pub use error::ReconstructError;
pub use thickness::{Reconstructed, Reconstructor};

/// Reads a picture.
///
/// # Errors
/// A file that cannot be read, or is no picture that can be used.
pub fn read(path: &Path) -> Result<GreyImage, Error> {
    read_grey(path)
}

/// For `numpy.load`: `depth_mm` and `contact`, rows x columns.
///
/// # Errors
/// Arrays that are larger than their file can be.
pub fn npz_of(size_px: [usize; 2], shown: &Reconstructed) -> Result<Vec<u8>, Error> {
    let array = |name: &str, values| Array {
        name: name.to_owned(),
        shape: vec![size_px[1], size_px[0]],
        values,
    };
    npz(&[
        array("depth_mm", Values::F32(shown.depth_mm.clone())),
        array("contact", Values::Bool(shown.contact.clone())),
    ])
    .map_err(Error::bug)
}

/// Pictures that one core reconstructs in a second, decoding apart: of the fastest of some runs.
pub fn pictures_per_s(reconstructor: &Reconstructor, picture: &GreyImage) -> f64 {
    const RUNS: usize = 5;
    let run = |_| {
        let start = Instant::now();
        std::hint::black_box(reconstructor.of_values(picture.values()));
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(run).fold(f64::INFINITY, f64::min).recip()
}
