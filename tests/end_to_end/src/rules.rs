//! Design rules, for test programs that check many variants of few sensors.

use std::sync::LazyLock;

use fabkit_checks::{CheckReport, Finding, InvalidBody, Memo, Rule, check_rules};
use fabkit_geometry::Sensor;

/// Memo of clean bodies in one test program. Most variants differ in one body, so the rest is not examined again. A
/// test of the rules ensures that findings are the same without it.
static CLEAN: LazyLock<Memo> = LazyLock::new(Memo::default);

/// Applies all rules, see [`fabkit_checks::check`].
///
/// # Errors
/// See there.
pub fn check(sensor: &Sensor) -> Result<CheckReport, InvalidBody> {
    check_rules(sensor, &Rule::ALL, &CLEAN)
}

/// Applies some rules and returns their findings.
///
/// # Errors
/// See [`check`].
pub fn found(sensor: &Sensor, rules: &[Rule]) -> Result<Vec<Finding>, InvalidBody> {
    Ok(check_rules(sensor, rules, &CLEAN)?.findings)
}

/// Applies the rule on motions, see [`fabkit_checks::motions`].
///
/// # Errors
/// See there.
pub fn motions(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    found(sensor, &[Rule::Motion])
}
