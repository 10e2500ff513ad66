//! Parser from the text of an expression to a tree.

use fabkit_geometry::{Angle, Length};

use super::quantity::{Dimension, Function, Quantity};
use super::{ExpressionError, MAX_CHARACTERS, MAX_DEPTH, Operation, Term, TermKind};
use crate::{Scalar, did_you_mean, find_similar, to_printable};

/// Hint that lists the parts of an expression.
const SYNTAX_HINT: &str = "an expression has names such as `section.name`, numbers with units, + - * / ( ), \
                    min, max, abs, sqrt, sin, cos, tan, asin, acos, atan, floor, ceil, round, given and pi";

/// Function `given(name, b)`: the value of a parameter if it is written as a plain value, otherwise `b`.
const GIVEN: &str = "given";

/// Parses the text behind the `=`.
pub(super) fn parse(text: &str) -> Result<Term, ExpressionError> {
    let count = text.chars().count();
    if count > MAX_CHARACTERS {
        return Err(ExpressionError::new(
            format!("has {count} characters; at most {MAX_CHARACTERS} are read"),
            "divide it among several parameters",
        )
        .code("expression_too_large"));
    }
    let mut parser = Parser { text, at: 0, depth: 0 };
    let term = parser.parse_sum()?;
    match parser.peek() {
        None => Ok(term),
        Some(')') => Err(parser.error("has a `)` without a `(`", "remove it, or add the `(`")),
        // Something follows a complete expression.
        Some(_) => Err(parser.unexpected()),
    }
}

/// Recursive-descent parser of one expression.
struct Parser<'a> {
    text: &'a str,
    /// Offset of the next byte.
    at: usize,
    depth: usize,
}

impl<'a> Parser<'a> {
    /// Returns the text that has not been read.
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// Skips white space and returns the next character.
    fn peek(&mut self) -> Option<char> {
        self.at = self.text.len() - self.rest().trim_start().len();
        self.rest().chars().next()
    }

    /// Consumes `sign` if it comes next, and returns whether it did.
    fn take_if_next(&mut self, sign: char) -> bool {
        let is_next = self.peek() == Some(sign);
        if is_next {
            self.at += sign.len_utf8();
        }
        is_next
    }

    /// Creates an error at the present position.
    fn error(&self, says: impl Into<String>, hint: impl Into<String>) -> ExpressionError {
        let character = self.text[..self.at].chars().count() + 1;
        ExpressionError::new(format!("{} (character {character} of it)", says.into()), hint)
    }

    /// Creates the error for an unexpected character.
    fn unexpected(&mut self) -> ExpressionError {
        let Some(next) = self.peek() else {
            return self.error("ends too early", SYNTAX_HINT);
        };
        match next {
            '^' => self.error("has a `^`", "write a product, for example `a.b * a.b`"),
            ',' | '.' if self.depth == 0 => {
                self.error(format!("has a `{next}` here"), "write decimals with a point: `0.5 mm`")
            }
            c if c.is_alphanumeric() => {
                let word: String =
                    self.rest().chars().take_while(|c| is_name_character(*c)).collect();
                let says =
                    format!("goes on with `{}` where it should be at its end", to_printable(&word));
                self.error(says, "write + - * or / between two values")
            }
            c => self.error(format!("has a `{}` here", to_printable(&c.to_string())), SYNTAX_HINT),
        }
    }

    /// Creates a node whose text runs from `start` to the present position.
    fn term(&self, start: usize, what: TermKind) -> Term {
        Term { text: self.text[start..self.at].trim().to_owned(), kind: what }
    }

    /// Parses a sum of products.
    fn parse_sum(&mut self) -> Result<Term, ExpressionError> {
        self.parse_operators(
            &[('+', Operation::Add), ('-', Operation::Subtract)],
            Self::parse_product,
        )
    }

    /// Parses a product of operands.
    fn parse_product(&mut self) -> Result<Term, ExpressionError> {
        self.parse_operators(
            &[('*', Operation::Multiply), ('/', Operation::Divide)],
            Self::parse_operand,
        )
    }

