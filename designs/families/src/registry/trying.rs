//! Trials of a design with other values in place of its own: rules are checked, nothing is built.

use std::collections::BTreeMap;

use fabkit_text::{Document, InvalidDesign, Number, Reader, Report};

use super::{Example, Extra, Laid, Registry, Run, SensorText};
use crate::own::Known;

/// Layered texts of a design, which can be read any number of times.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    document: Document,
    probe: fn(Reader) -> Report,
    known: Known,
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
        let extra = Extra { others, section: None };
        let Laid { document, family, own } = self.laid(text, overrides, extra)?;
        Ok(Trial { document, probe: family.probe, known: own.known() })
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
    ) -> Result<Report, InvalidDesign> {
        let extra = Extra { others, section: None };
        let Laid { document, family, own } = self.laid(text, overrides, extra)?;
        let example: Option<Example> = self.example(&family);
        let reader = Reader::new(document).knowing(own.known());
        let Run { report, .. } = (family.run)(reader, example.as_ref(), &mut |_| ());
        Ok(report)
    }
}

impl Trial {
    /// Returns every number of the design.
    pub(crate) fn numbers(&self) -> Vec<Number> {
        let mut document = self.document.clone();
        document.resolve();
        document.numbers()
    }

    /// Replaces values, by path. Returns the problems of the changed design, and the new values of `numbers`.
    pub(crate) fn with(
        &self,
        values: &BTreeMap<String, String>,
        numbers: &[Number],
    ) -> (Report, Vec<Option<f64>>) {
        let mut document = self.document.clone();
        document.write_over(values);
        document.resolve();
        let number = |number: &Number| document.number(&number.path, number.kind);
        let numbers = numbers.iter().map(number).collect();
        ((self.probe)(Reader::new(document).knowing(self.known.clone())), numbers)
    }
}
