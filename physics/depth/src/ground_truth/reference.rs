//! Undeformed sensing surface, cast once per camera.

use fabkit_geometry::{InvalidSolid, Scratch, TouchSurface, Vector3};
use fabkit_optics::SensingSurface;
use rayon::prelude::*;

use super::PixelRays;

/// Sensing surface as one camera sees it without contact.
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
/// use fabkit_depth::ground_truth::{PixelRays, ReferenceSurface};
/// use fabkit_geometry::{Pose, Vector3};
///
/// // A hemisphere of radius 10 mm around the camera: all of it is 10 mm away, and faces the camera.
/// let rays = PixelRays::new(&Camera::equidistant(61, 61, 2.0)?, &Pose::identity());
/// let surface = ReferenceSurface::cast(&touch, &rays)?;
/// assert_eq!(surface.visible_pixels(), 61 * 61);
/// assert!(surface.range_mm().iter().all(|range_mm| (range_mm - 10.0).abs() < 1e-9));
/// // Normals point out of the gel, away from the camera.
/// assert!((surface.normal_in_sensor()[30 * 61 + 30] - Vector3::z()).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
