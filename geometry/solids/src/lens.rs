//! The lens that a camera is designed with: how it lays angles onto the picture, and how well that is known.

/// How far from the picture's middle a lens shows what it sees at an angle off its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// As far as the angle: r = f a.
    #[default]
    Equidistant,
    /// r = 2 f sin(a / 2): equal solid angles get equal areas.
    Equisolid,
    /// r = 2 f tan(a / 2): small circles stay circles.
    Stereographic,
}

impl Projection {
    /// Coefficients k of r / f = a + k0 a^3 + k1 a^5 + k2 a^7 + k3 a^9, the law's own series.
    ///
    /// What is left out is below 1e-5 of the focal length within a radian of the axis.
    pub const fn terms(self) -> [f64; 4] {
        match self {
            Self::Equidistant => [0.0; 4],
            Self::Equisolid => [-1.0 / 24.0, 1.0 / 1920.0, -1.0 / 322_560.0, 1.0 / 92_897_280.0],
            Self::Stereographic => [1.0 / 12.0, 1.0 / 120.0, 17.0 / 20_160.0, 31.0 / 362_880.0],
        }
    }

    /// Distance from the picture's middle over the focal length, for an angle off the axis, rad.
    pub fn radius(self, angle_rad: f64) -> f64 {
        let square = angle_rad * angle_rad;
        let series = self.terms().iter().rev().fold(0.0, |sum, term| (sum + term) * square);
        angle_rad * (1.0 + series)
    }

    /// What a radian off the axis is long along the radius, over the focal length.
    pub fn slope(self, angle_rad: f64) -> f64 {
        let square = angle_rad * angle_rad;
        let [a, b, c, d] = self.terms();
        let rising = [3.0 * a, 5.0 * b, 7.0 * c, 9.0 * d];
        1.0 + rising.iter().rev().fold(0.0, |sum, term| (sum + term) * square)
    }
}

/// How far a bought lens may be from the one that is described.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LensTolerance {
    /// Of the focal length, as a share of it, either way.
    pub focal_share: f64,
    /// Of the axis beside the picture's middle, px.
    pub centre_px: f64,
}

/// The lens of a camera as designed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NominalLens {
    /// Its law.
    pub projection: Projection,
    /// How well it is known; zeros where nobody says.
    pub tolerance: LensTolerance,
    /// What it does to how bright and how sharp pictures are; nothing where nobody says.
    pub imaging: LensImaging,
}

/// What a lens does to pictures beside laying out angles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LensImaging {
    /// Light falls off by the cosine of the angle to its axis, in air, to this power: 4 by the natural law, 0 not at all.
    pub falloff_power: f64,
    /// Diameter of its entrance pupil, mm: focal length over f-number; 0 of a pinhole.
    pub pupil_mm: f64,
    /// Distance in focus from the optical centre along the axis, as in air, mm.
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
