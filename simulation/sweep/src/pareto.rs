//! Pareto front of variants.

use crate::plan::Direction;

/// Computes the Pareto front: true for each row for which no other row is at least as good in every objective and
/// better in one. Rows with a missing value are not on it.
///
/// Rows are visited from best to worst in the first objective (Kung, Luccio and Preparata, J. ACM 22, 1975), so that
/// each is compared only with the front found so far.
///
/// ```
/// use fabkit_sweep::{Direction::{Max, Min}, pareto_front};
/// let rows = [vec![Some(1.0), Some(5.0)], vec![Some(2.0), Some(9.0)], vec![Some(2.0), Some(5.0)]];
/// // Less of the first, more of the second: the last is beaten by both.
/// assert_eq!(pareto_front(&rows, &[Min, Max]), [true, true, false]);
/// ```
pub fn pareto_front(rows: &[Vec<Option<f64>>], directions: &[Direction]) -> Vec<bool> {
    // Costs: smaller is better.
    let cost = |row: &Vec<Option<f64>>| -> Option<Vec<f64>> {
        let sign = |direction: &Direction| if *direction == Direction::Max { -1.0 } else { 1.0 };
        row.iter().zip(directions).map(|(value, d)| Some((*value)? * sign(d))).collect()
    };
    let mut costs: Vec<(usize, Vec<f64>)> =
        rows.iter().enumerate().filter_map(|(i, row)| Some((i, cost(row)?))).collect();
    let order = |a: &[f64], b: &[f64]| {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    // Ties are broken by the row's index, so that the result is the same in every run.
    costs.sort_by(|a, b| order(&a.1, &b.1).then(a.0.cmp(&b.0)));
    let mut best: Vec<&Vec<f64>> = Vec::new();
    let mut on_front = vec![false; rows.len()];
    for (i, cost) in &costs {
        let beats = |other: &&Vec<f64>| {
            other.iter().zip(cost).all(|(a, b)| a <= b)
                && other.iter().zip(cost).any(|(a, b)| a < b)
        };
        // A later row cannot beat an earlier one, because it is worse in the first objective in which they differ.
        if !directions.is_empty() && !best.iter().any(beats) {
            on_front[*i] = true;
            best.push(cost);
        }
    }
    on_front
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..Default::default() })]
        /// Against the definition, on a coarse grid so that ties abound.
        #[test]
        fn agrees_with_the_definition(values in proptest::collection::vec(proptest::collection::vec(proptest::option::weighted(0.9, 0u8..6), 3), 0..40)) {
            let rows: Vec<Vec<Option<f64>>> =
                values.iter().map(|row| row.iter().map(|v| v.map(f64::from)).collect()).collect();
            let directions = [Direction::Min, Direction::Max, Direction::Min];
            let beats = |a: &[Option<f64>], b: &[Option<f64>]| {
                let better = |i: usize| {
                    let (a, b) = (a[i].unwrap(), b[i].unwrap());
                    if directions[i] == Direction::Max { b.total_cmp(&a) } else { a.total_cmp(&b) }
                };
                (0..3).all(|i| better(i).is_le()) && (0..3).any(|i| better(i).is_lt())
            };
            let whole = |row: &[Option<f64>]| row.iter().all(Option::is_some);
            let expected: Vec<bool> = rows.iter().map(|row| {
                whole(row) && !rows.iter().any(|other| whole(other) && beats(other, row))
            }).collect();
            prop_assert_eq!(pareto_front(&rows, &directions), expected);
        }
    }
}
