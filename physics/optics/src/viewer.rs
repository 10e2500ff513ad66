//! Camera that looks through a sensor's bodies: maps pixels to paths, and points to pixels.

use fabkit_camera::{Camera, Interface, OutsideDomain, Point2};
use fabkit_geometry::{Point3, Pose, Ray};
use nalgebra::Matrix2x3;

use crate::inverse::{SightLine, SightLineSolver, ViewStacks};
use crate::trace::{LightPath, Refraction, Tracer};

/// Camera at its place; one is needed per thread.
///
/// ```
/// # use fabkit_geometry::{Angle, NominalCamera, Point3, Pose, Sensor};
/// # let nominal = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// use fabkit_camera::{Camera, Point2};
/// use fabkit_optics::{CameraView, OpticalStack, ViewStacks};
///
/// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("air", "Air", "", nominal, []))?);
/// // 90 degrees over a diagonal of 800 px; the camera stands 5 mm below the sensor's origin and looks along +z.
/// let camera = Camera::equidistant(640, 480, 90_f64.to_radians())?;
/// let mut view = CameraView::new(&camera, &Pose::translation(0.0, 0.0, -5.0), &sights);
/// assert_eq!(view.pupil(), Point3::new(0.0, 0.0, -5.0));
/// // 10 mm aside at a distance of 10 mm: the edge of the field, 400 px from the middle.
/// let look = view.project(&Point3::new(8.0, 6.0, 5.0))?;
/// assert!((look.pixel - Point2::new(319.5 + 320.0, 239.5 + 240.0)).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct CameraView<'a> {
    camera: Camera,
    sensor_from_camera: Pose,
    camera_from_sensor: Pose,
    seeker: SightLineSolver<'a>,
    tracer: Tracer<'a>,
}

/// Reason why a point has no pixel.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProjectionError {
    /// No ray leads there: light from the point is totally reflected or bent past the pupil.
    #[error("no light from ({:.3}, {:.3}, {:.3}) mm reaches the pupil", .place_in_sensor.x, .place_in_sensor.y, .place_in_sensor.z)]
    NoLight {
        /// Position of the point, sensor frame, mm.
        place_in_sensor: Point3<f64>,
    },
    /// The lens does not map the direction of the ray.
    #[error(transparent)]
    Lens(#[from] OutsideDomain),
}

/// Pixel of a point, with its ray.
#[derive(Clone, Copy, Debug)]
pub struct PointProjection {
    /// Column and row, px; they may lie outside the image, see [`Camera::is_in_image`].
    pub pixel: Point2<f64>,
    /// Ray to the point, with anything that hides it.
    pub sight: SightLine,
}

impl<'a> CameraView<'a> {
    /// Places a camera among bodies. `camera` must be a lens alone, because the bodies refract its rays.
    pub fn new(camera: &Camera, sensor_from_camera: &Pose, sights: &'a ViewStacks) -> Self {
        debug_assert!(
            matches!(camera.interface(), Interface::None | Interface::FromDrawing),
            "light would be bent twice"
        );
        Self {
            camera: *camera,
            sensor_from_camera: *sensor_from_camera,
            camera_from_sensor: sensor_from_camera.inverse(),
            seeker: sights.sight_line_solver(),
            tracer: Tracer::new(sights.stack()),
        }
    }

    /// Returns the camera, which is its lens alone.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Returns the position of the pupil, sensor frame, mm.
    pub fn pupil(&self) -> Point3<f64> {
        self.sensor_from_camera.point(Point3::origin())
    }

