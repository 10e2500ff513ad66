//! Numbers with physical dimensions.

use std::f64::consts::PI;
use std::fmt;

use crate::ValueKind;

/// Dimension of a number: powers of length and of angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    length: i16,
    angle: i16,
}

impl Dimension {
    /// Dimension of plain numbers.
    pub const NUMBER: Self = Self { length: 0, angle: 0 };
    /// Dimension of lengths.
    pub const LENGTH: Self = Self { length: 1, angle: 0 };
    /// Dimension of angles.
    pub const ANGLE: Self = Self { length: 0, angle: 1 };

    /// Returns the dimension of a kind of value; `None` for switches, texts and lists.
    pub fn of(kind: ValueKind) -> Option<Self> {
        match kind {
            ValueKind::Length => Some(Self::LENGTH),
            ValueKind::Angle => Some(Self::ANGLE),
            ValueKind::Count | ValueKind::Number => Some(Self::NUMBER),
            ValueKind::Switch | ValueKind::Text | ValueKind::List => None,
        }
    }

    /// Returns the dimension of the product, or of the quotient for `sign` -1.
    pub fn multiply(self, other: Self, sign: i16) -> Self {
        Self {
            length: self.length.saturating_add(sign * other.length),
            angle: self.angle.saturating_add(sign * other.angle),
        }
    }

    /// Returns the dimension of the square root, if all powers are even.
    fn square_root(self) -> Option<Self> {
        // Only even powers have a root in whole powers.
        let is_even = self.length % 2 == 0 && self.angle % 2 == 0;
        is_even.then_some(Self { length: self.length / 2, angle: self.angle / 2 })
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.length, self.angle) {
            (0, 0) => f.write_str("a plain number"),
            (1, 0) => f.write_str("a length"),
            (2, 0) => f.write_str("an area"),
            (0, 1) => f.write_str("an angle"),
            (length, 0) => write!(f, "in mm^{length}"),
            (0, angle) => write!(f, "in deg^{angle}"),
            (length, angle) => write!(f, "in mm^{length} deg^{angle}"),
        }
    }
}

/// Number in millimetres, degrees, their powers, or without unit. Degrees, because people write them: half of `161 deg`
/// is `80.5 deg`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Dimension of the number.
    pub dimension: Dimension,
}

/// Functions available in expressions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    Min,
    Max,
    Abs,
    Sqrt,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Floor,
    Ceil,
    Round,
}

impl Function {
    /// All functions with their names.
    pub const ALL: [(&str, Self); 13] = [
        ("min", Self::Min),
        ("max", Self::Max),
        ("abs", Self::Abs),
        ("sqrt", Self::Sqrt),
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("asin", Self::Asin),
        ("acos", Self::Acos),
        ("atan", Self::Atan),
        ("floor", Self::Floor),
        ("ceil", Self::Ceil),
        ("round", Self::Round),
    ];

    /// Returns whether the function accepts `count` values: two or more for `min` and `max`, one for the others.
    pub fn accepts_count(self, count: usize) -> bool {
        match self {
            Self::Min | Self::Max => count >= 2,
            _ => count == 1,
        }
    }

    /// Returns the dimension of the result for an argument of dimension `of`, whatever its value.
    ///
    /// # Errors
    /// A description of the arguments that the function takes.
    pub fn result_dimension(self, of: Dimension) -> Result<Dimension, &'static str> {
        // Zero is in the domain of every function, so only the dimension can be refused.
        self.apply(Quantity { value: 0.0, dimension: of }).map(|made| made.dimension)
    }

    /// Applies the function to one value.
    ///
    /// # Errors
    /// A description of the arguments that the function takes.
    pub fn apply(self, of: Quantity) -> Result<Quantity, &'static str> {
        let Quantity { value, dimension } = of;
        let number = |value| Ok(Quantity { value, dimension: Dimension::NUMBER });
        let angle =
            |rad: f64| Ok(Quantity { value: rad.to_degrees(), dimension: Dimension::ANGLE });
        let is_angle = dimension == Dimension::ANGLE;
        let is_number = dimension == Dimension::NUMBER;
        match self {
            // Reached for dimensions only: the values are compared by the caller.
            Self::Min | Self::Max => Ok(of),
            Self::Abs => Ok(Quantity { value: value.abs(), dimension }),
            Self::Sqrt => match dimension.square_root() {
                _ if value < 0.0 => Err("0 or more"),
                Some(dimension) => Ok(Quantity { value: value.sqrt(), dimension }),
                None => Err("a plain number or an area"),
            },
            Self::Sin if is_angle => number(value.to_radians().sin()),
            Self::Cos if is_angle => number(value.to_radians().cos()),
            Self::Tan if is_angle => number(value.to_radians().tan()),
            Self::Sin | Self::Cos | Self::Tan => Err("an angle"),
            Self::Asin | Self::Acos | Self::Atan if !is_number => Err("a plain number"),
            Self::Asin | Self::Acos if value.abs() > 1.0 => Err("a number from -1 to 1"),
            Self::Asin => angle(value.asin()),
            Self::Acos => angle(value.acos()),
            Self::Atan => angle(value.atan()),
            Self::Floor | Self::Ceil | Self::Round if !is_number => Err("a plain number"),
            Self::Floor => number(value.floor()),
            Self::Ceil => number(value.ceil()),
            Self::Round => number(value.round()),
        }
    }
}

impl Quantity {
    /// Ratio of a circle's circumference to its diameter.
    pub const PI: Self = Self { value: PI, dimension: Dimension::NUMBER };

    /// Returns the product, or the quotient for `sign` -1.
    pub fn multiply(self, other: Self, sign: i16) -> Self {
        let value = if sign < 0 { self.value / other.value } else { self.value * other.value };
        Self { value, dimension: self.dimension.multiply(other.dimension, sign) }
    }

    /// Formats the value of a parameter as it would be written, with the unit of its dimension.
    ///
    /// Rounded to 1e-9 of the unit, so that decimals come out as people write them: 3 times 0.1 mm is 0.3 mm.
    pub fn to_text(self) -> String {
        /// Above this size, doubles have too few digits for rounding to 1e-9.
        const LARGE: f64 = 1e6;
        let rounded =
            if self.value.abs() < LARGE { (self.value * 1e9).round() / 1e9 } else { self.value };
        // Adding 0 turns `-0` into `0`.
        let number = rounded + 0.0;
        match self.dimension {
            Dimension::LENGTH => format!("{number} mm"),
            Dimension::ANGLE => format!("{number} deg"),
            _ => format!("{number}"),
        }
    }
}
