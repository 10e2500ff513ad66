//! Casting: the reference surface once per camera, pressers once per press.

use fabkit_geometry::{InvalidSolid, Scratch, TouchSurface, Vector3};
use fabkit_optics::SensingSurface;
use rayon::prelude::*;

use super::PixelRays;
use super::map::{DepthMap, NO_LABEL, SURFACE_LABEL};
use super::presser::{Presser, Reach};
use super::tiles::Tile;

/// The sensing surface as one camera sees it without contact.
#[derive(Clone, Debug)]
pub struct ReferenceSurface<'a> {
    rays: &'a PixelRays,
    pub(super) touch: TouchSurface,
    inside: SensingSurface,
    /// Row by row; `NaN` where the surface is not seen.
    range_mm: Vec<f64>,
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

    /// A map from what was kept of it, mm and labels, row by row, without normals: what has moved by less than `still_mm` is
    /// at rest.
    pub fn indented(&self, indentation_mm: &[f32], label: &[u8], still_mm: f64) -> DepthMap<'_> {
        let mut map = self.untouched();
        for (range_mm, by_mm) in map.range_mm.iter_mut().zip(indentation_mm) {
            let by_mm = f64::from(*by_mm);
            if by_mm.abs() >= still_mm {
                *range_mm -= by_mm;
            }
        }
        map.label = label.iter().map(|label| u16::from(*label)).collect();
        map
    }

    /// The map without contact.
    pub fn untouched(&self) -> DepthMap<'_> {
        let seen = |range: &f64| if range.is_finite() { SURFACE_LABEL } else { NO_LABEL };
        DepthMap {
            surface: self,
            range_mm: self.range_mm.clone(),
            label: self.range_mm.iter().map(seen).collect(),
            names: vec!["none".into(), "surface".into()],
            moved: Vec::new(),
        }
    }

    /// The map with pressers, whose labels follow [`SURFACE_LABEL`] in their order.
    ///
    /// The nearest presser wins; where two are equally near, the first in the list.
    pub fn pressed(&self, pressers: &[Presser]) -> DepthMap<'_> {
        let mut map = self.untouched();
        map.names.extend(pressers.iter().map(|presser| presser.name.clone()));
        let reached = pressers.iter().map(|presser| presser.reach(&self.touch));
        let reached: Vec<_> = (SURFACE_LABEL + 1..)
            .zip(pressers)
            .zip(reached)
            .filter_map(|((label, presser), reach)| Some((label, presser, reach?)))
            .collect();
        let hits: Vec<Vec<Touched>> = self
            .rays
            .tiles()
            .par_iter()
            .map_init(Scratch::default, |scratch, tile| self.press_tile(tile, &reached, scratch))
            .collect();
        map.moved.reserve_exact(hits.iter().map(Vec::len).sum());
        for Touched { pixel, range_mm, normal, label } in hits.into_iter().flatten() {
            (map.range_mm[pixel], map.label[pixel]) = (range_mm, label);
            map.moved.push((pixel as u32, normal));
        }
        map
    }

    fn press_tile(
        &self,
        tile: &Tile,
        pressers: &[(u16, &Presser, Reach)],
        scratch: &mut Scratch,
    ) -> Vec<Touched> {
        let near = pressers.iter().filter(|(_, _, reach)| tile.may_meet(&reach.ball));
        let near: Vec<_> = near.collect();
        let mut touched = Vec::new();
        if near.is_empty() {
            return touched;
        }
        for pixel in tile.pixels(self.rays.width_px()) {
            let Some(ray) = self.rays.ray(pixel) else { continue };
            let mut nearest_mm = self.range_mm[pixel];
            // Where the surface is not seen nothing presses into it.
            if nearest_mm.is_nan() {
                continue;
            }
            let mut first = None;
            for (label, presser, reach) in &near {
                if reach.ball.may_meet(&ray)
                    && let Some((range_mm, normal)) =
                        presser.entry(&ray, reach, nearest_mm, scratch)
                {
                    nearest_mm = range_mm;
                    // Out of the gel is into the presser.
                    first = Some(Touched { pixel, range_mm, normal: -normal, label: *label });
                }
            }
            touched.extend(first);
        }
        touched
    }
}

/// A pixel that sees a presser.
struct Touched {
    pixel: usize,
    range_mm: f64,
    normal: Vector3<f64>,
    label: u16,
}