    /// Traces the ray of a pixel.
    ///
    /// # Errors
    /// If the lens does not map the pixel.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, NominalCamera, Placement, Pose, Sensor, Solid};
    /// # let nominal = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// # let lid = Body::bought("lid", "steel", Solid::cylinder(20.0, 1.0).at(0.0, 0.0, 10.0))
    /// #     .placed([Placement::in_place(Assembly::sensor())]);
    /// use fabkit_camera::{Camera, Point2};
    /// use fabkit_optics::{CameraView, OpticalStack, ViewStacks};
    ///
    /// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("box", "A box", "", nominal, [lid]))?);
    /// let camera = Camera::equidistant(640, 480, 90_f64.to_radians())?;
    /// let mut view = CameraView::new(&camera, &Pose::identity(), &sights);
    /// // The middle of 640 x 480 pixels, whose first centre is (0, 0), looks straight at the lid 10 mm away.
    /// let path = view.path(&Point2::new(319.5, 239.5))?;
    /// assert!((path.end_mm - 10.0).abs() < 1e-12);
    /// assert_eq!(sights.stack().name_of(path.end), "lid");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn path(&mut self, pixel: &Point2<f64>) -> Result<LightPath, OutsideDomain> {
        let direction = self.camera.unproject(pixel)?.direction;
        let ray =
            Ray { origin: self.pupil(), direction: self.sensor_from_camera.vector(direction) };
        Ok(self.tracer.follow(&ray))
    }

    /// Returns the start and the points of refraction of the last pixel's ray, sensor frame, mm.
    pub fn corners(&self) -> &[Point3<f64>] {
        self.tracer.corners()
    }

    /// Returns the refractions of the last pixel's ray, sensor frame.
    pub fn bends(&self) -> &[Refraction] {
        self.tracer.bends()
    }

    /// Finds the pixel at which a point is seen, or would be if nothing opaque hid it.
    ///
    /// # Errors
    /// [`ProjectionError`].
    pub fn project(
        &mut self,
        place_in_sensor: &Point3<f64>,
    ) -> Result<PointProjection, ProjectionError> {
        let sight = self.seeker.find_sight_line(&self.pupil(), place_in_sensor);
        let sight = sight.ok_or(ProjectionError::NoLight { place_in_sensor: *place_in_sensor })?;
        let direction = self.camera_from_sensor.vector(sight.direction);
        // Directions are projected like points, since the lens depends on the direction only.
        Ok(PointProjection { pixel: self.camera.project(&Point3::from(direction))?, sight })
    }

    /// Finds all pixels at which a point is seen, or would be if nothing opaque hid it, by increasing path length. See
    /// [`SightLineSolver::find_all_sight_lines`]. Rays that the lens does not map are omitted; the result is empty if no light leads from the
    /// point to the pupil.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity};
    /// # use fabkit_geometry::{Placement, Point3, Pose, Sensor, Solid};
    /// # let nominal = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// # let mut ball = Body::bought("ball", "glass", Solid::sphere(2.0).at(0.0, 0.0, 6.0))
    /// #     .with_clarity(OpticalClarity::Clear)
    /// #     .placed([Placement::in_place(Assembly::sensor())]);
    /// # ball.substance = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
    /// use fabkit_camera::Camera;
    /// use fabkit_optics::{CameraView, OpticalStack, ViewStacks};
    ///
    /// // A point behind a ball of glass appears twice: past the ball on its own side, and through it on the other.
    /// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("ball", "A ball", "", nominal, [ball]))?);
    /// let camera = Camera::equidistant(640, 480, 90_f64.to_radians())?;
    /// let mut view = CameraView::new(&camera, &Pose::identity(), &sights);
    /// let looks = view.project_all(&Point3::new(14.0, 0.0, 30.0));
    /// let is_right = |look: &fabkit_optics::PointProjection| look.pixel.x > 319.5;
    /// assert!(looks.iter().any(is_right) && !looks.iter().all(is_right));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn project_all(&mut self, place_in_sensor: &Point3<f64>) -> Vec<PointProjection> {
        let sights = self.seeker.find_all_sight_lines(&self.pupil(), place_in_sensor);
        let looks = sights.into_iter().filter_map(|sight| {
            let direction = self.camera_from_sensor.vector(sight.direction);
            Some(PointProjection {
                pixel: self.camera.project(&Point3::from(direction)).ok()?,
                sight,
            })
        });
        looks.collect()
    }

    /// Computes the derivative of the pixel by the point, px per mm along the sensor's axes; `None` if the lens has no
    /// derivative, or on a caustic.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, NominalCamera, Point3, Pose, Sensor};
    /// # let nominal = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// use fabkit_camera::Camera;
    /// use fabkit_optics::{CameraView, OpticalStack, ViewStacks};
    ///
    /// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("air", "Air", "", nominal, []))?);
    /// // 2 rad over a diagonal of 800 px: 400 px per radian.
    /// let camera = Camera::equidistant(640, 480, 2.0)?;
    /// let mut view = CameraView::new(&camera, &Pose::identity(), &sights);
    /// let point = Point3::new(0.0, 0.0, 20.0);
    /// let look = view.project(&point)?;
    /// let by_point = view.pixel_by_point(&point, &look).unwrap();
    /// // At 20 mm, a millimetre aside is 1/20 rad, or 20 px; a millimetre away changes nothing.
    /// assert!((by_point[(0, 0)] - 20.0).abs() < 1e-6 && (by_point[(1, 1)] - 20.0).abs() < 1e-6);
    /// assert!(by_point.column(2).norm() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pixel_by_point(
        &mut self,
        place_in_sensor: &Point3<f64>,
        look: &PointProjection,
    ) -> Option<Matrix2x3<f64>> {
        let direction = self.camera_from_sensor.vector(look.sight.direction);
        let lens = self.camera.project_with_jacobians(&Point3::from(direction)).ok()?;
        let by_place =
            self.seeker.direction_by_point(&self.pupil(), place_in_sensor, &look.sight)?;
        let across =
            self.camera_from_sensor.rotation() * SightLine::transverse_axes(&look.sight.direction);
        // Chain rule: pixel by direction, direction by its two components, these by the point.
        Some(lens.by_point * across * by_place)
    }

    /// Returns the corners of the path to a point that was looked at, sensor frame, mm, from the pupil on.
    pub fn path_corners(
        &mut self,
        place_in_sensor: &Point3<f64>,
        look: &PointProjection,
    ) -> Vec<Point3<f64>> {
        self.seeker.corners(&self.pupil(), place_in_sensor, &look.sight)
    }
}
