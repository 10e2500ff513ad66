//! Kannala and Brandt's polynomial in the incidence angle.

use std::f64::consts::PI;

use nalgebra::{Matrix2x3, Vector2, Vector3};

use super::{
    Intrinsics, LensModel, MAX_COEFFICIENTS, Normalised, Projector, array, check, check_limit,
};
use crate::error::InvalidCamera;
use crate::roots::{find_increasing_root, first_zero};

const NAMES: [&str; 4] = ["k1", "k2", "k3", "k4"];

/// Kannala-Brandt lens: the distance from the centre of the normalised plane is an odd polynomial in the incidence
/// angle, `r = theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9`.
///
/// Kannala and Brandt, "A generic camera model and calibration method for conventional, wide-angle, and fish-eye
/// lenses", PAMI 2006, radially symmetric part. OpenCV's `fisheye` and Kalibr's `equidistant` are the same polynomial,
/// but both compute the angle from `(x/z, y/z)`, which ends at 90 degrees. Here the polynomial holds wherever it grows,
/// up to 180 degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KannalaBrandt {
    pub(super) intrinsics: Intrinsics,
    k: [f64; 4],
    limit_rad: f64,
    /// Distance from the centre of the normalised plane at the limit.
    limit_radius: f64,
}

impl KannalaBrandt {
    /// Creates a lens with coefficients `k1..k4`; all zero is the equidistant lens.
    ///
    /// # Errors
    /// Fails for values that are not finite or absurd, naming each.
    ///
    /// ```
    /// use fabkit_camera::{Intrinsics, KannalaBrandt, Lens};
    /// let intrinsics = Intrinsics { fx_px: 286.0, fy_px: 286.0, cx_px: 319.5, cy_px: 239.5 };
    /// let limit_rad = |k| -> Result<f64, fabkit_camera::InvalidCamera> {
    ///     Ok(Lens::KannalaBrandt(KannalaBrandt::new(intrinsics, k)?).angle_limit_rad())
    /// };
    /// assert_eq!(limit_rad([0.0; 4])?, std::f64::consts::PI);
    /// // theta - theta^3 / 3 is largest at 1 radian.
    /// assert!((limit_rad([-1.0 / 3.0, 0.0, 0.0, 0.0])? - 1.0).abs() < 1e-9);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    pub fn new(intrinsics: Intrinsics, k: [f64; 4]) -> Result<Self, InvalidCamera> {
        check(&intrinsics, &NAMES, &k).finish()?;
        // The slope is a polynomial in the square of the angle, hence pi squared as the upper end.
        let slope = [1.0, 3.0 * k[0], 5.0 * k[1], 7.0 * k[2], 9.0 * k[3]];
        let limit_rad = first_zero(&slope, PI * PI).map_or(PI, f64::sqrt);
        check_limit((NAMES[0], k[0]), limit_rad)?;
        let mut lens = Self { intrinsics, k, limit_rad, limit_radius: 0.0 };
        lens.limit_radius = lens.radius(limit_rad).0;
        Ok(lens)
    }

    /// Computes the distance from the centre and its derivative by the angle.
    fn radius(&self, theta: f64) -> (f64, f64) {
        let [k1, k2, k3, k4] = self.k;
        let u = theta * theta;
        let radius = theta * (1.0 + u * (k1 + u * (k2 + u * (k3 + u * k4))));
        let slope = 1.0 + u * (3.0 * k1 + u * (5.0 * k2 + u * (7.0 * k3 + u * (9.0 * k4))));
        (radius, slope)
    }
}

#[allow(non_upper_case_globals, reason = "models are told apart as kinds are")]
impl LensModel {
    /// Kannala and Brandt's polynomial in the angle, `k1` to `k4`; OpenCV's `fisheye`.
    pub const KannalaBrandt: Self = Self {
        name: KannalaBrandt::NAME,
        family: KannalaBrandt::NAME,
        coefficients: &NAMES,
        start_coefficients: &[0.0; 4],
    };
}

impl Projector for KannalaBrandt {
    const NAME: &'static str = "kannala-brandt";

    fn from_coefficients(
        intrinsics: Intrinsics,
        coefficients: &[f64],
    ) -> Result<Self, InvalidCamera> {
        Self::new(intrinsics, array(coefficients))
    }

    fn names(&self) -> &'static [&'static str] {
        &NAMES
    }

    fn coefficients(&self) -> &[f64] {
        &self.k
    }

    fn limit_rad(&self) -> f64 {
        self.limit_rad
    }

    fn contains(&self, direction: &Vector3<f64>) -> bool {
        let across = direction.xy().norm();
        // Straight behind the lens there is no azimuth, even if the polynomial reaches 180 degrees.
        across.atan2(direction.z) <= self.limit_rad
            && (across > 0.0 || direction.z > 0.0)
            && across < f64::INFINITY
    }

    fn normalise(&self, direction: &Vector3<f64>) -> Vector2<f64> {
        let across = direction.xy().norm();
        if across == 0.0 {
            return Vector2::zeros();
        }
        direction.xy() * (self.radius(across.atan2(direction.z)).0 / across)
    }

    fn differentiate(&self, direction: &Vector3<f64>) -> Normalised {
        let across = direction.xy().norm();
        let theta = across.atan2(direction.z);
        let (radius, slope) = self.radius(theta);
        let squared = direction.norm_squared();
        // On the axis any azimuth will do: there the stretch is 1/z in both directions.
        let (azimuth, along_azimuth) = if across > 0.0 {
            (direction.xy() / across, radius / across)
        } else {
            (Vector2::x(), 1.0 / direction.z)
        };
        let along_radius = slope * direction.z / squared;
        // Stretch along the radius differs from that along the azimuth.
        let outward = azimuth * azimuth.transpose();
        let mut by_direction = Matrix2x3::zeros();
        by_direction.fixed_columns_mut::<2>(0).copy_from(
            &(nalgebra::Matrix2::identity() * along_azimuth
                + outward * (along_radius - along_azimuth)),
        );
        by_direction.set_column(2, &(azimuth * (-slope * across / squared)));
        let mut by_coefficients = [Vector2::zeros(); MAX_COEFFICIENTS];
        let mut power = theta;
        for by in &mut by_coefficients[..4] {
            power *= theta * theta;
            *by = azimuth * power;
        }
        Normalised { at: azimuth * radius, by_direction, by_coefficients }
    }

    fn direction(&self, normalised: &Vector2<f64>) -> Option<Vector3<f64>> {
        let radius = normalised.norm();
        if radius == 0.0 {
            return Some(Vector3::z());
        }
        if radius > self.limit_radius {
            return None;
        }
        let excess = |theta| {
            let (r, slope) = self.radius(theta);
            (r - radius, slope)
        };
        let theta = find_increasing_root(excess, 0.0, self.limit_rad, radius);
        let (sin, cos) = theta.sin_cos();
        // The result has unit length.
        let across = normalised * (sin / radius);
        Some(Vector3::new(across.x, across.y, cos))
    }
}
