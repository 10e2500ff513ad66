//! Axis of a plan: a parameter and its values.

use fabkit_text::ValueKind;

use super::quantity;
use crate::row::Value;

/// Parameter that is varied.
///
/// ```
/// use fabkit_sweep::{Plan, PlanSource};
///
/// let axes = "axes: {camera.depth: {from: 6 mm, to: 7 mm, steps: 3}}";
/// let text = &format!("format: 1\nsensor: rtac0\n{axes}\nmetrics: [coverage]\n");
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let plan = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml))?;
/// let depth = &plan.axes()[0];
/// assert_eq!(depth.column(), "camera.depth_mm");
/// let space = depth.search_space();
/// assert_eq!((&space["low"], &space["high"], &space["unit"]), (&6.0.into(), &7.0.into(), &"mm".into()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PlanAxis {
    /// Path of the parameter, for example `surface.radius`.
    pub path: String,
    /// Kind of the parameter.
    pub(super) kind: ValueKind,
    pub(super) values: Values,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    /// Values as written.
    List(Vec<String>),
    /// Range in the unit of the kind.
    Range(Range),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub from: f64,
    pub to: f64,
    /// True for equal ratios instead of equal differences.
    pub log: bool,
    /// Number of values; `None` for all values in between, which only samples can have.
    pub steps: Option<usize>,
}

impl Range {
    /// Returns the value at a fraction of the range, 0 to 1.
    fn at(&self, share: f64) -> f64 {
        let Self { from, to, log, .. } = *self;
        // The ends are returned exactly, without rounding errors.
        match share {
            0.0 => from,
            1.0 => to,
            _ if log => quantity::round_digits(from * (to / from).powf(share)),
            _ => quantity::round_digits(from + (to - from) * share),
        }
    }
}

impl PlanAxis {
    /// Returns the name of the column: the path with its unit.
    pub fn column(&self) -> String {
        format!("{}{}", self.path, quantity::suffix(self.kind))
    }

    /// Describes the axis as JSON, for optimisers that choose values themselves: a range of numbers in the column's
    /// unit (`low`, `high`, `log`, `steps`, `whole`) or a list (`choices`), and the unit of numbers.
    pub fn search_space(&self) -> serde_json::Value {
        let unit = quantity::suffix(self.kind).trim_start_matches('_');
        match &self.values {
            Values::List(choices) => {
                serde_json::json!({ "path": self.path, "unit": unit, "choices": choices })
            }
            Values::Range(Range { from, to, log, steps }) => serde_json::json!({
                "path": self.path,
                "unit": unit,
                "low": from,
                "high": to,
                "log": log,
                "steps": steps,
                "whole": self.kind == ValueKind::Count,
            }),
        }
    }

    /// Returns the number of values; `None` for a range from which only samples are drawn.
    pub(super) fn len(&self) -> Option<usize> {
        match &self.values {
            Values::List(values) => Some(values.len()),
            Values::Range(range) => range.steps,
        }
    }

    /// Returns the value with an index below [`PlanAxis::len`], as written in files.
    pub(super) fn value_text_at_index(&self, index: usize) -> String {
        match &self.values {
            Values::List(values) => values[index.min(values.len() - 1)].clone(),
            Values::Range(range) => {
                let last = range.steps.map_or(1, |steps| steps.max(2) - 1);
                self.show(range.at(index as f64 / last as f64))
            }
        }
    }

    /// Returns the value at a fraction of the axis, from 0 to below 1.
    pub(super) fn value_text_at_fraction(&self, share: f64) -> String {
        match (&self.values, self.len()) {
            (_, Some(len)) => {
                self.value_text_at_index(((share * len as f64) as usize).min(len - 1))
            }
            (Values::Range(range), None) => self.show(range.at(share)),
            (Values::List(_), None) => String::new(),
        }
    }

    fn show(&self, value: f64) -> String {
        let value = if self.kind == ValueKind::Count { value.round() } else { value };
        quantity::format_quantity(self.kind, value)
    }

    /// Converts a text of this axis to a cell of a table.
    pub(super) fn cell(&self, text: &str) -> Value {
        match quantity::parse(self.kind, text) {
            Some(number) => Value::Number(number),
            None => Value::Text(text.to_owned()),
        }
    }

    /// Returns the value in the middle of the axis.
    pub(crate) fn middle(&self) -> Option<Value> {
        let len = self.len()?;
        Some(self.cell(&self.value_text_at_index((len - 1) / 2)))
    }

    /// Returns the words of an axis without numbers, in order.
    pub(crate) fn words(&self) -> Option<&[String]> {
        match &self.values {
            Values::List(values) if !quantity::is_numeric(self.kind) => Some(values),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(kind: ValueKind, from: f64, to: f64, log: bool, steps: Option<usize>) -> PlanAxis {
        PlanAxis { path: "a".into(), kind, values: Values::Range(Range { from, to, log, steps }) }
    }

    #[test]
    fn ranges_hit_their_ends_and_round_numbers() {
        let axis = range(ValueKind::Length, 0.1, 0.7, false, Some(7));
        let all: Vec<String> = (0..7).map(|i| axis.value_text_at_index(i)).collect();
        assert_eq!(all, ["0.1 mm", "0.2 mm", "0.3 mm", "0.4 mm", "0.5 mm", "0.6 mm", "0.7 mm"]);
        let axis = range(ValueKind::Number, 1.0, 1000.0, true, Some(4));
        assert_eq!(
            (0..4).map(|i| axis.value_text_at_index(i)).collect::<Vec<_>>(),
            ["1", "10", "100", "1000"]
        );
        let axis = range(ValueKind::Count, 4.0, 8.0, false, Some(5));
        assert_eq!(axis.value_text_at_index(3), "7");
        assert_eq!(
            range(ValueKind::Angle, 90.0, 120.0, false, Some(2)).value_text_at_index(1),
            "120 deg"
        );
    }

    #[test]
    fn a_share_of_steps_is_a_step() {
        let axis = range(ValueKind::Count, 4.0, 6.0, false, Some(3));
        let all: Vec<String> =
            [0.0, 0.3, 0.34, 0.66, 0.67, 0.999].map(|u| axis.value_text_at_fraction(u)).into();
        assert_eq!(all, ["4", "4", "5", "5", "6", "6"]);
        assert_eq!(
            range(ValueKind::Length, 1.0, 3.0, false, None).value_text_at_fraction(0.25),
            "1.5 mm"
        );
    }
}