    /// Parses operators of one precedence, from left to right, such as `a + b - c`.
    fn parse_operators(
        &mut self,
        signs: &[(char, Operation)],
        inner: fn(&mut Self) -> Result<Term, ExpressionError>,
    ) -> Result<Term, ExpressionError> {
        // Skips white space, so that the term's text begins with its first character.
        self.peek();
        let start = self.at;
        let mut left = inner(self)?;
        while let Some((_, operation)) = signs.iter().find(|(sign, _)| self.take_if_next(*sign)) {
            let right = inner(self)?;
            // Left-associative: the tree so far becomes the left operand.
            let what = TermKind::Binary(*operation, Box::new(left), Box::new(right));
            left = self.term(start, what);
        }
        Ok(left)
    }

    /// Runs `inner` one level deeper, unless [`MAX_DEPTH`] is reached.
    fn deeper<T>(
        &mut self,
        inner: impl FnOnce(&mut Self) -> Result<T, ExpressionError>,
    ) -> Result<T, ExpressionError> {
        if self.depth >= MAX_DEPTH {
            let says = format!("is nested more than {MAX_DEPTH} deep");
            let wrong = self.error(says, "divide it among several parameters");
            return Err(wrong.code("expression_too_large"));
        }
        self.depth += 1;
        let result = inner(self);
        self.depth -= 1;
        result
    }

