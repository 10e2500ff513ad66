//! A camera: a lens behind its interface, with an image size.

use std::ops::Deref;

use nalgebra::{Matrix2x3, Point2, Point3, Vector2};

use crate::error::{InvalidCamera, OutsideDomain, ViolationCollector};
use crate::interface::{DirectionWithJacobians, Interface, MAX_INTERFACE_PARAMETERS, Refraction};
use crate::lens::{Intrinsics, KannalaBrandt, Lens, LensProjection, MAX_COEFFICIENTS};
use crate::view_ray::ViewRay;

/// Largest number of parameters of any camera: intrinsics, coefficients and interface.
pub const MAX_PARAMETERS: usize = 4 + MAX_COEFFICIENTS + MAX_INTERFACE_PARAMETERS;

/// Largest number of pixels of an image.
pub const MAX_PIXELS: u64 = 64_000_000;

/// Camera that is valid by construction, precomputed for projection, and cheap to copy.
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

/// Projected point with its derivatives.
///
/// ```
/// use fabkit_camera::{Camera, Point3};
/// let camera = Camera::equidistant(640, 480, 160f64.to_radians())?;
/// let projection = camera.project_with_jacobians(&Point3::new(0.0, 0.0, 20.0))?;
/// // On the axis, 1 mm aside at a distance of 20 mm is a twentieth of the focal length.
/// let fx_px = camera.lens().intrinsics().fx_px;
/// assert!((projection.by_point[(0, 0)] - fx_px / 20.0).abs() < 1e-12);
/// // Farther away is still on the axis.
/// assert_eq!(projection.by_point[(0, 2)], 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// Column and row, px.
    pub pixel: Point2<f64>,
    /// Derivative of the pixel by the point in the camera frame, px/mm, 2 x 3.
    pub by_point: Matrix2x3<f64>,
    /// Derivative of the pixel by each parameter, px per unit, in the order of [`Camera::parameters`].
    pub by_parameters: ParameterDerivatives,
}

