//! Quantities of materials and processes with their units, and how they are read and written.

use std::fmt;
use std::ops::RangeInclusive;

use fabkit_text::{Json, Refusal, Scalar, ValueKind, to_printable};

/// Splits a text into a number and its unit.
pub(crate) fn split_number(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | '_');
    let mut end = text.find(|c| !is_number(c)).unwrap_or(text.len());
    // An exponent, as in `1e3 kg/m3`.
    let exponent = text[end..].strip_prefix(['e', 'E']);
    if let Some(digits) = exponent.filter(|rest| rest.starts_with(is_number)) {
        let length = digits.find(|c| !is_number(c)).unwrap_or(digits.len());
        end += 1 + length;
    }
    let number = text[..end].replace('_', "").parse::<f64>().ok()?;
    Some((number, text[end..].trim()))
}

/// Parses a number with one of `units`, each given with its size in the first one.
fn parse(text: &str, units: &[(&str, f64)], example: &str) -> Result<f64, Refusal> {
    let refuse = |says: &str, hint: String| Err(Refusal::new(says, &hint));
    let known: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
    let write =
        || format!("write a number and one of {}, for example `{example}`", known.join(", "));
    // `nan` and `inf` get a message of their own.
    let lower = text.trim().to_lowercase();
    if lower.trim_start_matches(['+', '-', '.']).starts_with("nan") || lower.contains("inf") {
        return refuse("is not finite", write());
    }
    let Some((number, unit)) = split_number(text) else {
        return refuse("is not a number with a unit", write());
    };
    if unit.is_empty() {
        let hint = format!("write `{} {}`", to_printable(text.trim()), known[0]);
        return refuse("has no unit", hint);
    }
    let Some((_, size)) = units.iter().find(|(known, _)| *known == unit) else {
        return refuse(&format!("is in `{}`, which does not fit", to_printable(unit)), write());
    };
    match number * size {
        value if value.is_finite() => Ok(value),
        _ => refuse("is not finite", write()),
    }
}

/// Declares quantities: documentation, name, example, and units with their sizes in the first one.
macro_rules! quantities {
    ($($(#[doc = $doc:literal])+ $name:ident $example:literal [$($unit:literal = $size:expr),+];)+) => {$(
        $(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl $name {
            const UNITS: &'static [(&'static str, f64)] = &[$(($unit, $size)),+];

            fn with_unit(number: f64) -> String {
                // Adding zero turns `-0` into `0`.
                format!("{} {}", number + 0.0, Self::UNITS[0].0)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&Self::with_unit(self.0))
            }
        }

        impl Scalar for $name {
            // Kept as text: expressions only support lengths, angles and plain numbers.
            const KIND: ValueKind = ValueKind::Text;
            type Limits = RangeInclusive<f64>;

            fn parse(text: &str) -> Result<Self, Refusal> {
                parse(text, Self::UNITS, $example).map(Self)
            }

            fn is_within(&self, limits: &Self::Limits) -> bool {
                limits.contains(&self.0)
            }

            fn nearest(&self, limits: &Self::Limits) -> Option<Self> {
                Some(Self(self.0.max(*limits.start()).min(*limits.end())))
            }

            fn show(&self) -> String {
                self.to_string()
            }

            fn allowed(limits: &Self::Limits) -> String {
                let [low, high] = [limits.start(), limits.end()].map(|l| Self::with_unit(*l));
                format!("{low} to {high}")
            }

            fn must_be(limits: &Self::Limits) -> String {
                let [low, high] = [limits.start(), limits.end()].map(|l| Self::with_unit(*l));
                format!("between {low} and {high}")
            }

            fn schema(_: &Self::Limits) -> Json {
                let units: Vec<String> = Self::UNITS.iter().map(|(unit, _)| escaped(unit)).collect();
                let pattern = format!("^{NUMBER} *({})$", units.join("|"));
                Json::from_iter([("type", "string"), ("pattern", &pattern)])
            }
        }
    )+};
}

/// Regular expression for a number before its unit.
const NUMBER: &str = r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?";

fn escaped(unit: &str) -> String {
    unit.replace('.', r"\.").replace('$', r"\$")
}

