//! Typed values from the table of written ones. Problems are collected and reading goes on.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::sync::Arc;

use crate::expression::resolve;
use crate::parameter_table::ParameterTable;
use crate::place::{LocatedProblem, TextPlace, WrittenText, WrittenValue};
use crate::suggest::join_words;
use crate::{
    FieldShape, Refusal, RuleReport, Scalar, Setting, Suggestion, TextLayer, ValueKind, join,
};

/// Reader of parameters by path.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{
///     Dialect, FieldDeclaration, Parameter, ParameterTable, Reader, TextLayer, TextPlace,
///     apply_overrides,
/// };
///
/// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
/// let limits_mm = 1.0..=20.0;
/// let shape = Length::shape(&limits_mm);
/// let radius = FieldDeclaration { name: "radius", summary: "Radius.".into(), shape };
/// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
/// let mut table = ParameterTable::new(vec![radius], place);
/// apply_overrides(&mut table, &["radius=1.5 cm".into()]);
/// let mut reader = Reader::new(table);
/// let radius = Length::read(&mut reader, "radius", "Radius.", &limits_mm);
/// assert_eq!(radius.map(Length::mm), Some(15.0));
/// assert_eq!(reader.take_settings()[0].limits, "1 mm to 20 mm");
/// assert!(reader.finish(None).is_clean());
/// ```
#[derive(Debug)]
pub struct Reader {
    document: ParameterTable,
    settings: Vec<Setting>,
    missing: Vec<String>,
    found: Vec<LocatedProblem>,
    known: Option<Arc<dyn Any + Send + Sync>>,
    /// True if values are only tried: nobody asks for the settings.
    is_trial: bool,
}

impl Reader {
    /// Creates a reader and resolves the expressions of `document`.
    pub fn new(mut document: ParameterTable) -> Self {
        resolve(&mut document);
        // Includes the problems of expressions, which were resolved just before.
        let found = std::mem::take(&mut document.found);
        Self {
            document,
            settings: Vec::new(),
            missing: Vec::new(),
            found,
            known: None,
            is_trial: false,
        }
    }

    /// Returns a reader that records no settings, for searches that try thousands of values.
    #[must_use]
    pub fn for_trial(self) -> Self {
        Self { is_trial: true, ..self }
    }

    /// Attaches data as [`Reader::with_context`] does, shared with other readers.
    #[must_use]
    pub fn with_shared_context<K: Any + Send + Sync>(self, known: Arc<K>) -> Self {
        Self { known: Some(known), ..self }
    }

    /// Attaches data for look-ups by [`Reader::context`].
    #[must_use]
    pub fn with_context<K: Any + Send + Sync>(self, known: K) -> Self {
        Self { known: Some(Arc::new(known)), ..self }
    }

    /// Returns the attached data that values may name, for example materials.
    ///
    /// ```
    /// use fabkit_text::{Dialect, ParameterTable, Reader, TextLayer, TextPlace};
    ///
    /// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
    /// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
    /// let reader = Reader::new(ParameterTable::new(Vec::new(), place)).with_context(vec!["brass"]);
    /// assert_eq!(reader.context::<Vec<&str>>(), Some(&vec!["brass"]));
    /// assert_eq!(reader.context::<String>(), None);
    /// ```
    pub fn context<K: Any + Send + Sync>(&self) -> Option<&K> {
        self.known.as_deref()?.downcast_ref()
    }

    /// Returns whether anything was written at a path, even if it is wrong.
    pub fn is_written(&self, path: &str) -> bool {
        self.document.value(path).is_some() || self.document.is_unreadable(path)
    }

