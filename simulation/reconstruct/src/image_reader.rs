//! Reader of images of one sensor: depth, where its lighting or a network allows it, and markers, where there are any.

use std::path::Path;
use std::sync::Arc;

use fabkit_capture::plausibility::{ExpectedLight, ImageGate, Judged};
use fabkit_capture::{CapturedImage, LightConstants};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Sensor};
use fabkit_scene::SensorView;
use fabkit_scene::ground_truth::Viewpoint;

use super::{
    DepthNetwork, DepthResult, MarkerTracker, ReconstructError, Reconstructor, TrackedMarkers,
    encode_npz, explain_darkness, shows_depth, why_markers_hidden,
};

/// Reader that is calibrated with the image at rest.
///
/// ```
/// use std::path::Path;
///
/// use fabkit_capture::LightConstants;
/// use fabkit_reconstruct::{CapturedImage, ImageReader};
/// # use fabkit_capture::find_lighting;
/// # use fabkit_optics::ViewStacks;
/// # use fabkit_scene::ground_truth::{Viewpoint, project_points};
///
/// # let yaml = fabkit_designs::builtin_yaml("tactip").ok_or("no such sensor")?;
/// # let sensor = &fabkit_designs::load("tactip.yaml", yaml, &[], &["fixtures"])?.sensor;
/// # let viewpoint = Viewpoint::new(&sensor.camera, None, None)?.resized([320, 240])?;
/// # let sights = ViewStacks::new(viewpoint.stack(sensor)?);
/// # let places: Vec<_> = sensor.marks.iter().map(|mark| Some(mark.point)).collect();
/// # let dots = project_points(&viewpoint, &sights, &places);
/// # let image = |right_px: f64| {
/// #     let ink = |i: usize| {
/// #         let [x, y] = [i / 1 % 320, i / 1 / 320].map(|px| px as f64);
/// #         let square = |dot: &[f64; 2]| (dot[0] + right_px - x).powi(2) + (dot[1] - y).powi(2);
/// #         let nearest = dots.iter().flatten().map(square).fold(f64::INFINITY, f64::min);
/// #         (4.5 - nearest.sqrt()).clamp(0.0, 1.0) as f32
/// #     };
/// #     let values = (0..1 * 320 * 240).map(|i| 0.1 + 0.7 * ink(i)).collect();
/// #     CapturedImage { size_px: [320, 240], channels: 1, values }
/// # };
/// // `image` draws bright dots where the camera sees them, so many pixels further right.
/// let light = (find_lighting(sensor, None)?, &LightConstants::for_sensor(sensor));
/// let (rest, moved) = (image(0.0), image(1.5));
/// // Light that shows dots and no depth needs no view of the surface.
/// let no_view = || unreachable!();
/// let camera = (sensor, &viewpoint);
/// let rest = (Path::new("rest.png"), &rest);
/// let reader = ImageReader::new(camera, no_view, light, None, rest)?.accept()?;
/// let read = reader.read(Path::new("moved.png"), moved)?.accept()?;
/// assert!(read.depth.is_none() && read.contact_px().is_none());
/// assert!(reader.max_displacement_px(&read).is_some_and(|px| (px - 1.5).abs() < 0.2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ImageReader {
    size_px: [usize; 2],
    gate: Arc<ImageGate>,
    depth: Option<Reconstructor>,
    /// View of the sensor, where depth is reconstructed.
    pub scene: Option<SensorView>,
    /// Tracker of the markers, if there are any.
    pub marks: Option<MarkerTracker>,
    /// Quantities that images do not show, with reasons.
    pub omissions: Vec<String>,
}

/// Result of reading an image.
#[derive(Debug)]
pub struct ImageReading {
    /// Depth, where it is reconstructed.
    pub depth: Option<DepthResult>,
    /// Markers, where they are tracked.
    pub markers: Option<TrackedMarkers>,
}

/// Number of images that one core reads per second, without decoding.
#[derive(Clone, Copy, Debug)]
pub struct ReadingRates {
    /// Rate for everything that is read.
    pub images_per_s: f64,
    /// Rate for markers alone.
    pub marks_per_s: Option<f64>,
}

