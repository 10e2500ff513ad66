//! Kinds of value that a parameter can have, and the reading, limiting and printing of each.

use std::fmt::Display;
use std::ops::RangeInclusive;

use fabkit_geometry::{Angle, Length, UnitError};
use serde_json::{Value as Json, json};

/// Reason why a text is not the expected value.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::Scalar;
///
/// let refusal = <Length as Scalar>::parse("12.5").unwrap_err();
/// assert_eq!((refusal.says.as_str(), refusal.code), ("has no unit", "missing_unit"));
/// assert_eq!(refusal.instead.as_deref(), Some("12.5 mm"));
/// let other = <Length as Scalar>::parse("3 kg").unwrap_err();
/// assert_eq!((other.code, other.instead), ("wrong_unit", None));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Completes the sentence "`surface.radius` is `12.5`, which ...".
    pub says: String,
    /// Suggested correction, for people.
    pub hint: Option<String>,
    /// Short name of the kind of refusal, for programs.
    pub code: &'static str,
    /// Replacement value as it would be written, if that is within the limits.
    pub instead: Option<String>,
}

impl Refusal {
    /// Creates a refusal with the code `wrong_value`.
    pub fn new(says: impl Into<String>, hint: &str) -> Self {
        Self { says: says.into(), hint: Some(hint.to_owned()), code: "wrong_value", instead: None }
    }

    /// Sets the code.
    #[must_use]
    pub fn code(self, code: &'static str) -> Self {
        Self { code, ..self }
    }

    /// Creates the refusal of a word that is none of the declared `words`.
    ///
    /// ```
    /// use fabkit_text::Refusal;
    ///
    /// let refusal = Refusal::not_a_choice("sqare", &["round", "square"]);
    /// assert_eq!(refusal.hint.as_deref(), Some("did you mean `square`?"));
    /// assert_eq!(refusal.instead.as_deref(), Some("square"));
    /// let stranger = Refusal::not_a_choice("oval", &["round", "square"]);
    /// assert_eq!(stranger.hint.as_deref(), Some("write one of: round, square"));
    /// ```
    pub fn not_a_choice(written: &str, words: &[&str]) -> Self {
        let hint = crate::suggestion(written, words.iter().copied(), "write one of");
        // The most similar word, as a correction for programs.
        let instead =
            crate::find_similar(written, words.iter().copied()).first().map(|w| (*w).into());
        Self { instead, ..Self::new("is not one of the choices", &hint).code("unknown_choice") }
    }
}

/// Kind of a value, for callers that compute new ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// A length with its unit.
    Length,
    /// An angle with its unit.
    Angle,
    /// A whole number, 0 or more.
    Count,
    /// Number without unit.
    Number,
    /// `true` or `false`.
    Switch,
    /// A word or a text.
    Text,
    /// Several values of one kind.
    List,
}

/// Single value: one YAML scalar.
///
/// ```
/// use fabkit_geometry::{Angle, Length};
/// use fabkit_text::Scalar;
///
/// let limits_mm = 4.0..=60.0;
/// let radius = <Length as Scalar>::parse("7 cm")?;
/// assert!(!radius.is_within(&limits_mm));
/// assert_eq!(radius.nearest(&limits_mm).map(Length::mm), Some(60.0));
/// assert_eq!(Length::allowed(&limits_mm), "4 mm to 60 mm");
/// // Limits of angles are in degrees, whatever unit was written.
/// assert!(<Angle as Scalar>::parse("1.5 rad")?.is_within(&(80.0..=90.0)));
/// # Ok::<(), fabkit_text::Refusal>(())
/// ```
pub trait Scalar: Sized + Clone {
    /// Kind of the value.
    const KIND: ValueKind;
    /// Type of the limits; `()` where the type itself is the limit.
    type Limits;

    /// Reads the text of the scalar.
    ///
    /// # Errors
    /// If the text is not such a value, whatever the limits.
    fn parse(text: &str) -> Result<Self, Refusal>;

    /// Returns whether the value is within the limits.
    fn is_within(&self, limits: &Self::Limits) -> bool;

    /// Returns the nearest value within the limits, if the kind has one.
    fn nearest(&self, limits: &Self::Limits) -> Option<Self>;

    /// Returns other values within the limits, to find out what depends on this one. Numbers change by `share` of their
    /// size (taken as at least 1), counts by one; choices return all other choices, texts nothing.
    ///
    /// ```
    /// use fabkit_text::Scalar;
    ///
    /// assert_eq!(Scalar::neighbours(&8.0, &(0.0..=10.0), 0.25), [6.0, 10.0]);
    /// assert_eq!(Scalar::neighbours(&0.0, &(-1.0..=1.0), 0.25), [-0.25, 0.25]);
    /// // A count at its upper limit has only one neighbour.
    /// assert_eq!(Scalar::neighbours(&64, &(1..=64), 0.25), [63]);
    /// ```
    fn neighbours(&self, _limits: &Self::Limits, _share: f64) -> Vec<Self> {
        Vec::new()
    }

