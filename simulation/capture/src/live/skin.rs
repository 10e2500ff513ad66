//! Live simulation of a skin with liquid channels: press after press, with forces, columns and markers.

use std::sync::Arc;

use fabkit_elastic::{ElasticError, LiquidOutcome, LiquidSolver, LiquidStack};
use fabkit_files::Error;
use fabkit_fixtures::{Press, Project};
use fabkit_geometry::{Lighting, Marker, Vector3, VisibleEffect};
use fabkit_optics::ViewStacks;
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::Viewpoint;
use fabkit_scene::press_simulation::{
    MarkerDisplacement, PressingError, press_skin, with_indenters,
};

/// Default distance of nodes, mm.
const SPACING_MM: f64 = 1.0;

/// A skin that is ready for presses.
#[derive(Debug)]
pub struct LiveSkin {
    project: Arc<Project>,
    stack: LiquidStack,
    /// Lightings with their cameras: one sees the markers, one the columns.
    views: Vec<(Lighting, Viewpoint, ViewStacks)>,
}

/// Selection of images to render of presses.
#[derive(Clone, Debug, Default)]
pub struct SkinImageRequest {
    /// Names of the lightings.
    pub lights: Vec<String>,
    /// Seed of the first press's noise; the next presses use the next numbers. `None` for images without noise.
    pub seed: Option<u64>,
}

/// Images of a skin in one of its lightings.
#[derive(Clone, Debug)]
pub struct SkinImages {
    /// Name of the lighting.
    pub light: String,
    /// Number of columns and rows.
    pub size_px: [usize; 2],
    /// Number of values per pixel: 1, or 3 for red, green and blue.
    pub channels: usize,
    /// Image of each press, row by row, 0 to 255, not rounded.
    pub grey: Vec<Vec<f64>>,
}

/// Result of a press on a skin.
#[derive(Clone, Debug)]
pub struct SkinResult {
    /// Force of the indenters on the skin, sensor frame, N; zeros without contact.
    pub force_n: [f64; 3],
    /// Displacement of the liquid of each channel in its tube, away from the needle, mm.
    pub column_mm: Vec<f64>,
    /// Pixel of each column's end in the image of the display.
    pub column_px: Vec<Option<[f64; 2]>>,
    /// Displacement of each marker, mm.
    pub mark_mm: Vec<[f64; 3]>,
    /// Pixel of each marker.
    pub mark_px: Vec<Option<[f64; 2]>>,
    /// Markers and column ends that images show.
    marks: Vec<MarkerDisplacement>,
    columns: Vec<MarkerDisplacement>,
}

impl LiveSkin {
    /// Sets a skin up with nodes `spacing_mm` apart, which takes seconds. Its cameras have their nominal number of
    /// pixels, or `size_px`.
    ///
    /// # Errors
    /// Returns an error for a sensor without such a skin, for more nodes than allowed, and for cameras that are not
    /// valid.
    pub fn new(
        project: Arc<Project>,
        spacing_mm: Option<f64>,
        size_px: Option<[u32; 2]>,
    ) -> Result<Self, Error> {
        let sensor = &project.design.sensor;
        if sensor.liquid.is_none() {
            let problem = format!("{} has no skin with channels of liquid", sensor.name);
            return Err(PressingError::Contact { problem }.into());
        }
        let stack = LiquidStack::from_sensor(sensor, spacing_mm.unwrap_or(SPACING_MM));
        let stack = stack.map_err(PressingError::from)?;
        let views = sensor.lightings.iter().map(|lighting| {
            // Each lighting may have a camera of its own.
            let mut seen = sensor.clone();
            seen.camera = lighting.camera.clone().unwrap_or(seen.camera);
            let wrong = |error| SceneError::viewpoint(None, error);
            let mut viewpoint = Viewpoint::new(&seen.camera, None, None).map_err(wrong)?;
            if let Some(size_px) = size_px {
                viewpoint = viewpoint.resized(size_px).map_err(wrong)?;
            }
            let sights = ViewStacks::new(viewpoint.stack(&seen).map_err(SceneError::Light)?);
            Ok::<_, Error>((lighting.clone(), viewpoint, sights))
        });
        let views = views.collect::<Result<_, _>>()?;
        Ok(Self { project, stack, views })
    }

    /// Returns the names of the channels.
    pub fn channels(&self) -> impl Iterator<Item = &str> {
        self.stack.skin().channels.iter().map(|channel| channel.name.as_str())
    }

