//! Reconstruction of depth from images: by a trained network ([`DepthNetwork`]), or without one, from what a sensor's
//! lighting shows.
//!
//! Where the lighting shows **thickness** (R-Tac0, 9DTact), the darkening of a layer gives its thickness, and the
//! thickness gives the indentation. Inputs are the image at rest and the design's layers. The image at rest gives the
//! irradiance at each pixel. The law of the layer ([`TwoStream`](fabkit_light::TwoStream)) converts the loss of
//! intensity into a loss of thickness. The layers below are compressed too; `thins`, the loss of thickness per
//! millimetre of indentation, comes from an elastic press of a ball. With the intensity `L` of an infinitely thick
//! layer, the background `g` as a share of it, the scattering `s` and a path `p` in the layer,
//!
//! ```text
//! grey at rest = E L (R(p) + g)        R(p) = s p / (1 + s p)
//! darker       = E L (R(p) - R(p'))    depth = (1 - p' / p) thickness / thins / cosine
//! ```
//!
//! and `E L` is the image at rest divided by `R(p) + g`. The lateral spread of light in the layer makes narrow contacts
//! shallower; part of it is undone.
//!
//! Where the lighting shows **slopes** (ShadowTac, DIGIT, GelSight), the normal of each place of the coat is the one
//! for which the design's light sources give the observed colours (photometric stereo, Woodham 1980), relative to the
//! image at rest. The surface is integrated from these normals along the camera's own rays.
//!
//! ```
//! use fabkit_capture::{LightConstants, find_lighting};
//! use fabkit_reconstruct::{CapturedImage, Reconstructor};
//! use fabkit_scene::SensorView;
//!
//! /// Largest depth in an image, given the one at rest.
//! fn deepest_mm(
//!     view: &SensorView,
//!     rest: &CapturedImage,
//!     pressed: CapturedImage,
//! ) -> Result<Option<f32>, fabkit_files::Error> {
//!     let sensor = &view.project.design.sensor;
//!     let (lighting, constants) = (find_lighting(sensor, None)?, LightConstants::for_sensor(sensor));
//!     let reconstructor = Reconstructor::new(view, lighting, &constants, ("rest.png".as_ref(), rest))?;
//!     Ok(reconstructor.reconstruct("pressed.png".as_ref(), pressed)?.deepest_mm())
//! }
//! ```

mod drift;
mod error;
mod image_reader;
mod marker_tracking;
mod network_depth;
mod sharpen;
mod slopes;
mod surface_integration;
mod thickness_depth;

use std::path::Path;
use std::time::Instant;

use fabkit_capture::{LightConstants, check_size};
use fabkit_export::{NpyArray, NpyValues, npz};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, VisibleEffect};

pub use fabkit_capture::CapturedImage;
use fabkit_scene::SensorView;
use network_depth::NetworkReconstructor;
use slopes::PhotometricStereo;
use thickness_depth::ThicknessModel;

pub use error::ReconstructError;
pub use image_reader::{ImageReader, ImageReading, ReadingRates};
pub use marker_tracking::{MarkerTracker, TrackedMarker, TrackedMarkers, why_markers_hidden};
pub use network_depth::{DepthNetwork, InputNormalisation, MaskCircle, NetworkCard};

/// Returns whether depth can be reconstructed in this lighting without a network.
///
/// ```
/// use fabkit_reconstruct::shows_depth;
///
/// # let yaml = fabkit_designs::builtin_yaml("uvdtact").ok_or("no such sensor")?;
/// # let design = fabkit_designs::load("uvdtact.yaml", yaml, &[], &["fixtures"])?;
/// // White light shows how thick its layers are, ultraviolet light shows its markers.
/// let shows: Vec<_> = design.sensor.lightings.iter().map(|one| (one.name, shows_depth(one))).collect();
/// assert_eq!(shows, [("white", true), ("uv", false)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn shows_depth(lighting: &Lighting) -> bool {
    matches!(lighting.effect, VisibleEffect::Thickness { .. } | VisibleEffect::Slopes { .. })
}

/// Depth reconstructed from an image.
///
/// ```
/// use fabkit_reconstruct::DepthResult;
/// let result = DepthResult {
///     depth_mm: vec![-0.1, f32::NAN, 0.4, 0.9],
///     contact: vec![false, false, true, true],
///     relative_brightness: 1.0,
/// };
/// // Below a thousand pixels of contact, none is dropped.
/// assert_eq!(result.deepest_mm(), Some(0.9));
/// let apart = DepthResult { contact: vec![false; 4], ..result };
/// assert_eq!(apart.deepest_mm(), None);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DepthResult {
    /// Indentation along each pixel's ray, mm, as `indentation_mm` of ground truth: negative where the gel bulges, NaN
    /// where no surface is seen. A network returns the quantity it was trained on, and 0 without contact.
    pub depth_mm: Vec<f32>,
    /// Pixels in contact.
    pub contact: Vec<bool>,
    /// Brightness of the whole image relative to the one at rest. It is 1 with a network whose card does not request
    /// the comparison.
    pub relative_brightness: f32,
}

impl DepthResult {
    /// Returns the largest depth in contact, mm, after dropping the largest thousandth of its pixels: at a pad's edge,
    /// rays pass the displaced gel. `None` without contact.
    pub fn deepest_mm(&self) -> Option<f32> {
        let pressed = self.depth_mm.iter().zip(&self.contact).filter(|(_, contact)| **contact);
        let mut pressed: Vec<f32> = pressed.map(|(mm, _)| *mm).collect();
        pressed.sort_by(f32::total_cmp);
        // The subtraction fails for an empty list alone.
        let last = pressed.len().checked_sub(1 + pressed.len() / 1000)?;
        Some(pressed[last])
    }
}