    /// Formats the value as it would be written in YAML.
    fn show(&self) -> String;

    /// Describes the allowed values for a table: `4 mm to 60 mm`.
    fn allowed(limits: &Self::Limits) -> String;

    /// Returns the smallest and largest allowed value as they would be written, for numbers.
    fn bounds(_limits: &Self::Limits) -> Option<[String; 2]> {
        None
    }

    /// Describes the allowed values, to complete "it must be ...".
    fn must_be(limits: &Self::Limits) -> String {
        Self::allowed(limits)
    }

    /// Returns the JSON Schema of the scalar.
    fn schema(limits: &Self::Limits) -> Json;
}

/// Describes a range, to complete "it must be ...".
fn describe_range(low: impl Display, high: impl Display) -> String {
    format!("between {low} and {high}")
}

/// Regular expression of a number before its unit.
const NUMBER: &str = r"[+-]?([0-9][0-9_]*(\.[0-9_]*)?|\.[0-9][0-9_]*)([eE][+-]?[0-9]+)?";

/// Translates an error of a length or an angle.
fn unit_refusal(error: UnitError, units: &str, example: &str) -> Refusal {
    match error {
        UnitError::MissingUnit { text, .. } => {
            // The first unit of the list is the usual one.
            let unit = units.split(", ").next().unwrap_or_default();
            let instead = format!("{} {unit}", crate::to_printable(text.trim()));
            let refusal = Refusal::new("has no unit", &format!("write `{instead}`"));
            Refusal { instead: Some(instead), ..refusal.code("missing_unit") }
        }
        UnitError::UnknownUnit { unit, quantity, .. } => Refusal::new(
            format!("is in `{}`, not in a unit of {quantity}", crate::to_printable(&unit)),
            &format!("write a number and one of {units}, for example `{example}`"),
        )
        .code("wrong_unit"),
        UnitError::NotANumber { .. } => Refusal::new(
            "is not a number with a unit",
            &format!("write a number and one of {units}, for example `{example}`"),
        )
        .code("not_a_number"),
        UnitError::NotFinite { .. } => {
            Refusal::new("is not finite", &format!("write a number, for example `{example}`"))
                .code("not_finite")
        }
    }
}

/// Returns the number changed down and up by `share` of its size. Sizes below 1 count as 1.
fn neighbour_numbers(number: f64, share: f64) -> [f64; 2] {
    let by = share * number.abs().max(1.0);
    [number - by, number + by]
}

/// Limits are in millimetres.
impl Scalar for Length {
    const KIND: ValueKind = ValueKind::Length;
    type Limits = RangeInclusive<f64>;

    fn parse(text: &str) -> Result<Self, Refusal> {
        text.parse().map_err(|e| unit_refusal(e, "mm, um, cm, m, in", "12.5 mm"))
    }

    fn is_within(&self, limits: &Self::Limits) -> bool {
        limits.contains(&self.mm())
    }

    fn nearest(&self, limits: &Self::Limits) -> Option<Self> {
        Self::from_mm(nearest(self.mm(), limits))
    }

    fn neighbours(&self, limits: &Self::Limits, share: f64) -> Vec<Self> {
        let near = neighbour_numbers(self.mm(), share).map(Self::from_mm);
        near.into_iter().flatten().filter(|other| other.is_within(limits)).collect()
    }

    fn show(&self) -> String {
        self.to_string()
    }

    fn allowed(limits: &Self::Limits) -> String {
        format!("{} mm to {} mm", limits.start(), limits.end())
    }

    fn must_be(limits: &Self::Limits) -> String {
        describe_range(format!("{} mm", limits.start()), format!("{} mm", limits.end()))
    }

    fn bounds(limits: &Self::Limits) -> Option<[String; 2]> {
        Some([limits.start(), limits.end()].map(|end| format!("{end} mm")))
    }