    /// Reads a text that names something else, and records the name that `fabkit show` prints for it. `allowed`
    /// describes the allowed texts for people.
    ///
    /// ```
    /// use fabkit_text::{
    ///     Dialect, FieldDeclaration, Parameter, ParameterTable, Reader, Refusal, TextLayer, TextPlace,
    ///     apply_overrides,
    /// };
    ///
    /// const PAD: &Dialect = &Dialect::new("pad", 1, "");
    /// let shape = String::shape(&(1..=20));
    /// let gel = FieldDeclaration { name: "gel", summary: "Gel.".into(), shape };
    /// let place = TextPlace::new(TextLayer::File, "pad.yaml", PAD);
    /// let mut table = ParameterTable::new(vec![gel], place);
    /// apply_overrides(&mut table, &["gel=sofft".into()]);
    /// let mut reader = Reader::new(table);
    /// let young_mpa = reader.read_lookup("gel", "Gel.", "soft or hard", |name| match name {
    ///     "soft" => Ok((0.1, name.to_owned())),
    ///     "hard" => Ok((2.0, name.to_owned())),
    ///     _ => Err(Refusal::not_a_choice(name, &["soft", "hard"])),
    /// });
    /// assert_eq!(young_mpa, None);
    /// let invalid = reader.finish(None).into_invalid();
    /// assert_eq!(invalid.problems[0].hint.as_deref(), Some("did you mean `soft`?"));
    /// ```
    pub fn read_lookup<T>(
        &mut self,
        path: &str,
        summary: &str,
        allowed: &str,
        look_up: impl FnOnce(&str) -> Result<(T, String), Refusal>,
    ) -> Option<T> {
        let written = self.find_written(path)?;
        let WrittenText::Scalar(text) = &written.text else { return None };
        match look_up(text) {
            Ok((value, shown)) => {
                if !self.is_trial {
                    let setting = plain_setting(path, summary, shown, ValueKind::Text, &written);
                    self.settings.push(Setting { limits: allowed.to_owned(), ..setting });
                }
                Some(value)
            }
            Err(Refusal { says, hint, code, instead }) => {
                let message = format!("{path} is `{}`, {says}", crate::to_printable(text.trim()));
                let mut found =
                    written.place.problem(path, &crate::to_printable(text), message).code(code);
                found.problem.hint = hint;
                // A correction found by the caller, if there is one.
                found.problem.facts.suggestion =
                    instead.map(|value| Suggestion { path: path.into(), value });
                self.found.push(found);
                None
            }
        }
    }

    /// Reads one scalar.
    pub(crate) fn read_scalar<T: Scalar>(
        &mut self,
        path: &str,
        summary: &str,
        limits: &T::Limits,
    ) -> Option<T> {
        let written = self.find_written(path)?;
        let WrittenText::Scalar(text) = &written.text else { return None };
        match read_scalar_text::<T>(path, text, limits, &written.place) {
            Ok(value) => {
                if !self.is_trial {
                    let shown = value.show();
                    self.record_setting::<T>(path, summary, shown, T::KIND, limits, &written);
                }
                Some(value)
            }
            Err(found) => {
                self.found.push(self.add_formula_context(*found, &written));
                None
            }
        }
    }

    /// Adds the expression and its inputs to a problem of a computed value: it cannot be mended where it stands.
    fn add_formula_context(
        &self,
        mut found: LocatedProblem,
        written: &WrittenValue,
    ) -> LocatedProblem {
        let Some(formula) = &written.formula else { return found };
        let problem = &mut found.problem;
        problem.message =
            format!("{} (it is `{}`)", problem.message, crate::to_printable(&formula.text));
        let inputs: Vec<String> = self
            .document
            .ordered_inputs(formula)
            .into_iter()
            .map(|path| format!("`{path}`"))
            .collect();
        let change = join_words(&inputs, "or");
        problem.hint = Some(match problem.hint.take() {
            Some(hint) if !inputs.is_empty() => format!("{hint}; or change {change}"),
            Some(hint) => hint,
            None => format!("change {change}"),
        });
        found
    }

    /// Reads a list.
    pub(crate) fn read_list<T: Scalar>(
        &mut self,
        path: &str,
        summary: &str,
        count: &RangeInclusive<usize>,
        each: &T::Limits,
    ) -> Option<Vec<T>> {
        // A path without a value ends here; if necessary, it has been recorded as missing.
        let written = self.find_written(path)?;
        let WrittenText::List(items) = &written.text else { return None };
        if !count.contains(&items.len()) {
            let message = format!(
                "{path} has {} items; it must have between {} and {}",
                items.len(),
                count.start(),
                count.end()
            );
            let shown = written.text.to_printable();
            self.found.push(written.place.problem(path, &shown, message).code("wrong_count"));
            return None;
        }
        let mut values = Vec::new();
        for (i, (text, place)) in items.iter().enumerate() {
            let path = format!("{path}[{i}]");
            match read_scalar_text::<T>(&path, text, each, place) {
                Ok(value) => values.push(value),
                Err(found) => self.found.push(self.add_formula_context(*found, &written)),
            }
        }
        // The faulty items have been reported.
        if values.len() < items.len() {
            return None;
        }
        if self.is_trial {
            return Some(values);
        }
        let shown: Vec<String> = values.iter().map(Scalar::show).collect();
        let allowed =
            format!("{} to {} items, each {}", count.start(), count.end(), T::allowed(each));
        let shown = format!("[{}]", shown.join(", "));
        self.record_setting::<T>(path, summary, shown, ValueKind::List, each, &written);
        if let Some(setting) = self.settings.last_mut() {
            setting.limits = allowed;
        }
        Some(values)
    }

