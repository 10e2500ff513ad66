//! Pictures of a skin with channels of liquid: no surface of it is known that a fixture could go around, but its marks
//! are.

use std::sync::Arc;

use fabkit_elastic::LiquidStack;
use fabkit_fixtures::Project;
use fabkit_optics::Sights;

use super::{Captured, Capturing, MarkScene, mark_pixels, moved};
use crate::Error;
use crate::ground_truth::Viewpoint;
use crate::pressing::{Contact, Linear, Moved, on_solids};
use crate::scene::SceneError;

/// Distance of nodes that nobody asked for, mm.
const SPACING_MM: f64 = 1.0;

/// A sensor with a skin over marks, and the camera that looks at them.
#[derive(Clone, Debug)]
pub struct SkinView {
    /// The sensor.
    pub project: Arc<Project>,
    /// Its camera.
    pub viewpoint: Viewpoint,
}

impl Capturing<'_> {
    /// As [`Capturing::take`], of a skin with channels of liquid.
    ///
    /// # Errors
    /// A light that shows something else than marks; what the skin's solver says.
    pub fn take_of_skin(&self, view: &SkinView) -> Result<Captured, Error> {
        let sensor = &view.project.design.sensor;
        self.check(sensor, self.cast.presses.is_empty(), self.cast.contact)?;
        let scene = MarkScene::of(sensor, self.lighting, &self.constants)?;
        let mut marks = moved(sensor, None);
        if !self.cast.presses.is_empty() {
            let spacing_mm = match self.cast.contact {
                Contact::Linear(Linear { spacing_mm, .. }) => spacing_mm,
                _ => None,
            };
            let stack = LiquidStack::of(sensor, spacing_mm.unwrap_or(SPACING_MM))
                .map_err(crate::pressing::PressingError::from)?;
            let bodies: Vec<_> =
                self.cast.presses.iter().flat_map(|press| &press.bodies).cloned().collect();
            let outcome =
                on_solids(&bodies, |pressers| Ok(stack.ready(pressers)?.press(pressers)?))?;
            let pressed = |moved: Moved| Moved {
                displacement_mm: Some(outcome.displacement_mm(&stack, &moved.mark.point)),
                ..moved
            };
            marks = marks.into_iter().map(pressed).collect();
        }
        let painted = scene.paint(&view.viewpoint, self.cast.samples, marks)?;
        let camera = view.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()];
        let stack = view.viewpoint.stack(sensor).map_err(SceneError::Light)?;
        let mark_pixels = mark_pixels(&view.viewpoint, &Sights::new(stack), &painted.marks);
        let captured = self.recorded(sensor, painted, size_px, (scene.words(), scene.exposure));
        Ok(Captured { mark_pixels, ..captured })
    }
}
