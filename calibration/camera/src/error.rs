//! What a camera cannot be, and what it cannot answer.

use std::fmt;

use thiserror::Error;

/// Why a point has no pixel or a pixel no ray.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OutsideDomain {
    /// The direction lies beyond the angle up to which the lens's map can be inverted.
    #[error(
        "{:.3} degrees off the optical axis; the lens model ends at {:.3} degrees",
        angle_rad.to_degrees(),
        limit_rad.to_degrees()
    )]
    Angle {
        /// Angle between the direction in front of the lens and +z.
        angle_rad: f64,
        /// The largest angle that the lens maps.
        limit_rad: f64,
    },
    /// No direction within the lens's domain is seen at this pixel.
    #[error(
        "pixel ({x_px:.3}, {y_px:.3}) lies outside the image of the lens model, which ends at \
         {:.3} degrees",
        limit_rad.to_degrees()
    )]
    Pixel {
        /// Column.
        x_px: f64,
        /// Row.
        y_px: f64,
        /// The largest angle that the lens maps.
        limit_rad: f64,
    },
    /// The point lies on the lens's side of the refractive interface.
    #[error("the point lies {depth_mm:.6} mm in front of the refractive interface, not behind it")]
    BeforeInterface {
        /// Distance to the interface, mm, positive.
        depth_mm: f64,
    },
    /// The pixel's direction runs past the flat interface.
    #[error(
        "the ray meets the flat interface at {:.3} degrees to its normal; it must be below 90",
        angle_rad.to_degrees()
    )]
    MissesInterface {
        /// Angle between the direction in front of the lens and the interface's normal.
        angle_rad: f64,
    },
    /// A coordinate is not finite, or the point is the lens's centre, which is in no direction.
    #[error("the point or pixel is not finite, or the point is the centre of the lens")]
    NoDirection,
}

/// One value that a camera cannot have.
#[derive(Clone, Debug, PartialEq)]
pub struct LensViolation {
    /// The parameter's name, with its unit: `fx_px`.
    pub field: &'static str,
    /// What was given.
    pub value: f64,
    /// What it must fulfil, in words: `must be above 0 and at most 1000000`.
    pub limit: String,
}

impl fmt::Display for LensViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: {}", self.field, readable(self.value), self.limit)
    }
}

/// A number without rows of zeros.
pub(crate) fn readable(value: f64) -> String {
    let plain = value == 0.0 || (1e-6..1e12).contains(&value.abs()) || !value.is_finite();
    if plain { format!("{value}") } else { format!("{value:e}") }
}

/// Everything that is wrong with the parameters of a camera.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", violations.iter().map(LensViolation::to_string).collect::<Vec<_>>().join("; "))]
pub struct InvalidCamera {
    /// At least one.
    pub violations: Vec<LensViolation>,
}

/// Collects violations, so that all are reported at once.
#[derive(Default)]
pub(crate) struct Rules(Vec<LensViolation>);

impl Rules {
    pub(crate) fn require(
        &mut self,
        holds: bool,
        field: &'static str,
        value: f64,
        limit: impl Into<String>,
    ) {
        if !holds {
            self.0.push(LensViolation { field, value, limit: limit.into() });
        }
    }

    /// `above < value <= most`; NaN fulfils nothing.
    pub(crate) fn above(&mut self, field: &'static str, value: f64, above: f64, most: f64) {
        let holds = value > above && value <= most;
        self.require(holds, field, value, format!("must be above {above} and at most {most}"));
    }

    /// `least <= value <= most`; NaN fulfils nothing.
    pub(crate) fn within(&mut self, field: &'static str, value: f64, least: f64, most: f64) {
        let holds = (least..=most).contains(&value);
        self.require(holds, field, value, format!("must be {least} to {most}"));
    }

    pub(crate) fn finish(self) -> Result<(), InvalidCamera> {
        if self.0.is_empty() { Ok(()) } else { Err(InvalidCamera { violations: self.0 }) }
    }
}