    /// Returns the value at a path. A path that is neither written nor broken is recorded as missing.
    fn find_written(&mut self, path: &str) -> Option<Arc<WrittenValue>> {
        let written = self.document.shared_value(path);
        if written.is_none() && !self.document.is_unreadable(path) {
            self.missing.push(path.to_owned());
        }
        written
    }

    /// Records a parameter for `fabkit show`.
    fn record_setting<T: Scalar>(
        &mut self,
        path: &str,
        summary: &str,
        value: String,
        kind: ValueKind,
        limits: &T::Limits,
        written: &WrittenValue,
    ) {
        self.settings.push(Setting {
            limits: T::allowed(limits),
            bounds: T::bounds(limits),
            choices: choices::<T>(limits),
            ..plain_setting(path, summary, value, kind, written)
        });
    }

    /// Returns the settings read since the last call, in order.
    pub fn take_settings(&mut self) -> Vec<Setting> {
        std::mem::take(&mut self.settings)
    }

    /// Ends reading: reports missing parameters, with lines of the example, and returns the report for rules.
    ///
    /// ```
    /// use fabkit_geometry::Length;
    /// use fabkit_text::{
    ///     Dialect, FieldDeclaration, Parameter, ParameterTable, Reader, TextLayer, TextPlace,
    ///     apply_overrides, limits,
    /// };
    ///
    /// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
    /// let shape = Length::shape(&(1.0..=20.0));
    /// let radius = FieldDeclaration { name: "radius", summary: "Radius.".into(), shape };
    /// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
    /// let mut table = ParameterTable::new(vec![radius], place);
    /// apply_overrides(&mut table, &["radius=9 mm".into()]);
    /// let mut reader = Reader::new(table);
    /// let radius = Length::read(&mut reader, "radius", "Radius.", &(1.0..=20.0)).expect("it is valid");
    /// let mut report = reader.finish(None);
    /// limits! { report: radius <= 5.0, "the shaft is no longer"; }
    /// let problem = &report.into_invalid().problems[0];
    /// let says = "radius is 9 mm; it must be at most 5 mm, because the shaft is no longer";
    /// assert_eq!(problem.message, says);
    /// assert_eq!(problem.facts.at_most.as_deref(), Some("5 mm"));
    /// ```
    pub fn finish(mut self, example: Option<&Example>) -> RuleReport {
        // All parameters missing from one section are reported as one problem.
        let mut by_section: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for path in &self.missing {
            by_section.entry(self.nearest_section(path)).or_default().push(path);
        }
        let found: Vec<LocatedProblem> = by_section
            .into_iter()
            .map(|(section, paths)| self.describe_missing(section, &paths, example))
            .collect();
        self.found.extend(found);
        self.drop_consequential_problems();
        RuleReport::new(self.document.into_values(), self.found)
    }

    /// Drops problems of computed values whose inputs are wrong too: they are consequences.
    fn drop_consequential_problems(&mut self) {
        let wrong: BTreeSet<String> = self.found.iter().map(|f| f.problem.path.clone()).collect();
        self.found.retain(|found| {
            let written = self.document.value(&found.problem.path);
            let inputs = written.and_then(|written| written.formula.as_ref());
            !inputs.is_some_and(|formula| {
                self.document.collect_inputs(formula).iter().any(|input| wrong.contains(input))
            })
        });
    }

    /// Returns the innermost section around `path` that was written.
    fn nearest_section<'a>(&self, path: &'a str) -> &'a str {
        let mut section = path;
        while let Some((outer, _)) = section.rsplit_once('.') {
            if self.document.section(outer).is_some() {
                return outer;
            }
            section = outer;
        }
        ""
    }

    /// Describes what a section lacks, with example lines.
    fn describe_missing(
        &self,
        section: &str,
        paths: &[&str],
        example: Option<&Example>,
    ) -> LocatedProblem {
        /// Maximum number of examples in a hint, enough to show the form.
        const EXAMPLES: usize = 3;
        let mut keys: Vec<String> = Vec::new();
        for path in paths {
            let inner = path.strip_prefix(section).unwrap_or(path).trim_start_matches('.');
            // Of a missing subsection only its name is listed.
            let key = inner.split('.').next().unwrap_or(inner);
            let is_section = matches!(
                self.document.field(&join(section, key)).map(|field| &field.shape),
                Some(FieldShape::Section(_))
            );
            let key = if is_section { format!("the section `{key}`") } else { format!("`{key}`") };
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        let whole = if section.is_empty() { "the file" } else { section };
        let message = format!("{whole} lacks {}", join_words(&keys, "and"));
        let place = self.document.section(section).unwrap_or(&self.document.root);
        // A single missing parameter is named itself.
        let path = if let [one] = paths { one } else { section };
        let found = place.problem(path, "", message).code("missing_parameter");
        let Some(example) = example else { return found };
        let lines: Vec<String> = paths
            .iter()
            .take(EXAMPLES)
            .filter_map(|path| Some(format!("`{path}: {}`", example.values.get(*path)?)))
            .collect();
        let more = match paths.len().saturating_sub(EXAMPLES) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let name = example.name;
        found.hint(format!(
            "{name} has {}{more}; `extends: {name}` fills in whatever a file leaves out",
            lines.join(", ")
        ))
    }
}