impl ImageReader {
    /// Creates a reader from the image at rest, which is compared with the drawn light. `view` is called where depth is
    /// reconstructed, by the network if there is one.
    ///
    /// # Errors
    /// Returns an error for a lighting that shows neither depth nor markers, and the errors of [`Reconstructor::new`]
    /// and [`MarkerTracker::new`].
    pub fn new(
        (sensor, viewpoint): (&Sensor, &Viewpoint),
        view: impl FnOnce() -> Result<SensorView, Error>,
        (lighting, constants): (&Lighting, &LightConstants),
        network: Option<&DepthNetwork>,
        (file, reference): (&Path, &CapturedImage),
    ) -> Result<Judged<Self>, Error> {
        let camera = viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let mut left_out = Vec::new();
        // Without depth and without markers, the reconstructor returns the error to report.
        let needs_view = network.is_some()
            || shows_depth(lighting)
            || why_markers_hidden(sensor, lighting).is_some();
        let scene = if needs_view { Some(view()?) } else { None };
        let expected = match &scene {
            Some(scene) => ExpectedLight::render(scene, lighting, constants),
            None => ExpectedLight::from_markers(size_px),
        };
        let (gate, judgement) = ImageGate::new(expected, file, reference.clone())?.accept_anyway();
        let gate = Arc::new(gate);
        let mut depth = None;
        if let Some(scene) = &scene {
            let known = match network {
                Some(network) => Reconstructor::from_gate_with_network(scene, network, &gate),
                None => Reconstructor::from_gate(scene, lighting, constants, &gate),
            };
            depth = Some(known.map_err(|error| explain_darkness(error, &judgement))?);
        } else {
            let (sensor, light) = (sensor.name.clone(), lighting.name);
            left_out.push(ReconstructError::DepthNotShown { sensor, light }.to_string());
        }
        let marks = match MarkerTracker::new(sensor, viewpoint, lighting, gate.reference()) {
            Ok(marks) => Some(marks),
            // Depth does not need markers, so an image without them is still read.
            Err(error) if depth.is_some() => match error.downcast_ref() {
                Some(few @ ReconstructError::TooFewMarkers { .. }) => {
                    left_out.push(format!("{few}: they are not tracked"));
                    None
                }
                Some(none @ ReconstructError::NoMarkersShown { .. }) => {
                    left_out.push(none.to_string());
                    None
                }
                _ => return Err(error),
            },
            Err(error) => return Err(error),
        };
        let reader = Self { size_px, gate, depth, scene, marks, omissions: left_out };
        Ok(Judged::new(reader, judgement))
    }

    /// Returns the width and height of images, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// Reads an image, which was read from `file`. It is compared with the image at rest, and its depth with the layers.
    ///
    /// # Errors
    /// Returns an error for an image that has another size or lacks required colours, and for a network whose output is
    /// not finite.
    pub fn read(&self, file: &Path, image: CapturedImage) -> Result<Judged<ImageReading>, Error> {
        let (image, mut judgement) = self.gate.check(file, image)?.accept_anyway();
        let markers = self.marks.as_ref().map(|marks| marks.follow(&image)).transpose()?;
        let mut depth = None;
        if let Some(reconstructor) = &self.depth {
            let (found, of_depth) = reconstructor.reconstruct_checked(&image)?.accept_anyway();
            judgement.merge(&of_depth);
            depth = Some(found);
        }
        Ok(Judged::new(ImageReading { depth, markers }, judgement))
    }

    /// Encodes the result as NPZ file, as [`encode_npz`] does.
    ///
    /// # Errors
    /// Returns an error for arrays that are larger than their file can be.
    pub fn npz(&self, read: &ImageReading) -> Result<Vec<u8>, Error> {
        let of_marks = self.marks.as_ref().zip(read.markers.as_ref());
        let arrays = of_marks.map_or_else(Vec::new, |(marks, followed)| marks.arrays(followed));
        encode_npz(self.size_px, read.depth.as_ref(), arrays)
    }

    /// Returns the largest displacement of a marker, px; `None` if no marker is found.
    pub fn max_displacement_px(&self, read: &ImageReading) -> Option<f64> {
        let (marks, followed) = self.marks.as_ref().zip(read.markers.as_ref())?;
        let moved = marks.displacements_px(followed).into_iter().flatten();
        moved.map(|[x, y]| x.hypot(y)).max_by(f64::total_cmp)
    }

    /// Measures the rates at which images like this one are read.
    ///
    /// # Errors
    /// Returns the errors of [`Self::read`].
    pub fn measure_rates(&self, file: &Path, image: &CapturedImage) -> Result<ReadingRates, Error> {
        let of_depth = self.depth.as_ref().map(|depth| depth.measure_images_per_s(file, image));
        // Findings about the image do not change how long it takes.
        let (checked, _) = self.gate.check(file, image.clone())?.accept_anyway();
        let of_marks = self.marks.as_ref().map(|marks| marks.measure_images_per_s(&checked));
        let (of_depth, marks_per_s) = (of_depth.transpose()?, of_marks.transpose()?);
        let rates = [of_depth, marks_per_s].into_iter().flatten();
        // Times add up, so the inverse rates are summed.
        Ok(ReadingRates { images_per_s: rates.map(f64::recip).sum::<f64>().recip(), marks_per_s })
    }
}

impl ImageReading {
    /// Returns the number of pixels in contact, where depth is reconstructed.
    pub fn contact_px(&self) -> Option<usize> {
        let shown = self.depth.as_ref()?;
        Some(shown.contact.iter().filter(|contact| **contact).count())
    }
}
