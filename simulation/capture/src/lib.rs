//! Simulated captures of a sensor's camera, with their ground truth.
//!
//! Each lighting of a sensor states what its images show: the thickness of translucent layers, the slopes of a coat,
//! glowing layers, or markers. Optical paths, layers, markers and light sources are those of the design's bodies;
//! [`fabkit_scene::press_simulation`] computes how a press moves them.
//!
//! ```
//! use fabkit_capture::{CaptureRequest, LightConstants, find_lighting};
//! use fabkit_scene::{Cast, press_simulation::ContactModel};
//!
//! # let yaml = fabkit_designs::builtin_yaml("9dtact").ok_or("no such sensor")?;
//! # let project = fabkit_fixtures::load("9dtact.yaml", yaml, &[])?;
//! # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
//! # let viewpoint = viewpoint.resized([41, 31])?;
//! # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
//! // `scene` is the view of a 9DTact by its camera with 41 x 31 pixels.
//! let sensor = &scene.project.design.sensor;
//! let (lighting, constants) = (find_lighting(sensor, None)?, &LightConstants::for_sensor(sensor));
//! let cast = Cast::at_rest(ContactModel::Rigid);
//! let request = CaptureRequest { cast, lighting, constants, seed: None };
//! let image = request.render(&scene, 0, |_| Ok(()))?;
//! assert_eq!((image.size_px, image.channels), ([41, 31], 1));
//! // The exposure puts the middle of the surface at an intensity of 151.
//! assert!((image.grey[15 * 41 + 20] - 151.0).abs() < 5.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod captured_image;
mod coat;
mod columns;
mod constants;
mod constants_file;
mod document;
mod glow_layers;
mod irradiance_table;
mod jpeg_roundtrip;
mod layers;
mod lens;
mod lighting;
mod marker_index;
mod marks;
mod pack;
mod provenance;
mod renderer;
mod scene;
mod skin;
mod surface_table;
mod surfaces;
mod thickness_change;
mod unit;

pub mod light_fit;
pub mod live;
pub mod plausibility;

use fabkit_checks::UnknownProperty;
use fabkit_geometry::{Lighting, Marker, Rgb, Sensor, Vector3, VisibleEffect};
use fabkit_light::{ImageSensorNoise, LightingError, draw_drift};
use fabkit_optics::ViewStacks;
use rayon::prelude::*;

pub use captured_image::{CapturedImage, SizeMismatch, check_size};
pub use columns::column_ends;
pub use constants::LightConstants;
pub use constants_file::{ConstantsError, read_constants};
pub use document::{capture_comment, capture_document, unknown_document};
pub use lighting::{find_lighting, select_lighting};
pub use pack::{OpticsPack, SLOPE_BINS, optics_pack};
pub use provenance::{Constant, Provenance};
pub use renderer::Renderer;
pub use scene::LayerGeometry;
pub use skin::SkinView;
pub use surfaces::CameraGain;
pub use unit::{Unit, unit_document};

pub use self::coat::CoatScene;
use self::glow_layers::GlowScene;
use self::jpeg_roundtrip::jpeg_roundtrip;
pub use self::layers::{LayerScene, RestRay, ray_spacing_mm};
use self::lens::LensEffects;
use self::marks::MarkScene;
pub use self::scene::{placed_solid, surface_middle};
pub use self::skin::render_skin;
pub use self::thickness_change::ThicknessChange;
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained, UnknownName};
use fabkit_scene::ground_truth::{Viewpoint, project_points};
use fabkit_scene::press_simulation::{ContactModel, ContactSolution, MarkerDisplacement};
use fabkit_scene::{Cast, CastResult, SensorView};

