//! Values computed from other values, such as `= 2 * (surface.radius - translucent_gel.thickness) - 3 mm`.
//!
//! An expression is a text of bounded size and depth that names parameters by path. Units are checked, never guessed: a
//! length plus a plain number is refused, and the square root of an area is a length. [`ParameterTable`] replaces each
//! expression by its value before anything is read, so limits, messages and tables deal with values only. The
//! expression is kept beside the value.
//!
//! This is a small parser of its own because no library has units, positions and bounded evaluation together.

mod parse;
mod quantity;
mod resolve;

pub(crate) use resolve::{find_dependents, resolve};

use std::collections::BTreeSet;

use crate::{TextLayer, to_printable};
use quantity::{Dimension, Function, Quantity};

/// Maximum length of an expression, characters.
pub const MAX_CHARACTERS: usize = 1000;
/// Maximum nesting of brackets, functions and signs.
pub const MAX_DEPTH: usize = 64;

/// Returns the text of an expression written in place of a value; `None` if it is not an expression.
pub(crate) fn expression_text(written: &str) -> Option<&str> {
    written.trim().strip_prefix('=').map(str::trim)
}

/// Expression that a value was computed from.
///
/// ```
/// use fabkit_text::{
///     Dialect, FieldDeclaration, Parameter, ParameterTable, TextLayer, TextPlace, apply_overrides,
/// };
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let count = |name| FieldDeclaration { name, summary: String::new(), shape: u32::shape(&(1..=99)) };
/// let place = TextPlace::new(TextLayer::File, "pins.yaml", PINS);
/// let mut table = ParameterTable::new(vec![count("rows"), count("columns")], place);
/// apply_overrides(&mut table, &["rows=4".into(), "columns== 2 * rows + 1".into()]);
/// table.resolve();
/// let columns = table.written("columns").expect("it is written");
/// assert_eq!(columns.text.to_printable(), "9");
/// let formula = columns.formula.as_ref().expect("it is computed");
/// assert_eq!(formula.text, "= 2 * rows + 1");
/// assert!(formula.inputs.iter().eq(["rows"]));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    /// Text as written, beginning with `= `.
    pub text: String,
    /// Paths of the parameters that it names.
    pub inputs: BTreeSet<String>,
    /// Layer of the text that contains it.
    pub layer: TextLayer,
}

/// Error in an expression.
#[derive(Clone, Debug, PartialEq, Eq)]
struct ExpressionError {
    /// Completes the sentence "`surface.radius` is `= ...`, which ...".
    says: String,
    hint: String,
    /// Kind of error, for programs.
    code: &'static str,
}

impl ExpressionError {
    /// Creates an error with the code `bad_expression`.
    fn new(says: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { says: says.into(), hint: hint.into(), code: "bad_expression" }
    }

    /// Sets the code.
    fn code(self, code: &'static str) -> Self {
        Self { code, ..self }
    }
}

/// Node of an expression tree, with its text.
#[derive(Clone, Debug, PartialEq)]
struct Term {
    text: String,
    kind: TermKind,
}

/// Kind of a term, with its operands.
#[derive(Clone, Debug, PartialEq)]
enum TermKind {
    Quantity(Quantity),
    /// Value of a parameter, by path.
    Name(String),
    Negative(Box<Term>),
    Binary(Operation, Box<Term>, Box<Term>),
    Call(Function, Vec<Term>),
    /// `given(name, otherwise)`: the value of a parameter if it is written as a plain value, otherwise the second
    /// argument.
    Given(Box<Term>, Box<Term>),
}

/// Source of the values of names.
trait NameLookup {
    /// Returns the dimension of a name, whatever its value.
    fn dimension(&self, name: &str) -> Result<Dimension, Failure>;
    /// Returns the value of a name.
    fn value(&mut self, name: &str) -> Result<Quantity, Failure>;
    /// Returns the value of a name if it is written as a plain value, `None` if it is an expression.
    fn plain(&mut self, name: &str) -> Result<Option<Quantity>, Failure>;
}

/// Binary operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operation {
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// Reason why there is no value.
enum Failure {
    Error(ExpressionError),
    /// An input has no value either; the problem is reported there.
    ReportedElsewhere,
}

