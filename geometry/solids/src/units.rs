//! Lengths and angles as people write them: a number and a unit, always finite.

use std::fmt;
use std::str::FromStr;

/// Finite length.
///
/// ```
/// use fabkit_geometry::Length;
/// assert_eq!("0.5 in".parse::<Length>()?.mm(), 12.7);
/// assert!("12.5".parse::<Length>().is_err()); // no unit
/// # Ok::<(), fabkit_geometry::UnitError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Length(f64);

/// Finite angle.
///
/// ```
/// use fabkit_geometry::Angle;
/// assert_eq!("180 deg".parse::<Angle>()?.rad(), std::f64::consts::PI);
/// # Ok::<(), fabkit_geometry::UnitError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Angle(f64);

/// Error in parsing a length or an angle.
///
/// ```
/// use fabkit_geometry::{Angle, Length};
/// let told = "12.5".parse::<Length>().unwrap_err().to_string();
/// assert_eq!(told, "`12.5` has no unit; write for example `12.5 mm`");
/// let told = "3 mm".parse::<Angle>().unwrap_err().to_string();
/// assert_eq!(told, "`mm` is not a unit of angle; use deg or rad");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// Number without a unit, which would be ambiguous.
    #[error("`{text}` has no unit; write for example `{text} {example}`")]
    MissingUnit {
        /// The text as written.
        text: String,
        /// Example of a valid unit.
        example: &'static str,
    },
    /// Unit of another quantity, or unknown unit.
    #[error("`{unit}` is not a unit of {quantity}; use {expected}")]
    UnknownUnit {
        /// The unit as written.
        unit: String,
        /// Expected quantity.
        quantity: &'static str,
        /// Valid units.
        expected: &'static str,
    },
    /// Text before the unit that is not a number.
    #[error("`{text}` is not a number with a unit")]
    NotANumber {
        /// The text as written.
        text: String,
    },
    /// NaN or an infinity.
    #[error("`{text}` is not finite")]
    NotFinite {
        /// The text as written.
        text: String,
    },
}

/// Formats a length or another figure for people: rounded to a thousandth, without zeros at its end. A micrometre is finer
/// than what any of the processes keeps.
///
/// ```
/// use fabkit_geometry::format_rounded;
///
/// assert_eq!(format_rounded(0.10000000000000009), "0.1");
/// assert_eq!(format_rounded(78.855246445), "78.855");
/// assert_eq!(format_rounded(-0.0001), "0");
/// ```
pub fn format_rounded(number: f64) -> String {
    // Adding 0 turns -0 into 0.
    ((number * 1e3).round() / 1e3 + 0.0).to_string()
}

impl Length {
    /// Creates a length from millimetres; `None` if it is not finite.
    pub fn from_mm(mm: f64) -> Option<Self> {
        mm.is_finite().then_some(Self(mm))
    }

    /// Returns the length in millimetres.
    pub fn mm(self) -> f64 {
        self.0
    }
}

impl Angle {
    /// Creates an angle from radians; `None` if it is not finite.
    pub fn from_rad(rad: f64) -> Option<Self> {
        rad.is_finite().then_some(Self(rad))
    }

    /// Creates an angle from degrees; `None` if it is not finite.
    ///
    /// ```
    /// use fabkit_geometry::Angle;
    /// let right = Angle::from_deg(90.0).unwrap();
    /// assert_eq!((right.rad(), right.to_string()), (std::f64::consts::FRAC_PI_2, "90 deg".into()));
    /// assert!(Angle::from_deg(f64::NAN).is_none());
    /// ```
    pub fn from_deg(deg: f64) -> Option<Self> {
        Self::from_rad(deg.to_radians())
    }

    /// Returns the angle in radians.
    pub fn rad(self) -> f64 {
        self.0
    }

    /// Returns the angle in degrees.
    pub fn deg(self) -> f64 {
        self.0.to_degrees()
    }
}

