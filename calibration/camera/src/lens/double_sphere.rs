//! Double sphere camera model.

use nalgebra::{Matrix2x3, Vector2, Vector3};

use super::{
    Intrinsics, LensModel, MAX_COEFFICIENTS, Normalised, Projector, array, check, check_limit,
    unified,
};
use crate::error::InvalidCamera;

const NAMES: [&str; 2] = ["xi", "alpha"];

/// Double sphere model: closed forms for both directions, for lenses beyond 180 degrees.
///
/// Usenko, Demmel and Cremers, "The Double Sphere Camera Model", 3DV 2018. With
/// `d1 = |(x, y, z)|`, `z1 = z + xi d1` and `d2 = |(x, y, z1)|` the normalised plane shows
/// `(x, y) / (alpha d2 + (1 - alpha) z1)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleSphere {
    pub(super) intrinsics: Intrinsics,
    /// `xi`, `alpha`.
    coefficients: [f64; 2],
    limit_rad: f64,
    limit_cosine: f64,
}

impl DoubleSphere {
    /// Creates a lens with `-1 < xi < 1` and `0 <= alpha <= 1`; both zero is a pinhole.
    ///
    /// # Errors
    /// Fails for values that are not finite, absurd or outside the model's ranges, naming each.
    ///
    /// ```
    /// use fabkit_camera::{Camera, DoubleSphere, Interface, Intrinsics, Lens, Point3};
    /// let intrinsics = Intrinsics { fx_px: 100.0, fy_px: 100.0, cx_px: 319.5, cy_px: 239.5 };
    /// let lens = Lens::DoubleSphere(DoubleSphere::new(intrinsics, 0.5, 0.0)?);
    /// assert!((lens.angle_limit_rad().to_degrees() - 120.0).abs() < 1e-9);
    /// // With alpha = 0 the radius is sin(theta) / (cos(theta) + xi): 2 at 90 degrees.
    /// let camera = Camera::new(640, 480, lens, Interface::None)?;
    /// assert!((camera.project(&Point3::new(7.0, 0.0, 0.0))?.x - (319.5 + 200.0)).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(intrinsics: Intrinsics, xi: f64, alpha: f64) -> Result<Self, InvalidCamera> {
        let mut rules = check(&intrinsics, &[], &[]);
        rules.require(xi > -1.0 && xi < 1.0, NAMES[0], xi, "must be above -1 and below 1");
        rules.within(NAMES[1], alpha, 0.0, 1.0);
        rules.finish()?;
        // From the second sphere's centre the incidence angle `theta` appears as `t`: sine rule in the triangle of both
        // centres and a point of the first sphere.
        let t = unified::limit_angle(alpha);
        let limit_rad = t + (xi * t.sin()).asin();
        check_limit((NAMES[0], xi), limit_rad)?;
        let coefficients = [xi, alpha];
        Ok(Self { intrinsics, coefficients, limit_rad, limit_cosine: limit_rad.cos() })
    }
}

#[allow(non_upper_case_globals, reason = "models are told apart as kinds are")]
impl LensModel {
    /// Double sphere: 2 coefficients.
    pub const DoubleSphere: Self = Self {
        name: DoubleSphere::NAME,
        family: DoubleSphere::NAME,
        coefficients: &NAMES,
        start_coefficients: &[0.0, 0.55],
    };
}

impl Projector for DoubleSphere {
    const NAME: &'static str = "double-sphere";
    const KALIBR: Option<&'static str> = Some("ds");

    fn from_coefficients(
        intrinsics: Intrinsics,
        coefficients: &[f64],
    ) -> Result<Self, InvalidCamera> {
        let [xi, alpha] = array(coefficients);
        Self::new(intrinsics, xi, alpha)
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
        let [xi, alpha] = self.coefficients;
        let across_squared = direction.xy().norm_squared();
        let z1 = direction.z + xi * direction.norm();
        let d2 = (across_squared + z1 * z1).sqrt();
        direction.xy() / (alpha * d2 + (1.0 - alpha) * z1)
    }

    fn differentiate(&self, direction: &Vector3<f64>) -> Normalised {
        let [xi, alpha] = self.coefficients;
        let across = direction.xy();
        let d1 = direction.norm();
        let z1 = direction.z + xi * d1;
        let d2 = (across.norm_squared() + z1 * z1).sqrt();
        let scale = 1.0 / (alpha * d2 + (1.0 - alpha) * z1);
        let at = across * scale;

        // Quotient rule for `across / denominator`, with the chain through z1 and d2.
        let z1_by_direction = (Vector3::z() + direction * (xi / d1)).transpose();
        let by_z1 = alpha * z1 / d2 + (1.0 - alpha);
        let d2_by_across = Vector3::new(across.x, across.y, 0.0).transpose() / d2;
        let by_direction = Matrix2x3::new(scale, 0.0, 0.0, 0.0, scale, 0.0)
            - at * (z1_by_direction * by_z1 + d2_by_across * alpha) * scale;

        let mut by_coefficients = [Vector2::zeros(); MAX_COEFFICIENTS];
        by_coefficients[0] = at * (-scale * by_z1 * d1);
        by_coefficients[1] = at * (-scale * (d2 - z1));
        Normalised { at, by_direction, by_coefficients }
    }

    fn direction(&self, normalised: &Vector2<f64>) -> Option<Vector3<f64>> {
        let [xi, alpha] = self.coefficients;
        let squared = normalised.norm_squared();
        let height = unified::unprojected_height(alpha, squared)?;
        // Follows the line from the second sphere's centre along (x, y, height) to the first sphere.
        let length_squared = height * height + squared;
        let reach =
            (height * xi + (height * height + (1.0 - xi * xi) * squared).sqrt()) / length_squared;
        Some(Vector3::new(reach * normalised.x, reach * normalised.y, reach * height - xi))
    }
}