/// Reason why a capture cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// A sensor without a known lighting, or without what that lighting shows.
    #[error("`{sensor}` has no known light, or its light shows nothing known")]
    UnknownLighting {
        /// Name of the sensor.
        sensor: String,
    },
    /// A sensor without a surface of known shape.
    #[error("`{sensor}` has no surface of known shape")]
    NoSurface {
        /// Name of the sensor.
        sensor: String,
    },
    /// An unknown lighting.
    #[error("`{sensor}` has no light `{light}`: it has {}", .known.join(", "))]
    NoSuchLighting {
        /// Name of the sensor.
        sensor: String,
        /// Requested lighting.
        light: String,
        /// Names of the sensor's lightings.
        known: Vec<&'static str>,
    },
    /// Fitted constants with a lighting that does not show thickness.
    #[error(
        "fitted constants are those of translucent layers; `{sensor}` in `{light}` light shows something else"
    )]
    ConstantsMismatch {
        /// Name of the sensor.
        sensor: String,
        /// Name of the lighting.
        light: &'static str,
    },
    /// A press with a contact model that does not move markers, in a lighting that shows markers.
    #[error("`rigid` contact does not move markers, which `{light}` light shows")]
    RigidMarks {
        /// Name of the lighting.
        light: &'static str,
    },
    /// A lighting for which simulators have no tables.
    #[error(
        "simulators have tables of slopes and of thickness; `{sensor}` in `{light}` light shows something else"
    )]
    NoTable {
        /// Name of the sensor.
        sensor: String,
        /// Name of the lighting.
        light: &'static str,
    },
    /// A table of slopes for a surface that is not flat.
    #[error(
        "tables of slopes count pixels of one size on a flat gel; the surface of `{sensor}` is curved"
    )]
    NotFlat {
        /// Name of the sensor.
        sensor: String,
    },
    /// A lighting whose light sources are not known.
    #[error(transparent)]
    NoLight(#[from] LightingError),
    /// Light sources whose light does not reach the surface.
    #[error(
        "no light of `{sensor}`'s light sources reaches the bodies in view: opaque bodies are in the way"
    )]
    Dark {
        /// Name of the sensor.
        sensor: String,
    },
}

impl Explained for CaptureError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::UnknownLighting { .. } | Self::NoSurface { .. } => {
                "take a built-in sensor, or one of its family"
            }
            Self::NoSuchLighting { light, known, .. } => {
                return Some(UnknownName::new("light", light, known.iter().copied()).hint());
            }
            Self::ConstantsMismatch { .. } => "leave the constants out",
            Self::NoTable { .. } => {
                "take another of its lights, or render images with `fabkit capture`"
            }
            Self::NotFlat { .. } => "render its images with `fabkit capture` or `fabkit dataset`",
            Self::RigidMarks { .. } => "take `linear` contact",
            Self::NoLight(LightingError::NoLamps { .. }) => "draw its light sources",
            Self::Dark { .. } => "`fabkit check` says what is in the way",
            Self::NoLight(_) => return None,
        };
        Some(hint.to_owned())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new("no_light")
    }
}

/// Options of a capture.
///
/// ```
/// # use fabkit_capture::{CaptureRequest, LightConstants, find_lighting};
/// # use fabkit_scene::{Cast, press_simulation::ContactModel};
/// # let yaml = fabkit_designs::builtin_yaml("9dtact").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("9dtact.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([20, 15])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let sensor = &scene.project.design.sensor;
/// let constants = &LightConstants::for_sensor(sensor);
/// let cast = Cast::at_rest(ContactModel::Rigid);
/// let clean = CaptureRequest { cast, lighting: find_lighting(sensor, None)?, constants, seed: None };
/// let noisy = CaptureRequest { seed: Some(1), ..clean.clone() };
/// let first = noisy.render(&scene, 0, |_| Ok(()))?;
/// // The same seed gives the same noise.
/// assert_eq!(first.grey, noisy.render(&scene, 0, |_| Ok(()))?.grey);
/// assert_ne!(first.grey, clean.render(&scene, 0, |_| Ok(()))?.grey);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CaptureRequest<'a> {
    /// Presses, contact model and samples. A sample is one ray; a pixel records the mean of its samples.
    pub cast: Cast<'a>,
    /// Lighting of the sensor.
    pub lighting: &'a Lighting,
    /// Optical constants of the sensor.
    pub constants: &'a LightConstants,
    /// Seed of noise and drift; `None` for a capture without either.
    pub seed: Option<u64>,
}

