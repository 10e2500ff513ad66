//! Rows of a sweep's table.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Error code of a variant that made fabkit panic, which is a bug; the reason names the place.
pub const PANIC: &str = "panic";

/// Result of a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The variant can be built, and fulfils all constraints.
    Ok,
    /// The variant violates a constraint of the plan.
    Excluded,
    /// The variant cannot be built.
    Invalid,
    /// A metric is not finite, or fabkit panicked.
    Failed,
}

impl Status {
    /// All statuses, in the order of reports.
    pub const ALL: [Self; 4] = [Self::Ok, Self::Excluded, Self::Invalid, Self::Failed];

    /// Name of the status in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Excluded => "excluded",
            Self::Invalid => "invalid",
            Self::Failed => "failed",
        }
    }
}

/// Value on an axis: a number in the unit of its column, or a word.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Number in mm, degrees, or without unit.
    Number(f64),
    /// Word: a material, a choice, or a list.
    Text(String),
}

impl Value {
    /// Returns the number; `None` for a word.
    ///
    /// ```
    /// use fabkit_sweep::Value;
    /// assert_eq!(Value::Number(6.5).number(), Some(6.5));
    /// assert_eq!(Value::Text("6.5 mm".into()).number(), None);
    /// ```
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(_) => None,
        }
    }
}

/// Row of a sweep's table.
///
/// ```
/// use fabkit_sweep::{Row, Status, Value};
/// let line = r#"{"variant": 3, "status": "ok", "error_code": null, "reason": null, "notes": [],
///     "parameters": [6.5, "black PLA"], "metrics": {"coverage": 0.75}}"#;
/// let row = Row::from_line(line)?;
/// assert_eq!((row.variant, row.status), (3, Status::Ok));
/// assert_eq!(row.parameters, [Value::Number(6.5), Value::Text("black PLA".into())]);
/// // The row itself fits on one line.
/// assert!(!row.to_line()?.contains('\n'));
/// # Ok::<(), fabkit_sweep::InvalidRow>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Number of the variant.
    pub variant: usize,
    /// Result of the variant.
    pub status: Status,
    /// Error code: `design`, `constraint`, `not-finite` or [`panic`](PANIC); `None` for [`Status::Ok`].
    pub error_code: Option<String>,
    /// Reason why the status is not ok, for people.
    pub reason: Option<String>,
    /// Reasons why cells are empty.
    pub notes: Vec<String>,
    /// Additional changes that make the variant buildable, as `path=value`; only if the plan asks for them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<String>,
    /// Values on the plan's axes, in their order.
    pub parameters: Vec<Value>,
    /// Metrics that apply, by name.
    pub metrics: BTreeMap<String, f64>,
}

/// Error of a line that is not a row.
#[derive(Debug, thiserror::Error)]
#[error("this is not a row of a sweep: {0}")]
pub struct InvalidRow(#[from] serde_json::Error);

impl Row {
    /// Creates a row with the status ok and without metrics.
    pub(crate) fn new(variant: usize, parameters: Vec<Value>) -> Self {
        Self {
            variant,
            status: Status::Ok,
            error_code: None,
            reason: None,
            notes: Vec::new(),
            changes: Vec::new(),
            parameters,
            metrics: BTreeMap::new(),
        }
    }

    pub(crate) fn set_failure(&mut self, status: Status, code: &str, reason: String) {
        self.status = status;
        self.error_code = Some(code.into());
        self.reason = Some(reason);
    }

    /// Writes one line of JSON, without a newline.
    ///
    /// # Errors
    /// Returns [`InvalidRow`] for a number that JSON cannot hold; [`Plan::evaluate`](crate::Plan::evaluate) creates no
    /// such row.
    pub fn to_line(&self) -> Result<String, InvalidRow> {
        Ok(serde_json::to_string(self)?)
    }

    /// Reads a line.
    ///
    /// # Errors
    /// Returns [`InvalidRow`] for a line that is not a row.
    pub fn from_line(line: &str) -> Result<Self, InvalidRow> {
        Ok(serde_json::from_str(line)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_survives_its_line() {
        let mut row =
            Row::new(7, vec![Value::Number(0.1 + 0.2), Value::Text("black, \"PLA\"".into())]);
        row.metrics.insert("mass_g[black PLA]".into(), 1.0 / 3.0);
        row.set_failure(Status::Excluded, "constraint", "a < b".into());
        let line = row.to_line().unwrap();
        assert!(!line.contains('\n'));
        assert_eq!(Row::from_line(&line).unwrap(), row);
        assert!(Row::from_line("{}").is_err());
    }
}
