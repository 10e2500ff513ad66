//! Ball indentation test: Young's modulus of a gel disc from loads and depths.

use fabkit_geometry::Point3;

use crate::{
    BallIndenter, ElasticError, ElasticLayer, ElasticMaterial, FiniteStack, LayeredBody,
    MeshDensity,
};

/// Nodes across the widest contact radius.
const ACROSS: f64 = 24.0;
/// Number of depths at which the law of force and depth is computed.
const STEPS: usize = 8;
/// Depth of the deepest press as a part of the gel's thickness, and of the ball's radius.
const DEEPEST: [f64; 2] = [0.3, 0.6];
/// Assumptions about what is not measured: Poisson's ratio, and whether the gel adheres to its cup's wall. First the
/// nominal pair, then the two that make a gel appear stiffest and softest.
const ASSUMED: [(f64, bool); 3] = [(0.495, true), (0.499, true), (0.49, false)];
/// Standard deviation of reading a calliper by hand, mm; a lower bound of a fit's scatter.
const READING_SIGMA_MM: f64 = 0.02;
/// Number of moduli tried between the softest and the stiffest that the readings permit.
const TRIED: usize = 400;
/// Relative standard deviation above which the modulus counts as unknown: twice it is half of the modulus.
const VAGUE: f64 = 0.25;

/// Measurements of a ball indentation test.
#[derive(Clone, Debug, PartialEq)]
pub struct BallIndentationTest {
    /// Radius of the ball, mm.
    pub ball_radius_mm: f64,
    /// Thickness of the gel, mm.
    pub thickness_mm: f64,
    /// Radius of the gel, mm.
    pub radius_mm: f64,
    /// Loads and gaps.
    pub readings: Vec<IndentationReading>,
}

/// One load and its gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndentationReading {
    /// Load on the gel, N.
    pub force_n: f64,
    /// Any length that shrinks by as much as the ball sinks in, mm.
    pub gap_mm: f64,
}

/// Fitted modulus.
#[derive(Clone, Debug, PartialEq)]
pub struct BallModulus {
    /// Young's modulus at small strain of a neo-Hookean gel, MPa.
    pub young_mpa: f64,
    /// Standard deviation from the scatter of the readings, at least that of reading a calliper, MPa.
    pub sigma_mpa: f64,
    /// Range over the assumptions on Poisson's ratio and the wall, extended by two standard deviations on either side,
    /// MPa.
    pub range_mpa: [f64; 2],
    /// Gap at first touch, mm.
    pub touching_gap_mm: f64,
    /// Depth of each reading below first touch, mm.
    pub depths_mm: Vec<f64>,
    /// Measured less fitted gap of each reading, mm.
    pub residuals_mm: Vec<f64>,
}

/// Errors of fitting a modulus.
///
/// ```
/// use fabkit_elastic::{BallIndentationError, BallIndentationTest, IndentationReading};
///
/// // One weight read three times does not tell a modulus.
/// let readings = vec![IndentationReading { force_n: 0.5, gap_mm: 19.8 }; 3];
/// let test = BallIndentationTest { ball_radius_mm: 3.0, thickness_mm: 10.0, radius_mm: 20.0, readings };
/// assert_eq!(test.fit().unwrap_err(), BallIndentationError::TooFewLoads { different: 1 });
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BallIndentationError {
    /// Fewer than three different loads, or all of similar size.
    #[error(
        "{different} different loads give no modulus: 3 are needed, the heaviest at least twice the lightest"
    )]
    TooFewLoads {
        /// Number of different loads.
        different: usize,
    },
    /// Readings that no modulus explains.
    #[error(
        "no modulus explains these readings: at the heaviest load the ball must be {least_mm:.2} to {most_mm:.2} mm deep; the law holds up to 0.3 of the gel's thickness and 0.6 of the ball's radius"
    )]
    OutsideLaw {
        /// Depth of the shallowest press that is tried, mm.
        least_mm: f64,
        /// Depth of the deepest press that is tried, mm.
        most_mm: f64,
    },
    /// Readings that scatter so widely that nearly any modulus explains them.
    #[error(
        "the readings scatter so far that the modulus of {young_mpa:.4} MPa has a standard deviation of \
         {sigma_mpa:.4} MPa; a quarter of it is the most that is taken"
    )]
    TooMuchScatter {
        /// Best fit, MPa.
        young_mpa: f64,
        /// Its standard deviation, MPa.
        sigma_mpa: f64,
    },
    /// Error of the elastic solver.
    #[error(transparent)]
    Elastic(#[from] ElasticError),
}