/// A simulated capture with the data behind it.
#[derive(Clone, Debug)]
pub struct SimulatedCapture {
    /// Number of columns and rows.
    pub size_px: [u32; 2],
    /// Number of values per pixel: 1, or 3 for red, green and blue.
    pub channels: usize,
    /// Intensities row by row, 0 to 255, not rounded to integers. Quantised only where the chip has fewer than eight
    /// bits, or where the camera sends JPEG.
    pub grey: Vec<f64>,
    /// Thickness of the layers along each ray, mm; NaN where a ray meets none. Row by row with `samples` rays along
    /// each side of a pixel; empty where no thickness is shown.
    pub thickness_mm: Vec<f64>,
    /// Factor on all light.
    pub exposure: f64,
    /// Gain of the camera over the exposure that suits usual materials.
    pub camera_gain: CameraGain,
    /// Properties of drawn materials that the image depends on and no source states; usual ones stand for them.
    pub not_known: Vec<UnknownProperty>,
    /// Offset of the intensity of the whole image by drift.
    pub drift_grey: f64,
    /// Description of what the lighting shows.
    pub shown: String,
    /// Description of the light sources.
    pub light_sources: String,
    /// Markers during the press, where the lighting shows them.
    pub marks: Vec<MarkerDisplacement>,
    /// Column and row of each marker, px, even if an opaque body hides it; `None` outside the image.
    pub mark_pixels: Vec<Option<[f64; 2]>>,
    /// Solution of the soft layers as JSON; `None` without elastic contact.
    pub elastic: Option<serde_json::Value>,
    /// Name of the contact model.
    pub contact_level: &'static str,
}

impl SimulatedCapture {
    /// Returns the smallest and the largest intensity.
    pub fn range_grey(&self) -> [f64; 2] {
        let ends = |[low, high]: [f64; 2], grey: &f64| [low.min(*grey), high.max(*grey)];
        self.grey.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends)
    }
}

/// Light of all rays, before the lens and the chip.
pub struct RenderedLight {
    /// Light of each ray, in intensities.
    pub light: Vec<Rgb>,
    /// Same as [`SimulatedCapture::thickness_mm`].
    thickness_mm: Vec<f64>,
    /// Same as [`SimulatedCapture::marks`].
    marks: Vec<MarkerDisplacement>,
    /// Properties of bodies behind markers that no source states.
    not_known: Vec<UnknownProperty>,
}

impl RenderedLight {
    /// Applies the lens: the light as it arrives at the chip.
    fn with_lens(mut self, lens: Option<&LensEffects>) -> Self {
        if let Some(lens) = lens {
            lens.apply(&mut self.light);
        }
        self
    }
}

