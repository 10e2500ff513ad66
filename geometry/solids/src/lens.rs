//! Nominal lens of a camera: projection law, tolerances and effects on brightness and sharpness.

/// Projection law of a lens: distance from the image centre as a function of the angle to the optical axis. In the
/// formulas r is that distance, f the focal length and a the angle, rad.
///
/// ```
/// use fabkit_geometry::Projection;
/// let angle_rad = 40f64.to_radians();
/// assert_eq!(Projection::Equidistant.radius(angle_rad), angle_rad);
/// let [sin, tan] = [20f64.to_radians().sin(), 20f64.to_radians().tan()];
/// assert!((Projection::Equisolid.radius(angle_rad) - 2.0 * sin).abs() < 1e-5);
/// assert!((Projection::Stereographic.radius(angle_rad) - 2.0 * tan).abs() < 1e-5);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// r = f a.
    #[default]
    Equidistant,
    /// r = 2 f sin(a / 2): equal solid angles map to equal areas.
    Equisolid,
    /// r = 2 f tan(a / 2): small circles map to circles.
    Stereographic,
}

impl Projection {
    /// Returns the coefficients k of the power series r / f = a + k0 a^3 + k1 a^5 + k2 a^7 + k3 a^9 of the projection
    /// law.
    ///
    /// The truncation error is below 1e-5 of the focal length within a radian of the axis.
    pub const fn terms(self) -> [f64; 4] {
        match self {
            Self::Equidistant => [0.0; 4],
            Self::Equisolid => [-1.0 / 24.0, 1.0 / 1920.0, -1.0 / 322_560.0, 1.0 / 92_897_280.0],
            Self::Stereographic => [1.0 / 12.0, 1.0 / 120.0, 17.0 / 20_160.0, 31.0 / 362_880.0],
        }
    }

    /// Computes the distance from the image centre, in units of the focal length, for an angle to the optical axis,
    /// rad.
    pub fn radius(self, angle_rad: f64) -> f64 {
        let square = angle_rad * angle_rad;
        let series = self.terms().iter().rev().fold(0.0, |sum, term| (sum + term) * square);
        angle_rad * (1.0 + series)
    }

    /// Computes the derivative of [`Projection::radius`] with respect to the angle, in units of the focal length per
    /// radian.
    pub fn slope(self, angle_rad: f64) -> f64 {
        let square = angle_rad * angle_rad;
        let [a, b, c, d] = self.terms();
        let rising = [3.0 * a, 5.0 * b, 7.0 * c, 9.0 * d];
        1.0 + rising.iter().rev().fold(0.0, |sum, term| (sum + term) * square)
    }
}

/// Tolerances of a bought lens relative to its nominal values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LensTolerance {
    /// Tolerance of the focal length, as a fraction of it, in either direction.
    pub focal_share: f64,
    /// Largest offset of the optical axis from the image centre, px.
    pub centre_px: f64,
}

/// Nominal lens of a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NominalLens {
    /// Projection law.
    pub projection: Projection,
    /// Tolerances; zeros if no source states them.
    pub tolerance: LensTolerance,
    /// Effects on brightness and sharpness; all zero if no source states them.
    pub imaging: LensImaging,
}

/// Effects of a lens on images besides the projection: vignetting and defocus.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LensImaging {
    /// Exponent n of the relative illumination cos^n of the angle to the optical axis, in air: 4 for the natural
    /// (cosine-fourth) law, 0 for no falloff.
    pub falloff_power: f64,
    /// Diameter of the entrance pupil, mm: focal length over f-number; 0 for a pinhole.
    pub pupil_mm: f64,
    /// In-focus distance from the optical centre along the axis, as measured in air, mm.
    pub focus_mm: f64,
}

#[cfg(test)]
mod tests {
    use super::Projection;

    #[test]
    fn series_follow_their_laws() {
        for angle in [0.0, 0.3, 0.7, 1.0] {
            let half: f64 = angle / 2.0;
            assert_eq!(Projection::Equidistant.radius(angle), angle);
            assert!((Projection::Equisolid.radius(angle) - 2.0 * half.sin()).abs() < 1e-9);
            assert!((Projection::Stereographic.radius(angle) - 2.0 * half.tan()).abs() < 1e-5);
            assert!((Projection::Equisolid.slope(angle) - half.cos()).abs() < 1e-8);
            let steeper = 1.0 / (half.cos() * half.cos());
            assert!((Projection::Stereographic.slope(angle) - steeper).abs() < 2e-4);
        }
    }
}