    /// Parses an operand: a sign, brackets, a number, a name or a call.
    fn parse_operand(&mut self) -> Result<Term, ExpressionError> {
        let next = self.peek();
        let start = self.at;
        match next {
            Some('-') => {
                self.at += 1;
                let inner = self.deeper(Self::parse_operand)?;
                Ok(self.term(start, TermKind::Negative(Box::new(inner))))
            }
            Some('(') => {
                self.at += 1;
                let inner = self.deeper(Self::parse_sum)?;
                self.expect_closing()?;
                Ok(self.term(start, inner.kind))
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.parse_number(start),
            Some(c) if c.is_alphabetic() || c == '_' => self.parse_name(start),
            _ => Err(self.unexpected()),
        }
    }

    /// Consumes a closing bracket.
    fn expect_closing(&mut self) -> Result<(), ExpressionError> {
        match (self.take_if_next(')'), self.peek()) {
            (true, _) => Ok(()),
            (false, None) => Err(self.error(
                "lacks a `)`",
                "add it; within `{}` and `[]` an expression with a comma stands in quotes",
            )),
            (false, Some(_)) => Err(self.unexpected()),
        }
    }

    /// Parses a number with an optional unit.
    fn parse_number(&mut self, start: usize) -> Result<Term, ExpressionError> {
        let rest = self.rest();
        let digits = |text: &str| {
            text.find(|c: char| !c.is_ascii_digit() && c != '.' && c != '_').unwrap_or(text.len())
        };
        let mut end = digits(rest);
        // An exponent counts only if digits follow: in `2 em` the `e` belongs to a unit.
        if let Some(power) = rest[end..].strip_prefix(['e', 'E']) {
            let sign = power.len() - power.trim_start_matches(['+', '-']).len();
            // At least one digit makes it an exponent.
            let count = power[sign..].bytes().take_while(u8::is_ascii_digit).count();
            if count > 0 && sign < 2 {
                end += 1 + sign + count;
            }
        }
        let number = &rest[..end];
        let behind = rest[end..].trim_start();
        let unit = &behind[..behind.find(|c| !is_unit_character(c)).unwrap_or(behind.len())];
        // `2 surface.radius` lacks an operator: what follows is a name, not a unit.
        let after = &behind[unit.len()..];
        let is_unit = !unit.is_empty() && !after.starts_with(|c| is_name_character(c) || c == '(');
        if !is_unit {
            self.at = start + end;
            let value = <f64 as Scalar>::parse(&number.replace('_', "")).map_err(|e| {
                ExpressionError::new(
                    format!("has `{}`, which {}", to_printable(number), e.says),
                    SYNTAX_HINT,
                )
            })?;
            let what = TermKind::Quantity(Quantity { value, dimension: Dimension::NUMBER });
            return Ok(self.term(start, what));
        }
        self.at = self.text.len() - after.len();
        let written = format!("{number} {unit}");
        // Units of length and of angle have no names in common.
        let quantity = match (written.parse::<Length>(), written.parse::<Angle>()) {
            (Ok(length), _) => Quantity { value: length.mm(), dimension: Dimension::LENGTH },
            (_, Ok(angle)) => {
                // Degrees keep the written digits; the way through radians would round them.
                let deg = match (unit, number.parse()) {
                    ("deg" | "°", Ok(deg)) => deg,
                    _ => angle.deg(),
                };
                Quantity { value: deg, dimension: Dimension::ANGLE }
            }
            (Err(_), Err(_)) => {
                let says = format!(
                    "has `{}`, which is no finite number with a unit",
                    to_printable(&written)
                );
                return Err(ExpressionError::new(
                    says,
                    "the units are um, mm, cm, m, in, deg and rad",
                ));
            }
        };
        Ok(self.term(start, TermKind::Quantity(quantity)))
    }

    /// Parses the arguments of a call, `(a, b, ...)`.
    fn parse_arguments(&mut self) -> Result<Vec<Term>, ExpressionError> {
        self.at += 1;
        self.deeper(|parser| {
            let mut values = vec![parser.parse_sum()?];
            while parser.take_if_next(',') {
                values.push(parser.parse_sum()?);
            }
            parser.expect_closing()?;
            Ok(values)
        })
    }

    /// Parses the arguments of `given(section.name, b)`; the function's name has been read.
    fn parse_given(&mut self, start: usize) -> Result<Term, ExpressionError> {
        const HOW: &str = "write `given(section.name, b)`";
        let values = self.parse_arguments()?;
        let count = values.len();
        let Ok([of, otherwise]) = <[Term; 2]>::try_from(values) else {
            return Err(ExpressionError::new(format!("gives {count} values to `{GIVEN}`"), HOW));
        };
        let TermKind::Name(name) = &of.kind else {
            let says =
                format!("asks with `{GIVEN}` for `{}`, which is no name", to_printable(&of.text));
            return Err(ExpressionError::new(says, HOW));
        };
        // Text without brackets around the name, because the name is looked up by it.
        let of = Term { text: name.clone(), kind: of.kind };
        Ok(self.term(start, TermKind::Given(Box::new(of), Box::new(otherwise))))
    }

    /// Parses a name, a call or `pi`.
    fn parse_name(&mut self, start: usize) -> Result<Term, ExpressionError> {
        let rest = self.rest();
        let name = &rest[..rest.find(|c| !is_name_character(c)).unwrap_or(rest.len())];
        self.at += name.len();
        // A name before a bracket is a function.
        if self.peek() == Some('(') {
            if name == GIVEN {
                return self.parse_given(start);
            }
            let Some((_, function)) = Function::ALL.iter().find(|(word, _)| *word == name) else {
                let words = Function::ALL.iter().map(|(word, _)| *word);
                let near = find_similar(name, words.chain([GIVEN]));
                let hint = if near.is_empty() { SYNTAX_HINT.into() } else { did_you_mean(&near) };
                return Err(ExpressionError::new(
                    format!("has `{}`, which is no function", to_printable(name)),
                    hint,
                ));
            };
            let values = self.parse_arguments()?;
            if !function.accepts_count(values.len()) {
                let says = format!("gives {} values to `{name}`", values.len());
                let hint = if values.len() == 1 {
                    format!("write `{name}(a, b)`")
                } else {
                    format!("write `{name}(a)`")
                };
                return Err(ExpressionError::new(says, hint));
            }
            return Ok(self.term(start, TermKind::Call(*function, values)));
        }
        if name == "pi" {
            return Ok(self.term(start, TermKind::Quantity(Quantity::PI)));
        }
        Ok(self.term(start, TermKind::Name(name.to_owned())))
    }
}

/// Returns whether a character may occur in the path of a parameter.
fn is_name_character(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '.'
}

/// Returns whether a character may occur in a unit.
fn is_unit_character(c: char) -> bool {
    c.is_alphabetic() || c == '°'
}