quantities! {
    /// Density, g/cm^3.
    Density "1.07 g/cm3" ["g/cm3" = 1.0, "g/cm^3" = 1.0, "g/ml" = 1.0, "g/mL" = 1.0, "kg/m3" = 1e-3, "kg/m^3" = 1e-3];
    /// Curing time, h.
    Hours "24 h" ["h" = 1.0, "min" = 1.0 / 60.0, "d" = 24.0];
    /// Working time, min.
    Minutes "45 min" ["min" = 1.0, "h" = 60.0, "s" = 1.0 / 60.0];
    /// Temperature, degrees Celsius.
    Celsius "23 C" ["C" = 1.0, "°C" = 1.0, "degC" = 1.0];
    /// Share, percent.
    Percent "0.1 %" ["%" = 1.0];
    /// Viscosity, Pa s.
    Viscosity "3 Pa s" ["Pa s" = 1.0, "mPa s" = 1e-3, "cP" = 1e-3, "P" = 0.1];
    /// Force, N.
    Force "10 N" ["N" = 1.0, "mN" = 1e-3, "kN" = 1e3];
    /// Mass, g.
    Mass "120 g" ["g" = 1.0, "kg" = 1e3, "mg" = 1e-3];
    /// Stress, kPa.
    Pressure "69 kPa" ["kPa" = 1.0, "MPa" = 1e3, "Pa" = 1e-3, "psi" = 6.894_757_293_168_361];
    /// Price, EUR.
    Euros "12 EUR" ["EUR" = 1.0, "€" = 1.0, "ct" = 0.01];
    /// Price by mass, USD/kg.
    PriceByMass "25 USD/kg" ["USD/kg" = 1.0, "$/kg" = 1.0];
    /// Voltage, V.
    Voltage "2.9 V" ["V" = 1.0, "mV" = 1e-3];
    /// Current, mA.
    Current "20 mA" ["mA" = 1.0, "A" = 1e3];
    /// Wavelength of light, nm.
    Wavelength "365 nm" ["nm" = 1.0];
    /// Scattering coefficient, 1/mm.
    Scattering "0.14 /mm" ["/mm" = 1.0, "1/mm" = 1.0, "/cm" = 0.1, "1/cm" = 0.1];
    /// Colour temperature of white light, K.
    Kelvin "4000 K" ["K" = 1.0];
}

impl Percent {
    /// Returns the value as a fraction of 1.
    pub fn share(self) -> f64 {
        self.0 / 100.0
    }
}

/// Diffuse reflectance for red, green and blue light, percent.
///
/// ```
/// use fabkit_designs::materials::Reflectance;
/// use fabkit_designs::parameters::Scalar;
/// let read = |text| Reflectance::parse(text).map_err(|refusal| refusal.says);
/// assert_eq!(read("85 %")?, Reflectance([85.0; 3]));
/// assert_eq!(read("60 %, 20 %, 10 %")?.to_string(), "60 %, 20 %, 10 %");
/// assert!(read("60 %, 20 %").is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflectance(pub [f64; 3]);

impl Reflectance {
    /// Returns the values as fractions of 1.
    pub fn shares(self) -> [f64; 3] {
        self.0.map(|percent| Percent(percent).share())
    }
}

impl fmt::Display for Reflectance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [red, green, blue] = self.0.map(Percent);
        if red == green && green == blue {
            write!(f, "{red}")
        } else {
            write!(f, "{red}, {green}, {blue}")
        }
    }
}

impl Scalar for Reflectance {
    const KIND: ValueKind = ValueKind::Text;
    type Limits = RangeInclusive<f64>;

    /// Parses one percentage, or three of red, green and blue light with commas between them.
    fn parse(text: &str) -> Result<Self, Refusal> {
        let parts = text.split(',').map(<Percent as Scalar>::parse);
        let parts = parts.map(|part| part.map(|Percent(percent)| percent));
        match parts.collect::<Result<Vec<f64>, _>>()?[..] {
            [grey] => Ok(Self([grey; 3])),
            [red, green, blue] => Ok(Self([red, green, blue])),
            _ => Err(Refusal::new(
                "is neither one percentage nor three",
                "write `85 %`, or `60 %, 20 %, 10 %` for red, green and blue light",
            )),
        }
    }

    fn is_within(&self, limits: &Self::Limits) -> bool {
        self.0.iter().all(|percent| limits.contains(percent))
    }

    fn nearest(&self, limits: &Self::Limits) -> Option<Self> {
        Some(Self(self.0.map(|percent| percent.max(*limits.start()).min(*limits.end()))))
    }

    fn show(&self) -> String {
        self.to_string()
    }

    fn allowed(limits: &Self::Limits) -> String {
        <Percent as Scalar>::allowed(limits)
    }

    fn must_be(limits: &Self::Limits) -> String {
        <Percent as Scalar>::must_be(limits)
    }

    fn schema(_: &Self::Limits) -> Json {
        let percent = format!("{NUMBER} *%");
        let pattern = format!("^{percent}( *, *{percent} *, *{percent})?$");
        Json::from_iter([("type", "string"), ("pattern", &pattern)])
    }
}

/// Durometer scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Scale for gels and very soft silicones.
    Shore00,
    /// Scale for rubbers.
    ShoreA,
    /// Scale for hard plastics.
    ShoreD,
}

