//! Undeformed sensing surface, cast once per camera.

use fabkit_geometry::{InvalidSolid, Scratch, TouchSurface, Vector3};
use fabkit_optics::SensingSurface;
use rayon::prelude::*;

use super::PixelRays;

/// Sensing surface as one camera sees it without contact.
#[derive(Clone, Debug)]
pub struct ReferenceSurface<'a> {
    pub(super) rays: &'a PixelRays,
    pub(super) touch: TouchSurface,
    inside: SensingSurface,
    /// Range of each pixel, mm, row by row; `NaN` where the surface is not seen.
    pub(super) range_mm: Vec<f64>,
}

impl<'a> ReferenceSurface<'a> {
    /// Casts every ray against the touch surface of a sensor.
    ///
    /// # Errors
    /// Dimensions that do not form a solid.
    pub fn cast(touch: &TouchSurface, rays: &'a PixelRays) -> Result<Self, InvalidSolid> {
        let (inside, touch) = (SensingSurface::new(touch)?, touch.clone());
        let mut surface = Self { rays, touch, inside, range_mm: Vec::new() };
        surface.range_mm = surface.exits(f64::NAN, |range_mm, _| range_mm);
        Ok(surface)
    }

    /// Computes a value of each ray from its exit: range and outward normal.
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

    /// Returns the rays of the surface.
    pub fn rays(&self) -> &'a PixelRays {
        self.rays
    }

    /// Range of each pixel, mm; `NaN` where the surface is not seen.
    pub fn range_mm(&self) -> &[f64] {
        &self.range_mm
    }

    /// Computes the unit normals out of the gel, sensor frame; `NaN` where the surface is not seen. They are recomputed
    /// at each call, since most callers need ranges only.
    pub fn normal_in_sensor(&self) -> Vec<Vector3<f64>> {
        self.exits(Vector3::repeat(f64::NAN), |_, outward| outward)
    }

    /// Number of pixels that see the surface.
    pub fn visible_pixels(&self) -> usize {
        self.range_mm.iter().filter(|range| range.is_finite()).count()
    }
}
