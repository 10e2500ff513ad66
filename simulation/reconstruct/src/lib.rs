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
//!     let rest = ("rest.png".as_ref(), rest);
//!     // Images that cannot be right, and depth that cannot be, are errors.
//!     let reconstructor = Reconstructor::new(view, lighting, &constants, rest)?.accept()?;
//!     Ok(reconstructor.reconstruct("pressed.png".as_ref(), pressed)?.accept()?.deepest_mm())
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
use std::sync::Arc;
use std::time::Instant;

use fabkit_capture::LightConstants;
use fabkit_capture::plausibility::{
    CheckedImage, DepthFigures, ExpectedLight, ImageGate, Judged, Judgement,
};
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
///     size_px: [2, 2],
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
    /// Number of columns and rows.
    pub size_px: [usize; 2],
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
    /// Returns the largest depth in contact, mm, as [`DepthFigures::deepest_mm`] does: without the largest thousandth
    /// of each contact's pixels, and without small contacts at the rim. `None` without contact.
    pub fn deepest_mm(&self) -> Option<f32> {
        self.figures().deepest_mm()
    }

    fn figures(&self) -> DepthFigures<'_> {
        DepthFigures { size_px: self.size_px, depth_mm: &self.depth_mm, contact: &self.contact }
    }
}

/// Reconstructor of depth, calibrated with the image at rest.
#[derive(Clone, Debug)]
pub struct Reconstructor {
    size_px: [usize; 2],
    gate: Arc<ImageGate>,
    shown: DepthModel,
}

#[derive(Clone, Debug)]
enum DepthModel {
    Thickness(Box<ThicknessModel>),
    Slopes(Box<PhotometricStereo>),
    Learned(Box<NetworkReconstructor>),
}

impl Reconstructor {
    /// Creates a reconstructor from the view of a sensor and its image at rest, which was read from `file`. The image
    /// is compared with the drawn light.
    ///
    /// # Errors
    /// Returns an error for a lighting that shows neither thickness nor slopes, layers that cannot be pressed, and an
    /// image that has another size, shows something else or lacks required colours.
    pub fn new(
        scene: &SensorView,
        lighting: &Lighting,
        constants: &LightConstants,
        (file, reference): (&Path, &CapturedImage),
    ) -> Result<Judged<Self>, Error> {
        let expected = ExpectedLight::render(scene, lighting, constants);
        let (gate, judgement) = ImageGate::new(expected, file, reference.clone())?.accept_anyway();
        let gate = Arc::new(gate);
        let known = Self::from_gate(scene, lighting, constants, &gate);
        let known = known.map_err(|error| explain_darkness(error, &judgement))?;
        Ok(Judged::new(known, judgement))
    }

    /// Creates a reconstructor from the image at rest of a gate.
    ///
    /// # Errors
    /// Returns an error for a lighting that shows neither thickness nor slopes, layers that cannot be pressed, and an
    /// image that shows something else or lacks required colours.
    pub(crate) fn from_gate(
        scene: &SensorView,
        lighting: &Lighting,
        constants: &LightConstants,
        gate: &Arc<ImageGate>,
    ) -> Result<Self, Error> {
        let reference = gate.reference();
        let shown = match &lighting.effect {
            VisibleEffect::Thickness { .. } => {
                let model = ThicknessModel::new(scene, lighting, constants, reference)?;
                DepthModel::Thickness(Box::new(model))
            }
            VisibleEffect::Slopes { .. } => {
                check_has_colours(reference)?;
                let model = PhotometricStereo::new(scene, lighting, constants, reference)?;
                DepthModel::Slopes(Box::new(model))
            }
            _ => {
                let (sensor, light) = (scene.project.design.sensor.name.clone(), lighting.name);
                return Err(ReconstructError::DepthNotShown { sensor, light }.into());
            }
        };
        let size_px = reference.image().size_px;
        Ok(Self { size_px, gate: Arc::clone(gate), shown })
    }

