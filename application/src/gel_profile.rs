//! How stiff a batch of gel is, from what was read on its coupon.

use std::fmt::Write as _;

use fabkit_designs::profile::GelCoupon;
use fabkit_elastic::{BallModulus, BallReading, BallTest, BallTestError};

use crate::error::{ErrorKind, Explained};

/// Standard gravity, m/s2, as scales take it (CGPM, 1901).
const GRAVITY: f64 = 9.806_65;

/// A measured batch.
#[derive(Clone, Debug, PartialEq)]
pub struct GelProfile {
    /// What was fitted.
    pub modulus: BallModulus,
}

/// Fits a modulus to a filled-in coupon.
///
/// # Errors
/// Loads that differ too little, readings that no modulus explains.
pub fn gel_profile(coupon: &GelCoupon) -> Result<GelProfile, BallTestError> {
    let reading = |reading: &fabkit_designs::profile::GelReading| BallReading {
        force_n: 1e-3 * reading.load_g * GRAVITY,
        gap_mm: reading.gap_mm,
    };
    let test = BallTest {
        ball_radius_mm: coupon.ball_mm / 2.0,
        thickness_mm: coupon.thickness_mm,
        radius_mm: coupon.diameter_mm / 2.0,
        readings: coupon.readings.iter().map(reading).collect(),
    };
    Ok(GelProfile { modulus: test.fit()? })
}

impl GelProfile {
    /// A file of materials that changes one modulus: for `FABKIT_MATERIALS`, or for a sensor's file.
    pub fn to_yaml(&self, coupon: &GelCoupon) -> String {
        let BallModulus { young_mpa, sigma_mpa, range_mpa, touching_gap_mm, .. } = &self.modulus;
        let kpa = |mpa: f64| format!("{:.1} kPa", 1e3 * mpa);
        let mut yaml = String::from(
            "# How stiff a batch came out. Source of all figures: measured, by a ball on a cup of gel.\n",
        );
        // Writing to a String cannot fail.
        for (reading, off_mm) in coupon.readings.iter().zip(&self.modulus.residuals_mm) {
            let _ = writeln!(
                yaml,
                "#   {} g: gap {} mm, {off_mm:+.3} mm off",
                reading.load_g, reading.gap_mm
            );
        }
        let _ = writeln!(yaml, "#   the ball touched at {touching_gap_mm:.2} mm (fitted)");
        let _ = writeln!(yaml, "format: 1\nmaterials:");
        let _ = writeln!(yaml, "  {}:", serde_json::Value::from(coupon.material.as_str()));
        let note = format!(
            "ball of {} mm on {} mm of gel, {} loads; neo-Hookean, Poisson's ratio 0.495; sigma {}",
            coupon.ball_mm,
            coupon.thickness_mm,
            coupon.readings.len(),
            kpa(*sigma_mpa)
        );
        let others = "two sigmas further than Poisson's ratios of 0.49 to 0.499 and a wall that holds or not";
        let mut line = |key: &str, mpa: f64, note: &str| {
            let value = kpa(mpa);
            let _ =
                writeln!(yaml, "    {key}: {{value: {value}, source: measured, note: \"{note}\"}}");
        };
        line("youngs_modulus", *young_mpa, &note);
        line("youngs_modulus_least", range_mpa[0], others);
        line("youngs_modulus_most", range_mpa[1], others);
        yaml
    }
}

impl Explained for BallTestError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Few { .. } | Self::Outside { .. } => ErrorKind::BadInput,
            Self::Elastic(_) => ErrorKind::Limit,
        }
    }

    fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Few { .. } => "read gaps under more weights".to_owned(),
            Self::Outside { .. } => {
                "is the load in g all that rests on the gel, and does the gap shrink with it? else take \
                 lighter or heavier weights"
                    .to_owned()
            }
            Self::Elastic(_) => return None,
        })
    }
}