impl Term {
    /// Collects the names that the value is computed from. `is_plain` tells which names are written as plain values.
    ///
    /// The parameter of an unfulfilled `given` is not among them: it may itself be computed from this one.
    fn collect_names(&self, is_plain: &dyn Fn(&str) -> bool, names: &mut BTreeSet<String>) {
        match &self.kind {
            TermKind::Quantity(_) => {}
            TermKind::Name(name) => {
                names.insert(name.clone());
            }
            TermKind::Negative(inner) => inner.collect_names(is_plain, names),
            TermKind::Binary(_, left, right) => {
                left.collect_names(is_plain, names);
                right.collect_names(is_plain, names);
            }
            TermKind::Call(_, values) => {
                values.iter().for_each(|value| value.collect_names(is_plain, names))
            }
            // Only the argument that is used counts as an input.
            TermKind::Given(of, otherwise) => {
                let used = if is_plain(&of.text) { of } else { otherwise };
                used.collect_names(is_plain, names);
            }
        }
    }

    /// Visits every name, whether or not its value is used.
    fn visit_names(&self, visit: &mut dyn FnMut(&str)) {
        match &self.kind {
            TermKind::Quantity(_) => {}
            TermKind::Name(name) => visit(name),
            TermKind::Negative(inner) => inner.visit_names(visit),
            TermKind::Binary(_, left, right) | TermKind::Given(left, right) => {
                left.visit_names(visit);
                right.visit_names(visit);
            }
            TermKind::Call(_, values) => values.iter().for_each(|value| value.visit_names(visit)),
        }
    }

    /// Computes the dimension without the value.
    ///
    /// Units in `given` are thus checked whether or not its second argument is used.
    fn dimension(&self, lookup: &dyn NameLookup) -> Result<Dimension, Failure> {
        Ok(match &self.kind {
            TermKind::Quantity(quantity) => quantity.dimension,
            TermKind::Name(name) => lookup.dimension(name)?,
            TermKind::Negative(inner) => inner.dimension(lookup)?,
            TermKind::Binary(operation, left, right) => {
                let (a, b) = (left.dimension(lookup)?, right.dimension(lookup)?);
                match operation {
                    Operation::Multiply => a.multiply(b, 1),
                    Operation::Divide => a.multiply(b, -1),
                    Operation::Add | Operation::Subtract => {
                        check_same_unit(operation.word(), (left, a), (right, b))?;
                        a
                    }
                }
            }
            TermKind::Call(function, terms) => {
                let mut dimensions = Vec::with_capacity(terms.len());
                for term in terms {
                    dimensions.push(term.dimension(lookup)?);
                }
                self.call_dimension(*function, terms, &dimensions)?
            }
            TermKind::Given(of, otherwise) => self.given_dimension(of, otherwise, lookup)?,
        })
    }

    /// Returns the common dimension of both arguments of `given`.
    fn given_dimension(
        &self,
        of: &Self,
        otherwise: &Self,
        lookup: &dyn NameLookup,
    ) -> Result<Dimension, Failure> {
        let (a, b) = (of.dimension(lookup)?, otherwise.dimension(lookup)?);
        check_same_unit("put in place of each other", (of, a), (otherwise, b))?;
        Ok(a)
    }

    /// Computes the value, which must be finite.
    fn value(&self, lookup: &mut dyn NameLookup) -> Result<Quantity, Failure> {
        let value = match &self.kind {
            TermKind::Quantity(quantity) => *quantity,
            TermKind::Name(name) => lookup.value(name)?,
            TermKind::Negative(inner) => {
                let inner = inner.value(lookup)?;
                Quantity { value: -inner.value, ..inner }
            }
            TermKind::Binary(operation, left, right) => {
                let (a, b) = (left.value(lookup)?, right.value(lookup)?);
                self.combine(*operation, (left, a), (right, b))?
            }
            TermKind::Call(function, terms) => {
                let mut values = Vec::with_capacity(terms.len());
                for term in terms {
                    values.push(term.value(lookup)?);
                }
                self.call(*function, terms, &values)?
            }
            TermKind::Given(of, otherwise) => {
                // Checked even though only one argument is used.
                self.given_dimension(of, otherwise, lookup)?;
                match lookup.plain(&of.text)? {
                    Some(plain) => plain,
                    None => otherwise.value(lookup)?,
                }
            }
        };
        // Overflow, and results such as 0/0, are refused at the innermost term.
        if value.value.is_finite() {
            return Ok(value);
        }
        let says = format!("is not finite at `{}`", to_printable(&self.text));
        Err(Failure::Error(ExpressionError::new(says, "use smaller numbers").code("not_finite")))
    }