/// Splits `12.5 mm` into its number and its unit.
fn number_and_unit<'a>(text: &'a str, example: &'static str) -> Result<(f64, &'a str), UnitError> {
    let text = text.trim();
    let is_unit = |c: char| c.is_alphabetic() || matches!(c, '°' | '"' | '\'' | '%');
    // An exponent (`1e-3 mm`) belongs to the number: cut at the last run of unit letters.
    let unit_start = text
        .rfind(|c| !is_unit(c))
        .map_or(0, |i| i + text[i..].chars().next().map_or(0, char::len_utf8));
    let (number, unit) = (text[..unit_start].trim(), &text[unit_start..]);
    if number.is_empty() {
        // `nan` and `inf` consist of unit letters only.
        let lower = unit.trim_start_matches(['+', '-', '.']).to_ascii_lowercase();
        return Err(if lower.starts_with("nan") || lower.starts_with("inf") {
            UnitError::NotFinite { text: text.into() }
        } else {
            UnitError::NotANumber { text: text.into() }
        });
    }
    // `.nan`, `-.inf`: the unit letters were cut off, only sign and point remain.
    if matches!(number, "-" | "+" | "." | "-." | "+.") {
        return Err(UnitError::NotFinite { text: text.into() });
    }
    let value: f64 = number.replace('_', "").parse().map_err(|_| {
        let lower = number.to_ascii_lowercase();
        if lower.contains("nan") || lower.contains("inf") {
            UnitError::NotFinite { text: text.into() }
        } else {
            UnitError::NotANumber { text: text.into() }
        }
    })?;
    if unit.is_empty() {
        return Err(UnitError::MissingUnit { text: text.into(), example });
    }
    if !value.is_finite() {
        return Err(UnitError::NotFinite { text: text.into() });
    }
    Ok((value, unit))
}

impl FromStr for Length {
    type Err = UnitError;

    /// Parses `um`, `µm`, `mm`, `cm`, `m`, `in`.
    fn from_str(text: &str) -> Result<Self, UnitError> {
        let (value, unit) = number_and_unit(text, "mm")?;
        let mm = match unit {
            "mm" => value,
            // Divisions by powers of ten are correctly rounded; multiplying by 1e-3 is not.
            "um" | "µm" | "μm" => value / 1000.0,
            "cm" => value * 10.0,
            "m" => value * 1000.0,
            "in" | "\"" => value * 25.4,
            _ => {
                return Err(UnitError::UnknownUnit {
                    unit: unit.into(),
                    quantity: "length",
                    expected: "um, mm, cm, m or in",
                });
            }
        };
        Self::from_mm(mm).ok_or_else(|| UnitError::NotFinite { text: text.into() })
    }
}

impl FromStr for Angle {
    type Err = UnitError;

    /// Parses `deg`, `°`, `rad`.
    fn from_str(text: &str) -> Result<Self, UnitError> {
        let (value, unit) = number_and_unit(text, "deg")?;
        let angle = match unit {
            "deg" | "°" => Self::from_deg(value),
            "rad" => Self::from_rad(value),
            _ => {
                return Err(UnitError::UnknownUnit {
                    unit: unit.into(),
                    quantity: "angle",
                    expected: "deg or rad",
                });
            }
        };
        angle.ok_or_else(|| UnitError::NotFinite { text: text.into() })
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} mm", self.0)
    }
}

impl fmt::Display for Angle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Rounded to 12 decimals, so that `160 deg` is written as it was read and not as 160.00000000000003.
        let deg = (self.deg() * 1e12).round() / 1e12;
        write!(f, "{deg} deg")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_every_unit() {
        for (text, mm) in [
            ("1 mm", 1.0),
            ("1mm", 1.0),
            ("-2.5 mm", -2.5),
            ("1e-3 m", 1.0),
            ("1.5e1cm", 150.0),
            ("10 µm", 0.01),
            ("1 in", 25.4),
        ] {
            assert_eq!(text.parse::<Length>().map(Length::mm), Ok(mm), "{text}");
        }
        assert_eq!("90°".parse::<Angle>().unwrap().deg(), 90.0);
        assert_eq!("160 deg".parse::<Angle>().unwrap().to_string(), "160 deg");
    }

    #[test]
    fn refuses_what_is_not_a_finite_length() {
        use UnitError::*;
        let error = |text: &str| text.parse::<Length>().unwrap_err();
        assert!(matches!(error("12.5"), MissingUnit { .. }));
        assert!(matches!(error("12.5 deg"), UnknownUnit { .. }));
        assert!(matches!(error("12.5 furlong"), UnknownUnit { .. }));
        assert!(matches!(error("nan"), NotFinite { .. }));
        assert!(matches!(error(".nan"), NotFinite { .. }));
        assert!(matches!(error("-.inf"), NotFinite { .. }));
        assert!(matches!(error("NaN mm"), NotFinite { .. }));
        assert!(matches!(error("inf mm"), NotFinite { .. }));
        assert!(matches!(error("1e999 mm"), NotFinite { .. }));
        assert!(matches!(error("mm"), NotANumber { .. }));
        assert!(matches!(error("1.2.3 mm"), NotANumber { .. }));
        assert!(matches!(error(""), NotANumber { .. }));
    }
}