/// Columns of a 2 x N Jacobian, one for each of [`Camera::parameters`], stored without heap allocation.
///
/// ```
/// use fabkit_camera::{Camera, Point3, Vector2};
/// let camera = Camera::equidistant(640, 480, 2.5)?;
/// let by = camera.project_with_jacobians(&Point3::new(3.0, 1.0, 10.0))?.by_parameters;
/// assert_eq!(by.len(), camera.parameter_count());
/// // The third parameter, `cx_px`, moves every pixel by as many columns.
/// assert_eq!(by[2], Vector2::new(1.0, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    /// Creates a camera whose image has `width_px` columns and `height_px` rows.
    ///
    /// # Errors
    /// Reports all of these together: an empty image or one above [`MAX_PIXELS`]; an optical axis more than one image
    /// size outside the image; an interface with impossible values.
    ///
    /// ```
    /// use fabkit_camera::{Camera, FlatInterface, Interface, Intrinsics, KannalaBrandt, Lens};
    /// let intrinsics = Intrinsics { fx_px: 286.0, fy_px: 286.0, cx_px: 3195.0, cy_px: 239.5 };
    /// let lens = Lens::KannalaBrandt(KannalaBrandt::new(intrinsics, [0.0; 4])?);
    /// // A lost decimal point, and a surface behind the lens.
    /// let behind = Interface::Flat(FlatInterface::bare_in_air(-2.0, 1.41));
    /// let wrong = Camera::new(640, 480, lens, behind).unwrap_err();
    /// let fields: Vec<&str> = wrong.violations.iter().map(|violation| violation.field).collect();
    /// assert_eq!(fields, ["interface_distance_mm", "cx_px"]);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    pub fn new(
        width_px: u32,
        height_px: u32,
        lens: Lens,
        interface: Interface,
    ) -> Result<Self, InvalidCamera> {
        let mut rules = check_size_and_interface(width_px, height_px, &interface);
        let Intrinsics { cx_px, cy_px, .. } = lens.intrinsics();
        let (width, height) = (f64::from(width_px), f64::from(height_px));
        if width_px > 0 && height_px > 0 {
            rules.within("cx_px", cx_px, -width, 2.0 * width);
            rules.within("cy_px", cy_px, -height, 2.0 * height);
        }
        rules.finish()?;
        Ok(Self { width_px, height_px, lens, interface, refraction: Refraction::new(&interface) })
    }

    /// Creates the equidistant lens of a data sheet: the distance from the image centre is proportional to the angle.
    ///
    /// `field_of_view_rad` is the full angle of view over the image's *diagonal*, `hypot(width, height)` pixels long,
    /// because makers of small cameras state it there. Real wide-angle lenses are within about a tenth of this model,
    /// which is near enough to start a calibration.
    ///
    /// # Errors
    /// Fails for an image size as in [`Camera::new`], or a field of view outside 0.1 to 2 pi radians.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Point2};
    /// let camera = Camera::equidistant(640, 480, 160f64.to_radians())?;
    /// // From corner to corner, so that a corner of the image is half the angle off the axis.
    /// let corner = camera.unproject(&Point2::new(-0.5, -0.5))?;
    /// assert!((corner.direction.z.acos().to_degrees() - 80.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn equidistant(
        width_px: u32,
        height_px: u32,
        field_of_view_rad: f64,
    ) -> Result<Self, InvalidCamera> {
        Self::from_data_sheet(width_px, height_px, field_of_view_rad, [0.0; 4])
    }

    /// Creates a lens with a field of view and a radial polynomial: radius / focal length = angle x (1 + k0 angle^2 +
    /// k1 angle^4 + ...), where `terms` are the k. See [`Camera::equidistant`] for the field of view.
    ///
    /// # Errors
    /// Fails as [`Camera::equidistant`], or for terms that [`KannalaBrandt::new`] refuses.
    ///
    /// ```
    /// use fabkit_camera::Camera;
    /// // Half the diagonal is 400 px and half the angle 1 rad: 400 = f x 1 x (1 + 0.25).
    /// let camera = Camera::from_data_sheet(640, 480, 2.0, [0.25, 0.0, 0.0, 0.0])?;
    /// assert_eq!(camera.lens().intrinsics().fx_px, 320.0);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    pub fn from_data_sheet(
        width_px: u32,
        height_px: u32,
        field_of_view_rad: f64,
        terms: [f64; 4],
    ) -> Result<Self, InvalidCamera> {
        let mut rules = ViolationCollector::default();
        check_size(&mut rules, width_px, height_px);
        let full_turn = 2.0 * std::f64::consts::PI;
        rules.within("field_of_view_rad", field_of_view_rad, 0.1, full_turn);
        rules.finish()?;
        let (width, height) = (f64::from(width_px), f64::from(height_px));
        // The image's diagonal spans the full angle, half of it on each side of the centre.
        let half_rad = field_of_view_rad / 2.0;
        let square = half_rad * half_rad;
        // Horner's scheme; the factor outside makes the lowest power the square.
        let series = terms.iter().rev().fold(0.0, |sum, term| (sum + term) * square);
        let px_per_rad = width.hypot(height) / 2.0 / (half_rad * (1.0 + series));
        let [cx_px, cy_px] = image_centre_px([width_px, height_px]);
        let intrinsics = Intrinsics { fx_px: px_per_rad, fy_px: px_per_rad, cx_px, cy_px };
        let lens = Lens::KannalaBrandt(KannalaBrandt::new(intrinsics, terms)?);
        Self::new(width_px, height_px, lens, Interface::None)
    }

    /// Number of columns of the image.
    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    /// Number of rows of the image.
    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// Returns the centre of the image, px: centres of pixels have whole coordinates, so it is not half the size.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Point2};
    /// // Between columns 319 and 320, and between rows 239 and 240.
    /// let camera = Camera::equidistant(640, 480, 80f64.to_radians())?;
    /// assert_eq!(camera.image_centre_px(), Point2::new(319.5, 239.5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn image_centre_px(&self) -> Point2<f64> {
        let [x, y] = image_centre_px([self.width_px, self.height_px]);
        Point2::new(x, y)
    }

    /// Lens of the camera.
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// Refracting interface between lens and scene.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// Largest incidence angle that has a pixel, radians; see [`Lens::angle_limit_rad`].
    pub fn angle_limit_rad(&self) -> f64 {
        self.lens.angle_limit_rad()
    }

    /// Returns whether a pixel lies in the image, including the outer half of the outermost pixels.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Point2, Point3};
    /// let camera = Camera::equidistant(640, 480, 80f64.to_radians())?;
    /// assert!(camera.is_in_image(&Point2::new(-0.5, 479.4)));
    /// assert!(!camera.is_in_image(&Point2::new(639.5, 0.0)));
    /// // A pixel is computed beyond the image, too: 45 degrees to the right are 450 px.
    /// let aside = camera.project(&Point3::new(1.0, 0.0, 1.0))?;
    /// assert!((aside.x - 769.5).abs() < 1e-9 && !camera.is_in_image(&aside));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn is_in_image(&self, pixel: &Point2<f64>) -> bool {
        let within = |value: f64, count: u32| value >= -0.5 && value < f64::from(count) - 0.5;
        within(pixel.x, self.width_px) && within(pixel.y, self.height_px)
    }

    /// Computes the pixel of a point behind the interface, inside the image or not.
    ///
    /// # Errors
    /// Fails if the point is in front of the interface, beyond the lens's domain, or not finite.
    #[inline]
    pub fn project(&self, point_in_camera: &Point3<f64>) -> Result<Point2<f64>, OutsideDomain> {
        self.lens.project(&self.refraction.direction_towards(point_in_camera)?)
    }

    /// Computes [`Camera::project`] with derivatives by the point and by every parameter.
    ///
    /// # Errors
    /// Fails as [`Camera::project`].
    pub fn project_with_jacobians(
        &self,
        point_in_camera: &Point3<f64>,
    ) -> Result<Projection, OutsideDomain> {
        let DirectionWithJacobians { direction, by_point, by_parameters: of_interface } =
            self.refraction.differentiate(point_in_camera)?;
        let LensProjection { pixel, by_direction, by_coefficients, normalised } =
            self.lens.differentiate(&direction)?;
        let coefficients = self.lens.coefficients().len();
        let (_, interface_parameters) = self.interface.parameters();
        let count = 4 + coefficients + interface_parameters;

        // Columns 0 to 3 belong to fx, fy, cx and cy: the pixel is linear in them.
        let mut columns = [Vector2::zeros(); MAX_PARAMETERS];
        columns[0].x = normalised.x;
        columns[1].y = normalised.y;
        columns[2].x = 1.0;
        columns[3].y = 1.0;
        columns[4..4 + coefficients].copy_from_slice(&by_coefficients[..coefficients]);
        for (column, by) in columns[4 + coefficients..count].iter_mut().zip(&of_interface) {
            // Interface parameters act on the pixel through the direction in front of the lens.
            *column = by_direction * by;
        }
        let by_parameters = ParameterDerivatives { columns, count };
        Ok(Projection { pixel, by_point: by_direction * by_point, by_parameters })
    }

    /// Computes the ray, in the last medium, of all points that project to a pixel.
    ///
    /// # Errors
    /// Fails if the pixel lies outside the lens's image, or its ray does not meet a flat interface.
    ///
    /// ```
    /// use fabkit_camera::{Camera, OutsideDomain, Point2};
    /// let camera = Camera::equidistant(640, 480, 160f64.to_radians())?;
    /// // 286 px per radian, and no direction is more than pi radians off the axis.
    /// assert!(camera.unproject(&Point2::new(319.5 + 890.0, 239.5)).is_ok());
    /// let beyond = camera.unproject(&Point2::new(319.5 + 910.0, 239.5));
    /// assert!(matches!(beyond, Err(OutsideDomain::Pixel { .. })));
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    #[inline]
    pub fn unproject(&self, pixel: &Point2<f64>) -> Result<ViewRay, OutsideDomain> {
        self.refraction.refract_outward(self.lens.unproject(pixel)?)
    }

    /// Returns the number of parameters of this camera.
    pub fn parameter_count(&self) -> usize {
        4 + self.lens.coefficients().len() + self.interface.parameters().1
    }

    /// Returns the same lens without an interface.
    #[must_use]
    pub fn without_interface(&self) -> Self {
        Self { interface: Interface::None, refraction: Refraction::None, ..*self }
    }

    /// Returns the same lens with [`Interface::FromDrawing`]: the drawing says what stands in front of it.
    #[must_use]
    pub fn with_drawn_interface(&self) -> Self {
        Self { interface: Interface::FromDrawing, ..self.without_interface() }
    }

    /// Returns the camera of a rectangular part of the image, which starts at column and row `first_px` and has
    /// `size_px` pixels. The rays of its pixels are those of the whole camera. Its optical axis may lie anywhere
    /// outside of the part.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Point2};
    /// let camera = Camera::equidistant(640, 480, 2.5)?;
    /// let part = camera.cropped([500, 20], [64, 48])?;
    /// let [whole, own] = [(&camera, [520.0, 30.0]), (&part, [20.0, 10.0])];
    /// let ray = |(camera, [x, y]): (&Camera, [f64; 2])| camera.unproject(&Point2::new(x, y)).unwrap();
    /// assert!((ray(whole).direction - ray(own).direction).norm() < 1e-12);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    ///
    /// # Errors
    /// Fails for an empty part, or for one above [`MAX_PIXELS`].
    pub fn cropped(&self, first_px: [u32; 2], size_px: [u32; 2]) -> Result<Self, InvalidCamera> {
        let [width_px, height_px] = size_px;
        check_size_and_interface(width_px, height_px, &self.interface).finish()?;
        let mut values: Vec<f64> = self.lens.parameters().map(|(_, value)| value).collect();
        // Not through `Camera::new`, which refuses principal points far outside the image.
        values[2] -= f64::from(first_px[0]);
        values[3] -= f64::from(first_px[1]);
        Ok(Self { width_px, height_px, lens: self.lens.with_parameters(&values)?, ..*self })
    }

    /// Returns the same view in another number of pixels, as for a rendered or downscaled image.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Point2};
    /// let camera = Camera::equidistant(640, 480, 2.5)?;
    /// let small = camera.resized([160, 120])?;
    /// // Corners of images stay corners: half a pixel beyond the centres of the outermost pixels.
    /// let ray = |camera: &Camera, [x, y]: [f64; 2]| camera.unproject(&Point2::new(x, y)).unwrap();
    /// let [whole, own] = [ray(&camera, [-0.5, 100.0]), ray(&small, [-0.5, 24.625])];
    /// assert!((whole.direction - own.direction).norm() < 1e-12);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    ///
    /// # Errors
    /// Fails for an image without pixels, or with more than [`MAX_PIXELS`].
    pub fn resized(&self, size_px: [u32; 2]) -> Result<Self, InvalidCamera> {
        let [width_px, height_px] = size_px;
        check_size_and_interface(width_px, height_px, &self.interface).finish()?;
        let by = [
            f64::from(width_px) / f64::from(self.width_px),
            f64::from(height_px) / f64::from(self.height_px),
        ];
        let mut values: Vec<f64> = self.lens.parameters().map(|(_, value)| value).collect();
        for (i, by) in by.into_iter().enumerate() {
            values[i] *= by;
            // The image's corner lies at -0.5, and corners must stay corners.
            values[i + 2] = (values[i + 2] + 0.5) * by - 0.5;
        }
        Ok(Self { width_px, height_px, lens: self.lens.with_parameters(&values)?, ..*self })
    }

    /// Returns names with units, and values, of all parameters that can be calibrated: `fx_px`, `fy_px`, `cx_px`,
    /// `cy_px`, the lens's coefficients, the interface's parameters.
    ///
    /// ```
    /// use fabkit_camera::{Camera, FlatInterface, Interface};
    /// let lens = *Camera::equidistant(640, 480, 2.5)?.lens();
    /// let gel = Interface::Flat(FlatInterface::bare_in_air(5.0, 1.41));
    /// let parameters = Camera::new(640, 480, lens, gel)?.parameters();
    /// let names: Vec<&str> = parameters.iter().map(|(name, _)| *name).collect();
    /// assert_eq!(names[..8], ["fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "k3", "k4"]);
    /// assert_eq!(parameters[8], ("interface_distance_mm", 5.0));
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        let (of_interface, count) = self.interface.parameters();
        self.lens.parameters().chain(of_interface.into_iter().take(count)).collect()
    }

    /// Returns the same kind of camera with other parameter values, in the order of [`Camera::parameters`].
    ///
    /// # Errors
    /// Fails for another number of values, or values that [`Camera::new`] or the lens refuses.
    ///
    /// ```
    /// use fabkit_camera::Camera;
    /// let camera = Camera::equidistant(640, 480, 2.5)?;
    /// let mut values: Vec<f64> = camera.parameters().into_iter().map(|(_, value)| value).collect();
    /// values[2] += 3.0;
    /// assert_eq!(camera.with_parameters(&values)?.lens().intrinsics().cx_px, 322.5);
    /// let too_few = camera.with_parameters(&values[..4]).unwrap_err();
    /// assert_eq!(too_few.to_string(), "number of parameters = 4: this camera has 8");
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    pub fn with_parameters(&self, parameters: &[f64]) -> Result<Self, InvalidCamera> {
        let count = self.parameter_count();
        let mut rules = ViolationCollector::default();
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

/// Checks the conditions of [`Camera::new`] that do not depend on the lens.
pub(crate) fn check_size_and_interface(
    width_px: u32,
    height_px: u32,
    interface: &Interface,
) -> ViolationCollector {
    let mut rules = ViolationCollector::default();
    check_size(&mut rules, width_px, height_px);
    interface.check(&mut rules);
    rules
}

fn check_size(rules: &mut ViolationCollector, width_px: u32, height_px: u32) {
    rules.require(width_px > 0, "width_px", f64::from(width_px), "must be at least 1");
    rules.require(height_px > 0, "height_px", f64::from(height_px), "must be at least 1");
    let pixels = u64::from(width_px) * u64::from(height_px);
    let limit = format!("at most {MAX_PIXELS} pixels are supported");
    rules.require(pixels <= MAX_PIXELS, "width_px x height_px", pixels as f64, limit);
}

/// Returns the centre of an image of a width and height, px: centres of pixels have whole coordinates, so it is not half
/// the size.
///
/// ```
/// assert_eq!(fabkit_camera::image_centre_px([640, 3]), [319.5, 1.0]);
/// ```
pub fn image_centre_px(size_px: [u32; 2]) -> [f64; 2] {
    size_px.map(|px| 0.5 * (f64::from(px) - 1.0))
}
