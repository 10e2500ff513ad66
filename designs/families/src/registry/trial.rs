//! Trials of a design with other values in place of its own: rules are checked, nothing is built.

use std::collections::BTreeMap;
use std::sync::Arc;

use fabkit_text::{InvalidDesign, NumericParameter, Reader, RuleReport, TrialTable};

use super::{Example, LayeredDocument, OtherSections, ReadOutcome, Registry, SensorText};
use crate::user_catalogue::ReaderContext;

/// Layered texts of a design, which can be read any number of times.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    document: TrialTable,
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
        let document = TrialTable::new(document);
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
        self.document.numbers()
    }

    /// Replaces values, by path. Returns the problems of the changed design, and the new values of `numbers`.
    pub(crate) fn evaluate(
        &self,
        values: &BTreeMap<String, String>,
        numbers: &[NumericParameter],
    ) -> (RuleReport, Vec<Option<f64>>) {
        let document = self.document.with_values(values);
        let number = |number: &NumericParameter| document.number(&number.path, number.kind);
        let numbers = numbers.iter().map(number).collect();
        let reader = Reader::new(document).with_shared_context(Arc::clone(&self.known));
        ((self.probe)(reader.for_trial()), numbers)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use fabkit_text::ValueKind;

    use crate::{REGISTRY, SensorText};

    /// A search computes only the expressions that a change reaches. Each number of each sensor, changed alone and with the
    /// one before it, gives the document that computing all expressions gives.
    #[test]
    fn changed_values_reach_the_same_expressions_as_if_all_were_computed() {
        for sensor in crate::builtin_names() {
            let yaml = REGISTRY.builtin_yaml(sensor).unwrap();
            let text = SensorText::without_bases("mine.yaml", yaml);
            let extra = super::OtherSections { others: &["fixtures"], section: None };
            let document = REGISTRY.layer_texts(text, &[], extra).unwrap().document;
            let trial = fabkit_text::TrialTable::new(document.clone());
            let numbers = trial.numbers();
            let mut before = None;
            for (i, number) in numbers.iter().enumerate() {
                let step = if number.kind == ValueKind::Count { 1.0 } else { 0.37 };
                let text = number.format_value(number.value.unwrap() + step);
                let change = (number.path.clone(), text);
                let mut changes = BTreeMap::from([change.clone()]);
                if i % 2 == 1 {
                    changes.extend(before);
                }
                before = Some(change);
                let mut all = document.clone();
                all.override_values(&changes);
                all.resolve();
                let quick = trial.with_values(&changes);
                let said = |table: &fabkit_text::ParameterTable| format!("{:?}", table.found);
                assert_eq!(said(&quick), said(&all), "{sensor}: {changes:?}");
                let (quick, all) = (quick.into_values(), all.into_values());
                assert!(quick.keys().eq(all.keys()), "{sensor}: {changes:?}");
                for (path, value) in &all {
                    let (quick, all) = (format!("{:?}", quick[path]), format!("{value:?}"));
                    assert_eq!(quick, all, "{sensor}: {changes:?}: {path}");
                }
            }
        }
    }
}
