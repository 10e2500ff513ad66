//! Renderer for many captures of one sensor.

use fabkit_checks::UnknownProperty;
use fabkit_depth::ground_truth::{DepthMap, ReferenceSurface, StandardDeviations};
use fabkit_files::Error;
use fabkit_geometry::Lighting;
use fabkit_scene::ground_truth::find_deepest_contact;
use fabkit_scene::press_simulation::{ContactModel, ContactSolution};
use fabkit_scene::{Cast, CastResult, SensorView};
use serde_json::{Value, json};

use super::document::{camera_gain_document, unknown_document};
use super::{CaptureRequest, LensEffects, LightConstants, LightingRenderer};

/// A sensor, its camera and its lighting, with everything that no press changes computed once.
///
/// ```
/// use fabkit_capture::{LightConstants, Renderer, find_lighting};
/// use fabkit_depth::ground_truth::ReferenceSurface;
/// use fabkit_scene::press_simulation::ContactModel;
///
/// # let yaml = fabkit_designs::builtin_yaml("9dtact").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("9dtact.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([32, 24])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// let sensor = &scene.project.design.sensor;
/// let constants = LightConstants::for_sensor(sensor);
/// let grant = scene.request_memory("rendering", 1, Renderer::BYTES_PER_RAY)?;
/// let rays = scene.rays_of_rows(1, 0..u32::MAX, &grant);
/// let surface = ReferenceSurface::cast(scene.touch()?, &rays)?;
/// let renderer = Renderer::new(&scene, &surface, find_lighting(sensor, None)?, &constants, ContactModel::Rigid)?;
/// // One renderer for many presses: here, one of none.
/// let grey = renderer.render(&surface.map_without_contact(), None, None)?;
/// assert_eq!(grey.len(), 32 * 24 * renderer.channels());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Renderer<'a> {
    scene: &'a SensorView,
    capturing: CaptureRequest<'a>,
    painter: LightingRenderer<'a>,
    lens: Option<LensEffects>,
}

impl<'a> Renderer<'a> {
    /// Displacement below which the surface counts as unmoved, mm: R-Tac0's layer changes by 0.08 in intensity then,
    /// with a noise of 0.8.
    pub const MOTION_THRESHOLD_MM: f64 = 2e-3;
    /// Memory per ray of a renderer with one press at a time, bytes: the rays and the surface, the image at rest that is
    /// kept, and what a capture takes. Derived by counting.
    pub const BYTES_PER_RAY: u64 = 300;

    /// Prepares a renderer for the rays that `surface` was cast with. A pixel records the mean of its rays.
    ///
    /// # Errors
    /// Returns the errors of [`CaptureRequest::render`].
    pub fn new(
        scene: &'a SensorView,
        surface: &ReferenceSurface<'_>,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
        contact: ContactModel,
    ) -> Result<Self, Error> {
        let sensor = &scene.project.design.sensor;
        // The surface was cast with several rays per pixel; their number follows from the sizes.
        let samples = surface.rays().width_px() / scene.viewpoint.camera().width_px();
        let cast = Cast { samples, ..Cast::at_rest(contact) };
        let capturing = CaptureRequest { cast, lighting, constants, seed: None };
        // Checked as if pressed: captures of presses will follow.
        capturing.check(sensor, false, contact)?;
        let mut painter = LightingRenderer::new(sensor, lighting, constants)?;
        match &mut painter {
            LightingRenderer::Layers(layers) => layers.prepare(&surface.map_without_contact()),
            LightingRenderer::Coat(coat) => coat.prepare(&surface.map_without_contact()),
            LightingRenderer::Marks(marks) => marks.prepare(&scene.viewpoint, samples)?,
            // Glow is rendered anew each time.
            LightingRenderer::Glow(_) => {}
        }
        let lens = LensEffects::new(sensor, lighting, &scene.viewpoint, samples)?;
        Ok(Self { scene, capturing, painter, lens })
    }

    /// Returns the number of values per pixel: 1, or 3 for red, green and blue.
    pub fn channels(&self) -> usize {
        self.capturing.channels()
    }

    /// Returns whether maps need normals.
    pub fn needs_normals(&self) -> bool {
        matches!(self.painter, LightingRenderer::Coat(_))
    }

    /// Renders the capture of a press, row by row, 0 to 255, not rounded. Without a seed it has neither noise nor
    /// drift.
    ///
    /// # Errors
    /// Returns the errors of [`CaptureRequest::render`].
    pub fn render(
        &self,
        map: &DepthMap<'_>,
        answer: Option<&ContactSolution<'_>>,
        seed: Option<u64>,
    ) -> Result<Vec<f64>, Error> {
        let sensor = &self.scene.project.design.sensor;
        let touch = self.scene.touch()?;
        let deepest = self.needs_normals().then(|| find_deepest_contact(map, touch)).flatten();
        // Renderers use neither sigmas nor the count of pixels.
        let seen = CastResult {
            map,
            sigmas: &StandardDeviations::default(),
            deepest,
            surface_px: 0,
            answer,
            gap: None,
        };
        let painted = self.painter.paint(self.scene, &self.capturing.cast, &seen)?;
        let painted = painted.with_lens(self.lens.as_ref());
        let capturing = CaptureRequest { seed, ..self.capturing.clone() };
        let samples = self.capturing.cast.samples;
        let size_px = [map.width_px(), map.height_px()].map(|side| side / samples);
        capturing.pixel_intensities(sensor, (&painted.light, self.painter.camera_gain()), size_px)
    }

    /// Returns the properties of drawn materials that images depend on and no source states, by property and material.
    pub fn not_known(&self) -> Vec<UnknownProperty> {
        let of_constants = self.capturing.constants.not_known(&self.capturing.lighting.effect);
        UnknownProperty::merged(of_constants.into_iter().chain(self.painter.unknown_in_view()))
    }

    /// Returns as JSON what is shown, the light sources, the constants and what is left out.
    pub fn document(&self) -> Value {
        let lighting = self.capturing.lighting;
        let design = &self.scene.project.design;
        let [shown, lamps] = self.painter.words();
        json!({
            "is_simulated": true,
            "light": lighting.name,
            "shown": shown,
            "lamps": lamps,
            "exposure": self.painter.exposure(),
            "camera_gain": camera_gain_document(self.painter.camera_gain()),
            "not_known": unknown_document(&self.not_known()),
            "constants": super::document::constants(design, &self.capturing),
            "left_out": super::document::omitted_effects(&lighting.effect, super::lens::omitted_effects(&design.sensor, lighting)),
        })
    }
}
