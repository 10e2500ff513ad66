//! Check for constraints that exclude all variants, before anything is built.

use fabkit_text::{NodeReader, Position};

use super::super::{Constraint, Numbers, Plan};

/// Requires that the constraints on parameters leave at least one variant.
pub(super) fn require_a_variant(reading: &mut NodeReader, plan: &Plan, places: &[Position]) {
    let early: Vec<(usize, &Constraint)> =
        plan.constraints.iter().enumerate().filter(|(_, c)| plan.is_early(c)).collect();
    if early.is_empty() {
        return;
    }
    let none = Numbers::new();
    let mut kept = vec![0usize; early.len()];
    let mut nearest: Vec<(f64, String)> = vec![(f64::INFINITY, String::new()); early.len()];
    for number in 0..plan.len() {
        let parameters = plan.constraint_values(&plan.variant(number));
        let mut holds_all = true;
        for (i, (_, constraint)) in early.iter().enumerate() {
            if constraint.violation(&parameters, &none).is_none() {
                kept[i] += 1;
                continue;
            }
            holds_all = false;
            let found = constraint.distance(&parameters);
            if found.0 < nearest[i].0 {
                nearest[i] = found;
            }
        }
        // One variant is enough; all are visited only if every one is excluded.
        if holds_all {
            return;
        }
    }
    // Constraints that exclude every variant by themselves explain more than combinations.
    let alone: Vec<usize> = (0..early.len()).filter(|i| kept[*i] == 0).collect();
    let all = plan.len();
    for i in &alone {
        let (index, constraint) = early[*i];
        let message = format!("`{}` excludes all {all} variants", constraint.text);
        let hint = format!("the nearest to it is {}", nearest[*i].1);
        reading.report_problem(places[index], "constraints", &constraint.text, message, hint);
    }
    if alone.is_empty() {
        let counts =
            early.iter().zip(&kept).map(|((_, c), kept)| format!("`{}` leaves {kept}", c.text));
        let hint = counts.collect::<Vec<_>>().join(", ");
        let message = format!("the constraints together exclude all {all} variants");
        reading.report_problem(places[early[0].0], "constraints", "", message, hint);
    }
}