    fn schema(_: &Self::Limits) -> Json {
        json!({ "type": "string", "pattern": format!(r#"^{NUMBER} *(um|µm|μm|mm|cm|m|in|")$"#) })
    }
}

/// Limits are in degrees.
impl Scalar for Angle {
    const KIND: ValueKind = ValueKind::Angle;
    type Limits = RangeInclusive<f64>;

    fn parse(text: &str) -> Result<Self, Refusal> {
        text.parse().map_err(|e| unit_refusal(e, "deg, rad", "160 deg"))
    }

    fn is_within(&self, limits: &Self::Limits) -> bool {
        // Compared in radians, computed just as `60 deg` is: 60.00000000000001 degrees must not be refused.
        let (low, high) = (Self::from_deg(*limits.start()), Self::from_deg(*limits.end()));
        low.is_some_and(|low| low <= *self) && high.is_some_and(|high| *self <= high)
    }

    fn nearest(&self, limits: &Self::Limits) -> Option<Self> {
        Self::from_deg(nearest(self.deg(), limits))
    }

    fn neighbours(&self, limits: &Self::Limits, share: f64) -> Vec<Self> {
        let near = neighbour_numbers(self.deg(), share).map(Self::from_deg);
        near.into_iter().flatten().filter(|other| other.is_within(limits)).collect()
    }

    fn show(&self) -> String {
        self.to_string()
    }

    fn allowed(limits: &Self::Limits) -> String {
        format!("{} deg to {} deg", limits.start(), limits.end())
    }

    fn must_be(limits: &Self::Limits) -> String {
        describe_range(format!("{} deg", limits.start()), format!("{} deg", limits.end()))
    }

    fn bounds(limits: &Self::Limits) -> Option<[String; 2]> {
        Some([limits.start(), limits.end()].map(|end| format!("{end} deg")))
    }

    fn schema(_: &Self::Limits) -> Json {
        json!({ "type": "string", "pattern": format!(r"^{NUMBER} *(deg|°|rad)$") })
    }
}

/// Creates the refusal of an infinite or undefined number.
fn not_finite() -> Refusal {
    Refusal::new("is not finite", "write a number, for example `0.5`").code("not_finite")
}

/// Returns the nearest value within the limits.
fn nearest(value: f64, limits: &RangeInclusive<f64>) -> f64 {
    // Not `clamp`, which panics if a declaration has its limits the wrong way round.
    value.max(*limits.start()).min(*limits.end())
}

/// Count: a whole number, 0 or more.
impl Scalar for u32 {
    const KIND: ValueKind = ValueKind::Count;
    type Limits = RangeInclusive<u32>;

    fn parse(text: &str) -> Result<Self, Refusal> {
        let digits = text.trim();
        // Rust's parser would also accept a leading `+`.
        let is_whole = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
        match digits.parse() {
            Ok(count) if is_whole => Ok(count),
            _ if is_whole => Err(Refusal::new("is too large", "write a smaller number")),
            _ => Err(Refusal::new(
                "is not a whole number without sign or unit",
                "write digits only, for example `8`",
            )
            .code("not_a_number")),
        }
    }

    fn is_within(&self, limits: &Self::Limits) -> bool {
        limits.contains(self)
    }

    fn nearest(&self, limits: &Self::Limits) -> Option<Self> {
        Some(*self.max(limits.start()).min(limits.end()))
    }

    fn neighbours(&self, limits: &Self::Limits, _share: f64) -> Vec<Self> {
        // Fractions make no sense for counts, so `_share` is ignored.
        let near = [self.checked_sub(1), self.checked_add(1)];
        near.into_iter().flatten().filter(|other| other.is_within(limits)).collect()
    }

    fn show(&self) -> String {
        self.to_string()
    }

    fn allowed(limits: &Self::Limits) -> String {
        format!("{} to {}", limits.start(), limits.end())
    }

    fn must_be(limits: &Self::Limits) -> String {
        describe_range(limits.start(), limits.end())
    }

    fn bounds(limits: &Self::Limits) -> Option<[String; 2]> {
        Some([limits.start(), limits.end()].map(|end| end.to_string()))
    }

    fn schema(limits: &Self::Limits) -> Json {
        json!({ "type": "integer", "minimum": limits.start(), "maximum": limits.end() })
    }
}

/// Plain number without unit.
impl Scalar for f64 {
    const KIND: ValueKind = ValueKind::Number;
    type Limits = RangeInclusive<f64>;

    fn parse(text: &str) -> Result<Self, Refusal> {
        let lower = text.trim().to_ascii_lowercase();
        // Rust's parser accepts `inf` and `nan`; YAML writes `.inf` and `.nan`.
        let word = lower.trim_start_matches(['+', '-', '.']);
        if word.starts_with("nan") || word.starts_with("inf") {
            return Err(not_finite());
        }
        match lower.parse::<Self>() {
            Ok(number) if number.is_finite() => Ok(number),
            // Numbers too large for `f64` parse as infinity.
            Ok(_) => Err(not_finite()),
            Err(_) => Err(Refusal::new(
                "is not a plain number",
                "write a number without unit, for example `0.5`",
            )
            .code("not_a_number")),
        }
    }

    fn is_within(&self, limits: &Self::Limits) -> bool {
        limits.contains(self)
    }

    fn nearest(&self, limits: &Self::Limits) -> Option<Self> {
        Some(nearest(*self, limits))
    }

    fn neighbours(&self, limits: &Self::Limits, share: f64) -> Vec<Self> {
        neighbour_numbers(*self, share)
            .into_iter()
            .filter(|other| other.is_within(limits))
            .collect()
    }

    fn show(&self) -> String {
        self.to_string()
    }

    fn allowed(limits: &Self::Limits) -> String {
        format!("{} to {}", limits.start(), limits.end())
    }

    fn must_be(limits: &Self::Limits) -> String {
        describe_range(limits.start(), limits.end())
    }

    fn bounds(limits: &Self::Limits) -> Option<[String; 2]> {
        Some([limits.start(), limits.end()].map(|end| end.to_string()))
    }

    fn schema(limits: &Self::Limits) -> Json {
        json!({ "type": "number", "minimum": limits.start(), "maximum": limits.end() })
    }
}

impl Scalar for bool {
    const KIND: ValueKind = ValueKind::Switch;
    type Limits = ();

    fn parse(text: &str) -> Result<Self, Refusal> {
        match text.trim() {
            "true" => Ok(true),
            "false" => Ok(false),
            _ => Err(Refusal::new("is neither true nor false", "write `true` or `false`")),
        }
    }

    fn is_within(&self, (): &()) -> bool {
        true
    }

    fn nearest(&self, (): &()) -> Option<Self> {
        None
    }

    fn neighbours(&self, (): &(), _share: f64) -> Vec<Self> {
        vec![!self]
    }

    fn show(&self) -> String {
        self.to_string()
    }

    fn allowed((): &()) -> String {
        "true or false".into()
    }

    fn schema((): &()) -> Json {
        json!({ "type": "boolean" })
    }
}

/// One line of text. Limits are in characters.
impl Scalar for String {
    const KIND: ValueKind = ValueKind::Text;
    type Limits = RangeInclusive<usize>;

    fn parse(text: &str) -> Result<Self, Refusal> {
        // A folded YAML block ends with a line break that is not part of the text.
        let text = text.trim();
        match text.chars().find(|c| c.is_control()) {
            None => Ok(text.to_owned()),
            Some(_) => Err(Refusal::new(
                "contains a control character",
                "write it on one line, or folded with `>`",
            )),
        }
    }

    fn is_within(&self, limits: &Self::Limits) -> bool {
        limits.contains(&self.chars().count())
    }

    fn nearest(&self, _: &Self::Limits) -> Option<Self> {
        None
    }

    fn show(&self) -> String {
        self.clone()
    }

    fn allowed(limits: &Self::Limits) -> String {
        format!("{} to {} characters", limits.start(), limits.end())
    }

    fn must_be(limits: &Self::Limits) -> String {
        describe_range(limits.start(), format!("{} characters long", limits.end()))
    }

    fn schema(limits: &Self::Limits) -> Json {
        json!({ "type": "string", "minLength": limits.start(), "maxLength": limits.end() })
    }
}

/// Name that is also a file name: `[a-z0-9-]{1,64}`.
///
/// ```
/// use fabkit_text::{FileSafeName, Scalar};
///
/// assert_eq!(FileSafeName::parse("rtac0-wide")?.as_str(), "rtac0-wide");
/// for unsafe_name in ["../secret", "Wide", "", "a b"] {
///     assert!(FileSafeName::parse(unsafe_name).is_err());
/// }
/// # Ok::<(), fabkit_text::Refusal>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileSafeName(String);

impl FileSafeName {
    /// Returns the name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Scalar for FileSafeName {
    const KIND: ValueKind = ValueKind::Text;
    type Limits = ();

    fn parse(text: &str) -> Result<Self, Refusal> {
        let is_plain = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-';
        // Only ASCII, so that bytes are characters.
        if (1..=64).contains(&text.len()) && text.bytes().all(is_plain) {
            return Ok(Self(text.to_owned()));
        }
        Err(Refusal::new(
            "is not a name",
            "write small letters, digits and hyphens, for example `rtac0-wide`",
        ))
    }

    fn is_within(&self, (): &()) -> bool {
        true
    }

    fn nearest(&self, (): &()) -> Option<Self> {
        None
    }

    fn show(&self) -> String {
        self.0.clone()
    }

    fn allowed((): &()) -> String {
        "1 to 64 of a-z, 0-9 and -".into()
    }

    fn schema((): &()) -> Json {
        json!({ "type": "string", "pattern": "^[a-z0-9-]{1,64}$" })
    }
}
