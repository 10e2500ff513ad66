//! Depth maps by casting rays against indenters.

use fabkit_geometry::{Scratch, Vector3};
use rayon::prelude::*;

use super::indenter::{InsideBounds, PlacedIndenter};
use super::map::{DepthMap, NO_LABEL, SURFACE_LABEL};
use super::reference::ReferenceSurface;
use super::tiles::Tile;

impl ReferenceSurface<'_> {
    /// Restores a map from stored indentations, mm, and labels, row by row. The map has no normals of its own.
    /// Indentations below `still_mm` count as zero.
    ///
    /// ```
    /// # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path};
    /// # let grip = FixtureGrip {
    /// #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
    /// #     key: None, threads: Vec::new(),
    /// # };
    /// # let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
    /// # let touch = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 2.0, grip }.into();
    /// use fabkit_camera::Camera;
    /// use fabkit_depth::ground_truth::{PixelRays, ReferenceSurface, SURFACE_LABEL};
    /// use fabkit_geometry::Pose;
    ///
    /// // A hemisphere of radius 10 mm around the camera, in an image of two pixels.
    /// let rays = PixelRays::new(&Camera::equidistant(2, 1, 1.0)?, &Pose::identity());
    /// let surface = ReferenceSurface::cast(&touch, &rays)?;
    /// let labels = [SURFACE_LABEL as u8, SURFACE_LABEL as u8 + 1];
    /// // A micrometre is less than the two that count as still; half a millimetre is not.
    /// let map = surface.map_from_indentation(&[0.001, 0.5], &labels, 0.002);
    /// assert!((map.range_mm()[0] - 10.0).abs() < 1e-9 && (map.range_mm()[1] - 9.5).abs() < 1e-6);
    /// assert_eq!(map.contact().collect::<Vec<_>>(), [false, true]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn map_from_indentation(
        &self,
        indentation_mm: &[f32],
        label: &[u8],
        still_mm: f64,
    ) -> DepthMap<'_> {
        let mut map = self.map_without_contact();
        for (range_mm, by_mm) in map.range_mm.iter_mut().zip(indentation_mm) {
            let by_mm = f64::from(*by_mm);
            if by_mm.abs() >= still_mm {
                *range_mm -= by_mm;
            }
        }
        map.label = label.iter().map(|label| u16::from(*label)).collect();
        map
    }

    /// Returns the map without contact.
    ///
    /// ```
    /// # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path};
    /// # let grip = FixtureGrip {
    /// #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
    /// #     key: None, threads: Vec::new(),
    /// # };
    /// # let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
    /// # let touch = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 2.0, grip }.into();
    /// use fabkit_camera::Camera;
    /// use fabkit_depth::ground_truth::{NO_LABEL, PixelRays, ReferenceSurface, SURFACE_LABEL};
    /// use fabkit_geometry::Pose;
    ///
    /// // A fisheye of 200 degrees from edge to edge, in the centre of a hemisphere, sees below its foot.
    /// let rays = PixelRays::new(&Camera::equidistant(61, 1, 200_f64.to_radians())?, &Pose::identity());
    /// let surface = ReferenceSurface::cast(&touch, &rays)?;
    /// let map = surface.map_without_contact();
    /// assert_eq!((map.label()[0], map.label()[30]), (NO_LABEL, SURFACE_LABEL));
    /// assert!(map.range_mm()[0].is_nan() && map.indentation_mm().nth(30) == Some(0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn map_without_contact(&self) -> DepthMap<'_> {
        let seen = |range: &f64| if range.is_finite() { SURFACE_LABEL } else { NO_LABEL };
        DepthMap {
            surface: self,
            range_mm: self.range_mm.clone(),
            label: self.range_mm.iter().map(seen).collect(),
            names: vec!["none".into(), "surface".into()],
            changed_normals: Vec::new(),
        }
    }

    /// Computes the map of indenters pressed in rigidly. Their labels follow [`SURFACE_LABEL`] in list order.
    ///
    /// The nearest indenter wins; of two at equal range, the first in the list.
    ///
    /// ```
    /// # use fabkit_geometry::{DomeSurface, EllipsoidOffset, FixtureGrip, Path};
    /// # let grip = FixtureGrip {
    /// #     outline: Path::circle([0.0, 0.0], 10.0), top_z_mm: 0.0, bottom_z_mm: -20.0, clear_radius_mm: 8.0,
    /// #     key: None, threads: Vec::new(),
    /// # };
    /// # let dome = EllipsoidOffset { equatorial_mm: 10.0, polar_mm: 10.0, offset_mm: 0.0 };
    /// # let touch = DomeSurface { dome, centre_z_mm: 0.0, foot_z_mm: 0.0, max_indentation_mm: 2.0, grip }.into();
    /// use fabkit_camera::Camera;
    /// use fabkit_depth::ground_truth::{PixelRays, PlacedIndenter, ReferenceSurface};
    /// use fabkit_geometry::{Pose, Solid};
    ///
    /// // A hemisphere of radius 10 mm around the camera; one ball reaches in by 0.5 mm, the other not at all.
    /// let rays = PixelRays::new(&Camera::equidistant(61, 61, 2.0)?, &Pose::identity());
    /// let surface = ReferenceSurface::cast(&touch, &rays)?;
    /// let ball = |name, z_mm| PlacedIndenter::new(name, &Solid::sphere(3.0), Pose::translation(0.0, 0.0, z_mm));
    /// let map = surface.map_with_indenters(&[ball("high", 14.0)?, ball("low", 12.5)?]);
    /// // Labels count all of them, after `none` and `surface`.
    /// assert_eq!(map.names(), ["none", "surface", "high", "low"]);
    /// assert_eq!((map.label()[30 * 61 + 30], map.label()[0]), (3, 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn map_with_indenters(&self, indenters: &[PlacedIndenter]) -> DepthMap<'_> {
        let mut map = self.map_without_contact();
        map.names.extend(indenters.iter().map(|presser| presser.name.clone()));
        // Labels count all indenters, including those that lie wholly outside of the surface.
        let reached = indenters.iter().map(|presser| presser.reach(&self.touch));
        let reached: Vec<_> = (SURFACE_LABEL + 1..)
            .zip(indenters)
            .zip(reached)
            .filter_map(|((label, presser), reach)| Some((label, presser, reach?)))
            .collect();
        let hits: Vec<Vec<IndenterHit>> = self
            .rays
            .tiles()
            .par_iter()
            .map_init(Scratch::default, |scratch, tile| self.press_tile(tile, &reached, scratch))
            .collect();
        map.changed_normals.reserve_exact(hits.iter().map(Vec::len).sum());
        for IndenterHit { pixel, range_mm, normal, label } in hits.into_iter().flatten() {
            (map.range_mm[pixel], map.label[pixel]) = (range_mm, label);
            map.changed_normals.push((pixel as u32, normal));
        }
        map
    }

    /// Casts the rays of a tile against the indenters that it may see.
    fn press_tile(
        &self,
        tile: &Tile,
        indenters: &[(u16, &PlacedIndenter, InsideBounds)],
        scratch: &mut Scratch,
    ) -> Vec<IndenterHit> {
        let near = indenters.iter().filter(|(_, _, reach)| tile.may_meet(&reach.ball));
        let near: Vec<_> = near.collect();
        let mut touched = Vec::new();
        if near.is_empty() {
            return touched;
        }
        for pixel in tile.pixels(self.rays.width_px()) {
            let Some(ray) = self.rays.ray(pixel) else { continue };
            let mut nearest_mm = self.range_mm[pixel];
            // Pixels that do not see the surface cannot see a press either.
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
                    // The indenter's outward normal points into the gel; normals of the map point out of it.
                    first = Some(IndenterHit { pixel, range_mm, normal: -normal, label: *label });
                }
            }
            touched.extend(first);
        }
        touched
    }
}

/// A pixel that sees an indenter.
struct IndenterHit {
    pixel: usize,
    range_mm: f64,
    normal: Vector3<f64>,
    label: u16,
}
