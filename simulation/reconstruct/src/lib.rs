//! From pictures to depth: by a network that somebody has trained ([`DepthNetwork`]), or without one, by what a sensor's light
//! shows.
//!
//! Where light shows **thickness** (R-Tac0, 9DTact), how dark a layer has become says how thin it is, and so how far its
//! surface is pressed in. What it needs is the picture at rest and the drawn layers. The picture at rest says how much
//! light there is at each pixel; the law of the layer ([`TwoStream`](fabkit_light::TwoStream)) turns what is missing of
//! it into thickness, and what lies below gives way as an elastic press of a ball says. Of an endless layer's light `L`,
//! ground `g` as a part of it, scattering `s` and a path `p` in the layer,
//!
//! ```text
//! grey at rest = E L (R(p) + g)        R(p) = s p / (1 + s p)
//! darker       = E L (R(p) - R(p'))    depth = (1 - p' / p) thickness / thins / cosine
//! ```
//!
//! and `E L` is what the picture at rest has over `R(p) + g`. Light that goes sideways in the layer makes what is narrow
//! shallower; some of it is taken back.
//!
//! Where light shows **slopes** (ShadowTac, DIGIT, GelSight), each place of the coat looks where the drawn lamps would
//! give it the colours that it has (photometric stereo, Woodham 1980), again beside the picture at rest; and the surface
//! is the one whose neighbouring places lie across these ways, along the camera's own rays.

mod drift;
mod error;
mod following;
mod heights;
mod learned;
mod reader;
mod sharpen;
mod slopes;
mod thickness;

use std::path::Path;
use std::time::Instant;

use fabkit_capture::{LightConstants, check_size};
use fabkit_export::{Array, Values, npz};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Shows};

pub use fabkit_capture::Taken;
use fabkit_scene::SensorView;
use learned::Learned;
use slopes::Slopes;
use thickness::Thickness;

pub use error::ReconstructError;
pub use following::{Followed, MarkFollower, hides_marks};
pub use learned::{Card, Circle, DepthNetwork, Normalisation};
pub use reader::{PictureRead, PictureReader, ReadingRates};

/// Whether a light shows how deep something presses, without a network.
pub fn shows_depth(lighting: &Lighting) -> bool {
    matches!(lighting.shows, Shows::Thickness { .. } | Shows::Slopes { .. })
}

/// What a picture shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstructed {
    /// How much nearer the surface is than at rest, along each pixel's ray, mm, as `indentation_mm` of truth; negative
    /// where gel bulges; not a number where no surface is seen. By a network, what it was trained on, and 0 where nothing touches.
    pub depth_mm: Vec<f32>,
    /// Where something presses.
    pub contact: Vec<bool>,
    /// How much brighter the picture is as a whole than the one at rest: 1 is not, and with a network whose card does not ask
    /// for it nobody looks.
    pub brighter: f32,
}

impl Reconstructed {
    /// The deepest contact, mm, but for a thousandth of its pixels: at a pad's edge one sees past gel that has moved aside.
    pub fn deepest_mm(&self) -> Option<f32> {
        let pressed = self.depth_mm.iter().zip(&self.contact).filter(|(_, contact)| **contact);
        let mut pressed: Vec<f32> = pressed.map(|(mm, _)| *mm).collect();
        pressed.sort_by(f32::total_cmp);
        let last = pressed.len().checked_sub(1 + pressed.len() / 1000)?;
        Some(pressed[last])
    }
}

/// Knows the light of a sensor at rest.
#[derive(Clone, Debug)]
pub struct Reconstructor {
    size_px: [usize; 2],
    shown: Shown,
}

#[derive(Clone, Debug)]
enum Shown {
    Thickness(Box<Thickness>),
    Slopes(Box<Slopes>),
    Learned(Box<Learned>),
}

