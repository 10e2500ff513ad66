//! What a press looks like, pixel by pixel.

use fabkit_geometry::{Point3, Vector3};

use super::PixelRays;
use super::reference::ReferenceSurface;

/// The label of pixels that see no sensing surface.
pub const NO_LABEL: u16 = 0;
/// The label of the surface where nothing touches it.
pub const SURFACE_LABEL: u16 = 1;

/// Ground truth for one press: row by row, `NaN` where no surface is seen.
#[derive(Clone, Debug)]
pub struct DepthMap<'a> {
    pub(super) surface: &'a ReferenceSurface<'a>,
    pub(super) range_mm: Vec<f64>,
    pub(super) label: Vec<u16>,
    pub(super) names: Vec<String>,
    /// Pixels whose normals are not the surface's; of two entries for one the later counts.
    pub(super) moved: Vec<(u32, Vector3<f64>)>,
}

impl DepthMap<'_> {
    /// Columns.
    pub fn width_px(&self) -> u32 {
        self.surface.rays().width_px()
    }

    /// Rows.
    pub fn height_px(&self) -> u32 {
        self.surface.rays().height_px()
    }

    /// Distance along each ray, mm.
    pub fn range_mm(&self) -> &[f64] {
        &self.range_mm
    }

    /// Unit normals out of the gel, sensor frame. Computed at each call.
    pub fn normal_in_sensor(&self) -> Vec<Vector3<f64>> {
        self.normals_from(self.surface.normal_in_sensor())
    }

    /// The same, from those at rest, for who has them.
    pub fn normals_from(&self, at_rest: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
        let mut normals = at_rest;
        for &(pixel, normal) in &self.moved {
            normals[pixel as usize] = normal;
        }
        normals
    }

    /// What each pixel sees: an index into [`DepthMap::names`].
    pub fn label(&self) -> &[u16] {
        &self.label
    }

    /// Whether a pixel sees a presser, or the surface elsewhere than at rest.
    pub fn has_moved(&self, pixel: usize) -> bool {
        let (now_mm, rest_mm) = (self.range_mm[pixel], self.surface.range_mm()[pixel]);
        self.label[pixel] > SURFACE_LABEL
            || now_mm != rest_mm && !(now_mm.is_nan() && rest_mm.is_nan())
    }

    /// What the labels mean: `none`, `surface`, then the pressers.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// What of the sensor each ray sees, contact or not, and what the numbers mean: see
    /// [`PixelRays::seen_by`](super::PixelRays::seen_by). Of rays that were not followed through a sensor's
    /// bodies: the surface, or nothing.
    pub fn seen_by(&self) -> (Vec<u8>, Vec<String>) {
        let rays = self.surface.rays();
        if !rays.seen_by().is_empty() {
            return (rays.seen_by().to_vec(), rays.seen_by_names().to_vec());
        }
        let is_seen = self.surface.range_mm().iter().map(|range| u8::from(range.is_finite()));
        (is_seen.collect(), vec!["nothing".into(), "surface".into()])
    }

    /// The rays that were cast.
    pub fn rays(&self) -> &PixelRays {
        self.surface.rays()
    }

    /// Where each ray ends, mm in the sensor frame.
    pub fn point_in_sensor(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        let rays = self.surface.rays();
        self.range_mm.iter().enumerate().map(|(pixel, &range_mm)| match rays.ray(pixel) {
            Some(ray) => ray.at(range_mm),
            None => Point3::from(Vector3::repeat(f64::NAN)),
        })
    }

    /// Where a ray ends, and the unit direction in which it arrives, mm in the sensor frame; nothing of rays that are none.
    #[inline]
    pub fn arrival(&self, pixel: usize) -> Option<(Point3<f64>, Vector3<f64>)> {
        let ray = self.surface.rays().ray(pixel)?;
        Some((ray.at(self.range_mm[pixel]), ray.direction))
    }

    /// The unit direction in which each ray arrives there, sensor frame; NaN of rays that are none.
    pub fn direction_in_sensor(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        let rays = self.surface.rays();
        let nothing = Vector3::repeat(f64::NAN);
        (0..self.range_mm.len())
            .map(move |pixel| rays.ray(pixel).map_or(nothing, |ray| ray.direction))
    }

    /// Third coordinate of each point in the camera frame, mm.
    pub fn z_mm(&self) -> impl Iterator<Item = f64> + '_ {
        let rays = self.surface.rays();
        self.point_in_sensor().map(|point| rays.z_mm(&point))
    }

    /// Range without contact minus range with it, mm: at least 0.
    pub fn indentation_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.surface.range_mm().iter().zip(&self.range_mm).map(|(before, now)| before - now)
    }

    /// Whether each pixel sees a presser.
    pub fn contact(&self) -> impl Iterator<Item = bool> + '_ {
        self.label.iter().map(|&label| label > SURFACE_LABEL)
    }

    /// Angle between each ray and the normal, rad: 0 where the surface is looked at squarely.
    pub fn incidence_rad(&self) -> impl Iterator<Item = f64> + '_ {
        let rays = self.surface.rays();
        self.normal_in_sensor().into_iter().enumerate().map(|(pixel, normal)| {
            rays.ray(pixel).map_or(f64::NAN, |ray| {
                let cosine = ray.direction.dot(&normal);
                ray.direction.cross(&normal).norm().atan2(cosine)
            })
        })
    }
}
