//! `fabkit profile GEL.yaml -o FILE.yaml`: stiffness of a gel batch.

use fabkit_application::designs::profile::GelCoupon;
use fabkit_application::gel_profile::{self, BallModulus};
use serde_json::{Value, json};

use super::Outcome;
use crate::cli::Profile;
use crate::failure::Failure;
use crate::table::{Align::Right, table};

/// Fits the modulus. Returns the materials file and the outcome.
pub(super) fn fit_gel(
    args: &Profile,
    file: &str,
    text: &str,
) -> Result<(String, Outcome), Failure> {
    let coupon = GelCoupon::read(file, text)
        .map_err(|invalid| Failure::invalid(invalid, file.to_owned(), text.to_owned()))?;
    let fitted = gel_profile::fit_modulus(&coupon)?;
    let output = args.output.display().to_string();
    let outcome = Outcome {
        text: text_of(&coupon, &fitted, &output),
        json: json_of(&coupon, &fitted, &output),
        failed: false,
    };
    Ok((gel_profile::to_yaml(&coupon, &fitted), outcome))
}

fn text_of(coupon: &GelCoupon, fitted: &BallModulus, output: &str) -> String {
    let mut rows =
        vec![["load g", "gap mm", "depth mm", "residual mm"].map(str::to_owned).to_vec()];
    for ((reading, depth_mm), off_mm) in
        coupon.readings.iter().zip(&fitted.depths_mm).zip(&fitted.residuals_mm)
    {
        rows.push(vec![
            format!("{}", reading.load_g),
            format!("{:.2}", reading.gap_mm),
            format!("{depth_mm:.2}"),
            format!("{off_mm:+.3}"),
        ]);
    }
    let [least, most] = fitted.range_mpa.map(|mpa| 1e3 * mpa);
    table(&[Right; 4], &rows)
        + &format!(
            "Young's modulus {:.1} +- {:.1} kPa, {least:.1} to {most:.1} kPa with the effects that were not measured\n",
            1e3 * fitted.young_mpa,
            1e3 * fitted.sigma_mpa
        )
        + &format!("{output}: {}; use it with FABKIT_MATERIALS={output}\n", coupon.material)
}

fn json_of(coupon: &GelCoupon, fitted: &BallModulus, output: &str) -> Value {
    json!({
        "format": "fabkit-gel-profile",
        "version": 1,
        "file": output,
        "material": coupon.material,
        "youngs_modulus_mpa": fitted.young_mpa,
        "sigma_mpa": fitted.sigma_mpa,
        "range_mpa": fitted.range_mpa,
        "touching_gap_mm": fitted.touching_gap_mm,
        "depths_mm": fitted.depths_mm,
        "residuals_mm": fitted.residuals_mm,
    })
}