/// Law of force and depth for a gel of 1 MPa. Its table holds force to the power of 2/3 divided by depth, which varies
/// little, because a small ball on a thick gel follows Hertz.
struct ForceLaw {
    step_mm: f64,
    /// Values at multiples of `step_mm`, from depth 0 on.
    slopes: Vec<f64>,
}

impl BallIndentationTest {
    /// Fits the modulus, and the gap at which the ball touches.
    ///
    /// The law of force and depth is computed at large strain ([`FiniteStack`]) for the gel's thickness and width,
    /// without friction. It takes seconds.
    ///
    /// ```
    /// use fabkit_elastic::{IndentationReading, BallIndentationTest};
    ///
    /// // A gel so thick that it follows Hertz, of 0.1 MPa.
    /// let force_n = |depth_mm: f64| {
    ///     4.0 / 3.0 * 0.1 / (1.0 - 0.495_f64.powi(2)) * 3.0_f64.sqrt() * depth_mm.powf(1.5)
    /// };
    /// let reading = |depth_mm| IndentationReading { force_n: force_n(depth_mm), gap_mm: 20.0 - depth_mm };
    /// let readings = [0.2, 0.4, 0.6].map(reading).to_vec();
    /// let test = BallIndentationTest { ball_radius_mm: 3.0, thickness_mm: 60.0, radius_mm: 60.0, readings };
    /// let fitted = test.fit()?;
    /// assert!((fitted.young_mpa - 0.1).abs() < 0.003);
    /// assert!((fitted.touching_gap_mm - 20.0).abs() < 0.02);
    /// # Ok::<(), fabkit_elastic::BallIndentationError>(())
    /// ```
    ///
    /// # Errors
    /// Too few loads, readings that no modulus explains or nearly any does, or invalid dimensions.
    pub fn fit(&self) -> Result<BallModulus, BallIndentationError> {
        let mut loads: Vec<f64> = self.readings.iter().map(|reading| reading.force_n).collect();
        loads.sort_by(f64::total_cmp);
        loads.dedup();
        let spread = loads.last().zip(loads.first()).map_or(0.0, |(most, least)| most / least);
        if loads.len() < 3 || spread.is_nan() || spread < 2.0 {
            return Err(BallIndentationError::TooFewLoads { different: loads.len() });
        }
        let mut fits = Vec::new();
        for (poisson, is_held) in ASSUMED {
            let law = self.law(poisson, is_held)?;
            let young_mpa = self.fit_modulus_mpa(&law)?;
            fits.push((law, young_mpa));
        }
        // The first of the assumptions is the nominal one.
        let (law, young_mpa) = &fits[0];
        let (touching_gap_mm, residuals_mm) = self.residuals(law, *young_mpa);
        let sigma_mpa = self.sigma_mpa(law, *young_mpa, &residuals_mm);
        if sigma_mpa > VAGUE * young_mpa {
            return Err(BallIndentationError::TooMuchScatter { young_mpa: *young_mpa, sigma_mpa });
        }
        let ends = fits.iter().map(|(_, young_mpa)| *young_mpa);
        let least = ends.clone().fold(f64::INFINITY, f64::min) - 2.0 * sigma_mpa;
        let most = ends.fold(0.0, f64::max) + 2.0 * sigma_mpa;
        let depth = |reading: &IndentationReading| law.depth_mm(reading.force_n / young_mpa);
        Ok(BallModulus {
            young_mpa: *young_mpa,
            sigma_mpa,
            range_mpa: [least, most],
            touching_gap_mm,
            depths_mm: self.readings.iter().map(depth).collect(),
            residuals_mm,
        })
    }

    /// Depth of the deepest press, mm.
    fn deepest_mm(&self) -> f64 {
        (DEEPEST[0] * self.thickness_mm).min(DEEPEST[1] * self.ball_radius_mm)
    }