/// Renderer of a sensor in one of its lightings, by what the lighting shows.
#[derive(Debug)]
enum LightingRenderer<'a> {
    Layers(LayerScene<'a>),
    Coat(CoatScene<'a>),
    Glow(GlowScene<'a>),
    Marks(Box<MarkScene<'a>>),
}

impl<'a> LightingRenderer<'a> {
    fn new(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        Ok(match &lighting.effect {
            VisibleEffect::Thickness { .. } => {
                Self::Layers(LayerScene::new(sensor, lighting, constants)?)
            }
            VisibleEffect::Slopes { .. } => {
                Self::Coat(CoatScene::new(sensor, lighting, constants)?)
            }
            VisibleEffect::Fluorescence { .. } => {
                Self::Glow(GlowScene::new(sensor, lighting, constants)?)
            }
            VisibleEffect::Markers { .. } => {
                Self::Marks(Box::new(MarkScene::new(sensor, lighting, constants)?))
            }
            VisibleEffect::LiquidColumns { .. } => {
                let sensor = sensor.name.clone();
                return Err(CaptureError::UnknownLighting { sensor }.into());
            }
        })
    }

    fn paint(
        &self,
        scene: &SensorView,
        cast: &Cast<'_>,
        seen: &CastResult<'_>,
    ) -> Result<RenderedLight, Error> {
        Ok(match self {
            Self::Layers(layers) => layers.paint(seen.map, seen.answer),
            Self::Coat(coat) => coat.paint(seen),
            Self::Glow(glow) => {
                let marks = displaced_markers(&scene.project.design.sensor, seen.answer);
                RenderedLight { marks, ..glow.paint(seen.map, seen.answer) }
            }
            Self::Marks(marks) => {
                let moved = displaced_markers(&scene.project.design.sensor, seen.answer);
                marks.paint(&scene.viewpoint, cast.samples, moved)?
            }
        })
    }

    fn exposure(&self) -> f64 {
        match self {
            Self::Layers(layers) => layers.exposure,
            Self::Coat(coat) => coat.exposure,
            Self::Glow(glow) => glow.exposure,
            Self::Marks(marks) => marks.exposure,
        }
    }

    fn camera_gain(&self) -> CameraGain {
        match self {
            Self::Layers(layers) => layers.camera_gain,
            Self::Coat(coat) => coat.camera_gain,
            Self::Glow(_) => CameraGain::NONE,
            Self::Marks(marks) => marks.camera_gain,
        }
    }

    /// Returns properties of bodies behind markers that no source states, where the view is kept.
    fn unknown_in_view(&self) -> Vec<UnknownProperty> {
        match self {
            Self::Marks(marks) => marks.unknown_in_view(),
            Self::Layers(_) | Self::Coat(_) | Self::Glow(_) => Vec::new(),
        }
    }

    /// Returns descriptions of what is shown and of the light sources.
    fn words(&self) -> [String; 2] {
        match self {
            Self::Layers(layers) => layers.words(),
            Self::Coat(coat) => coat.words(),
            Self::Glow(glow) => glow.words(),
            Self::Marks(marks) => marks.words(),
        }
    }
}

impl CaptureRequest<'_> {
    /// Renders the capture. `also` is called with the ground truth that the image shows, of which it keeps so many bytes of
    /// each ray.
    ///
    /// # Errors
    /// Returns an error for a lighting that cannot be simulated, and the errors of [`SensorView::cast`].
    pub fn render(
        &self,
        scene: &SensorView,
        kept: u64,
        also: impl FnOnce(&CastResult<'_>) -> Result<(), Error>,
    ) -> Result<SimulatedCapture, Error> {
        let sensor = &scene.project.design.sensor;
        self.check(sensor, self.cast.presses.is_empty(), self.cast.contact)?;
        let painter = LightingRenderer::new(sensor, self.lighting, self.constants)?;
        let samples = self.cast.samples;
        let lens = LensEffects::new(sensor, self.lighting, &scene.viewpoint, samples)?;
        scene.cast(&self.cast, LIGHT_BYTES + kept, |seen| {
            also(&seen)?;
            let painted = painter.paint(scene, &self.cast, &seen)?.with_lens(lens.as_ref());
            let size_px = [seen.map.width_px(), seen.map.height_px()];
            let size_px = size_px.map(|side| side / self.cast.samples);
            let words = (painter.words(), painter.exposure(), painter.camera_gain());
            let elastic = seen.answer.map(fabkit_scene::press_simulation::solution_document);
            let mark_pixels = project_markers(&scene.viewpoint, scene.sights(), &painted.marks);
            let captured = self.record(sensor, painted, size_px, words)?;
            Ok::<_, Error>(SimulatedCapture { elastic, mark_pixels, ..captured })
        })
    }

    fn check(
        &self,
        sensor: &Sensor,
        is_at_rest: bool,
        contact: ContactModel,
    ) -> Result<(), CaptureError> {
        let shows = &self.lighting.effect;
        let shows_thickness = matches!(shows, VisibleEffect::Thickness { .. });
        // Only constants fitted to a real unit lack `middle_grey`, and fits exist for thickness alone.
        if self.constants.middle_grey.is_none() && !shows_thickness {
            let sensor = sensor.name.clone();
            return Err(CaptureError::ConstantsMismatch { sensor, light: self.lighting.name });
        }
        let is_elastic = matches!(contact, ContactModel::Linear(_));
        let has_marks = !sensor.marks.is_empty() && !shows_thickness;
        if has_marks && !is_elastic && !is_at_rest {
            return Err(CaptureError::RigidMarks { light: self.lighting.name });
        }
        Ok(())
    }

    /// Records the light with the chip, and collects the capture's data.
    fn record(
        &self,
        sensor: &Sensor,
        painted: RenderedLight,
        size_px: [u32; 2],
        ([shown, lamps], exposure, camera_gain): ([String; 2], f64, CameraGain),
    ) -> Result<SimulatedCapture, Error> {
        let of_constants = self.constants.not_known(&self.lighting.effect);
        Ok(SimulatedCapture {
            size_px,
            channels: self.channels(),
            grey: self.pixel_intensities(sensor, (&painted.light, camera_gain), size_px)?,
            thickness_mm: painted.thickness_mm,
            exposure,
            camera_gain,
            not_known: UnknownProperty::merged(of_constants.into_iter().chain(painted.not_known)),
            drift_grey: self.drift_grey(),
            shown,
            light_sources: lamps,
            marks: painted.marks,
            mark_pixels: Vec::new(),
            elastic: None,
            contact_level: self.cast.contact.name(),
        })
    }

    fn channels(&self) -> usize {
        if self.lighting.is_colored() { 3 } else { 1 }
    }

    fn drift_grey(&self) -> f64 {
        self.seed.map_or(0.0, |seed| draw_drift(self.constants.drift.value, seed))
    }

    /// Returns the JPEG quality of the sensor's images. A capture without noise is not compressed.
    fn jpeg_quality(&self, sensor: &Sensor) -> Option<u8> {
        sensor.jpeg_quality.filter(|_| self.seed.is_some())
    }

    /// Computes the intensities of all pixels from the light and the camera's gain: means over the samples, with drift and noise, quantised as by the chip,
    /// and compressed where the camera sends JPEG.
    fn pixel_intensities(
        &self,
        sensor: &Sensor,
        light: (&[Rgb], CameraGain),
        size_px: [u32; 2],
    ) -> Result<Vec<f64>, Error> {
        let taken = self.chip_intensities(sensor, light, size_px);
        match self.jpeg_quality(sensor) {
            Some(quality) => jpeg_roundtrip(&taken, size_px, quality),
            None => Ok(taken),
        }
    }

    fn chip_intensities(
        &self,
        sensor: &Sensor,
        (light, gain): (&[Rgb], CameraGain),
        [width, height]: [u32; 2],
    ) -> Vec<f64> {
        let samples = self.cast.samples as usize;
        let drift_grey = self.drift_grey();
        let (chip, seed) = match self.seed {
            Some(seed) => (self.constants.chip(gain), seed),
            None => (ImageSensorNoise::IDEAL, 0),
        };
        let (width, height) = (width as usize, height as usize);
        let channels = self.channels();
        // A chip with fewer than eight bits has fewer levels up to the same white; finer levels than eight bits do not
        // matter.
        let steps = f64::from((1u32 << sensor.intensity_bits.min(8)) - 1);
        let stepped = |grey: f64| match sensor.intensity_bits {
            8.. => grey,
            _ => (grey / 255.0 * steps).round() * 255.0 / steps,
        };
        let value = |i: usize| {
            // Rays lie row by row at `samples` times the image's width: `first` is the pixel's top left ray.
            let (pixel, channel) = (i / channels, i % channels);
            let first = pixel / width * samples * width * samples + pixel % width * samples;
            let rows = (0..samples).map(|row| first + row * width * samples);
            let all = rows.flat_map(|begin| &light[begin..begin + samples]);
            let mean = all.map(|light| light[channel]).sum::<f64>() / (samples * samples) as f64;
            // The index makes the noise of each value independent of threads and order.
            stepped(chip.add_noise(mean + drift_grey, seed, i as u64))
        };
        (0..width * height * channels).into_par_iter().map(value).collect()
    }
}

/// Memory per ray while a capture is rendered, bytes: light before and after the lens, thickness, spread, and the image.
const LIGHT_BYTES: u64 = 80;

/// Returns a sensor's markers at their places during a press; at rest without a solution.
///
/// ```
/// use fabkit_capture::displaced_markers;
///
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
/// let at_rest = displaced_markers(&project.design.sensor, None);
/// // 9 x 7 dots, which do not move without contact.
/// assert_eq!(at_rest.len(), 63);
/// assert!(at_rest.iter().all(|mark| mark.displacement_mm.is_some_and(|mm| mm.norm() == 0.0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn displaced_markers(
    sensor: &Sensor,
    answer: Option<&ContactSolution<'_>>,
) -> Vec<MarkerDisplacement> {
    let at_rest = |mark: &Marker| MarkerDisplacement {
        displacement_mm: Some(Vector3::zeros()),
        axis: mark.axis,
        mark: mark.clone(),
    };
    match (answer, &sensor.touch) {
        (Some(answer), Some(touch)) => answer.marks(sensor, touch),
        _ => sensor.marks.iter().map(at_rest).collect(),
    }
}

/// Projects markers to pixels; `None` for markers outside the image or of unknown place.
///
/// ```
/// use fabkit_capture::{displaced_markers, project_markers};
///
/// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([640, 480])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let mut marks = displaced_markers(&scene.project.design.sensor, None);
/// marks[0].displacement_mm = None;
/// let pixels = project_markers(&scene.viewpoint, scene.sights(), &marks);
/// assert_eq!(pixels[0], None);
/// // The dot in the middle of 9 x 7 is in the middle of the image.
/// let [column, row] = pixels[31].ok_or("outside the image")?;
/// assert!((column - 319.5).abs() < 0.01 && (row - 239.5).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn project_markers(
    viewpoint: &Viewpoint,
    sights: &ViewStacks,
    marks: &[MarkerDisplacement],
) -> Vec<Option<[f64; 2]>> {
    let place = |moved: &MarkerDisplacement| Some(moved.mark.point + moved.displacement_mm?);
    project_points(viewpoint, sights, &marks.iter().map(place).collect::<Vec<_>>())
}
