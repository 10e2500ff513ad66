//! The stereographic lens.

use nalgebra::{Matrix2x3, Vector2, Vector3};

use super::{Intrinsics, LensModel, MAX_COEFFICIENTS, Normalised, Projector, check};
use crate::error::InvalidCamera;

/// Projection from the far end of a unit sphere: `(x, y) 2 / (d + z)` with `d` the direction's length. Small
/// circles stay circles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stereographic {
    pub(super) intrinsics: Intrinsics,
}

/// The point behind is infinitely far away.
const LIMIT_RAD: f64 = 3.1;

impl Stereographic {
    /// A lens without coefficients.
    ///
    /// # Errors
    /// Intrinsics that are not finite or absurd, each named.
    pub fn new(intrinsics: Intrinsics) -> Result<Self, InvalidCamera> {
        check(&intrinsics, &[], &[]).finish()?;
        Ok(Self { intrinsics })
    }
}

#[allow(non_upper_case_globals, reason = "models are told apart as kinds are")]
impl LensModel {
    /// The stereographic lens: no coefficients.
    pub const Stereographic: Self =
        Self { name: Stereographic::NAME, of: Stereographic::NAME, coefficients: &[], plain: &[] };
}

impl Projector for Stereographic {
    const NAME: &'static str = "stereographic";

    fn from_coefficients(intrinsics: Intrinsics, _: &[f64]) -> Result<Self, InvalidCamera> {
        Self::new(intrinsics)
    }

    fn names(&self) -> &'static [&'static str] {
        &[]
    }

    fn coefficients(&self) -> &[f64] {
        &[]
    }

    fn limit_rad(&self) -> f64 {
        LIMIT_RAD
    }

    fn contains(&self, direction: &Vector3<f64>) -> bool {
        direction.z > LIMIT_RAD.cos() * direction.norm()
    }

    fn normalise(&self, direction: &Vector3<f64>) -> Vector2<f64> {
        direction.xy() * (2.0 / (direction.norm() + direction.z))
    }

    fn differentiate(&self, direction: &Vector3<f64>) -> Normalised {
        let d = direction.norm();
        let scale = 2.0 / (d + direction.z);
        let at = direction.xy() * scale;
        let by = (direction / d + Vector3::z()).transpose() * (-scale / 2.0);
        let by_direction = Matrix2x3::new(scale, 0.0, 0.0, 0.0, scale, 0.0) + at * by;
        Normalised { at, by_direction, by_coefficients: [Vector2::zeros(); MAX_COEFFICIENTS] }
    }

    fn direction(&self, normalised: &Vector2<f64>) -> Option<Vector3<f64>> {
        Some(Vector3::new(normalised.x, normalised.y, 1.0 - normalised.norm_squared() / 4.0))
    }
}
