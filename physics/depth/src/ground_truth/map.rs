//! Ground-truth depth map of a press.

use fabkit_geometry::{Point3, Vector3};

use super::PixelRays;
use super::reference::ReferenceSurface;

/// Label of pixels that do not see the sensing surface.
pub const NO_LABEL: u16 = 0;
/// Label of the surface where nothing touches it.
pub const SURFACE_LABEL: u16 = 1;

/// Ground truth of one press, row by row; `NaN` where no surface is seen.
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
/// use fabkit_geometry::Pose;
///
/// // A hemisphere of radius 10 mm around the camera, and 0.6 rad from pixel to pixel: the diagonal of 3 x 1 px is
/// // the square root of 10 px long.
/// let rays = PixelRays::new(&Camera::equidistant(3, 1, 0.6 * 10_f64.sqrt())?, &Pose::identity());
/// let surface = ReferenceSurface::cast(&touch, &rays)?;
/// let map = surface.map_without_contact();
/// // Range runs along the ray, z along the camera's axis.
/// assert!((map.range_mm()[2] - 10.0).abs() < 1e-9);
/// assert!((map.z_mm().nth(2).unwrap() - 10.0 * 0.6_f64.cos()).abs() < 1e-9);
/// // All rays meet the sphere at right angles.
/// assert!(map.incidence_rad().all(|angle_rad| angle_rad < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct DepthMap<'a> {
    pub(super) surface: &'a ReferenceSurface<'a>,
    pub(super) range_mm: Vec<f64>,
    pub(super) label: Vec<u16>,
    pub(super) names: Vec<String>,
    /// Pixels whose normals differ from the undeformed surface's. The later of two entries for a pixel counts.
    pub(super) changed_normals: Vec<(u32, Vector3<f64>)>,
}

impl DepthMap<'_> {
    /// Number of columns.
    pub fn width_px(&self) -> u32 {
        self.surface.rays().width_px()
    }

    /// Number of rows.
    pub fn height_px(&self) -> u32 {
        self.surface.rays().height_px()
    }

    /// Distance along each ray, mm.
    pub fn range_mm(&self) -> &[f64] {
        &self.range_mm
    }

    /// Computes the unit normals out of the gel, sensor frame. They are recomputed at each call.
    pub fn normal_in_sensor(&self) -> Vec<Vector3<f64>> {
        self.normals_from(self.surface.normal_in_sensor())
    }

    /// Computes the same normals from those of the undeformed surface, for callers that have them.
    pub fn normals_from(&self, at_rest: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
        let mut normals = at_rest;
        for &(pixel, normal) in &self.changed_normals {
            normals[pixel as usize] = normal;
        }
        normals
    }

    /// Label of each pixel: an index into [`DepthMap::names`].
    pub fn label(&self) -> &[u16] {
        &self.label
    }

    /// Returns whether a pixel sees an indenter, or the surface displaced.
    pub fn has_moved(&self, pixel: usize) -> bool {
        let (now_mm, rest_mm) = (self.range_mm[pixel], self.surface.range_mm()[pixel]);
        self.label[pixel] > SURFACE_LABEL
            || now_mm != rest_mm && !(now_mm.is_nan() && rest_mm.is_nan())
    }

    /// Names of the labels: `none`, `surface`, then the indenters.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns which part of the sensor each ray sees, with or without contact, and the names of these codes; see
    /// [`PixelRays::seen_by`](super::PixelRays::seen_by). Rays that were not traced through a sensor's bodies see the
    /// surface or nothing.
    pub fn seen_by(&self) -> (Vec<u8>, Vec<String>) {
        let rays = self.surface.rays();
        if !rays.seen_by().is_empty() {
            return (rays.seen_by().to_vec(), rays.seen_by_names().to_vec());
        }
        let is_seen = self.surface.range_mm().iter().map(|range| u8::from(range.is_finite()));
        (is_seen.collect(), vec!["nothing".into(), "surface".into()])
    }

    /// Returns the rays that were cast.
    pub fn rays(&self) -> &PixelRays {
        self.surface.rays()
    }

    /// Returns the end point of each ray, mm in the sensor frame.
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
    /// use fabkit_geometry::{Point3, Pose};
    ///
    /// // A hemisphere of radius 10 mm around the origin, seen from 4 mm below its tip.
    /// let rays = PixelRays::new(&Camera::equidistant(61, 61, 2.0)?, &Pose::translation(0.0, 0.0, 6.0));
    /// let surface = ReferenceSurface::cast(&touch, &rays)?;
    /// let map = surface.map_without_contact();
    /// let points: Vec<Point3<f64>> = map.point_in_sensor().collect();
    /// // Every pixel shows a point of it; the middle one shows the tip.
    /// assert!(points.iter().all(|point| (point.coords.norm() - 10.0).abs() < 1e-9));
    /// assert!((points[30 * 61 + 30] - Point3::new(0.0, 0.0, 10.0)).norm() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn point_in_sensor(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        let rays = self.surface.rays();
        self.range_mm.iter().enumerate().map(|(pixel, &range_mm)| match rays.ray(pixel) {
            Some(ray) => ray.at(range_mm),
            None => Point3::from(Vector3::repeat(f64::NAN)),
        })
    }

    /// Returns the end point of a ray and its unit direction there, in the sensor frame, mm; `None` outside the lens.
    #[inline]
    pub fn arrival(&self, pixel: usize) -> Option<(Point3<f64>, Vector3<f64>)> {
        let ray = self.surface.rays().ray(pixel)?;
        Some((ray.at(self.range_mm[pixel]), ray.direction))
    }

    /// Returns the unit direction of each ray at its end, sensor frame; NaN outside the lens.
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

    /// Indentation along each ray, mm: range without contact minus range with it. Rigid contact never makes it
    /// negative.
    pub fn indentation_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.surface.range_mm().iter().zip(&self.range_mm).map(|(before, now)| before - now)
    }

    /// Returns for each pixel whether it sees an indenter.
    pub fn contact(&self) -> impl Iterator<Item = bool> + '_ {
        self.label.iter().map(|&label| label > SURFACE_LABEL)
    }

    /// Angle between each ray and the normal, rad: 0 at perpendicular incidence.
    pub fn incidence_rad(&self) -> impl Iterator<Item = f64> + '_ {
        let rays = self.surface.rays();
        self.normal_in_sensor().into_iter().enumerate().map(|(pixel, normal)| {
            rays.ray(pixel).map_or(f64::NAN, |ray| {
                let cosine = ray.direction.dot(&normal);
                // The arctangent is accurate at small angles, where an arccosine is not.
                ray.direction.cross(&normal).norm().atan2(cosine)
            })
        })
    }
}
