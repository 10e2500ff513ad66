//! Reasons why a camera does not see a point.

use fabkit_camera::Point2;
use fabkit_geometry::Point3;

use crate::stack::OpticalStack;
use crate::trace::RayEnd;
use crate::viewer::{CameraView, ProjectionError};

/// Label of points outside the image. See [`InvisibleReason::label`].
pub const OUTSIDE_IMAGE: &str = "beside the picture";

/// Label of points whose light is bent away or totally reflected. See [`InvisibleReason::label`].
pub const REFRACTION: &str = "refraction";

/// Distance from a point at which the end of a ray counts as reaching it, mm.
const END_TOLERANCE_MM: f64 = 1e-6;

/// Reason why a point is not seen.
///
/// ```
/// use fabkit_optics::{InvisibleReason, RayEnd};
///
/// // A body hides a point; light that never comes near it was bent away.
/// assert_eq!(InvisibleReason::from_end(RayEnd::Body(3)), InvisibleReason::Hidden(3));
/// assert_eq!(InvisibleReason::from_end(RayEnd::TotalReflection(3)), InvisibleReason::Refraction);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InvisibleReason {
    /// A body hides it; index into the names of the stack.
    Hidden(u8),
    /// Its light is bent away or totally reflected.
    Refraction,
    /// Its light enters the lens, but arrives outside the image.
    OutsideImage,
}

impl InvisibleReason {
    /// Returns the reason that corresponds to the end of a ray.
    pub fn from_end(end: RayEnd) -> Self {
        match end {
            RayEnd::Body(name) => Self::Hidden(name),
            RayEnd::Surface | RayEnd::TotalReflection(_) | RayEnd::Nothing => Self::Refraction,
        }
    }

    /// Returns the name of the hiding body, or [`REFRACTION`], or [`OUTSIDE_IMAGE`].
    pub fn label(self, stack: &OpticalStack) -> &str {
        match self {
            Self::Hidden(name) => stack.name_of(RayEnd::Body(name)),
            Self::Refraction => REFRACTION,
            Self::OutsideImage => OUTSIDE_IMAGE,
        }
    }
}

impl CameraView<'_> {
    /// Returns the pixel of a visible point, sensor frame, mm.
    ///
    /// # Errors
    /// The reason why it is not seen.
    ///
    /// ```
    /// # use fabkit_geometry::{Angle, Assembly, Body, NominalCamera, Placement, Point3, Pose, Sensor, Solid};
    /// # let nominal = NominalCamera {
    /// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
    /// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
    /// # };
    /// # let lid = Body::bought("lid", "steel", Solid::cylinder(20.0, 1.0).at(0.0, 0.0, 10.0))
    /// #     .placed([Placement::in_place(Assembly::sensor())]);
    /// use fabkit_camera::Camera;
    /// use fabkit_optics::{CameraView, InvisibleReason, OpticalStack, ViewStacks};
    ///
    /// // A lid at z = 10 mm, and a camera that sees up to 45 degrees from its axis.
    /// let sights = ViewStacks::new(OpticalStack::from_sensor(&Sensor::new("box", "A box", "", nominal, [lid]))?);
    /// let camera = Camera::equidistant(640, 480, 90_f64.to_radians())?;
    /// let mut view = CameraView::new(&camera, &Pose::identity(), &sights);
    /// assert!(view.visible_pixel(&Point3::new(0.0, 0.0, 9.0)).is_ok());
    /// let hidden = view.visible_pixel(&Point3::new(0.0, 0.0, 15.0)).unwrap_err();
    /// assert_eq!((hidden, hidden.label(sights.stack())), (InvisibleReason::Hidden(0), "lid"));
    /// let beside = view.visible_pixel(&Point3::new(15.0, 0.0, 5.0)).unwrap_err();
    /// assert_eq!(beside, InvisibleReason::OutsideImage);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn visible_pixel(
        &mut self,
        place_in_sensor: &Point3<f64>,
    ) -> Result<Point2<f64>, InvisibleReason> {
        match self.project(place_in_sensor) {
            Err(ProjectionError::NoLight { .. }) => Err(InvisibleReason::Refraction),
            Err(ProjectionError::Lens(_)) => Err(InvisibleReason::OutsideImage),
            Ok(look) if !self.camera().is_in_image(&look.pixel) => {
                Err(InvisibleReason::OutsideImage)
            }
            Ok(look) => look
                .sight
                .hidden_by(END_TOLERANCE_MM)
                .map_or(Ok(look.pixel), |by| Err(InvisibleReason::from_end(by))),
        }
    }
}

/// Describes shares of invisible points by [`InvisibleReason::label`]: `27 % lies beside the image, diffuser hides 3 %`.
///
/// ```
/// let lost = [("refraction".to_owned(), 0.25), ("lid".to_owned(), 0.041)];
/// assert_eq!(fabkit_optics::describe_losses(&lost, 0), "25 % is bent or reflected away, lid hides 4 %");
/// ```
pub fn describe_losses(lost: &[(String, f64)], digits: usize) -> String {
    let part = |(by, share): &(String, f64)| {
        let percent = 100.0 * share;
        match by.as_str() {
            OUTSIDE_IMAGE => format!("{percent:.digits$} % lies beside the image"),
            REFRACTION => format!("{percent:.digits$} % is bent or reflected away"),
            body => format!("{body} hides {percent:.digits$} %"),
        }
    };
    lost.iter().map(part).collect::<Vec<_>>().join(", ")
}