    /// Solves presses, each on a skin at rest. Presses close to each other share one setup: several at one place cost
    /// hardly more than one.
    ///
    /// # Errors
    /// Returns the error of the first press that has one: a channel that is pressed shut, contact that does not
    /// converge.
    pub fn press(&self, presses: &[Press]) -> Result<Vec<SkinResult>, Error> {
        let bodies: Vec<_> = presses.iter().flat_map(|press| &press.bodies).cloned().collect();
        let ready = with_indenters(&bodies, |indenters| Ok(self.stack.prepare(indenters)?));
        match ready {
            Ok(ready) => presses.iter().map(|press| self.solve(&ready, press)).collect(),
            Err(error) if error.is_no_contact() => presses.iter().map(|_| self.at_rest()).collect(),
            // The nodes under all presses exceed what one setup can solve, so the presses are split.
            Err(PressingError::Elastic(ElasticError::TooFine { .. })) if presses.len() > 1 => {
                let (first, second) = presses.split_at(presses.len() / 2);
                let mut shown = self.press(first)?;
                shown.extend(self.press(second)?);
                Ok(shown)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Renders images of presses from the results of [`LiveSkin::press`].
    ///
    /// # Errors
    /// Returns an error for an unknown lighting.
    pub fn images(
        &self,
        shown: &[SkinResult],
        wanted: &SkinImageRequest,
    ) -> Result<Vec<SkinImages>, Error> {
        let sensor = &self.project.design.sensor;
        let of_light = |light: &String| {
            let lighting = crate::find_lighting(sensor, Some(light))?;
            let is_it =
                |(known, ..): &&(Lighting, Viewpoint, ViewStacks)| known.name == lighting.name;
            let view = self.views.iter().find(is_it);
            let (_, viewpoint, _) = view.ok_or_else(|| Error::bug("a light without a camera"))?;
            let is_of_columns = matches!(lighting.effect, VisibleEffect::LiquidColumns { .. });
            let presses = shown.iter().enumerate().map(|(i, one)| {
                let moved = if is_of_columns { &one.columns } else { &one.marks };
                // Presses get different noise.
                (moved.clone(), wanted.seed.map(|seed| seed.wrapping_add(i as u64)))
            });
            let presses = presses.collect();
            let grey = crate::render_skin(sensor, lighting, viewpoint, presses)?;
            let camera = viewpoint.camera();
            Ok(SkinImages {
                light: light.clone(),
                size_px: [camera.width_px(), camera.height_px()].map(|side| side as usize),
                channels: if lighting.is_colored() { 3 } else { 1 },
                grey,
            })
        };
        wanted.lights.iter().map(of_light).collect()
    }

    fn solve(&self, ready: &LiquidSolver<'_>, press: &Press) -> Result<SkinResult, Error> {
        match press_skin(ready, press) {
            Ok(outcome) => self.to_result(Some(&outcome)),
            Err(error) if error.is_no_contact() => self.at_rest(),
            Err(error) => Err(error.into()),
        }
    }

    fn at_rest(&self) -> Result<SkinResult, Error> {
        self.to_result(None)
    }

    fn to_result(&self, outcome: Option<&LiquidOutcome>) -> Result<SkinResult, Error> {
        let sensor = &self.project.design.sensor;
        let by_mm = |mark: &Marker| match outcome {
            Some(outcome) => outcome.displacement_mm(&self.stack, &mark.point),
            None => Vector3::zeros(),
        };
        let marks: Vec<MarkerDisplacement> = sensor
            .marks
            .iter()
            .map(|mark| MarkerDisplacement {
                displacement_mm: Some(by_mm(mark)),
                axis: mark.axis,
                mark: mark.clone(),
            })
            .collect();
        let channels = outcome.map_or(&[][..], |outcome| &outcome.channels);
        let (mut column_px, mut mark_px) = (Vec::new(), Vec::new());
        let mut ends = Vec::new();
        // If several lightings show the same kind, the last one defines the pixels.
        for (lighting, viewpoint, sights) in &self.views {
            if let VisibleEffect::LiquidColumns { columns, .. } = &lighting.effect {
                ends = crate::column_ends(columns, channels);
                column_px = crate::project_markers(viewpoint, sights, &ends);
            } else {
                mark_px = crate::project_markers(viewpoint, sights, &marks);
            }
        }
        let count = self.stack.skin().channels.len();
        let moved =
            |i: usize| channels.get(i).map_or(0.0, |channel| channel.column_displacement_mm);
        Ok(SkinResult {
            force_n: outcome.map_or([0.0; 3], |outcome| outcome.force_n.into()),
            column_mm: (0..count).map(moved).collect(),
            column_px,
            mark_mm: marks
                .iter()
                .map(|moved| moved.displacement_mm.map_or([f64::NAN; 3], <[f64; 3]>::from))
                .collect(),
            mark_px,
            marks,
            columns: ends,
        })
    }
}