    /// Computes the law for a gel of 1 MPa. Its value at depth 0 is Hertz's limit.
    fn law(&self, poisson: f64, is_rim_bonded: bool) -> Result<ForceLaw, ElasticError> {
        let gel =
            ElasticLayer { name: "gel".to_owned(), material: ElasticMaterial::new(1.0, poisson)? };
        let pad = LayeredBody::pad(self.radius_mm, vec![(gel, self.thickness_mm)]);
        let contact_mm = (2.0 * self.ball_radius_mm * self.deepest_mm()).sqrt();
        let division = MeshDensity::around_pole(contact_mm / ACROSS, 2.0 * contact_mm, 0);
        let stack = FiniteStack::new(&LayeredBody { is_rim_bonded, ..pad }, &division)?;
        // The ball starts 1 mm above the gel.
        let above_mm = self.thickness_mm + self.ball_radius_mm + 1.0;
        let ball = BallIndenter::new(Point3::new(0.0, 0.0, above_mm), self.ball_radius_mm)?;
        let step_mm = self.deepest_mm() / STEPS as f64;
        let depths_mm: Vec<f64> = (1..=STEPS).map(|i| i as f64 * step_mm).collect();
        let outcomes = stack.press(&ball, &depths_mm)?;
        // Hertz (Johnson, "Contact Mechanics", 1985, section 4.2): F = 4/3 E / (1 - nu^2) sqrt(R) d^1.5.
        let hertz = 4.0 / 3.0 / (1.0 - poisson * poisson) * self.ball_radius_mm.sqrt();
        let slope = |(outcome, depth_mm): (&crate::PressOutcome, &f64)| {
            (-outcome.force_n.z).powf(2.0 / 3.0) / depth_mm
        };
        let slopes = outcomes.iter().zip(&depths_mm).map(slope);
        Ok(ForceLaw {
            step_mm,
            slopes: std::iter::once(hertz.powf(2.0 / 3.0)).chain(slopes).collect(),
        })
    }

    /// Finds the modulus with the smallest sum of squares, MPa.
    fn fit_modulus_mpa(&self, law: &ForceLaw) -> Result<f64, BallIndentationError> {
        let most_n = self.readings.iter().map(|reading| reading.force_n).fold(0.0, f64::max);
        // The heaviest load presses between a twentieth of the deepest press and all of it.
        let (least_mm, most_mm) = (0.05 * self.deepest_mm(), self.deepest_mm());
        let modulus = |depth_mm: f64| (most_n / law.force_n(depth_mm)).ln();
        let [soft, stiff] = [modulus(most_mm), modulus(least_mm)];
        let squares = |ln_young: f64| {
            self.residuals(law, ln_young.exp()).1.iter().map(|mm| mm * mm).sum::<f64>()
        };
        let at = |i: usize| soft + (stiff - soft) * i as f64 / TRIED as f64;
        let best = (0..=TRIED).min_by(|&a, &b| squares(at(a)).total_cmp(&squares(at(b))));
        let Some(best) = best.filter(|best| (1..TRIED).contains(best)) else {
            return Err(BallIndentationError::OutsideLaw { least_mm, most_mm });
        };
        // Between neighbours there is one minimum: golden-section search.
        let (mut low, mut high) = (at(best - 1), at(best + 1));
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..60 {
            let [a, b] = [high - golden * (high - low), low + golden * (high - low)];
            if squares(a) < squares(b) { high = b } else { low = a }
        }
        Ok(f64::midpoint(low, high).exp())
    }

    /// Returns the gap at first touch and the residual of each reading, mm.
    fn residuals(&self, law: &ForceLaw, young_mpa: f64) -> (f64, Vec<f64>) {
        let depth = |reading: &IndentationReading| law.depth_mm(reading.force_n / young_mpa);
        let touching: Vec<f64> =
            self.readings.iter().map(|reading| reading.gap_mm + depth(reading)).collect();
        let mean_mm = touching.iter().sum::<f64>() / touching.len() as f64;
        (mean_mm, touching.iter().map(|mm| mm - mean_mm).collect())
    }

    /// Standard deviation by ordinary least squares in the modulus and the touching gap, MPa.
    fn sigma_mpa(&self, law: &ForceLaw, young_mpa: f64, residuals_mm: &[f64]) -> f64 {
        let free = self.readings.len() as f64 - 2.0;
        let scatter_mm = (residuals_mm.iter().map(|mm| mm * mm).sum::<f64>() / free).sqrt();
        // Derivative of depth by the logarithm of the modulus, less its mean, which the touching gap absorbs.
        let step = 1e-4_f64;
        let slopes: Vec<f64> = self
            .readings
            .iter()
            .map(|reading| {
                let depth =
                    |sign: f64| law.depth_mm(reading.force_n / young_mpa * (sign * step).exp());
                (depth(1.0) - depth(-1.0)) / (2.0 * step)
            })
            .collect();
        let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
        let lever = slopes.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>().sqrt();
        young_mpa * scatter_mm.max(READING_SIGMA_MM) / lever
    }
}

