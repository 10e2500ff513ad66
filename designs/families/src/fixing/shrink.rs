//! Minimization of a solution: from values that satisfy all rules to the fewest and smallest changes, in few digits.

use fabkit_text::ValueKind;

use super::space::{Space, Values};

/// Number of bisection steps when a change is reduced.
const HALVINGS: usize = 12;
/// Rounding steps, coarsest first; the coarsest that costs little and satisfies the rules is used.
const STEPS: [f64; 4] = [0.1, 0.05, 0.01, 0.001];
/// Largest relative change of a value by rounding.
const ROUNDING: f64 = 0.01;

/// Undoes the changes that are not needed and reduces the others as far as possible.
pub(super) fn shrink(space: &mut Space, begin: &Values, found: Values) -> Values {
    let mut values = found;
    let mut changed: Vec<usize> =
        values.keys().copied().filter(|number| !begin.contains_key(number)).collect();
    // The largest changes are undone first.
    let moved = |space: &Space, values: &Values, number: usize| {
        let from = space.numbers[number].value.unwrap_or_default();
        (values[&number] - from).abs() / space.scale(number)
    };
    changed.sort_by(|a, b| moved(space, &values, *b).total_cmp(&moved(space, &values, *a)));
    for number in &changed {
        let mut without = values.clone();
        without.remove(number);
        if space.outcome(&without).is_clean() {
            values = without;
        }
    }
    changed.retain(|number| values.contains_key(number));
    for number in changed {
        values = reduce_change(space, values, number);
    }
    values
}

/// Moves one number back towards its original value as far as the rules allow, then rounds it.
fn reduce_change(space: &mut Space, values: Values, number: usize) -> Values {
    let found = values[&number];
    let with = |value: f64| {
        let mut values = values.clone();
        values.insert(number, value);
        values
    };
    let is_count = space.numbers[number].kind == ValueKind::Count;
    let (mut bad, mut good) = (space.numbers[number].value.unwrap_or(found), found);
    for _ in 0..HALVINGS {
        let mut half = 0.5 * (bad + good);
        if is_count {
            half = half.round();
        }
        // Halving ended: counts reach their neighbour, and floats run out of digits.
        if half == bad || half == good {
            break;
        }
        if space.outcome(&with(half)).is_clean() { good = half } else { bad = half }
    }
    // The limiting value has many digits: prefer a rounded one nearby that holds too.
    for value in rounded_candidates(space, number, good, good >= bad) {
        if space.outcome(&with(value)).is_clean() {
            return with(value);
        }
    }
    with(good)
}

/// Returns values in few digits near a limiting value, coarsest first; of two equally coarse ones, the smaller change
/// first. The caller tries them in this order.
pub(super) fn rounded_candidates(space: &Space, number: usize, value: f64, up: bool) -> Vec<f64> {
    let [low, high] = space.numbers[number].range;
    let steps: &[f64] = match space.numbers[number].kind {
        ValueKind::Count => &[1.0],
        ValueKind::Angle => &[1.0, 0.5, 0.1, 0.01],
        ValueKind::Number => &[0.05, 0.01, 0.001, 0.0001],
        _ => &STEPS,
    };
    let last = steps.len() - 1;
    let mut values = Vec::new();
    for (i, step) in steps.iter().enumerate() {
        // Divides by whole numbers instead of multiplying by the step: 21.3, not 21.300000000000001.
        let parts = (1.0 / step).round();
        let both = [(value * parts).floor() / parts, (value * parts).ceil() / parts];
        for rounded in if up { both } else { [both[1], both[0]] } {
            let is_near = i == last || (rounded - value).abs() <= ROUNDING * value.abs();
            if is_near && (low..=high).contains(&rounded) {
                values.push(rounded);
            }
        }
    }
    values
}
