//! The extended unified camera model.

use nalgebra::{Matrix2x3, Vector2, Vector3};

use super::{
    Intrinsics, LensModel, MAX_COEFFICIENTS, Normalised, Projector, array, check, check_limit,
    unified,
};
use crate::error::InvalidCamera;

const NAMES: [&str; 2] = ["alpha", "beta"];

/// Extended unified camera model: projection onto an ellipsoid and from there onto a plane, with closed forms for both
/// directions.
///
/// Khomutenko, Garcia and Martinet, "An Enhanced Unified Camera Model", RA-L 2016: the normalised
/// plane shows `(x, y) / (alpha d + (1 - alpha) z)` with `d^2 = beta (x^2 + y^2) + z^2`. With
/// `beta = 1` it is the unified model (Mei without distortion), `alpha = xi / (1 + xi)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eucm {
    pub(super) intrinsics: Intrinsics,
    /// `alpha`, `beta`.
    coefficients: [f64; 2],
    limit_rad: f64,
    limit_cosine: f64,
}

impl Eucm {
    /// Creates a lens with `0 <= alpha <= 1` and `beta > 0`; `alpha = 0` is a pinhole.
    ///
    /// # Errors
    /// Fails for values that are not finite, absurd or outside the model's ranges, naming each.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Eucm, Interface, Intrinsics, Lens, Point3};
    /// let intrinsics = Intrinsics { fx_px: 100.0, fy_px: 100.0, cx_px: 319.5, cy_px: 239.5 };
    /// // alpha = 1/2 and beta = 1 is the stereographic lens, with the radius 2 tan(theta / 2).
    /// let lens = Lens::Eucm(Eucm::new(intrinsics, 0.5, 1.0)?);
    /// let camera = Camera::new(640, 480, lens, Interface::None)?;
    /// assert!((camera.project(&Point3::new(7.0, 0.0, 0.0))?.x - (319.5 + 200.0)).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(intrinsics: Intrinsics, alpha: f64, beta: f64) -> Result<Self, InvalidCamera> {
        let mut rules = check(&intrinsics, &[], &[]);
        rules.within(NAMES[0], alpha, 0.0, 1.0);
        rules.within(NAMES[1], beta, 1e-3, 1e3);
        rules.finish()?;
        // Stretching x and y by sqrt(beta) makes the ellipsoid a sphere.
        let (sin, cos) = unified::limit_angle(alpha).sin_cos();
        let limit_rad = (sin / beta.sqrt()).atan2(cos);
        check_limit((NAMES[0], alpha), limit_rad)?;
        let coefficients = [alpha, beta];
        Ok(Self { intrinsics, coefficients, limit_rad, limit_cosine: limit_rad.cos() })
    }
}

#[allow(non_upper_case_globals, reason = "models are told apart as kinds are")]
impl LensModel {
    /// Extended unified camera model: 2 coefficients.
    pub const Eucm: Self = Self {
        name: Eucm::NAME,
        family: Eucm::NAME,
        coefficients: &NAMES,
        start_coefficients: &[0.55, 1.0],
    };
}

impl Projector for Eucm {
    const NAME: &'static str = "eucm";
    const KALIBR: Option<&'static str> = Some("eucm");

    fn from_coefficients(
        intrinsics: Intrinsics,
        coefficients: &[f64],
    ) -> Result<Self, InvalidCamera> {
        let [alpha, beta] = array(coefficients);
        Self::new(intrinsics, alpha, beta)
    }

    fn names(&self) -> &'static [&'static str] {
        &NAMES
    }

    fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    fn limit_rad(&self) -> f64 {
        self.limit_rad
    }

    fn contains(&self, direction: &Vector3<f64>) -> bool {
        // At an infinite radius (alpha up to 1/2) the limit itself has no pixel, hence `>` and not `>=`.
        direction.z > self.limit_cosine * direction.norm()
    }

    fn normalise(&self, direction: &Vector3<f64>) -> Vector2<f64> {
        let [alpha, beta] = self.coefficients;
        let d = (beta * direction.xy().norm_squared() + direction.z * direction.z).sqrt();
        direction.xy() / (alpha * d + (1.0 - alpha) * direction.z)
    }

    fn differentiate(&self, direction: &Vector3<f64>) -> Normalised {
        let [alpha, beta] = self.coefficients;
        let across = direction.xy();
        let d = (beta * across.norm_squared() + direction.z * direction.z).sqrt();
        let scale = 1.0 / (alpha * d + (1.0 - alpha) * direction.z);
        let at = across * scale;

        let by_across = across * (alpha * beta / d);
        let by_z = alpha * direction.z / d + (1.0 - alpha);
        // Quotient rule for `across / denominator`.
        let denominator_by_direction = Vector3::new(by_across.x, by_across.y, by_z).transpose();
        let by_direction = Matrix2x3::new(scale, 0.0, 0.0, 0.0, scale, 0.0)
            - at * denominator_by_direction * scale;

        let mut by_coefficients = [Vector2::zeros(); MAX_COEFFICIENTS];
        by_coefficients[0] = at * (-scale * (d - direction.z));
        by_coefficients[1] = at * (-scale * alpha * across.norm_squared() / (2.0 * d));
        Normalised { at, by_direction, by_coefficients }
    }

    fn direction(&self, normalised: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [alpha, beta] = self.coefficients;
        let height = unified::unprojected_height(alpha, beta * normalised.norm_squared())?;
        Some(Vector3::new(normalised.x, normalised.y, height))
    }
}
