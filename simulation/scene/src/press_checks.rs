//! Checks of presses: each must touch the surface and stay within the soft layer.

use fabkit_files::Error;
use fabkit_fixtures::Press;
use rayon::prelude::*;

use super::{SceneError, SensorView};
use crate::ground_truth::{Penetration, find_deepest_point, find_penetration};

/// Tolerance for a press that reaches exactly to the bottom of the soft layer, mm: rounding.
const SLACK_MM: f64 = 1e-6;
/// Factors on the missing distance that are tried in turn for a suggested depth. More than 1, since surfaces curve.
const DEPTH_FACTORS: [f64; 4] = [1.05, 1.2, 1.5, 2.0];
/// Step of suggested depths, mm.
const DEPTH_STEP_MM: f64 = 0.01;

/// Deepest point of a press relative to the surface.
#[derive(Clone, Debug)]
pub(super) struct PressApproach {
    id: String,
    /// Deepest point over all bodies of the press; `None` if all of them lie below the surface's foot.
    deepest: Option<Penetration>,
}

impl SensorView {
    /// Checks presses, given with the names they are reported by. A press deeper than the surface's limit is refused:
    /// what lies below yields little or not at all, and is not simulated. A press that misses the
    /// surface is refused unless that is allowed.
    ///
    /// # Errors
    /// Lists every press that is too deep or misses, with its depth or distance and its place.
    pub(super) fn check_presses<'a>(
        &self,
        presses: impl Iterator<Item = (&'a str, &'a Press)>,
        allow_no_contact: bool,
    ) -> Result<Vec<PressApproach>, Error> {
        let touch = self.touch()?;
        let presses: Vec<_> = presses.collect();
        let bodies: Vec<_> = presses.iter().flat_map(|(_, press)| &press.bodies).collect();
        let found = bodies.par_iter().map(|body| find_deepest_point(touch, body));
        let found: Vec<_> = found.collect::<Result<_, _>>().map_err(Error::bug)?;
        // One result per body, in the order in which the loop below asks for them.
        let mut found = found.into_iter();
        let (mut too_deep, mut missing, mut example) = (Vec::new(), Vec::new(), None);
        let mut meetings = Vec::new();
        for (name, press) in &presses {
            let mut nearest: Option<Penetration> = None;
            for (body, deepest) in press.bodies.iter().zip(&mut found) {
                let Some(deepest) = deepest else { continue };
                if nearest.is_none_or(|nearest| deepest.depth_mm > nearest.depth_mm) {
                    nearest = Some(deepest);
                }
                if deepest.depth_mm > touch.max_indentation_mm() + SLACK_MM {
                    let body = if body.name == *name { "it" } else { &body.name };
                    too_deep.push(format!(
                        "`{name}`: {body} goes {:.3} mm deep at {}, but presses of this surface are \
                         simulated to {} mm",
                        deepest.depth_mm,
                        place(&deepest),
                        touch.max_indentation_mm(),
                    ));
                }
            }
            if !nearest.is_some_and(|nearest| nearest.depth_mm > 0.0) {
                // A name other than the press itself is a pattern that matched it; the message then names both.
                let pattern = if *name == press.id { "" } else { &format!("`{name}`: ") };
                missing.push(format!("{pattern}`{}` {}", press.id, describe_miss(nearest)));
                example = example.or_else(|| self.find_touching_press(press, nearest?));
            }
            meetings.push(PressApproach { id: press.id.clone(), deepest: nearest });
        }
        if !too_deep.is_empty() {
            return Err(SceneError::TooDeep(too_deep).into());
        }
        if missing.is_empty() || allow_no_contact {
            return Ok(meetings);
        }
        Err(SceneError::NoContact { faults: missing, deeper: example }.into())
    }

    /// Finds the same press at a depth at which it touches. Each candidate depth is verified, not only computed.
    fn find_touching_press(&self, press: &Press, nearest: Penetration) -> Option<String> {
        let touch = self.touch().ok()?;
        DEPTH_FACTORS.iter().find_map(|factor| {
            let by_mm = (factor * -nearest.depth_mm / DEPTH_STEP_MM).ceil() * DEPTH_STEP_MM;
            let deeper = self.project.press_deeper(&press.id, by_mm)?;
            let found = find_penetration(touch, deeper.bodies.first()?).ok()??;
            (found.depth_mm <= touch.max_indentation_mm() + SLACK_MM).then_some(deeper.id)
        })
    }

    /// Returns an error if no pixel sees any of the presses: ground truth without contact is just the reference.
    pub(super) fn check_visible(&self, presses: &[PressApproach]) -> Result<(), SceneError> {
        let unseen: Vec<String> = presses
            .iter()
            .filter_map(|press| {
                let deepest = press.deepest?;
                let in_camera =
                    self.viewpoint.sensor_from_camera.inverse().point(deepest.point_in_sensor);
                let off_deg = in_camera.x.hypot(in_camera.y).atan2(in_camera.z).to_degrees();
                Some(format!(
                    "the camera sees nothing of `{}`, which goes {:.3} mm deep at {}: {off_deg:.0} \
                     deg off its axis, beside its image or hidden",
                    press.id,
                    deepest.depth_mm,
                    place(&deepest),
                ))
            })
            .collect();
        if unseen.is_empty() {
            return Ok(());
        }
        Err(SceneError::PressNotVisible(unseen))
    }
}

fn describe_miss(nearest: Option<Penetration>) -> String {
    match nearest {
        Some(nearest) => format!(
            "does not touch the surface: it ends {:.3} mm above it, nearest at {}",
            -nearest.depth_mm,
            place(&nearest)
        ),
        None => "does not touch the surface: all of it lies below the surface's foot".into(),
    }
}

fn place(of: &Penetration) -> String {
    let at = of.point_in_sensor;
    format!("({:.2}, {:.2}, {:.2}) mm", at.x, at.y, at.z)
}
