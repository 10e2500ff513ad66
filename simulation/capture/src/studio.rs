//! Renderer for many captures of one sensor.

use fabkit_depth::truth::{DepthMap, ReferenceSurface, Sigmas};
use fabkit_files::Error;
use fabkit_geometry::Lighting;
use fabkit_scene::ground_truth::deepest;
use fabkit_scene::pressing::{Answer, Contact};
use fabkit_scene::{Cast, Seen, SensorView};
use serde_json::{Value, json};

use super::{Capturing, LensEffects, LightConstants, Painter};

/// A sensor, its camera and its lighting, with everything that no press changes computed once.
#[derive(Debug)]
pub struct Studio<'a> {
    scene: &'a SensorView,
    capturing: Capturing<'a>,
    painter: Painter<'a>,
    lens: Option<LensEffects>,
}

impl<'a> Studio<'a> {
    /// Displacement below which the surface counts as unmoved, mm: R-Tac0's layer changes by 0.08 in intensity then,
    /// with a noise of 0.8.
    pub const STILL_MM: f64 = 2e-3;

    /// Prepares a renderer for the rays that `surface` was cast with. A pixel records the mean of its rays.
    ///
    /// # Errors
    /// Returns the errors of [`Capturing::take`].
    pub fn new(
        scene: &'a SensorView,
        surface: &ReferenceSurface<'_>,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
        contact: Contact,
    ) -> Result<Self, Error> {
        let sensor = &scene.project.design.sensor;
        // The surface was cast with several rays per pixel; their number follows from the sizes.
        let samples = surface.rays().width_px() / scene.viewpoint.camera().width_px();
        let cast = Cast { samples, ..Cast::at_rest(contact) };
        let capturing = Capturing { cast, lighting, constants, seed: None };
        // Checked as if pressed: captures of presses will follow.
        capturing.check(sensor, false, contact)?;
        let mut painter = Painter::of(sensor, lighting, constants)?;
        match &mut painter {
            Painter::Layers(layers) => layers.prepare(&surface.untouched()),
            Painter::Coat(coat) => coat.prepare(&surface.untouched()),
            Painter::Marks(marks) => marks.prepare(&scene.viewpoint, samples)?,
            // Glow is rendered anew each time.
            Painter::Glow(_) => {}
        }
        let lens = LensEffects::of(sensor, lighting, &scene.viewpoint, samples)?;
        Ok(Self { scene, capturing, painter, lens })
    }

    /// Returns the number of values per pixel: 1, or 3 for red, green and blue.
    pub fn channels(&self) -> usize {
        self.capturing.channels()
    }

    /// Returns whether maps need normals.
    pub fn wants_normals(&self) -> bool {
        matches!(self.painter, Painter::Coat(_))
    }

    /// Renders the capture of a press, row by row, 0 to 255, not rounded. Without a seed it has neither noise nor
    /// drift.
    ///
    /// # Errors
    /// Returns the errors of [`Capturing::take`].
    pub fn take(
        &self,
        map: &DepthMap<'_>,
        answer: Option<&Answer<'_>>,
        seed: Option<u64>,
    ) -> Result<Vec<f64>, Error> {
        let sensor = &self.scene.project.design.sensor;
        let touch = self.scene.touch()?;
        let deepest = self.wants_normals().then(|| deepest(map, touch)).flatten();
        // Renderers use neither sigmas nor the count of pixels.
        let seen =
            Seen { map, sigmas: &Sigmas::default(), deepest, surface_px: 0, answer, gap: None };
        let painted = self.painter.paint(self.scene, &self.capturing.cast, &seen)?;
        let painted = painted.through(self.lens.as_ref());
        let capturing = Capturing { seed, ..self.capturing.clone() };
        let samples = self.capturing.cast.samples;
        let size_px = [map.width_px(), map.height_px()].map(|side| side / samples);
        capturing.values(sensor, &painted.light, size_px)
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
            "constants": super::document::constants(design, &self.capturing),
            "left_out": super::document::left_out(&lighting.shows, super::lens::left_out(&design.sensor, lighting)),
        })
    }
}