impl ForceLaw {
    /// Returns the force on a gel of 1 MPa at a depth, N.
    fn force_n(&self, depth_mm: f64) -> f64 {
        let at = (depth_mm / self.step_mm).max(0.0);
        let i = (at as usize).min(self.slopes.len() - 2);
        let share = at - i as f64;
        // Beyond the last depth the last piece is extrapolated: readings there then show as misfits.
        let slope = self.slopes[i] + share * (self.slopes[i + 1] - self.slopes[i]);
        (slope * depth_mm.max(0.0)).powf(1.5)
    }

    /// Finds the depth at which a gel of 1 MPa bears a force, mm.
    fn depth_mm(&self, force_n: f64) -> f64 {
        let mut high = self.step_mm;
        // Brackets the depth, then bisects.
        while self.force_n(high) < force_n {
            high *= 2.0;
        }
        let mut low = 0.0;
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if self.force_n(middle) < force_n { low = middle } else { high = middle }
        }
        f64::midpoint(low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(young_mpa: f64, off_mm: impl Fn(usize) -> f64) -> BallIndentationTest {
        // Depths at large strain for a gel in a cup that holds it, computed on another mesh than the fit's.
        let gel = ElasticLayer {
            name: "gel".to_owned(),
            material: ElasticMaterial::new(young_mpa, 0.495).unwrap(),
        };
        let body = LayeredBody { is_rim_bonded: true, ..LayeredBody::pad(25.0, vec![(gel, 12.0)]) };
        let stack = FiniteStack::new(&body, &MeshDensity::around_pole(0.1, 10.0, 0)).unwrap();
        let ball = BallIndenter::new(Point3::new(0.0, 0.0, 20.0), 6.0).unwrap();
        let depths_mm = [0.7, 1.1, 1.5, 1.9, 2.4];
        let outcomes = stack.press(&ball, &depths_mm).unwrap();
        let reading = |(i, (outcome, depth_mm)): (usize, (&crate::PressOutcome, f64))| {
            IndentationReading { force_n: -outcome.force_n.z, gap_mm: 18.0 - depth_mm + off_mm(i) }
        };
        BallIndentationTest {
            ball_radius_mm: 6.0,
            thickness_mm: 12.0,
            radius_mm: 25.0,
            readings: outcomes.iter().zip(depths_mm).enumerate().map(reading).collect(),
        }
    }

    #[test]
    fn a_modulus_is_found_again_without_knowing_where_the_ball_touches() {
        let fitted = test(0.07, |_| 0.0).fit().unwrap();
        assert!((fitted.young_mpa / 0.07 - 1.0).abs() < 0.005, "{fitted:?}");
        assert!((fitted.touching_gap_mm - 18.0).abs() < 0.01, "{fitted:?}");
        let [least, most] = fitted.range_mpa;
        assert!(least < 0.068 && most > 0.072 && most / least < 1.3, "{fitted:?}");
    }

    #[test]
    fn slips_of_the_calliper_are_within_what_is_said() {
        let exact = test(0.07, |_| 0.0);
        // Errors of a calliper: 0.03 mm each way.
        for signs in [1, 6_u32] {
            let mut off = exact.clone();
            for (i, reading) in off.readings.iter_mut().enumerate() {
                reading.gap_mm += if signs >> (i % 3) & 1 == 0 { 0.03 } else { -0.03 };
            }
            let fitted = off.fit().unwrap();
            let sigmas = (fitted.young_mpa - 0.07) / fitted.sigma_mpa;
            assert!(sigmas.abs() < 3.0, "{signs}: {fitted:?}");
        }
    }

    #[test]
    fn what_gives_no_modulus_is_refused() {
        let mut few = test(0.07, |_| 0.0);
        few.readings.truncate(2);
        assert_eq!(few.fit(), Err(BallIndentationError::TooFewLoads { different: 2 }));
        // A calliper that slips by half a millimetre.
        let mut slipped = test(0.07, |_| 0.0);
        slipped.readings[2].gap_mm += 0.5;
        assert!(
            matches!(slipped.fit(), Err(BallIndentationError::TooMuchScatter { .. })),
            "{:?}",
            slipped.fit()
        );
        // A ball that rises under load.
        let mut upwards = test(0.07, |_| 0.0);
        upwards.readings.iter_mut().for_each(|reading| reading.gap_mm = -reading.gap_mm);
        assert!(matches!(upwards.fit(), Err(BallIndentationError::OutsideLaw { .. })));
    }
}
