//! A lens behind its interface, with an image size.

use std::ops::Deref;

use nalgebra::{Matrix2x3, Point2, Point3, Vector2};

use crate::error::{InvalidCamera, OutsideDomain, Rules};
use crate::interface::{Bent, Interface, MAX_INTERFACE_PARAMETERS, Refraction};
use crate::lens::{Intrinsics, KannalaBrandt, Lens, LensProjection, MAX_COEFFICIENTS};
use crate::view_ray::ViewRay;

/// Most parameters that any camera has: intrinsics, coefficients, interface.
pub const MAX_PARAMETERS: usize = 4 + MAX_COEFFICIENTS + MAX_INTERFACE_PARAMETERS;

/// Largest image, pixels.
pub const MAX_PIXELS: u64 = 64_000_000;

/// A camera: valid by construction, prepared for questions, and cheap to copy.
///
/// ```
/// use std::f64::consts::FRAC_PI_2;
/// use fabkit_camera::{Camera, Point3};
///
/// // 160 degrees over the diagonal of 640 x 480: 286 px per radian.
/// let camera = Camera::equidistant(640, 480, 160f64.to_radians())?;
/// let pixel = camera.project(&Point3::new(10.0, 0.0, 10.0))?;
/// assert!((pixel.x - (319.5 + 400.0 / 80.0 * 45.0)).abs() < 1e-10);
/// assert!((pixel.y - 239.5).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    width_px: u32,
    height_px: u32,
    lens: Lens,
    interface: Interface,
    refraction: Refraction,
}

/// A projected point with its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// Column and row.
    pub pixel: Point2<f64>,
    /// Pixels per mm of the point in the camera frame, 2 x 3.
    pub by_point: Matrix2x3<f64>,
    /// Pixels per unit of each parameter, in the order of [`Camera::parameters`].
    pub by_parameters: ParameterDerivatives,
}

/// The columns of a 2 x N Jacobian, one for each of [`Camera::parameters`]; a slice without a heap.
#[derive(Clone, Copy, Debug)]
pub struct ParameterDerivatives {
    columns: [Vector2<f64>; MAX_PARAMETERS],
    count: usize,
}

impl Deref for ParameterDerivatives {
    type Target = [Vector2<f64>];

    fn deref(&self) -> &Self::Target {
        &self.columns[..self.count]
    }
}

impl Camera {
    /// A camera whose image has `width_px` columns and `height_px` rows.
    ///
    /// # Errors
    /// An empty image or one above [`MAX_PIXELS`]; an optical axis more than an image size outside
    /// the image; an interface that cannot be. All at once.
    pub fn new(
        width_px: u32,
        height_px: u32,
        lens: Lens,
        interface: Interface,
    ) -> Result<Self, InvalidCamera> {
        let mut rules = check_around(width_px, height_px, &interface);
        let Intrinsics { cx_px, cy_px, .. } = lens.intrinsics();
        let (width, height) = (f64::from(width_px), f64::from(height_px));
        if width_px > 0 && height_px > 0 {
            rules.within("cx_px", cx_px, -width, 2.0 * width);
            rules.within("cy_px", cy_px, -height, 2.0 * height);
        }
        rules.finish()?;
        Ok(Self { width_px, height_px, lens, interface, refraction: Refraction::new(&interface) })
    }

    /// The lens that a data sheet promises: pixels from the centre grow with the angle.
    ///
    /// `field_of_view_rad` is the full angle of view over the image's *diagonal*, on which makers
    /// of small cameras state it: it spans `hypot(width, height)` pixels. Real wide-angle lenses
    /// are within about a tenth of it, which is near enough to start a calibration.
    ///
    /// # Errors
    /// An image size as in [`Camera::new`], or a field of view outside 0.1 to 2 pi radians.
    pub fn equidistant(
        width_px: u32,
        height_px: u32,
        field_of_view_rad: f64,
    ) -> Result<Self, InvalidCamera> {
        Self::nominal(width_px, height_px, field_of_view_rad, [0.0; 4])
    }

