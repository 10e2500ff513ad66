//! The rules, for programs that look at many variants of few sensors.

use std::sync::LazyLock;

use fabkit_checks::{CheckReport, Finding, InvalidBody, Memo, Rule, check_rules};
use fabkit_geometry::Sensor;

/// What the tests of one program found clean: most differ from each other in one body, and look at all the others.
/// Findings are the same without it, which a test of the rules holds.
static CLEAN: LazyLock<Memo> = LazyLock::new(Memo::default);

/// [`fabkit_checks::check`].
///
/// # Errors
/// As there.
pub fn check(sensor: &Sensor) -> Result<CheckReport, InvalidBody> {
    check_rules(sensor, &Rule::ALL, &CLEAN)
}

/// What some of its rules find.
///
/// # Errors
/// As there.
pub fn found(sensor: &Sensor, rules: &[Rule]) -> Result<Vec<Finding>, InvalidBody> {
    Ok(check_rules(sensor, rules, &CLEAN)?.findings)
}

/// [`fabkit_checks::motions`].
///
/// # Errors
/// As there.
pub fn motions(sensor: &Sensor) -> Result<Vec<Finding>, InvalidBody> {
    found(sensor, &[Rule::Motion])
}
