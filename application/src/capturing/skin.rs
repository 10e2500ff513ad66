//! Pictures of a skin with channels of liquid: no surface of it is known that a fixture could go around, but its marks
//! are.

use std::sync::Arc;

use fabkit_elastic::{LiquidOutcome, LiquidStack};
use fabkit_fixtures::Project;
use fabkit_geometry::{Sensor, Shows};
use fabkit_optics::Sights;

use super::columns::{ColumnScene, column_ends};
use super::{Captured, Capturing, MarkScene, mark_pixels};
use crate::Error;
use crate::ground_truth::Viewpoint;
use crate::pressing::{Contact, Linear, Moved, PressingError, on_solids};
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
        let pressed = self.pressed(sensor)?;
        let samples = self.cast.samples;
        let (painted, words) = if let Shows::Columns { .. } = self.lighting.shows {
            let scene = ColumnScene::of(sensor, self.lighting, self.constants)?;
            let channels = pressed.as_ref().map(|(_, outcome)| &outcome.channels[..]);
            let ends = column_ends(scene.columns, channels.unwrap_or_default());
            (scene.paint(&view.viewpoint, samples, ends)?, (scene.words(), scene.exposure))
        } else {
            let scene = MarkScene::of(sensor, self.lighting, self.constants)?;
            let moved = |moved: Moved| Moved {
                displacement_mm: match &pressed {
                    Some((stack, outcome)) => {
                        Some(outcome.displacement_mm(stack, &moved.mark.point))
                    }
                    None => moved.displacement_mm,
                },
                ..moved
            };
            let marks = super::moved(sensor, None).into_iter().map(moved).collect();
            (scene.paint(&view.viewpoint, samples, marks)?, (scene.words(), scene.exposure))
        };
        let camera = view.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()];
        // Seen by the camera that looks at it.
        let mut seen = sensor.clone();
        seen.camera = self.lighting.camera.clone().unwrap_or(seen.camera);
        let stack = view.viewpoint.stack(&seen).map_err(SceneError::Light)?;
        let mark_pixels = mark_pixels(&view.viewpoint, &Sights::new(stack), &painted.marks);
        let captured = self.recorded(sensor, painted, size_px, words);
        Ok(Captured { mark_pixels, ..captured? })
    }

    /// What the skin answers, if something presses it.
    fn pressed(&self, sensor: &Sensor) -> Result<Option<(LiquidStack, LiquidOutcome)>, Error> {
        if self.cast.presses.is_empty() {
            return Ok(None);
        }
        let spacing_mm = match self.cast.contact {
            Contact::Linear(Linear { spacing_mm, .. }) => spacing_mm,
            _ => None,
        };
        let stack = LiquidStack::of(sensor, spacing_mm.unwrap_or(SPACING_MM));
        let stack = stack.map_err(PressingError::from)?;
        let presses = self.cast.presses.iter();
        let bodies: Vec<_> = presses.flat_map(|press| &press.bodies).cloned().collect();
        let outcome = on_solids(&bodies, |pressers| Ok(stack.ready(pressers)?.press(pressers)?))?;
        Ok(Some((stack, outcome)))
    }
}
