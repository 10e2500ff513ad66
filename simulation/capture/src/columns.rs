//! Rendering of columns of dyed liquid before a white background in room light.

use std::sync::Arc;

use fabkit_depth::ground_truth::PixelRays;
use fabkit_elastic::ChannelOutcome;
use fabkit_files::Error;
use fabkit_geometry::{
    CompiledSolid, Lighting, LiquidColumn, Marker, MarkerCarrier, Ray, Rgb, Scratch, Sensor,
    Vector3, VisibleEffect,
};
use fabkit_optics::{OpticalStack, ViewStacks};
use fabkit_scene::SceneError;
use fabkit_scene::ground_truth::Viewpoint;
use fabkit_scene::press_simulation::MarkerDisplacement;
use rayon::prelude::*;

use super::scene::placed_solid;
use super::surfaces::{USUAL_MARK, reflectance, unknown_in_view};
use super::{CaptureError, LightConstants, RenderedLight};

/// A sensor's display as seen by the camera above it.
#[derive(Debug)]
pub(super) struct ColumnScene<'a> {
    /// The sensor with that camera in place of its own, and without the liquid.
    sensor: Sensor,
    liquid: CompiledSolid,
    pub(super) columns: &'a [LiquidColumn],
    constants: &'a LightConstants,
    pub(super) exposure: f64,
    /// Rays of the view, kept where several captures share it.
    rays: Option<PixelRays>,
}

impl<'a> ColumnScene<'a> {
    pub(super) fn new(
        sensor: &Sensor,
        lighting: &'a Lighting,
        constants: &'a LightConstants,
    ) -> Result<Self, Error> {
        let missing = || CaptureError::UnknownLighting { sensor: sensor.name.clone() };
        let (VisibleEffect::LiquidColumns { liquid, columns }, Some(camera)) =
            (&lighting.effect, &lighting.camera)
        else {
            return Err(missing().into());
        };
        let compiled = placed_solid(sensor.body(liquid).ok_or_else(missing)?)?;
        let mut sensor = sensor.clone();
        sensor.camera = camera.clone();
        sensor.bodies.retain(|body| body.name != *liquid);
        // A white background gets the intensity of a light marker.
        let exposure = constants.mark_grey.value / USUAL_MARK;
        Ok(Self { sensor, liquid: compiled, columns, constants, exposure, rays: None })
    }

    pub(super) fn words(&self) -> [String; 2] {
        [format!("ends of {} columns", self.columns.len()), "the room".to_owned()]
    }

    /// Keeps the rays of a view for several captures.
    pub(super) fn keep_view(&mut self, viewpoint: &Viewpoint, samples: u32) -> Result<(), Error> {
        self.rays = Some(self.rays(viewpoint, samples)?);
        Ok(())
    }

    fn rays(&self, viewpoint: &Viewpoint, samples: u32) -> Result<PixelRays, Error> {
        let stack = OpticalStack::without_refraction(&self.sensor).map_err(SceneError::Light)?;
        Ok(viewpoint.rays(samples).traced_through(&Arc::new(ViewStacks::new(stack))))
    }

    pub(super) fn paint(
        &self,
        viewpoint: &Viewpoint,
        samples: u32,
        marks: Vec<MarkerDisplacement>,
    ) -> Result<RenderedLight, Error> {
        let own;
        let rays = match &self.rays {
            Some(rays) => rays,
            None => {
                own = self.rays(viewpoint, samples)?;
                &own
            }
        };
        let [_, ground] = &self.constants.marks;
        // Reflectance of each body on which rays may end.
        let sends: Vec<f64> = rays
            .seen_by_names()
            .iter()
            .map(|name| reflectance(self.sensor.body(name), ground))
            .collect();
        let per_mm = self.constants.dye_per_mm.value;
        let ray = |scratch: &mut Scratch, i: usize| -> Rgb {
            let back = self.exposure * sends[usize::from(rays.seen_by()[i])];
            let Some(ray) = rays.ray(i) else { return [self.constants.beside_grey.value; 3] };
            let left = (-per_mm * self.in_liquid_mm(&ray, &marks, scratch)).exp();
            // The dye transmits red.
            [back, back * left, back * left]
        };
        let light = (0..rays.len()).into_par_iter().map_init(Scratch::default, ray).collect();
        let not_known = unknown_in_view(&self.sensor, rays, &[]);
        Ok(RenderedLight { light, thickness_mm: Vec::new(), marks, not_known })
    }

    /// Returns the length of a ray in the liquid, mm.
    fn in_liquid_mm(&self, ray: &Ray, marks: &[MarkerDisplacement], scratch: &mut Scratch) -> f64 {
        let Some((column, moved)) = self.find_column(ray, marks) else { return 0.0 };
        let by_mm = moved.displacement_mm.map_or(0.0, |by| by.dot(&column.direction));
        let back = Ray { origin: ray.origin - by_mm * column.direction, ..*ray };
        let mut length_mm = |ray: &Ray| {
            let mut found = Vec::new();
            self.liquid.stretches_into(ray, scratch, &mut found);
            found.iter().map(|[from, to]| to - from).sum::<f64>()
        };
        let [at_rest, shifted] = [ray, &back].map(&mut length_mm);
        // A column pushed forward fills the place at rest and more; drawn back it fills less. The liquid's solid is
        // shifted along the channel, so the union or the intersection with the place at rest is taken.
        if by_mm >= 0.0 { at_rest.max(shifted) } else { at_rest.min(shifted) }
    }

    /// Finds the column whose channel a ray passes at the height of the column's end.
    fn find_column<'m>(
        &self,
        ray: &Ray,
        marks: &'m [MarkerDisplacement],
    ) -> Option<(&'a LiquidColumn, &'m MarkerDisplacement)> {
        self.columns.iter().zip(marks).find(|(column, _)| {
            let down_mm = (column.end.z - ray.origin.z) / ray.direction.z;
            let off = ray.at(down_mm) - column.end;
            let across = off - off.dot(&column.direction) * column.direction;
            across.norm() < column.width_mm
        })
    }
}

/// Returns the columns as markers at their ends, displaced by the channels' liquid.
pub fn column_ends(
    columns: &[LiquidColumn],
    channels: &[ChannelOutcome],
) -> Vec<MarkerDisplacement> {
    let end = |(i, column): (usize, &LiquidColumn)| {
        let moves_mm = channels.get(i).map_or(0.0, |channel| channel.column_displacement_mm);
        let mark = Marker {
            name: format!("column {}", i + 1),
            point: column.end,
            axis: Vector3::z(),
            radius_mm: 0.5 * column.width_mm,
            carrier: MarkerCarrier::Gel,
        };
        MarkerDisplacement {
            displacement_mm: Some(moves_mm * column.direction),
            axis: mark.axis,
            mark,
        }
    };
    columns.iter().enumerate().map(end).collect()
}
