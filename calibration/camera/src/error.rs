//! Errors of invalid cameras, and of points or pixels outside a camera's domain.

use std::fmt;

use thiserror::Error;

/// Reason why a point has no pixel or a pixel has no ray.
///
/// ```
/// use fabkit_camera::{Camera, Interface, Intrinsics, Lens, OpenCv, OutsideDomain, Point3};
///
/// let intrinsics = Intrinsics { fx_px: 500.0, fy_px: 500.0, cx_px: 319.5, cy_px: 239.5 };
/// let pinhole = Lens::OpenCv(OpenCv::new(intrinsics, &[])?);
/// let camera = Camera::new(640, 480, pinhole, Interface::None)?;
/// // A pinhole sees nothing 90 degrees off its axis.
/// let aside = camera.project(&Point3::new(10.0, 0.0, 0.0)).unwrap_err();
/// assert!(matches!(aside, OutsideDomain::Angle { .. }));
/// assert!(aside.to_string().starts_with("90.000 degrees off the optical axis"));
/// assert_eq!(camera.project(&Point3::origin()), Err(OutsideDomain::NoDirection));
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OutsideDomain {
    /// The direction lies beyond the angle up to which the lens's map can be inverted.
    #[error(
        "{:.3} degrees off the optical axis; the lens model ends at {:.3} degrees",
        angle_rad.to_degrees(),
        limit_rad.to_degrees()
    )]
    Angle {
        /// Incidence angle of the direction, radians.
        angle_rad: f64,
        /// Largest incidence angle that the lens maps, radians.
        limit_rad: f64,
    },
    /// No direction within the lens's domain maps to this pixel.
    #[error(
        "pixel ({x_px:.3}, {y_px:.3}) lies outside the image of the lens model, which ends at \
         {:.3} degrees",
        limit_rad.to_degrees()
    )]
    Pixel {
        /// Column of the pixel.
        x_px: f64,
        /// Row of the pixel.
        y_px: f64,
        /// Largest incidence angle that the lens maps, radians.
        limit_rad: f64,
    },
    /// The point lies on the lens's side of the refractive interface.
    #[error("the point lies {depth_mm:.6} mm in front of the refractive interface, not behind it")]
    BeforeInterface {
        /// Distance to the interface, mm, positive.
        depth_mm: f64,
    },
    /// The ray of the pixel does not meet the flat interface.
    #[error(
        "the ray meets the flat interface at {:.3} degrees to its normal; it must be below 90",
        angle_rad.to_degrees()
    )]
    MissesInterface {
        /// Angle between the direction in front of the lens and the interface's normal.
        angle_rad: f64,
    },
    /// A coordinate is not finite, or the point is the lens's centre, which has no direction.
    #[error("the point or pixel is not finite, or the point is the centre of the lens")]
    NoDirection,
}

/// Single value that a camera cannot have.
///
/// ```
/// use fabkit_camera::Camera;
/// let wrong = Camera::equidistant(0, 480, 2.5).unwrap_err();
/// assert_eq!(wrong.violations[0].field, "width_px");
/// assert_eq!(wrong.violations[0].to_string(), "width_px = 0: must be at least 1");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterViolation {
    /// The parameter's name, with its unit: `fx_px`.
    pub field: &'static str,
    /// Value that was given.
    pub value: f64,
    /// Condition that the value must fulfil, in words: `must be above 0 and at most 1000000`.
    pub limit: String,
}

impl fmt::Display for ParameterViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: {}", self.field, format_number(self.value), self.limit)
    }
}

/// Formats a number in plain digits, or with an exponent if it is below 1e-6 or at least 1e12.
pub(crate) fn format_number(value: f64) -> String {
    let plain = value == 0.0 || (1e-6..1e12).contains(&value.abs()) || !value.is_finite();
    if plain { format!("{value}") } else { format!("{value:e}") }
}

/// All invalid parameters of a camera.
///
/// ```
/// use fabkit_camera::Camera;
/// // Two mistakes: no columns, and a field of view in degrees where radians are meant.
/// let wrong = Camera::equidistant(0, 480, 160.0).unwrap_err();
/// let fields: Vec<&str> = wrong.violations.iter().map(|violation| violation.field).collect();
/// assert_eq!(fields, ["width_px", "field_of_view_rad"]);
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", violations.iter().map(ParameterViolation::to_string).collect::<Vec<_>>().join("; "))]
pub struct InvalidCamera {
    /// Violated conditions, at least one.
    pub violations: Vec<ParameterViolation>,
}

/// Collector of violations, so that all are reported together.
#[derive(Default)]
pub(crate) struct ViolationCollector(Vec<ParameterViolation>);

impl ViolationCollector {
    /// Records a violation unless `holds`.
    pub(crate) fn require(
        &mut self,
        holds: bool,
        field: &'static str,
        value: f64,
        limit: impl Into<String>,
    ) {
        if !holds {
            self.0.push(ParameterViolation { field, value, limit: limit.into() });
        }
    }

    /// Requires `above < value <= most`; NaN fails.
    pub(crate) fn above(&mut self, field: &'static str, value: f64, above: f64, most: f64) {
        let holds = value > above && value <= most;
        self.require(holds, field, value, format!("must be above {above} and at most {most}"));
    }

    /// Requires `least <= value <= most`; NaN fails.
    pub(crate) fn within(&mut self, field: &'static str, value: f64, least: f64, most: f64) {
        let holds = (least..=most).contains(&value);
        self.require(holds, field, value, format!("must be {least} to {most}"));
    }

    pub(crate) fn finish(self) -> Result<(), InvalidCamera> {
        if self.0.is_empty() { Ok(()) } else { Err(InvalidCamera { violations: self.0 }) }
    }
}
