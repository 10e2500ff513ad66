//! Viewpoints of images.

use fabkit_geometry::{Angle, Point3, Vector3};

use super::{RenderError, check_size};

/// Viewpoint and size of an image. The scene is always framed to fit.
///
/// ```
/// use fabkit_depth::View;
/// use fabkit_geometry::{Point3, Vector3};
/// // The front half is taken away, so that a mold shows its cavity.
/// let view = View::section(800, 600, Point3::origin(), -Vector3::y());
/// assert!(view.cut.is_some());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Image width, px.
    pub width_px: u32,
    /// Image height, px.
    pub height_px: u32,
    /// Viewing direction, scene frame. The image's up is z as far as possible, or y when looking along z.
    pub looking: Vector3<f64>,
    /// Projection onto the image.
    pub projection: ViewProjection,
    /// Half-space that is removed before drawing.
    pub cut: Option<SectionCut>,
    /// Free border on each side, as a fraction of the shorter side: 0 to 0.45.
    pub margin: f64,
}

/// Projection of space onto the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewProjection {
    /// Parallel rays: lengths in one direction keep their ratios.
    Orthographic,
    /// Rays from one point, whose distance follows from the field of view.
    Perspective {
        /// Angle that the scene's bounding ball subtends, 1 to 120 degrees; 20 to 30 look natural.
        field_of_view: Angle,
    },
}

/// A half-space removed from every actor. A body that it cuts shows a hatched face.
///
/// ```
/// use fabkit_depth::{Actor, View, render};
/// use fabkit_geometry::{CompiledSolid, Point3, Solid, Vector3};
///
/// // A box with a red ball in it: only where the front half is cut away does the ball show.
/// let shell = CompiledSolid::new(&Solid::cuboid(8.0, 8.0, 8.0).at_z(-4.0).minus(Solid::sphere(3.0)))?;
/// let actors = [Actor::new(shell, [90; 3]), Actor::new(CompiledSolid::new(&Solid::sphere(2.0))?, [220, 0, 0])];
/// let whole = View::front(64, 64);
/// let half = whole.clone().cut(Point3::new(0.0, -2.5, 0.0), -Vector3::y());
/// let is_red = |view| render(&actors, view).map(|image| image.pixel(32, 32)).map(|[r, g, _]| r / 2 > g);
/// assert_eq!((is_red(&whole)?, is_red(&half)?), (false, true));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionCut {
    /// Point on the cutting plane, scene frame, mm.
    pub point: Point3<f64>,
    /// Direction into the removed half-space; need not be of unit length.
    pub outward: Vector3<f64>,
}

impl View {
    /// Creates a view along a direction in the scene frame.
    pub fn along(looking: Vector3<f64>, width_px: u32, height_px: u32) -> Self {
        let projection = ViewProjection::Orthographic;
        Self { width_px, height_px, looking, projection, cut: None, margin: 0.05 }
    }

    /// Creates a view from the front (-y), the right (+x) and above, all three equally.
    pub fn isometric(width_px: u32, height_px: u32) -> Self {
        Self::along(Vector3::new(-1.0, 1.0, -1.0), width_px, height_px)
    }

    /// Creates a view from a viewer's direction: azimuth around z from +x towards +y, and elevation over the x-y plane,
    /// degrees. Straight from above or below, y is up.
    ///
    /// ```
    /// use fabkit_depth::View;
    /// use fabkit_geometry::Vector3;
    /// let front = View::from_side(-90.0, 0.0, 80, 60);
    /// assert!((front.looking - Vector3::y()).norm() < 1e-15);
    /// ```
    pub fn from_side(azimuth_deg: f64, elevation_deg: f64, width_px: u32, height_px: u32) -> Self {
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        let (up, out) = elevation_deg.to_radians().sin_cos();
        // The rounded cosine of a right angle is not zero and would decide which way up the image is.
        let out = if out.abs() < 1e-12 { 0.0 } else { out };
        Self::along(Vector3::new(-cos * out, -sin * out, -up), width_px, height_px)
    }

    /// Creates a view from -y: x to the right, z up.
    pub fn front(width_px: u32, height_px: u32) -> Self {
        Self::along(Vector3::y(), width_px, height_px)
    }

