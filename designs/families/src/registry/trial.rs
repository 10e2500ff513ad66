//! Trials of a design with other values in place of its own: rules are checked, nothing is built.

use std::collections::BTreeMap;
use std::sync::Arc;

use fabkit_text::{InvalidDesign, NumericParameter, ParameterTable, Reader, RuleReport};

use super::{Example, LayeredDocument, OtherSections, ReadOutcome, Registry, SensorText};
use crate::user_catalogue::ReaderContext;

/// Layered texts of a design, which can be read any number of times.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    document: ParameterTable,
    probe: fn(Reader) -> RuleReport,
    known: Arc<ReaderContext>,
}

impl Registry {
    /// Lays the texts of a design over each other.
    ///
    /// # Errors
    /// Texts that cannot be read at all.
    pub(crate) fn trial(
        &self,
        text: SensorText,
        overrides: &[String],
        others: &[&str],
    ) -> Result<Trial, InvalidDesign> {
        let extra = OtherSections { others, section: None };
        let LayeredDocument { document, family, own } = self.layer_texts(text, overrides, extra)?;
        Ok(Trial { document, probe: family.probe, known: Arc::new(own.known()) })
    }

    /// Returns the problems of a design, each limit with the values it follows from; a clean report if there are none.
    ///
    /// # Errors
    /// As for [`Registry::trial`].
    pub(crate) fn report(
        &self,
        text: SensorText,
        overrides: &[String],
        others: &[&str],
    ) -> Result<RuleReport, InvalidDesign> {
        let extra = OtherSections { others, section: None };
        let LayeredDocument { document, family, own } = self.layer_texts(text, overrides, extra)?;
        let example: Option<Example> = self.example(&family);
        let reader = Reader::new(document).with_context(own.known());
        let ReadOutcome { report, .. } = (family.run)(reader, example.as_ref(), &mut |_| ());
        Ok(report)
    }
}

impl Trial {
    /// Returns every number of the design.
    pub(crate) fn numbers(&self) -> Vec<NumericParameter> {
        let mut document = self.document.clone();
        document.resolve();
        document.numbers()
    }

    /// Replaces values, by path. Returns the problems of the changed design, and the new values of `numbers`.
    pub(crate) fn evaluate(
        &self,
        values: &BTreeMap<String, String>,
        numbers: &[NumericParameter],
    ) -> (RuleReport, Vec<Option<f64>>) {
        let mut document = self.document.clone();
        document.override_values(values);
        document.resolve();
        let number = |number: &NumericParameter| document.number(&number.path, number.kind);
        let numbers = numbers.iter().map(number).collect();
        let reader = Reader::new(document).with_shared_context(Arc::clone(&self.known));
        ((self.probe)(reader.for_trial()), numbers)
    }
}