/// Built-in file that example values are taken from.
///
/// ```
/// use std::collections::BTreeMap;
///
/// use fabkit_text::{Dialect, Example, Parameter, ParameterTable, Reader, TextLayer, TextPlace};
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let place = TextPlace::new(TextLayer::File, "pins.yaml", PINS);
/// let mut reader = Reader::new(ParameterTable::new(Vec::new(), place));
/// assert_eq!(u32::read(&mut reader, "rows", "Rows.", &(1..=9)), None);
/// let values = BTreeMap::from([("rows".to_owned(), "4".to_owned())]);
/// let invalid = reader.finish(Some(&Example { name: "pins4", values })).into_invalid();
/// assert_eq!(invalid.problems[0].message, "the file lacks `rows`");
/// let hint = invalid.problems[0].hint.as_deref().unwrap_or_default();
/// assert!(hint.starts_with("pins4 has `rows: 4`; `extends: pins4`"));
/// ```
#[derive(Debug)]
pub struct Example {
    /// Name as written behind `extends:`.
    pub name: &'static str,
    /// Values as written, by path.
    pub values: BTreeMap<String, String>,
}

/// Parses one scalar and checks its limits. The error says in one sentence what is wrong and what to do.
pub(crate) fn read_scalar_text<T: Scalar>(
    path: &str,
    text: &str,
    limits: &T::Limits,
    place: &TextPlace,
) -> Result<T, Box<LocatedProblem>> {
    let parsed = match T::parse(text) {
        Ok(value) if value.is_within(limits) => return Ok(value),
        parsed => parsed,
    };
    let written = crate::to_printable(text.trim());
    let (message, hint, code, instead) = match parsed {
        Ok(value) => {
            let message = format!("{path} is {written}; it must be {}", T::must_be(limits));
            let nearest = value.nearest(limits).map(|value| value.show());
            let hint = nearest.as_ref().map(|v| format!("the nearest allowed value is {v}"));
            (message, hint, "out_of_range", nearest)
        }
        Err(Refusal { says, hint, code, instead }) => {
            let must_be = T::must_be(limits);
            let message = format!("{path} is `{written}`, which {says}; it must be {must_be}");
            // What lacks its unit may be out of its limits too.
            let meant = instead.as_ref().and_then(|text| T::parse(text).ok());
            match meant.filter(|value| !value.is_within(limits)) {
                Some(outside) => {
                    let nearest = outside.nearest(limits).map(|value| value.show());
                    let hint = nearest.as_ref().map(|value| format!("write for example `{value}`"));
                    (message, hint.or(Some("write a number and its unit".into())), code, None)
                }
                None => (message, hint, code, instead),
            }
        }
    };
    let mut found = place.problem(path, &crate::to_printable(text), message).code(code);
    found.problem.hint = hint;
    let facts = &mut found.problem.facts;
    [facts.at_least, facts.at_most] = match T::bounds(limits) {
        Some(bounds) => bounds.map(Some),
        None => [None, None],
    };
    facts.choices = choices::<T>(limits);
    facts.suggestion = instead.map(|value| Suggestion { path: path.into(), value });
    Err(Box::new(found))
}

/// Returns the allowed words, if the value is one of a few.
fn choices<T: Scalar>(limits: &T::Limits) -> Vec<String> {
    // The schema is where every scalar type lists its words.
    let schema = T::schema(limits);
    let words = schema["enum"].as_array().map(Vec::as_slice).unwrap_or_default();
    words.iter().filter_map(|word| word.as_str().map(str::to_owned)).collect()
}

/// Creates a setting without limits.
fn plain_setting(
    path: &str,
    summary: &str,
    value: String,
    kind: ValueKind,
    written: &WrittenValue,
) -> Setting {
    Setting {
        path: path.to_owned(),
        value,
        kind,
        source: written.source.clone(),
        summary: summary.to_owned(),
        limits: String::new(),
        bounds: None,
        choices: Vec::new(),
        expression: written.formula.as_ref().map(|formula| formula.text.clone()),
        is_default: written.place.layer == TextLayer::Default,
    }
}
