//! What is known of one variant.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The error code of a variant that made fabkit panic, which is a bug; the reason says where.
pub const PANIC: &str = "panic";

/// What became of a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It can be built, and fulfils all constraints.
    Ok,
    /// It breaks a constraint of the plan.
    Excluded,
    /// It cannot be built.
    Invalid,
    /// A metric came out as no number, or fabkit panicked.
    Failed,
}

impl Status {
    /// In the order of reports.
    pub const ALL: [Self; 4] = [Self::Ok, Self::Excluded, Self::Invalid, Self::Failed];

    /// As written in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Excluded => "excluded",
            Self::Invalid => "invalid",
            Self::Failed => "failed",
        }
    }
}

/// The value of an axis: a number in the unit of its column, or a word.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// mm, degrees, or plain.
    Number(f64),
    /// A material, a choice, a list.
    Text(String),
}

impl Value {
    /// The number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(_) => None,
        }
    }
}

/// One row of a sweep's table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The variant's number.
    pub variant: usize,
    /// What became of it.
    pub status: Status,
    /// `design`, `constraint`, `not-finite` or [`panic`](PANIC); nothing for [`Status::Ok`].
    pub error_code: Option<String>,
    /// Why it is not ok, for people.
    pub reason: Option<String>,
    /// Why cells are empty that might have been filled.
    pub notes: Vec<String>,
    /// What else had to change so that it can be built, as `path=value`; only where the plan says so.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<String>,
    /// The values of the plan's axes, in their order.
    pub parameters: Vec<Value>,
    /// Metrics that apply, by name.
    pub metrics: BTreeMap<String, f64>,
}

/// Why a line is no row.
#[derive(Debug, thiserror::Error)]
#[error("this is not a row of a sweep: {0}")]
pub struct InvalidRow(#[from] serde_json::Error);

impl Row {
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

    pub(crate) fn refuse(&mut self, status: Status, code: &str, reason: String) {
        self.status = status;
        self.error_code = Some(code.into());
        self.reason = Some(reason);
    }

    /// One line of JSON, without the line's end.
    ///
    /// # Errors
    /// [`InvalidRow`] for a number that JSON does not have; [`Plan::evaluate`](crate::Plan::evaluate)
    /// makes no such row.
    pub fn to_line(&self) -> Result<String, InvalidRow> {
        Ok(serde_json::to_string(self)?)
    }

    /// Reads a line.
    ///
    /// # Errors
    /// [`InvalidRow`].
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
        row.refuse(Status::Excluded, "constraint", "a < b".into());
        let line = row.to_line().unwrap();
        assert!(!line.contains('\n'));
        assert_eq!(Row::from_line(&line).unwrap(), row);
        assert!(Row::from_line("{}").is_err());
    }
}
