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
///
/// ```
/// use fabkit_application::designs::profile::{GelCoupon, GelReading};
/// use fabkit_application::gel_profile::{fit_modulus, to_yaml};
///
/// // A ball of 10 mm on 12 mm of gel, under four masses.
/// let readings = [(20.0, 9.47), (50.0, 9.01), (100.0, 8.43), (200.0, 7.51)];
/// let coupon = GelCoupon {
///     material: "Smooth-On Ecoflex 00-30".into(),
///     ball_mm: 10.0,
///     thickness_mm: 12.0,
///     diameter_mm: 50.0,
///     readings: readings.map(|(load_g, gap_mm)| GelReading { load_g, gap_mm }).to_vec(),
/// };
/// let modulus = fit_modulus(&coupon)?;
/// assert!(to_yaml(&coupon, &modulus).contains("youngs_modulus: {value: "));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
