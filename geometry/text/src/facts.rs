//! Machine-readable part of a problem.

/// Code of a name that no parameter, key or section has.
pub const UNKNOWN_PARAMETER: &str = "unknown_parameter";

/// Machine-readable part of a problem. Values are written with their units.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProblemFacts {
    /// Stable short name of the kind of problem, such as `out_of_range`.
    pub code: &'static str,
    /// Smallest allowed value, if there is one.
    pub at_least: Option<String>,
    /// Largest allowed value, if there is one.
    pub at_most: Option<String>,
    /// Allowed words, if the value is one of a few.
    pub choices: Vec<String>,
    /// Value to write instead, if one is known.
    pub suggestion: Option<Suggestion>,
}

/// Parameter and the value to give it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suggestion {
    /// Dotted path of the parameter.
    pub path: String,
    /// Value as it would be written.
    pub value: String,
}

impl Default for ProblemFacts {
    fn default() -> Self {
        Self::new("invalid")
    }
}

impl ProblemFacts {
    /// Creates facts with nothing but the code.
    pub fn new(code: &'static str) -> Self {
        Self { code, at_least: None, at_most: None, choices: Vec::new(), suggestion: None }
    }

    /// Creates the facts of a limit that several values set together; `offer` is text such as `at most 3 mm`.
    pub(crate) fn from_limit(path: &str, offer: Option<&str>) -> Self {
        let after = |words| offer.and_then(|offer| offer.strip_prefix(words)).map(str::to_owned);
        let (at_least, at_most) = (after("at least "), after("at most "));
        let value = at_least.as_ref().or(at_most.as_ref()).cloned();
        let suggestion = value.map(|value| Suggestion { path: path.into(), value });
        Self { at_least, at_most, suggestion, ..Self::new("limit_broken") }
    }
}

/// Splits a text such as `12.5 mm` into number and unit. The unit of a plain number is empty. Returns `None` for any
/// other text.
///
/// ```
/// use fabkit_text::number_and_unit;
/// assert_eq!(number_and_unit("12.5 mm"), Some((12.5, "mm")));
/// assert_eq!(number_and_unit("1e2"), Some((100.0, "")));
/// assert_eq!(number_and_unit("31 x 24 mm"), None);
/// assert_eq!(number_and_unit("1e999 mm"), None);
/// ```
pub fn number_and_unit(text: &str) -> Option<(f64, &str)> {
    /// Maximum length of a number with its unit, bytes.
    const LONGEST: usize = 60;
    let text = text.trim();
    // `inf` and `nan` would parse as numbers.
    let begins = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
    if !begins || text.len() > LONGEST {
        return None;
    }
    // The longest prefix that is a number wins.
    let ends = text.char_indices().map(|(i, _)| i).chain([text.len()]).rev();
    let (number, unit) = ends.into_iter().find_map(|end| {
        let number = text[..end].trim_end().replace('_', "").parse::<f64>().ok()?;
        Some((number, text[end..].trim()))
    })?;
    let is_unit = |c: char| !c.is_whitespace() && !c.is_ascii_digit() && !"+-.,()[]*".contains(c);
    // Units of area and volume, such as `mm2`.
    let letters = unit.strip_suffix(['2', '3']).unwrap_or(unit);
    (number.is_finite() && letters.chars().all(is_unit)).then_some((number, unit))
}