    /// Applies an operation to two values.
    fn combine(
        &self,
        operation: Operation,
        (left, a): (&Self, Quantity),
        (right, b): (&Self, Quantity),
    ) -> Result<Quantity, Failure> {
        match operation {
            Operation::Multiply => Ok(a.multiply(b, 1)),
            Operation::Divide if b.value == 0.0 => {
                let says = format!("divides by `{}`, which is 0", to_printable(&right.text));
                let wrong = ExpressionError::new(says, "divide by something that cannot become 0");
                Err(Failure::Error(wrong.code("division_by_zero")))
            }
            Operation::Divide => Ok(a.multiply(b, -1)),
            Operation::Add | Operation::Subtract => {
                check_same_unit(operation.word(), (left, a.dimension), (right, b.dimension))?;
                // Both have the same unit here.
                let sign = if operation == Operation::Add { 1.0 } else { -1.0 };
                Ok(Quantity { value: a.value + sign * b.value, ..a })
            }
        }
    }

    /// Returns the dimension of a function's result.
    fn call_dimension(
        &self,
        function: Function,
        terms: &[Self],
        dimensions: &[Dimension],
    ) -> Result<Dimension, Failure> {
        let (Some(first), [one, ..]) = (dimensions.first(), terms) else {
            return Err(Failure::ReportedElsewhere); // The parser accepts no call without values.
        };
        for (term, dimension) in terms.iter().zip(dimensions).skip(1) {
            check_same_unit("compared", (one, *first), (term, *dimension))?;
        }
        function.result_dimension(*first).map_err(|takes| {
            let says = format!(
                "has `{}`, but `{}` is {first}",
                to_printable(&self.text),
                to_printable(&one.text)
            );
            let wrong = ExpressionError::new(says, format!("that function takes {takes}"));
            Failure::Error(wrong.code("wrong_unit"))
        })
    }

    /// Applies a function to its arguments.
    fn call(
        &self,
        function: Function,
        terms: &[Self],
        values: &[Quantity],
    ) -> Result<Quantity, Failure> {
        let (Some(first), [one, ..]) = (values.first(), terms) else {
            return Err(Failure::ReportedElsewhere); // The parser accepts no call without values.
        };
        for (term, value) in terms.iter().zip(values).skip(1) {
            check_same_unit("compared", (one, first.dimension), (term, value.dimension))?;
        }
        // All arguments have the dimension of the first.
        let numbers = values.iter().map(|value| value.value);
        match function {
            Function::Min => {
                Ok(Quantity { value: numbers.fold(f64::INFINITY, f64::min), ..*first })
            }
            Function::Max => {
                Ok(Quantity { value: numbers.fold(f64::NEG_INFINITY, f64::max), ..*first })
            }
            _ => function.apply(*first).map_err(|takes| {
                let says = format!(
                    "has `{}`, but `{}` is {}, {}",
                    to_printable(&self.text),
                    to_printable(&one.text),
                    first.to_text(),
                    first.dimension
                );
                let wrong = ExpressionError::new(says, format!("that function takes {takes}"));
                Failure::Error(wrong.code("wrong_unit"))
            }),
        }
    }
}

impl Operation {
    /// Returns the participle used in messages.
    fn word(self) -> &'static str {
        match self {
            Self::Add => "added",
            Self::Subtract => "subtracted",
            Self::Multiply => "multiplied",
            Self::Divide => "divided",
        }
    }
}

/// Returns an error unless both terms have the same dimension. `word` names the operation, for the message.
fn check_same_unit(
    word: &str,
    (left, a): (&Term, Dimension),
    (right, b): (&Term, Dimension),
) -> Result<(), Failure> {
    if a == b {
        return Ok(());
    }
    let says = format!(
        "is wrong in its units: `{}` is {} and `{}` is {}, which cannot be {word}",
        to_printable(&left.text),
        a,
        to_printable(&right.text),
        b
    );
    // A plain number beside a length or an angle most likely lacks its unit.
    let bare = [(left, b), (right, a)].into_iter().find_map(|(term, other)| {
        let is_bare = |q: &Quantity| q.dimension == Dimension::NUMBER;
        match (&term.kind, other) {
            (TermKind::Quantity(q), Dimension::LENGTH) if is_bare(q) => {
                Some(format!("{} mm", term.text))
            }
            (TermKind::Quantity(q), Dimension::ANGLE) if is_bare(q) => {
                Some(format!("{} deg", term.text))
            }
            _ => None,
        }
    });
    let hint = match bare {
        Some(unit) => format!("write `{unit}`"),
        None => "make both of one unit".into(),
    };
    Err(Failure::Error(ExpressionError::new(says, hint).code("wrong_unit")))
}

#[cfg(test)]
mod tests;
