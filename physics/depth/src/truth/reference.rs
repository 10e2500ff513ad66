//! The surface without contact, cast once per camera.

use fabkit_geometry::{InvalidSolid, Scratch, TouchSurface, Vector3};
use fabkit_optics::SensingSurface;
use rayon::prelude::*;

use super::PixelRays;

/// The sensing surface as one camera sees it without contact.
#[derive(Clone, Debug)]
pub struct ReferenceSurface<'a> {
    pub(super) rays: &'a PixelRays,
    pub(super) touch: TouchSurface,
    inside: SensingSurface,
    /// Row by row; `NaN` where the surface is not seen.
    pub(super) range_mm: Vec<f64>,
}

impl<'a> ReferenceSurface<'a> {
    /// Casts every ray against the touch surface of a sensor.
    ///
    /// # Errors
    /// Dimensions that make no solid.
    pub fn cast(touch: &TouchSurface, rays: &'a PixelRays) -> Result<Self, InvalidSolid> {
        let (inside, touch) = (SensingSurface::new(touch)?, touch.clone());
        let mut surface = Self { rays, touch, inside, range_mm: Vec::new() };
        surface.range_mm = surface.exits(f64::NAN, |range_mm, _| range_mm);
        Ok(surface)
    }

    /// Something of each ray's exit, by its range and the outward normal there.
    #[inline]
    fn exits<T: Clone + Send>(
        &self,
        unseen: T,
        of: impl Fn(f64, Vector3<f64>) -> T + Sync,
    ) -> Vec<T> {
        let width = self.rays.width_px() as usize;
        let mut all = vec![unseen; self.rays.len()];
        all.par_chunks_mut(width).enumerate().for_each_init(
            Scratch::default,
            |scratch, (row, values)| {
                for (column, value) in values.iter_mut().enumerate() {
                    let Some(ray) = self.rays.free_ray(row * width + column) else { continue };
                    if let Some((range_mm, outward)) = self.inside.exit(&ray, scratch) {
                        *value = of(range_mm, outward);
                    }
                }
            },
        );
        all
    }

    /// The rays it was cast with.
    pub fn rays(&self) -> &'a PixelRays {
        self.rays
    }

    /// Range of the surface at a pixel, mm; `NaN` where it is not seen.
    pub fn range_mm(&self) -> &[f64] {
        &self.range_mm
    }

    /// Unit normals out of the gel, sensor frame; `NaN` where the surface is not seen. Computed at
    /// each call: most maps are only asked for their ranges.
    pub fn normal_in_sensor(&self) -> Vec<Vector3<f64>> {
        self.exits(Vector3::repeat(f64::NAN), |_, outward| outward)
    }

    /// How many pixels see the surface.
    pub fn seen(&self) -> usize {
        self.range_mm.iter().filter(|range| range.is_finite()).count()
    }
}