    /// Creates a view from above: x to the right, y up.
    ///
    /// ```
    /// use fabkit_depth::{Actor, View, render_with_framing};
    /// use fabkit_geometry::{CompiledSolid, Point3, Solid};
    ///
    /// // Seen from above, +x is on the right, and +y above the middle. Rows of pixels count downwards.
    /// let plate = Actor::new(CompiledSolid::new(&Solid::cuboid(20.0, 10.0, 1.0))?, [200; 3]);
    /// let (_, framing) = render_with_framing(&[plate], &View::top(200, 100), &|_, _| {})?;
    /// let [x_axis, y_axis] = [[9.0, 0.0, 0.5], [0.0, 4.0, 0.5]].map(|at| framing.project(&Point3::from(at)));
    /// assert!(x_axis[0] > 150.0 && y_axis[1] < 25.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn top(width_px: u32, height_px: u32) -> Self {
        Self::along(-Vector3::z(), width_px, height_px)
    }

    /// Creates a view of the remainder of a cut, seen from the cut side, a little from the right and from above.
    pub fn section(
        width_px: u32,
        height_px: u32,
        point: Point3<f64>,
        outward: Vector3<f64>,
    ) -> Self {
        let towards = outward.try_normalize(0.0).unwrap_or_else(|| -Vector3::y());
        let right = Vector3::z().cross(&towards).try_normalize(1e-6).unwrap_or_else(Vector3::x);
        let above = if towards.z.abs() < 0.999 { Vector3::z() } else { -Vector3::y() };
        let looking = -(towards + right * 0.42 + above * 0.45);
        Self::along(looking, width_px, height_px).cut(point, outward)
    }

    /// Removes the half-space beyond the plane through `point`, on the side that `outward` points to.
    #[must_use]
    pub fn cut(mut self, point: Point3<f64>, outward: Vector3<f64>) -> Self {
        self.cut = Some(SectionCut { point, outward });
        self
    }

    /// Sets a perspective projection.
    ///
    /// ```
    /// use fabkit_depth::{Actor, RenderError, View, render};
    /// use fabkit_geometry::{Angle, CompiledSolid, Solid};
    ///
    /// let ball = [Actor::new(CompiledSolid::new(&Solid::sphere(5.0))?, [200; 3])];
    /// let view = |deg| View::front(64, 48).perspective(Angle::from_deg(deg).unwrap());
    /// assert!(render(&ball, &view(25.0)).is_ok());
    /// assert_eq!(render(&ball, &view(150.0)), Err(RenderError::FieldOfView { field_of_view_deg: 150.0 }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn perspective(mut self, field_of_view: Angle) -> Self {
        self.projection = ViewProjection::Perspective { field_of_view };
        self
    }

    /// Checks size, direction, margin, field of view and cut.
    pub(super) fn validate(&self) -> Result<(), RenderError> {
        check_size(self.width_px, self.height_px)?;
        if !is_direction(&self.looking) {
            return Err(RenderError::NoDirection);
        }
        if !(0.0..=0.45).contains(&self.margin) {
            return Err(RenderError::Margin { margin: self.margin });
        }
        if let ViewProjection::Perspective { field_of_view } = self.projection {
            let field_of_view_deg = field_of_view.deg();
            if !(1.0..=120.0).contains(&field_of_view_deg) {
                return Err(RenderError::FieldOfView { field_of_view_deg });
            }
        }
        match &self.cut {
            // The cut's direction must be checked here, since `excess_mm` normalises it.
            Some(cut)
                if !is_direction(&cut.outward) || !cut.point.iter().all(|v| v.is_finite()) =>
            {
                Err(RenderError::BadCut)
            }
            _ => Ok(()),
        }
    }
}

impl SectionCut {
    /// Signed distance of a point into the removed half-space, mm; negative in the part that stays.
    pub(super) fn excess_mm(&self, point: &Point3<f64>) -> f64 {
        (point - self.point).dot(&self.outward.normalize())
    }

    /// Collects the corners of the part of a box that the cut leaves.
    pub(super) fn clip_box(&self, corners: &[Point3<f64>; 8], points: &mut Vec<Point3<f64>>) {
        for (index, corner) in corners.iter().enumerate() {
            let excess = self.excess_mm(corner);
            if excess <= 0.0 {
                points.push(*corner);
            }
            // Indices of corners that share an edge differ in one bit.
            for other in (0..3).map(|axis| index | 1 << axis).filter(|&other| other > index) {
                let other_excess = self.excess_mm(&corners[other]);
                if excess * other_excess < 0.0 {
                    let along = excess / (excess - other_excess);
                    points.push(corner + (corners[other] - corner) * along);
                }
            }
        }
    }
}

/// Returns whether a vector can be normalised without overflow or loss of its direction.
fn is_direction(vector: &Vector3<f64>) -> bool {
    let norm = vector.norm();
    norm.is_finite() && norm > 1e-100
}
