//! Constraints: comparisons of parameters, metrics and numbers.

use std::collections::BTreeMap;

use fabkit_text::{ValueKind, suggestion};

use super::KnownNames;
use super::quantity;

/// Comparison, for example `surface.radius <= 0.5 * envelope.diameter`.
///
/// ```
/// use fabkit_sweep::{Plan, PlanSource, Status};
///
/// let text = "
/// format: 1
/// sensor: rtac0
/// axes: {camera.depth: [6 mm, 7 mm]}
/// constraints: [camera.depth <= 6.5 mm]
/// metrics: [coverage]
/// ";
/// let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let plan = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml))?;
/// assert_eq!(plan.evaluate(0).status, Status::Ok);
/// assert_eq!(plan.evaluate(1).status, Status::Excluded);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    /// Constraint as written.
    pub text: String,
    left: Term,
    relation: Relation,
    right: Term,
}

/// Unit of a name or number in a constraint; `None` for plain numbers.
type Unit = Option<&'static str>;

#[derive(Clone, Debug, PartialEq)]
struct Term {
    factor: f64,
    operand: Operand,
    unit: Unit,
    text: String,
}

#[derive(Clone, Debug, PartialEq)]
enum Operand {
    Number,
    Parameter(String),
    Metric(String),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Less,
    AtMost,
    More,
    AtLeast,
    Equal,
    Unequal,
}

/// Signs of relations. A sign that begins with another one comes before it.
const RELATIONS: [(&str, Relation); 6] = [
    ("<=", Relation::AtMost),
    (">=", Relation::AtLeast),
    ("==", Relation::Equal),
    ("!=", Relation::Unequal),
    ("<", Relation::Less),
    (">", Relation::More),
];

impl Relation {
    /// Returns whether the relation holds between two numbers.
    fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Self::Less => left < right,
            Self::AtMost => left <= right,
            Self::More => left > right,
            Self::AtLeast => left >= right,
            Self::Equal => left == right,
            Self::Unequal => left != right,
        }
    }
}

/// Problem of a constraint, and advice.
pub(super) type Problem = (String, String);

/// Values of parameters and metrics by name, in the units of their columns.
pub(crate) type Numbers = BTreeMap<String, f64>;

impl Constraint {
    /// Reads `TERM RELATION TERM`, where a term is a name, a number with its unit, or `NUMBER * NAME`.
    pub(super) fn read(text: &str, known: &KnownNames) -> Result<Self, Problem> {
        let found = RELATIONS.iter().filter_map(|(sign, r)| Some((text.find(sign)?, *sign, *r)));
        // Of signs at the same place the longer one comes first in the table, and `min_by_key` returns the first.
        let Some((at, sign, relation)) = found.min_by_key(|(at, ..)| *at) else {
            return Err((
                format!("`{text}` is not a comparison"),
                "write for example `smallest_wall_mm >= 0.8` or `surface.radius < 14 mm`".into(),
            ));
        };
        let left = Term::read(&text[..at], known)?;
        let right = Term::read(&text[at + sign.len()..], known)?;
        // Parameters with units need numbers with units; metrics carry their unit in the name.
        for (one, other) in [(&left, &right), (&right, &left)] {
            let unit = one.unit.unwrap_or("");
            let Operand::Parameter(path) = &one.operand else {
                if let (Some(a), Some(b)) = (one.unit, other.unit)
                    && a != b
                {
                    let message = format!("`{}` is in {a}, `{}` in {b}", one.text, other.text);
                    return Err((message, "compare values of one unit".into()));
                }
                continue;
            };
            if one.unit.is_some() && other.operand == Operand::Number && other.unit.is_none() {
                let message = format!("`{path}` has a unit, `{}` has none", other.text);
                return Err((message, format!("write `{} {unit}`", other.text)));
            }
            if other.unit.is_some() && one.unit != other.unit {
                let message = format!("`{}` and `{}` are not of one unit", one.text, other.text);
                return Err((message, "compare values of one unit".into()));
            }
        }
        Ok(Self { text: text.trim().to_owned(), left, relation, right })
    }

    /// Returns whether the constraint depends on parameters alone.
    pub(crate) fn depends_on_parameters_only(&self) -> bool {
        [&self.left, &self.right].iter().all(|term| !matches!(term.operand, Operand::Metric(_)))
    }

    /// Lists the parameters of the constraint.
    pub(super) fn parameters(&self) -> impl Iterator<Item = &str> {
        [&self.left, &self.right].into_iter().filter_map(|term| match &term.operand {
            Operand::Parameter(path) => Some(path.as_str()),
            _ => None,
        })
    }

    /// Returns whether the constraint contains a parameter.
    pub(super) fn mentions(&self, path: &str) -> bool {
        self.parameters().any(|parameter| parameter == path)
    }

