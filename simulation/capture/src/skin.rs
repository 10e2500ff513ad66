//! Captures of a skin with liquid channels. Such a skin has no surface of known shape for casts, but its markers are
//! known.

use std::sync::Arc;

use fabkit_elastic::{LiquidOutcome, LiquidStack};
use fabkit_files::Error;
use fabkit_fixtures::Project;
use fabkit_geometry::{Lighting, Marker, Sensor, VisibleEffect};
use fabkit_optics::ViewStacks;
use fabkit_scene::ground_truth::Viewpoint;
use fabkit_scene::press_simulation::{
    ContactModel, LinearOptions, MarkerDisplacement, PressingError, with_indenters,
};
use fabkit_scene::{Cast, SceneError};

use super::columns::{ColumnScene, column_ends};
use super::{
    CameraGain, CaptureRequest, LensEffects, LightConstants, MarkScene, RenderedLight,
    SimulatedCapture, project_markers,
};

/// Default distance of nodes, mm.
const SPACING_MM: f64 = 1.0;

/// A sensor with a skin over markers, and the camera that sees them.
///
/// ```
/// use fabkit_capture::{CaptureRequest, SkinView, select_lighting};
/// # use fabkit_scene::ground_truth::Viewpoint;
/// # use fabkit_scene::press_simulation::{ContactModel, LinearOptions};
///
/// # let yaml = fabkit_designs::builtin_yaml("fluidic").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("fluidic.yaml", yaml, &[])?;
/// let (lighting, constants) = &select_lighting(&project, None, None)?;
/// let camera = lighting.camera.as_ref().unwrap_or(&project.design.sensor.camera);
/// let viewpoint = Viewpoint::new(camera, None, None)?.resized([64, 48])?;
/// let view = SkinView { project: std::sync::Arc::new(project.clone()), viewpoint };
/// let cast = fabkit_scene::Cast::at_rest(ContactModel::Linear(LinearOptions::default()));
/// let image = CaptureRequest { cast, lighting, constants, seed: None }.render_skin(&view)?;
/// assert_eq!(image.size_px, [64, 48]);
/// // At rest, no column of liquid has moved.
/// assert!(image.marks.iter().all(|end| end.displacement_mm.is_some_and(|mm| mm.norm() == 0.0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SkinView {
    /// The sensor's design and fixtures.
    pub project: Arc<Project>,
    /// Viewpoint of the camera.
    pub viewpoint: Viewpoint,
}

/// Renderer of a skin, by what its lighting shows.
enum SkinScene<'a> {
    Columns(Box<ColumnScene<'a>>),
    Marks(Box<MarkScene<'a>>),
}

impl<'a> SkinScene<'a> {
    fn of(
        sensor: &'a Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        Ok(match lighting.effect {
            VisibleEffect::LiquidColumns { .. } => {
                Self::Columns(Box::new(ColumnScene::new(sensor, lighting, constants)?))
            }
            _ => Self::Marks(Box::new(MarkScene::new(sensor, lighting, constants)?)),
        })
    }

    fn paint(
        &self,
        viewpoint: &Viewpoint,
        samples: u32,
        moved: Vec<MarkerDisplacement>,
    ) -> Result<RenderedLight, Error> {
        match self {
            Self::Columns(scene) => scene.paint(viewpoint, samples, moved),
            Self::Marks(scene) => scene.paint(viewpoint, samples, moved),
        }
    }

    /// Returns descriptions of what is shown and of the light sources, the exposure, and the camera's gain.
    fn words(&self) -> ([String; 2], f64, CameraGain) {
        match self {
            Self::Columns(scene) => (scene.words(), scene.exposure, CameraGain::NONE),
            Self::Marks(scene) => (scene.words(), scene.exposure, scene.camera_gain),
        }
    }
}

