//! Numbers as text.

/// Number of millimetres in a metre.
pub(super) const MM_PER_M: f64 = 1000.0;

/// Formats a number to nine digits, with the fewest characters.
pub(super) fn number(value: f64) -> String {
    // The formatted number always parses; the fallback is unreachable.
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    if rounded == 0.0 { "0".to_owned() } else { rounded.to_string() }
}

pub(super) fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(number).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exact_enough() {
        assert_eq!(numbers([0.0, -0.0, 0.1, 1e-9 / 3.0]), "0 0 0.1 0.000000000333333333");
    }
}