/// Reconstructor of depth, calibrated with the image at rest.
#[derive(Clone, Debug)]
pub struct Reconstructor {
    size_px: [usize; 2],
    shown: DepthModel,
}

#[derive(Clone, Debug)]
enum DepthModel {
    Thickness(Box<ThicknessModel>),
    Slopes(Box<PhotometricStereo>),
    Learned(Box<NetworkReconstructor>),
}

impl Reconstructor {
    /// Creates a reconstructor from the view of a sensor and its image at rest, which was read from `file`.
    ///
    /// # Errors
    /// Returns an error for a lighting that shows neither thickness nor slopes, layers that cannot be pressed, and an
    /// image that has another size, shows something else or lacks required colours.
    pub fn new(
        scene: &SensorView,
        lighting: &Lighting,
        constants: &LightConstants,
        (file, reference): (&Path, &CapturedImage),
    ) -> Result<Self, Error> {
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        check_size(file, reference, size_px)?;
        let shown = match &lighting.effect {
            VisibleEffect::Thickness { .. } => {
                let grey = reference.clone().grey();
                DepthModel::Thickness(Box::new(ThicknessModel::new(
                    scene,
                    lighting,
                    constants,
                    (file, &grey),
                )?))
            }
            VisibleEffect::Slopes { .. } => {
                check_has_colours(file, reference)?;
                DepthModel::Slopes(Box::new(PhotometricStereo::new(
                    scene,
                    lighting,
                    constants,
                    (file, &reference.values),
                )?))
            }
            _ => {
                let (sensor, light) = (scene.project.design.sensor.name.clone(), lighting.name);
                return Err(ReconstructError::DepthNotShown { sensor, light }.into());
            }
        };
        Ok(Self { size_px, shown })
    }

    /// Creates a reconstructor with a network from the view of a sensor and its image at rest, which was read from
    /// `file`.
    ///
    /// # Errors
    /// Returns an error for an image of another size, and a network that needs more memory than allowed.
    pub fn with_network(
        scene: &SensorView,
        network: &DepthNetwork,
        (file, reference): (&Path, &CapturedImage),
    ) -> Result<Self, Error> {
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        check_size(file, reference, size_px)?;
        let learned = NetworkReconstructor::new(network, scene, &reference.clone().grey())?;
        Ok(Self { size_px, shown: DepthModel::Learned(Box::new(learned)) })
    }

    /// Returns the width and height of images, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// Reconstructs the depth of an image, which was read from `file`.
    ///
    /// # Errors
    /// Returns an error for an image that has another size or lacks required colours.
    pub fn reconstruct(&self, file: &Path, image: CapturedImage) -> Result<DepthResult, Error> {
        check_size(file, &image, self.size_px)?;
        Ok(match &self.shown {
            DepthModel::Thickness(known) => known.reconstruct(&image.grey()),
            DepthModel::Learned(known) => known.reconstruct(&image.grey())?,
            DepthModel::Slopes(known) => {
                check_has_colours(file, &image)?;
                known.reconstruct(&image.values)
            }
        })
    }

    /// Measures the number of images that one core reconstructs per second, without decoding: the fastest of several
    /// runs.
    ///
    /// # Errors
    /// Returns the errors of [`Self::reconstruct`].
    pub fn measure_images_per_s(&self, file: &Path, image: &CapturedImage) -> Result<f64, Error> {
        const RUNS: usize = 5;
        // Reconstruction is parallel otherwise.
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(Error::bug)?;
        let mut fastest_s = f64::INFINITY;
        for _ in 0..RUNS {
            let image = image.clone();
            let start = Instant::now();
            // The result must not be optimised away.
            std::hint::black_box(one.install(|| self.reconstruct(file, image))?);
            fastest_s = fastest_s.min(start.elapsed().as_secs_f64());
        }
        Ok(fastest_s.recip())
    }
}

fn check_has_colours(file: &Path, image: &CapturedImage) -> Result<(), ReconstructError> {
    if image.channels == 3 {
        return Ok(());
    }
    Err(ReconstructError::NoColors { file: file.to_owned() })
}

/// Encodes results as NPZ file for `numpy.load`: `depth_mm` and `contact`, rows x columns, where depth is
/// reconstructed, and the arrays of [`MarkerTracker::arrays`] where markers are tracked.
///
/// # Errors
/// Returns an error for arrays that are larger than their file can be.
///
/// ```
/// use fabkit_reconstruct::{DepthResult, encode_npz};
/// let (depth_mm, contact) = (vec![0.0, 0.1], vec![false, true]);
/// let shown = DepthResult { depth_mm, contact, relative_brightness: 1.0 };
/// let npz = encode_npz([2, 1], Some(&shown), Vec::new())?;
/// // An NPZ file is a ZIP archive.
/// assert_eq!(npz[..2], *b"PK");
/// # Ok::<(), fabkit_files::Error>(())
/// ```
pub fn encode_npz(
    size_px: [usize; 2],
    shown: Option<&DepthResult>,
    marks: Vec<NpyArray>,
) -> Result<Vec<u8>, Error> {
    let array = |name: &str, values| NpyArray {
        name: name.to_owned(),
        // NumPy counts rows first.
        shape: vec![size_px[1], size_px[0]],
        values,
    };
    let mut arrays = Vec::new();
    if let Some(shown) = shown {
        arrays.push(array("depth_mm", NpyValues::F32(shown.depth_mm.clone())));
        arrays.push(array("contact", NpyValues::Bool(shown.contact.clone())));
    }
    arrays.extend(marks);
    npz(&arrays).map_err(Error::bug)
}
