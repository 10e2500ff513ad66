//! Design rules, for test programs that check many variants of few sensors.

use std::sync::LazyLock;

use fabkit_checks::{CheckReport, Finding, InvalidBody, Memo, Rule, check_rules};
use fabkit_geometry::Sensor;

/// Memo of clean bodies in one test program. Most variants differ in one body, so the rest is not examined again. A
/// test of the rules ensures that findings are the same without it.
static CLEAN_BODIES: LazyLock<Memo> = LazyLock::new(Memo::default);

/// Applies all rules, see [`fabkit_checks::check`].
///
/// # Errors
/// See there.
pub fn check(sensor: &Sensor) -> Result<CheckReport, InvalidBody> {
    check_rules(sensor, &Rule::ALL, &CLEAN_BODIES)
}

/// Applies some rules and returns their findings.
///
/// # Errors
/// See [`check`].
pub fn find_findings(sensor: &Sensor, rules: &[Rule]) -> Result<Vec<Finding>, InvalidBody> {
    Ok(check_rules(sensor, rules, &CLEAN_BODIES)?.findings)
}

/// Applies the rule on motions, see [`fabkit_checks::check_motions`].
///
/// # Errors
/// See there.
pub fn motions(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    find_findings(sensor, &[Rule::Motion])
}