/// Shore hardness.
///
/// ```
/// use fabkit_designs::materials::{Hardness, Scale};
/// use fabkit_designs::parameters::Scalar;
/// for text in ["Shore A 43", "43A", "A-43"] {
///     let hardness = Hardness::parse(text).map_err(|refusal| refusal.says)?;
///     assert_eq!(hardness, Hardness { scale: Scale::ShoreA, value: 43.0 });
/// }
/// assert!(Hardness::parse("43").is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hardness {
    /// Durometer scale.
    pub scale: Scale,
    /// Reading of the durometer, 0 to 100.
    pub value: f64,
}

impl Scale {
    fn from_word(word: &str) -> Option<Self> {
        match word {
            "00" | "OO" | "oo" => Some(Self::Shore00),
            "A" | "a" => Some(Self::ShoreA),
            "D" | "d" => Some(Self::ShoreD),
            _ => None,
        }
    }

    /// Returns the scale as makers write it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Shore00 => "00",
            Self::ShoreA => "A",
            Self::ShoreD => "D",
        }
    }
}

impl fmt::Display for Hardness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gap = if self.scale == Scale::Shore00 { "-" } else { " " };
        write!(f, "Shore {}{gap}{}", self.scale.word(), self.value)
    }
}

impl Scalar for Hardness {
    const KIND: ValueKind = ValueKind::Text;
    type Limits = ();

    /// Parses `Shore 00-30`, `00-30`, `Shore A 43` or `43A`.
    fn parse(text: &str) -> Result<Self, Refusal> {
        let text = text.trim();
        let is_shore = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case("shore"));
        let plain = if is_shore { text[5..].trim() } else { text };
        // A hyphen within a word joins scale and value; before a number it would be a sign, which no hardness has.
        let words: Vec<&str> = match plain.split_once('-') {
            Some((scale, value)) if !plain.contains(' ') => vec![scale, value],
            _ => plain.split_whitespace().collect(),
        };
        let found = match &words[..] {
            [scale, value] if Scale::from_word(scale).is_some() => {
                Some((Scale::from_word(scale), *value))
            }
            [value, scale] => Some((Scale::from_word(scale), *value)),
            // Value and scale in one word, such as `43A`.
            [one] => one
                .strip_suffix(['A', 'D'])
                .map(|value| (Scale::from_word(&one[value.len()..]), value)),
            _ => None,
        };
        let is_plain = |value: &&str| value.bytes().all(|b| b.is_ascii_digit() || b == b'.');
        let found = found.and_then(|(scale, value)| {
            Some(Self { scale: scale?, value: Some(value).filter(is_plain)?.parse().ok()? })
        });
        match found {
            Some(hardness) if (0.0..=100.0).contains(&hardness.value) => Ok(hardness),
            _ => Err(Refusal::new(
                "is no hardness on a scale of Shore",
                "write for example `Shore 00-30` or `Shore A 43`",
            )),
        }
    }

    fn is_within(&self, (): &()) -> bool {
        true
    }

    fn nearest(&self, (): &()) -> Option<Self> {
        None
    }

    fn show(&self) -> String {
        self.to_string()
    }

    fn allowed((): &()) -> String {
        "0 to 100 on the scales Shore 00, A and D".into()
    }

    fn schema((): &()) -> Json {
        Json::from_iter([("type", "string")])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_parse_and_missing_units_are_rejected() {
        let density = |text| <Density as Scalar>::parse(text).map(|d| d.0).map_err(|e| e.says);
        assert_eq!(density("1.07 g/cm3"), Ok(1.07));
        assert_eq!(density("1070kg/m3"), Ok(1.07));
        assert_eq!(density("1.07e3 kg/m3"), Ok(1.07));
        for (text, says) in [
            ("1.07", "has no unit"),
            ("nan g/cm3", "is not finite"),
            ("1e999 g/cm3", "is not finite"),
            ("1.07 mm", "is in `mm`, which does not fit"),
            ("heavy", "is not a number with a unit"),
            ("", "is not a number with a unit"),
            ("é", "is not a number with a unit"),
        ] {
            assert_eq!(density(text).unwrap_err(), says, "{text}");
        }
        assert_eq!(<Minutes as Scalar>::parse("1.5 h").map(|m| m.0), Ok(90.0));
        // The shares that built-in sensors are scaled by, to the last digit.
        for (percent, share) in [(0.1, 0.001), (339.0, 3.39), (145.0, 1.45), (120.0, 1.2)] {
            assert_eq!(Percent(percent).share(), share);
        }
    }

    #[test]
    fn hardness_is_read_as_makers_write_it() {
        let read = |text| <Hardness as Scalar>::parse(text).map(|h| h.to_string());
        for text in ["Shore 00-30", "00-30", "shore 00 30", "30 00"] {
            assert_eq!(read(text), Ok("Shore 00-30".to_owned()), "{text}");
        }
        for text in ["Shore A 43", "43A", "A-43", "43 A"] {
            assert_eq!(read(text), Ok("Shore A 43".to_owned()), "{text}");
        }
        for text in ["43", "Shore", "Shore B 43", "A 143", "A -4", "é", "shoré 4"] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
