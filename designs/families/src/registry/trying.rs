//! A design's values, to be tried with others in their place: what is looked at, and nothing built.

use std::collections::BTreeMap;

use fabkit_text::{Document, InvalidDesign, Number, Reader, Report};

use super::{Example, Extra, Laid, Registry, Run, SensorText};
use crate::own::Known;

/// The texts of a design laid over each other, to be read as often as somebody likes.
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

    /// What is wrong with a design, each limit with what it follows from; clean where nothing is.
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
    /// Every number.
    pub(crate) fn numbers(&self) -> Vec<Number> {
        let mut document = self.document.clone();
        document.resolve();
        document.numbers()
    }

    /// With these values, by path, over what is there: what is wrong, and what some numbers are then.
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