    /// The same for a lens with a law of its own: the radius over the focal length is the angle times
    /// 1 + k0 angle^2 + k1 angle^4 + ..., and `terms` are these k.
    ///
    /// # Errors
    /// As for [`Camera::equidistant`]; terms that no lens has, as for [`KannalaBrandt::new`].
    pub fn nominal(
        width_px: u32,
        height_px: u32,
        field_of_view_rad: f64,
        terms: [f64; 4],
    ) -> Result<Self, InvalidCamera> {
        let mut rules = Rules::default();
        check_size(&mut rules, width_px, height_px);
        let full_turn = 2.0 * std::f64::consts::PI;
        rules.within("field_of_view_rad", field_of_view_rad, 0.1, full_turn);
        rules.finish()?;
        let (width, height) = (f64::from(width_px), f64::from(height_px));
        let half_rad = field_of_view_rad / 2.0;
        let square = half_rad * half_rad;
        let series = terms.iter().rev().fold(0.0, |sum, term| (sum + term) * square);
        let px_per_rad = width.hypot(height) / 2.0 / (half_rad * (1.0 + series));
        let intrinsics = Intrinsics {
            fx_px: px_per_rad,
            fy_px: px_per_rad,
            cx_px: 0.5 * (width - 1.0),
            cy_px: 0.5 * (height - 1.0),
        };
        let lens = Lens::KannalaBrandt(KannalaBrandt::new(intrinsics, terms)?);
        Self::new(width_px, height_px, lens, Interface::None)
    }

    /// Columns of the image.
    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    /// Rows of the image.
    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// The lens.
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// What stands between lens and scene.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// The largest angle to +z, in front of the lens, that has a pixel; see
    /// [`Lens::angle_limit_rad`].
    pub fn angle_limit_rad(&self) -> f64 {
        self.lens.angle_limit_rad()
    }

    /// Whether a pixel lies in the image, whose outermost pixels reach half a pixel beyond their
    /// centres.
    pub fn sees(&self, pixel: &Point2<f64>) -> bool {
        let within = |value: f64, count: u32| value >= -0.5 && value < f64::from(count) - 0.5;
        within(pixel.x, self.width_px) && within(pixel.y, self.height_px)
    }

    /// The pixel at which a point behind the interface is seen, inside the image or not.
    ///
    /// # Errors
    /// The point is in front of the interface, beyond the lens's domain, or not finite.
    #[inline]
    pub fn project(&self, point_in_camera: &Point3<f64>) -> Result<Point2<f64>, OutsideDomain> {
        self.lens.project(&self.refraction.towards(point_in_camera)?)
    }

    /// [`Camera::project`] with derivatives by the point and by every parameter.
    ///
    /// # Errors
    /// As [`Camera::project`].
    pub fn project_with_jacobians(
        &self,
        point_in_camera: &Point3<f64>,
    ) -> Result<Projection, OutsideDomain> {
        let Bent { direction, by_point, by_parameters: of_interface } =
            self.refraction.differentiate(point_in_camera)?;
        let LensProjection { pixel, by_direction, by_coefficients, normalised } =
            self.lens.differentiate(&direction)?;
        let coefficients = self.lens.coefficients().len();
        let (_, interface_parameters) = self.interface.parameters();
        let count = 4 + coefficients + interface_parameters;

        let mut columns = [Vector2::zeros(); MAX_PARAMETERS];
        columns[0].x = normalised.x;
        columns[1].y = normalised.y;
        columns[2].x = 1.0;
        columns[3].y = 1.0;
        columns[4..4 + coefficients].copy_from_slice(&by_coefficients[..coefficients]);
        for (column, by) in columns[4 + coefficients..count].iter_mut().zip(&of_interface) {
            *column = by_direction * by;
        }
        let by_parameters = ParameterDerivatives { columns, count };
        Ok(Projection { pixel, by_point: by_direction * by_point, by_parameters })
    }

    /// The ray, in the last medium, of all points that are seen at a pixel.
    ///
    /// # Errors
    /// The lens shows nothing at this pixel, or its direction runs past a flat interface.
    #[inline]
    pub fn unproject(&self, pixel: &Point2<f64>) -> Result<ViewRay, OutsideDomain> {
        self.refraction.outward(self.lens.unproject(pixel)?)
    }

    /// How many parameters this camera has.
    pub fn parameter_count(&self) -> usize {
        4 + self.lens.coefficients().len() + self.interface.parameters().1
    }

    /// The same lens with nothing before it.
    #[must_use]
    pub fn in_air(&self) -> Self {
        Self { interface: Interface::None, refraction: Refraction::None, ..*self }
    }

    /// The same lens, said to be known by itself: see [`Interface::Drawn`].
    #[must_use]
    pub fn behind_drawing(&self) -> Self {
        Self { interface: Interface::Drawn, ..self.in_air() }
    }