    /// Explains why the constraint does not hold; `None` if it does.
    pub(crate) fn violation(&self, parameters: &Numbers, metrics: &Numbers) -> Option<String> {
        let both = [&self.left, &self.right].map(|term| match &term.operand {
            Operand::Number => Ok(term.factor),
            Operand::Parameter(path) => {
                parameters.get(path).map(|value| term.factor * value).ok_or(path)
            }
            Operand::Metric(name) => metrics.get(name).map(|value| term.factor * value).ok_or(name),
        });
        match both {
            [Err(name), _] | [_, Err(name)] => {
                Some(format!("{} cannot hold: {name} does not apply", self.text))
            }
            [Ok(left), Ok(right)] if self.relation.holds(left, right) => None,
            [Ok(left), Ok(right)] => Some(format!(
                "{} does not hold: {} against {}",
                self.text,
                self.left.shown(left),
                self.right.shown(right)
            )),
        }
    }

    /// Computes the distance from holding, in the unit of the terms, and describes both sides; infinite if a term is
    /// missing.
    pub(crate) fn distance(&self, parameters: &Numbers) -> (f64, String) {
        let of = |term: &Term| match &term.operand {
            Operand::Number => Some(term.factor),
            Operand::Parameter(path) => Some(term.factor * parameters.get(path)?),
            Operand::Metric(_) => None,
        };
        match (of(&self.left), of(&self.right)) {
            (Some(left), Some(right)) => {
                let shown = [self.left.shown(left), self.right.shown(right)];
                ((left - right).abs(), shown.join(" against "))
            }
            _ => (f64::INFINITY, String::new()),
        }
    }
}

impl Term {
    /// Reads a term, and checks its names.
    fn read(text: &str, known: &KnownNames) -> Result<Self, Problem> {
        let text = text.trim();
        let term = |factor, what, unit| Self { factor, operand: what, unit, text: text.to_owned() };
        if text.is_empty() {
            let hint = "write a name or a number on both sides".into();
            return Err(("one side of the comparison is empty".into(), hint));
        }
        for (kind, unit) in [
            (ValueKind::Number, None),
            (ValueKind::Length, Some("mm")),
            (ValueKind::Angle, Some("deg")),
        ] {
            if let Some(number) = quantity::parse(kind, text) {
                return Ok(term(number, Operand::Number, unit));
            }
        }
        let (factor, name) = match text.split_once('*') {
            None => (1.0, text),
            Some((factor, name)) => match quantity::parse(ValueKind::Number, factor) {
                Some(factor) => (factor, name.trim()),
                None => {
                    let message = format!("`{}` is not a number", factor.trim());
                    return Err((message, "write `NUMBER * NAME`, for example `0.5 * a.b`".into()));
                }
            },
        };
        let name = crate::metrics::current_name(name);
        if let Some(setting) = known.parameters.get(name) {
            return if quantity::is_numeric(setting.kind) {
                let unit = Some(quantity::suffix(setting.kind).trim_start_matches('_'));
                let unit = unit.filter(|unit| !unit.is_empty());
                Ok(term(factor, Operand::Parameter(name.into()), unit))
            } else {
                Err((
                    format!("`{name}` is not a number"),
                    "only numbers, lengths and angles can be compared".into(),
                ))
            };
        }
        if known.is_computed(name) {
            let unit = ["mm", "deg"].into_iter().find(|unit| name.ends_with(&format!("_{unit}")));
            return Ok(term(factor, Operand::Metric(name.into()), unit));
        }
        if crate::metrics::is_metric(name) {
            let message = format!("`{name}` is not among the metrics of this plan");
            return Err((message, format!("add `{name}` to `metrics`")));
        }
        let names = known.names();
        let hint = suggestion(name, names.iter().map(String::as_str), "known are");
        // A list of all parameters would be too long to help.
        let hint = if hint.starts_with("known are") {
            "`fabkit show SENSOR` lists the parameters, the docs list the metrics".into()
        } else {
            hint
        };
        Err((format!("`{name}` is neither a parameter nor a metric"), hint))
    }

    fn shown(&self, value: f64) -> String {
        let value = quantity::round_digits(value);
        self.unit.map_or(format!("{value}"), |unit| format!("{value} {unit}"))
    }
}

#[cfg(test)]
mod tests {
    use crate::{Plan, PlanSource, Status};

    #[test]
    fn what_follows_from_an_axis_is_compared_as_each_variant_has_it() {
        let text = "format: 1\nsensor: rtac0\naxes: {surface.radius: [15 mm, 16 mm]}\n\
                    metrics: [coverage]\nconstraints: [envelope.diameter <= 31 mm]\n";
        let yaml = fabkit_designs::builtin_yaml("rtac0").unwrap();
        let plan = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml)).unwrap();
        let rows = [0, 1].map(|number| plan.evaluate(number));
        assert_eq!(rows[0].status, Status::Ok, "{:?}", rows[0].reason);
        assert_eq!(rows[1].status, Status::Excluded);
        let reason = "envelope.diameter <= 31 mm does not hold: 32 mm against 31 mm";
        assert_eq!(rows[1].reason.as_deref(), Some(reason));
    }
}