    /// Creates a reconstructor with a network from the view of a sensor and its image at rest, which was read from
    /// `file`. The image is compared with the light that is drawn for the sensor as `lighting`.
    ///
    /// # Errors
    /// Returns an error for an image of another size, and a network that needs more memory than allowed.
    pub fn with_network(
        scene: &SensorView,
        network: &DepthNetwork,
        lighting: &Lighting,
        (file, reference): (&Path, &CapturedImage),
    ) -> Result<Judged<Self>, Error> {
        let constants = LightConstants::for_sensor(&scene.project.design.sensor);
        let expected = ExpectedLight::render(scene, lighting, &constants);
        let (gate, judgement) = ImageGate::new(expected, file, reference.clone())?.accept_anyway();
        let known = Self::from_gate_with_network(scene, network, &Arc::new(gate))?;
        Ok(Judged::new(known, judgement))
    }

    /// Creates a reconstructor with a network from the image at rest of a gate.
    ///
    /// # Errors
    /// Returns an error for a network that needs more memory than allowed.
    pub(crate) fn from_gate_with_network(
        scene: &SensorView,
        network: &DepthNetwork,
        gate: &Arc<ImageGate>,
    ) -> Result<Self, Error> {
        let learned = NetworkReconstructor::new(network, scene, gate.reference())?;
        let size_px = gate.reference().image().size_px;
        let shown = DepthModel::Learned(Box::new(learned));
        Ok(Self { size_px, gate: Arc::clone(gate), shown })
    }

    /// Returns the width and height of images, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// Reconstructs the depth of an image, which was read from `file`. The image is compared with the one at rest, and
    /// its depth with the layers.
    ///
    /// # Errors
    /// Returns an error for an image that has another size or lacks required colours, and for a network whose output is
    /// not finite.
    pub fn reconstruct(
        &self,
        file: &Path,
        image: CapturedImage,
    ) -> Result<Judged<DepthResult>, Error> {
        let (image, mut judgement) = self.gate.check(file, image)?.accept_anyway();
        let (result, of_depth) = self.reconstruct_checked(&image)?.accept_anyway();
        judgement.merge(&of_depth);
        Ok(Judged::new(result, judgement))
    }

    /// Reconstructs the depth of an image that passed the gate, and judges the depth.
    ///
    /// # Errors
    /// Returns an error for an image that lacks required colours, and for a network whose output is not finite.
    pub(crate) fn reconstruct_checked(
        &self,
        image: &CheckedImage,
    ) -> Result<Judged<DepthResult>, Error> {
        let result = self.compute(image)?;
        let judgement = self.gate.judge_depth(image.file(), &result.figures());
        Ok(Judged::new(result, judgement))
    }

    fn compute(&self, image: &CheckedImage) -> Result<DepthResult, Error> {
        Ok(match &self.shown {
            DepthModel::Thickness(known) => known.reconstruct(image),
            DepthModel::Learned(known) => known.reconstruct(image)?,
            DepthModel::Slopes(known) => {
                check_has_colours(image)?;
                known.reconstruct(image)
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
        // Findings about the image do not change how long it takes.
        let (image, _) = self.gate.check(file, image.clone())?.accept_anyway();
        for _ in 0..RUNS {
            let start = Instant::now();
            // The result must not be optimised away.
            std::hint::black_box(one.install(|| self.compute(&image))?);
            fastest_s = fastest_s.min(start.elapsed().as_secs_f64());
        }
        Ok(fastest_s.recip())
    }
}

fn check_has_colours(image: &CheckedImage) -> Result<(), ReconstructError> {
    if image.image().channels == 3 {
        return Ok(());
    }
    Err(ReconstructError::NoColors { file: image.file().to_owned() })
}

/// Adds the findings to an error about a dark image: they say why it is dark.
fn explain_darkness(error: Error, judgement: &Judgement) -> Error {
    let is_dark = matches!(error.downcast_ref(), Some(ReconstructError::TooDark { .. }));
    match judgement.error().filter(|_| is_dark) {
        Some(findings) => Error::join(vec![error, findings]).unwrap_or_else(|| Error::bug("two")),
        None => error,
    }
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
/// let shown = DepthResult { size_px: [2, 1], depth_mm, contact, relative_brightness: 1.0 };
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
