//! Stitching of two half presses into one map at a seam.

use fabkit_geometry::Vector3;

use super::reference::ReferenceSurface;

/// Side of a plane through the sensor's axis on which each pixel sees the surface.
///
/// Halves that meet at a plane can be pressed, captured and cast separately, since one half does not show on the other
/// side. Near the plane the gel belongs to neither half, so a margin is left out.
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
/// use fabkit_depth::ground_truth::{PixelRays, ReferenceSurface, Seam, Side};
/// use fabkit_geometry::{Pose, Vector3};
///
/// // Three pixels in a row along x, whose camera is in the centre of a hemisphere.
/// let rays = PixelRays::new(&Camera::equidistant(3, 1, 2.0)?, &Pose::identity());
/// let surface = ReferenceSurface::cast(&touch, &rays)?;
/// let seam = Seam::new(&surface, Vector3::x(), 1.0);
/// assert_eq!(seam.sides(), [Side::Left, Side::Neither, Side::Right]);
/// assert_eq!(seam.stitch(&[1, 2, 3], &[10, 20, 30], 0), [1, 0, 30]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seam {
    sides: Vec<Side>,
}

/// Position of a pixel relative to the seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Side that the seam's normal points away from.
    Left,
    /// Side that the seam's normal points to.
    Right,
    /// Within the margin, or no surface at all.
    Neither,
}

impl Seam {
    /// Creates a seam along the plane through z whose normal, from left to right, is `left_to_right` (sensor frame).
    ///
    /// A pixel belongs to a side if the *undeformed* surface that it sees is farther than `margin_mm` from the plane.
    pub fn new(surface: &ReferenceSurface, left_to_right: Vector3<f64>, margin_mm: f64) -> Self {
        let normal = left_to_right.normalize();
        let side = |signed_mm: f64| {
            if signed_mm > margin_mm {
                Side::Right
            } else if signed_mm < -margin_mm {
                Side::Left
            } else {
                Side::Neither
            }
        };
        let points = surface.map_without_contact();
        let sides = points.point_in_sensor().map(|point| side(point.coords.dot(&normal))).collect();
        Self { sides }
    }

    /// Side of each pixel.
    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// Composes a map or an image of two, value by value; `neither` fills the margin.
    ///
    /// # Panics
    /// If the lengths differ from the seam's number of pixels.
    pub fn stitch<T: Copy>(&self, left: &[T], right: &[T], neither: T) -> Vec<T> {
        assert_eq!((left.len(), right.len()), (self.sides.len(), self.sides.len()));
        let pick = |((side, &left), &right): ((&Side, &T), &T)| match side {
            Side::Left => left,
            Side::Right => right,
            Side::Neither => neither,
        };
        self.sides.iter().zip(left).zip(right).map(pick).collect()
    }
}