impl Reconstructor {
    /// From a sensor as its camera sees it, and its picture at rest, which came from `file`.
    ///
    /// # Errors
    /// Light that shows neither thickness nor slopes, layers that cannot be pressed, a picture of another size or of
    /// something else, or without colours where they are needed.
    pub fn new(
        scene: &SensorView,
        lighting: &Lighting,
        constants: &LightConstants,
        (file, reference): (&Path, &Taken),
    ) -> Result<Self, Error> {
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        check_size(file, reference, size_px)?;
        let shown = match &lighting.shows {
            Shows::Thickness { .. } => {
                let grey = reference.clone().grey();
                Shown::Thickness(Box::new(Thickness::new(
                    scene,
                    lighting,
                    constants,
                    (file, &grey),
                )?))
            }
            Shows::Slopes { .. } => {
                check_colors(file, reference)?;
                Shown::Slopes(Box::new(Slopes::new(
                    scene,
                    lighting,
                    constants,
                    (file, &reference.values),
                )?))
            }
            _ => {
                let (sensor, light) = (scene.project.design.sensor.name.clone(), lighting.name);
                return Err(ReconstructError::OtherLight { sensor, light }.into());
            }
        };
        Ok(Self { size_px, shown })
    }

    /// By a network, from a sensor as its camera sees it, and its picture at rest, which came from `file`.
    ///
    /// # Errors
    /// A picture of another size, a network that needs more memory than is allowed.
    pub fn with_network(
        scene: &SensorView,
        network: &DepthNetwork,
        (file, reference): (&Path, &Taken),
    ) -> Result<Self, Error> {
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        check_size(file, reference, size_px)?;
        let learned = Learned::new(network, scene, &reference.clone().grey())?;
        Ok(Self { size_px, shown: Shown::Learned(Box::new(learned)) })
    }

    /// Width and height of pictures, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// What a picture shows, which came from `file`.
    ///
    /// # Errors
    /// A picture of another size, or without colours where they are needed.
    pub fn reconstruct(&self, file: &Path, picture: Taken) -> Result<Reconstructed, Error> {
        check_size(file, &picture, self.size_px)?;
        Ok(match &self.shown {
            Shown::Thickness(known) => known.of_values(&picture.grey()),
            Shown::Learned(known) => known.of_values(&picture.grey())?,
            Shown::Slopes(known) => {
                check_colors(file, &picture)?;
                known.of_values(&picture.values)
            }
        })
    }

    /// Pictures that one core reconstructs in a second, decoding apart: of the fastest of some runs.
    ///
    /// # Errors
    /// As for [`Self::reconstruct`].
    pub fn pictures_per_s(&self, file: &Path, picture: &Taken) -> Result<f64, Error> {
        const RUNS: usize = 5;
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(Error::bug)?;
        let mut fastest_s = f64::INFINITY;
        for _ in 0..RUNS {
            let picture = picture.clone();
            let start = Instant::now();
            std::hint::black_box(one.install(|| self.reconstruct(file, picture))?);
            fastest_s = fastest_s.min(start.elapsed().as_secs_f64());
        }
        Ok(fastest_s.recip())
    }
}

fn check_colors(file: &Path, picture: &Taken) -> Result<(), ReconstructError> {
    if picture.channels == 3 {
        return Ok(());
    }
    Err(ReconstructError::NoColors { file: file.to_owned() })
}

/// For `numpy.load`: `depth_mm` and `contact`, rows x columns, of a light that shows them; and what
/// [`MarkFollower::arrays`] says, of one that shows marks.
///
/// # Errors
/// Arrays that are larger than their file can be.
pub fn npz_of(
    size_px: [usize; 2],
    shown: Option<&Reconstructed>,
    marks: Vec<Array>,
) -> Result<Vec<u8>, Error> {
    let array = |name: &str, values| Array {
        name: name.to_owned(),
        shape: vec![size_px[1], size_px[0]],
        values,
    };
    let mut arrays = Vec::new();
    if let Some(shown) = shown {
        arrays.push(array("depth_mm", Values::F32(shown.depth_mm.clone())));
        arrays.push(array("contact", Values::Bool(shown.contact.clone())));
    }
    arrays.extend(marks);
    npz(&arrays).map_err(Error::bug)
}