/// Renders images of a skin in one of its lightings, row by row, 0 to 255, not rounded. Each press is given as its
/// moved markers or column ends, and the seed of its noise.
///
/// # Errors
/// Returns the errors of [`CaptureRequest::render_skin`].
pub fn render_skin(
    sensor: &Sensor,
    lighting: &Lighting,
    viewpoint: &Viewpoint,
    presses: Vec<(Vec<MarkerDisplacement>, Option<u64>)>,
) -> Result<Vec<Vec<f64>>, Error> {
    let constants = LightConstants::for_sensor(sensor);
    let mut scene = SkinScene::of(sensor, lighting, &constants)?;
    let cast = Cast { samples: 1, ..Cast::at_rest(ContactModel::Linear(LinearOptions::default())) };
    match &mut scene {
        SkinScene::Columns(scene) => scene.keep_view(viewpoint, cast.samples)?,
        SkinScene::Marks(scene) => scene.keep_view(viewpoint, cast.samples)?,
    }
    let camera = viewpoint.camera();
    let size_px = [camera.width_px(), camera.height_px()];
    let lens = LensEffects::new(sensor, lighting, viewpoint, cast.samples)?;
    let image = |(moved, seed): (Vec<MarkerDisplacement>, Option<u64>)| {
        let capturing =
            CaptureRequest { cast: cast.clone(), lighting, constants: &constants, seed };
        let painted = scene.paint(viewpoint, cast.samples, moved)?.with_lens(lens.as_ref());
        let (.., gain) = scene.words();
        capturing.pixel_intensities(sensor, (&painted.light, gain), size_px)
    };
    presses.into_iter().map(image).collect()
}

impl CaptureRequest<'_> {
    /// Renders the capture of a skin with liquid channels, as [`CaptureRequest::render`] does for other surfaces.
    ///
    /// # Errors
    /// Returns an error for a lighting that shows neither markers nor columns, and the errors of the skin's solver.
    pub fn render_skin(&self, view: &SkinView) -> Result<SimulatedCapture, Error> {
        let sensor = &view.project.design.sensor;
        self.check(sensor, self.cast.presses.is_empty(), self.cast.contact)?;
        let pressed = self.solve_skin(sensor)?;
        let samples = self.cast.samples;
        let scene = SkinScene::of(sensor, self.lighting, self.constants)?;
        let moved = match (&self.lighting.effect, &pressed) {
            (VisibleEffect::LiquidColumns { columns, .. }, pressed) => {
                let channels = pressed.as_ref().map(|(_, outcome)| &outcome.channels[..]);
                column_ends(columns, channels.unwrap_or_default())
            }
            (_, Some((stack, outcome))) => {
                let by_mm = |mark: &Marker| outcome.displacement_mm(stack, &mark.point);
                let moved = |moved: MarkerDisplacement| MarkerDisplacement {
                    displacement_mm: Some(by_mm(&moved.mark)),
                    ..moved
                };
                super::displaced_markers(sensor, None).into_iter().map(moved).collect()
            }
            (_, None) => super::displaced_markers(sensor, None),
        };
        let lens = LensEffects::new(sensor, self.lighting, &view.viewpoint, samples)?;
        let painted = scene.paint(&view.viewpoint, samples, moved)?.with_lens(lens.as_ref());
        let words = scene.words();
        let camera = view.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()];
        // The stack must belong to the camera of this lighting, which may not be the sensor's own.
        let mut seen = sensor.clone();
        seen.camera = self.lighting.camera.clone().unwrap_or(seen.camera);
        let stack = view.viewpoint.stack(&seen).map_err(SceneError::Light)?;
        let mark_pixels = project_markers(&view.viewpoint, &ViewStacks::new(stack), &painted.marks);
        let captured = self.record(sensor, painted, size_px, words);
        Ok(SimulatedCapture { mark_pixels, ..captured? })
    }

    /// Solves the skin under the presses; `None` without presses.
    fn solve_skin(&self, sensor: &Sensor) -> Result<Option<(LiquidStack, LiquidOutcome)>, Error> {
        if self.cast.presses.is_empty() {
            return Ok(None);
        }
        let spacing_mm = match self.cast.contact {
            ContactModel::Linear(LinearOptions { spacing_mm, .. }) => spacing_mm,
            // Other contact models carry no spacing; the default applies.
            _ => None,
        };
        let stack = LiquidStack::from_sensor(sensor, spacing_mm.unwrap_or(SPACING_MM));
        let stack = stack.map_err(PressingError::from)?;
        let presses = self.cast.presses.iter();
        let bodies: Vec<_> = presses.flat_map(|press| &press.bodies).cloned().collect();
        let outcome =
            with_indenters(&bodies, |indenters| Ok(stack.prepare(indenters)?.press(indenters)?))?;
        Ok(Some((stack, outcome)))
    }
}
