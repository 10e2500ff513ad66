//! Other values in place of those of a document, thousands of times over.

use std::collections::{BTreeMap, BTreeSet};

use crate::expression::find_dependents;
use crate::{NumericParameter, ParameterTable};

/// Document whose values can be replaced any number of times: expressions that name none of them are computed once.
///
/// ```
/// use std::collections::BTreeMap;
///
/// use fabkit_geometry::Length;
/// use fabkit_text::{
///     Dialect, FieldDeclaration, Parameter, ParameterTable, TextLayer, TextPlace, TrialTable, ValueKind,
///     apply_overrides,
/// };
///
/// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
/// let shape = Length::shape(&(0.1..=20.0));
/// let length = |name| FieldDeclaration { name, summary: String::new(), shape: shape.clone() };
/// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
/// let mut table = ParameterTable::new(vec![length("radius"), length("wall")], place);
/// apply_overrides(&mut table, &["radius=6 mm".into(), "wall== radius / 4".into()]);
/// let trial = TrialTable::new(table);
/// assert_eq!(trial.numbers()[1].value, Some(1.5));
/// let other = trial.with_values(&BTreeMap::from([("radius".to_owned(), "8 mm".to_owned())]));
/// assert_eq!(other.number("wall", ValueKind::Length), Some(2.0));
/// ```
#[derive(Clone, Debug)]
pub struct TrialTable {
    written: ParameterTable,
    resolved: ParameterTable,
    /// Paths whose expressions name a parameter, by that parameter; `None` if an expression has no value, so that all have
    /// to be computed anew to report what is wrong.
    dependents: Option<BTreeMap<String, BTreeSet<String>>>,
}

impl TrialTable {
    /// Creates the document of values as written.
    pub fn new(written: ParameterTable) -> Self {
        let mut resolved = written.clone();
        resolved.resolve();
        let is_sound = resolved.found.len() == written.found.len();
        let dependents = is_sound.then(|| find_dependents(&written)).flatten();
        Self { written, resolved, dependents }
    }

    /// Lists every parameter that is one number, in order of declaration.
    pub fn numbers(&self) -> Vec<NumericParameter> {
        self.resolved.numbers()
    }

    /// Returns the document with values replaced, by path, and all expressions computed.
    pub fn with_values(&self, values: &BTreeMap<String, String>) -> ParameterTable {
        let Some(dependents) = &self.dependents else {
            let mut table = self.written.clone();
            table.override_values(values);
            table.resolve();
            return table;
        };
        let mut table = self.resolved.clone();
        let mut affected: BTreeSet<&String> = BTreeSet::new();
        let mut next: Vec<&String> = values.keys().collect();
        while let Some(path) = next.pop() {
            let further = dependents.get(path).into_iter().flatten();
            next.extend(further.filter(|path| affected.insert(path)));
        }
        for path in affected {
            if let Some(written) = self.written.shared_value(path) {
                table.set(path, written);
            }
        }
        table.override_values(values);
        table.resolve();
        table
    }
}
