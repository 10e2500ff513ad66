//! Young's modulus of a gel batch, fitted to readings of a gel coupon.

use std::fmt::Write as _;

use fabkit_designs::profile::{GelCoupon, GelReading};
pub use fabkit_elastic::BallModulus;
use fabkit_elastic::{BallIndentationError, BallIndentationTest, IndentationReading};
use fabkit_files::{ErrorKind, ErrorSubject, Explained};

/// Standard gravity, m/s2, as used by scales (CGPM, 1901).
const GRAVITY: f64 = 9.806_65;

/// Fits a Young's modulus to the readings of a coupon.
///
/// # Errors
/// Loads that differ too little, or readings that no modulus, or almost any, explains.
pub fn fit_modulus(coupon: &GelCoupon) -> Result<BallModulus, GelError> {
    let reading = |reading: &GelReading| IndentationReading {
        force_n: 1e-3 * reading.load_g * GRAVITY,
        gap_mm: reading.gap_mm,
    };
    let test = BallIndentationTest {
        ball_radius_mm: coupon.ball_mm / 2.0,
        thickness_mm: coupon.thickness_mm,
        radius_mm: coupon.diameter_mm / 2.0,
        readings: coupon.readings.iter().map(reading).collect(),
    };
    Ok(test.fit()?)
}

/// Writes a materials file that changes one modulus: usable as a user's own file or as a section of a sensor file.
///
/// ```
/// use fabkit_application::designs::profile::{GelCoupon, GelReading};
/// use fabkit_application::gel_profile::{BallModulus, to_yaml};
/// # let (material, readings) = ("Smooth-On Ecoflex 00-30".into(), vec![GelReading { load_g: 50.0, gap_mm: 9.0 }]);
/// # let (depths_mm, residuals_mm) = (vec![1.0], vec![0.01]);
/// let coupon = GelCoupon { material, ball_mm: 10.0, thickness_mm: 12.0, diameter_mm: 50.0, readings };
/// let (young_mpa, sigma_mpa, range_mpa) = (0.069, 0.002, [0.06, 0.08]);
/// let modulus = BallModulus { young_mpa, sigma_mpa, range_mpa, touching_gap_mm: 10.0, depths_mm, residuals_mm };
/// // Materials files have kPa.
/// assert!(to_yaml(&coupon, &modulus).contains("youngs_modulus: {value: 69.0 kPa, source: measured"));
/// ```
pub fn to_yaml(coupon: &GelCoupon, modulus: &BallModulus) -> String {
    let kpa = |mpa: f64| format!("{:.1} kPa", 1e3 * mpa);
    let mut yaml = String::from("# How stiff a batch came out, by a ball on a cup of gel.\n");
    // Writing to a String cannot fail.
    for (reading, off_mm) in coupon.readings.iter().zip(&modulus.residuals_mm) {
        let GelReading { load_g, gap_mm } = reading;
        let _ = writeln!(yaml, "#   {load_g} g: gap {gap_mm} mm, {off_mm:+.3} mm off");
    }
    let _ = writeln!(yaml, "#   the ball touched at {:.2} mm (fitted)", modulus.touching_gap_mm);
    let material = serde_json::Value::from(coupon.material.as_str());
    let _ = writeln!(yaml, "format: 1\nmaterials:\n  {material}:");
    let how = format!(
        "ball of {} mm on {} mm of gel, {} loads; neo-Hookean, Poisson's ratio 0.495; sigma {}",
        coupon.ball_mm,
        coupon.thickness_mm,
        coupon.readings.len(),
        kpa(modulus.sigma_mpa)
    );
    let range = "two sigmas beyond what Poisson's ratios of 0.49 to 0.499 and a wall that holds or not change";
    let [least_mpa, most_mpa] = modulus.range_mpa;
    for (key, mpa, note) in [
        ("youngs_modulus", modulus.young_mpa, &*how),
        ("youngs_modulus_least", least_mpa, range),
        ("youngs_modulus_most", most_mpa, range),
    ] {
        let value = kpa(mpa);
        let _ = writeln!(yaml, "    {key}: {{value: {value}, source: measured, note: \"{note}\"}}");
    }
    yaml
}

/// Error of a modulus fit.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct GelError(#[from] BallIndentationError);

impl Explained for GelError {
    fn kind(&self) -> ErrorKind {
        match &self.0 {
            BallIndentationError::TooFewLoads { .. }
            | BallIndentationError::OutsideLaw { .. }
            | BallIndentationError::TooMuchScatter { .. } => ErrorKind::BadInput,
            BallIndentationError::Elastic(_) => ErrorKind::Limit,
        }
    }

    fn hint(&self) -> Option<String> {
        Some(match &self.0 {
            BallIndentationError::TooFewLoads { .. } => "read gaps under more weights".to_owned(),
            BallIndentationError::OutsideLaw { .. } => {
                "is the load in g all that rests on the gel, and does the gap shrink with it? else take \
                 lighter or heavier weights"
                    .to_owned()
            }
            BallIndentationError::TooMuchScatter { .. } => {
                "read the gaps again, and under more weights that differ more".to_owned()
            }
            BallIndentationError::Elastic(_) => return None,
        })
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match &self.0 {
            BallIndentationError::Elastic(_) => "no_contact_solution",
            _ => "no_modulus",
        })
    }
}
