//! From values that keep all rules to the fewest and the least changed of them, in few digits.

use fabkit_text::Kind;

use super::space::{Space, Values};

/// How often what a change may be less is halved.
const HALVINGS: usize = 12;
/// Values are rounded to whole multiples of these, the coarsest that costs little and holds.
const STEPS: [f64; 4] = [0.1, 0.05, 0.01, 0.001];
/// Rounding may move a value by this share of it.
const ROUNDING: f64 = 0.01;

/// Takes back what is not needed, and of the rest as much as can be.
pub(super) fn shrink(space: &mut Space, begin: &Values, found: Values) -> Values {
    let mut values = found;
    let mut changed: Vec<usize> =
        values.keys().copied().filter(|number| !begin.contains_key(number)).collect();
    // What was moved furthest goes back first.
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
        values = less(space, values, number);
    }
    values
}

/// The same with one number as near to what it was as can be, rounded.
fn less(space: &mut Space, values: Values, number: usize) -> Values {
    let found = values[&number];
    let with = |value: f64| {
        let mut values = values.clone();
        values.insert(number, value);
        values
    };
    let is_count = space.numbers[number].kind == Kind::Count;
    let (mut bad, mut good) = (space.numbers[number].value.unwrap_or(found), found);
    for _ in 0..HALVINGS {
        let mut half = 0.5 * (bad + good);
        if is_count {
            half = half.round();
        }
        if half == bad || half == good {
            break;
        }
        if space.outcome(&with(half)).is_clean() { good = half } else { bad = half }
    }
    for value in readable(space, number, good, good >= bad) {
        if space.outcome(&with(value)).is_clean() {
            return with(value);
        }
    }
    with(good)
}

/// Values in few digits beside one that just holds, the shortest first, and of two as short that which
/// changes less: whoever asks tries them.
pub(super) fn readable(space: &Space, number: usize, value: f64, up: bool) -> Vec<f64> {
    let [low, high] = space.numbers[number].range;
    let steps: &[f64] = match space.numbers[number].kind {
        Kind::Count => &[1.0],
        Kind::Angle => &[1.0, 0.5, 0.1, 0.01],
        Kind::Number => &[0.05, 0.01, 0.001, 0.0001],
        _ => &STEPS,
    };
    let last = steps.len() - 1;
    let mut values = Vec::new();
    for (i, step) in steps.iter().enumerate() {
        // Of whole parts: 21.3, not 21.300000000000001.
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