    /// A part of its picture as the picture of a camera of its own, from a column and a row, px: it sees along the same rays.
    /// Its axis may lie anywhere outside.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Point2};
    /// let camera = Camera::equidistant(640, 480, 2.5)?;
    /// let part = camera.part([500, 20], [64, 48])?;
    /// let [whole, own] = [(&camera, [520.0, 30.0]), (&part, [20.0, 10.0])];
    /// let ray = |(camera, [x, y]): (&Camera, [f64; 2])| camera.unproject(&Point2::new(x, y)).unwrap();
    /// assert!((ray(whole).direction - ray(own).direction).norm() < 1e-12);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    ///
    /// # Errors
    /// An empty part.
    pub fn part(&self, first_px: [u32; 2], size_px: [u32; 2]) -> Result<Self, InvalidCamera> {
        let [width_px, height_px] = size_px;
        check_around(width_px, height_px, &self.interface).finish()?;
        let mut values: Vec<f64> = self.lens.parameters().map(|(_, value)| value).collect();
        values[2] -= f64::from(first_px[0]);
        values[3] -= f64::from(first_px[1]);
        Ok(Self { width_px, height_px, lens: self.lens.with_parameters(&values)?, ..*self })
    }

    /// The same view in another number of pixels: what a simulator renders, or a picture that was shrunk, shows.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Point2};
    /// let camera = Camera::equidistant(640, 480, 2.5)?;
    /// let small = camera.resized([160, 120])?;
    /// // Corners of pictures stay corners: half a pixel beyond the centres of the outermost pixels.
    /// let ray = |camera: &Camera, [x, y]: [f64; 2]| camera.unproject(&Point2::new(x, y)).unwrap();
    /// let [whole, own] = [ray(&camera, [-0.5, 100.0]), ray(&small, [-0.5, 24.625])];
    /// assert!((whole.direction - own.direction).norm() < 1e-12);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    ///
    /// # Errors
    /// A picture without pixels, or with more than cameras have.
    pub fn resized(&self, size_px: [u32; 2]) -> Result<Self, InvalidCamera> {
        let [width_px, height_px] = size_px;
        check_around(width_px, height_px, &self.interface).finish()?;
        let by = [
            f64::from(width_px) / f64::from(self.width_px),
            f64::from(height_px) / f64::from(self.height_px),
        ];
        let mut values: Vec<f64> = self.lens.parameters().map(|(_, value)| value).collect();
        for (i, by) in by.into_iter().enumerate() {
            values[i] *= by;
            values[i + 2] = (values[i + 2] + 0.5) * by - 0.5;
        }
        Ok(Self { width_px, height_px, lens: self.lens.with_parameters(&values)?, ..*self })
    }

    /// Names with units, and values, of everything that can be calibrated: `fx_px`, `fy_px`,
    /// `cx_px`, `cy_px`, the lens's coefficients, the interface's parameters.
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        let (of_interface, count) = self.interface.parameters();
        self.lens.parameters().chain(of_interface.into_iter().take(count)).collect()
    }

    /// The same kind of camera with other numbers, in the order of [`Camera::parameters`].
    ///
    /// # Errors
    /// Another count of numbers, or numbers that no camera has; see [`Camera::new`].
    pub fn with_parameters(&self, parameters: &[f64]) -> Result<Self, InvalidCamera> {
        let count = self.parameter_count();
        let mut rules = Rules::default();
        let given = parameters.len();
        let limit = format!("this camera has {count}");
        rules.require(given == count, "number of parameters", given as f64, limit);
        rules.finish()?;
        let (of_lens, of_interface) = parameters.split_at(4 + self.lens.coefficients().len());
        let lens = self.lens.with_parameters(of_lens)?;
        let interface = self.interface.with_parameters(of_interface);
        Self::new(self.width_px, self.height_px, lens, interface)
    }
}

/// The rules of [`Camera::new`] that do not depend on its lens.
pub(crate) fn check_around(width_px: u32, height_px: u32, interface: &Interface) -> Rules {
    let mut rules = Rules::default();
    check_size(&mut rules, width_px, height_px);
    interface.check(&mut rules);
    rules
}

fn check_size(rules: &mut Rules, width_px: u32, height_px: u32) {
    rules.require(width_px > 0, "width_px", f64::from(width_px), "must be at least 1");
    rules.require(height_px > 0, "height_px", f64::from(height_px), "must be at least 1");
    let pixels = u64::from(width_px) * u64::from(height_px);
    let limit = format!("at most {MAX_PIXELS} pixels are supported");
    rules.require(pixels <= MAX_PIXELS, "width_px x height_px", pixels as f64, limit);
}
