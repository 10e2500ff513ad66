//! Findings of `fabkit check` as metrics.

use fabkit_checks::{Memo, Rule, Severity, check_variant};
use fabkit_geometry::Sensor;

use super::ComputedMetrics;

/// Computes the group's metrics.
pub(super) fn compute(sensor: &Sensor, memo: &Memo, computed: &mut ComputedMetrics) {
    let report = match check_variant(sensor, memo) {
        Ok(report) => report,
        Err(invalid) => return computed.notes.push(format!("checks: {invalid}")),
    };
    let severities = [
        ("check_errors", Severity::Error),
        ("check_warnings", Severity::Warning),
        ("check_notes", Severity::Note),
    ];
    for (name, severity) in severities {
        let count = report.findings.iter().filter(|finding| finding.severity == severity).count();
        computed.put(name, count as f64);
    }
    computed.put("overlaps", report.for_rule(Rule::Interference).count() as f64);
    let pulls = report.examined.iter().any(|e| e.rule == Rule::Demolding && e.count > 0);
    if pulls {
        // Each finding of the rule states one of the two, distinguished by its unit.
        let largest = |unit: &str| {
            let measured = report.for_rule(Rule::Demolding).filter_map(|finding| finding.measured);
            measured.filter(|m| m.unit == unit).map(|m| m.value).fold(0.0, f64::max)
        };
        computed.put("undercut_mm2", largest("mm2"));
        computed.put("demolding_strain", largest("strain"));
    }
}
