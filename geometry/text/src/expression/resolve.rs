//! Replacement of the expressions of a document by their values.

use std::collections::{BTreeMap, BTreeSet};

use super::quantity::{Dimension, Quantity};
use super::{ExpressionError, Failure, Formula, NameLookup, Term, expression_text, parse};
use crate::parameter_table::ParameterTable;
use crate::place::{LocatedProblem, TextPlace, WrittenText};
use crate::{FieldShape, Scalar, TextLayer, UNKNOWN_PARAMETER, ValueKind, to_printable};

/// Maximum distance of a count from a whole number.
const TOLERANCE: f64 = 1e-9;

/// Magnitude above all limits of parameters, in any unit.
const MAX_MAGNITUDE: f64 = 1e12;

/// Expression in the table of values.
struct ExpressionEntry {
    /// Item number, for lists.
    item: Option<usize>,
    /// Text as written.
    text: String,
    place: TextPlace,
    term: Term,
}

/// State of a parameter during evaluation.
enum State {
    /// Being computed: another request for it means that there is a cycle.
    Open,
    Done(Option<Quantity>),
}

/// Evaluator of all expressions of a document.
struct Resolver<'a> {
    document: &'a ParameterTable,
    entries: BTreeMap<String, Vec<ExpressionEntry>>,
    states: BTreeMap<String, State>,
    /// Parameters being computed, outermost first.
    open: Vec<String>,
    found: Vec<LocatedProblem>,
    /// Computed values, by path, each with its item number.
    values: BTreeMap<String, Vec<(Option<usize>, String)>>,
    unreadable: BTreeSet<String>,
}

/// Replaces every expression by its value. Problems go to the document.
pub(crate) fn resolve(document: &mut ParameterTable) {
    let mut resolver = Resolver {
        document,
        entries: BTreeMap::new(),
        states: BTreeMap::new(),
        open: Vec::new(),
        found: Vec::new(),
        values: BTreeMap::new(),
        unreadable: BTreeSet::new(),
    };
    resolver.collect();
    if resolver.entries.is_empty() && resolver.unreadable.is_empty() {
        return;
    }
    let paths: Vec<String> = resolver.entries.keys().cloned().collect();
    for path in &paths {
        resolver.compute(path);
    }
    let Resolver { entries, found, values, unreadable: broken, .. } = resolver;
    document.found.extend(found);
    for (path, values) in values {
        // A name with an expression is not plain, although its value is known by now.
        let is_plain = |name: &str| {
            let is_computed = document.value(name).is_some_and(|written| written.formula.is_some());
            !entries.contains_key(name) && !is_computed
        };
        let formula = build_formula(&entries[&path], &is_plain);
        document.replace_expressions(&path, values, formula);
    }
    for path in broken {
        document.mark_unreadable(&path);
    }
}

/// Expression as it stands in the table of values.
struct WrittenExpression<'a> {
    path: &'a str,
    /// Item number, for lists.
    item: Option<usize>,
    text: &'a str,
    place: &'a TextPlace,
}

/// Lists every expression that has not been replaced by its value.
fn written_expressions(document: &ParameterTable) -> impl Iterator<Item = WrittenExpression<'_>> {
    document.values().iter().flat_map(move |(path, written)| {
        let texts: Vec<(Option<usize>, &str, &TextPlace)> = match &written.text {
            WrittenText::Scalar(text) => vec![(None, text, &written.place)],
            WrittenText::List(items) => {
                let items = items.iter().enumerate();
                items.map(|(i, (text, place))| (Some(i), text.as_str(), place)).collect()
            }
        };
        // Only numbers are expressions: a title may begin with `=`.
        let is_number = || match document.field(path).map(|field| &field.shape) {
            Some(FieldShape::Value { kind, .. }) => Dimension::of(*kind).is_some(),
            _ => false,
        };
        let expression = move |(item, text, place)| {
            let text = expression_text(text).filter(|_| is_number())?;
            Some(WrittenExpression { path: path.as_str(), item, text, place })
        };
        texts.into_iter().filter_map(expression)
    })
}

/// Returns the paths whose expressions name a parameter, by that parameter; `None` if an expression cannot be read.
pub(crate) fn find_dependents(
    document: &ParameterTable,
) -> Option<BTreeMap<String, BTreeSet<String>>> {
    let mut dependents: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for WrittenExpression { path, text, .. } in written_expressions(document) {
        parse::parse(text).ok()?.visit_names(&mut |name| {
            dependents.entry(name.to_owned()).or_default().insert(path.to_owned());
        });
    }
    Some(dependents)
}

/// Builds the formula that is kept beside the values.
fn build_formula(entries: &[ExpressionEntry], is_plain: &dyn Fn(&str) -> bool) -> Formula {
    let mut inputs = BTreeSet::new();
    entries.iter().for_each(|entry| entry.term.collect_names(is_plain, &mut inputs));
    let texts: Vec<String> = entries.iter().map(|entry| format!("= {}", entry.text)).collect();
    let layer = entries.first().map_or(TextLayer::Base, |entry| entry.place.layer);
    Formula { text: texts.join(", "), inputs, layer }
}

impl Resolver<'_> {
    /// Finds and parses every expression.
    fn collect(&mut self) {
        for WrittenExpression { path, item, text, place } in written_expressions(self.document) {
            match parse::parse(text) {
                Ok(term) => {
                    let (text, place) = (collapse_spaces(text), place.clone());
                    let entry = ExpressionEntry { item, text, place, term };
                    self.entries.entry(path.to_owned()).or_default().push(entry);
                }
                Err(wrong) => {
                    self.found.push(problem(path, text, place, wrong));
                    self.unreadable.insert(path.to_owned());
                }
            }
        }
    }

    /// Computes the value of a path that has expressions; `None` if something is wrong.
    fn compute(&mut self, path: &str) -> Option<Quantity> {
        match self.states.get(path) {
            Some(State::Done(value)) => return *value,
            Some(State::Open) => {
                self.report_cycle(path);
                return None;
            }
            None => {}
        }
        let kind = self.kind(path);
        // Taken out of the map because evaluation borrows `self`; put back below.
        let entries = self.entries.remove(path)?;
        self.states.insert(path.to_owned(), State::Open);
        self.open.push(path.to_owned());
        let mut last = None;
        let mut values = Vec::new();
        for entry in &entries {
            let value = entry.term.value(self);
            let value = value.and_then(|value| check_value(value, kind).map_err(Failure::Error));
            match value {
                Ok(value) => {
                    values.push((entry.item, value.to_text()));
                    last = Some(value);
                }
                Err(Failure::Error(wrong)) => {
                    self.found.push(problem(path, &entry.text, &entry.place, wrong));
                }
                Err(Failure::ReportedElsewhere) => {}
            }
        }
        self.open.pop();
        // One faulty item makes the whole list unusable.
        if values.len() == entries.len() && !self.unreadable.contains(path) {
            self.values.insert(path.to_owned(), values);
        } else {
            self.unreadable.insert(path.to_owned());
            last = None;
        }
        self.entries.insert(path.to_owned(), entries);
        self.states.insert(path.to_owned(), State::Done(last));
        last
    }

    /// Returns the kind of the value at a path.
    fn kind(&self, path: &str) -> ValueKind {
        match self.document.field(path).map(|field| &field.shape) {
            Some(FieldShape::Value { kind, .. }) => *kind,
            _ => ValueKind::Text,
        }
    }

    /// Returns whether the value of a parameter is computed here, or has been.
    fn is_expression(&self, name: &str) -> bool {
        self.entries.contains_key(name) || self.states.contains_key(name)
    }

    /// Returns whether an earlier call has replaced a parameter's expression by its value.
    fn is_replaced(&self, name: &str) -> bool {
        self.document.value(name).is_some_and(|written| written.formula.is_some())
    }

    /// Returns kind and dimension of a name in an expression; fails unless it is a single number.
    fn kind_and_dimension(&self, name: &str) -> Result<(ValueKind, Dimension), Failure> {
        let wrong =
            |says: String, hint: String| Err(Failure::Error(ExpressionError::new(says, hint)));
        let kind = match self.document.field(name).map(|field| &field.shape) {
            Some(FieldShape::Value { kind, is_list: false, .. }) => *kind,
            Some(FieldShape::Value { .. }) => {
                let says = format!("uses `{name}`, which is a list");
                return wrong(says, "use a single value".into());
            }
            Some(FieldShape::Section(fields)) => {
                let keys: Vec<String> =
                    fields.iter().map(|f| format!("`{name}.{}`", f.name)).collect();
                let says = format!("uses `{name}`, which is a section, not a value");
                return wrong(says, format!("use one of {}", keys.join(", ")));
            }
            None => {
                let says = format!("uses `{}`, which is not a parameter", to_printable(name));
                let wrong = ExpressionError::new(says, self.document.suggest_hint(name));
                return Err(Failure::Error(wrong.code(UNKNOWN_PARAMETER)));
            }
        };
        match Dimension::of(kind) {
            Some(dimension) => Ok((kind, dimension)),
            None => {
                let says = format!("uses `{name}`, which is not a number");
                wrong(says, "use lengths, angles and numbers".into())
            }
        }
    }

    /// Returns the value of a name that is a plain value.
    fn plain_value(&self, name: &str) -> Result<Quantity, Failure> {
        let (kind, dimension) = self.kind_and_dimension(name)?;
        // Missing or unreadable values are reported at their own place.
        let Some(WrittenText::Scalar(text)) = self.document.value(name).map(|w| &w.text) else {
            return Err(Failure::ReportedElsewhere);
        };
        let value = match kind {
            ValueKind::Length => text.parse::<fabkit_geometry::Length>().ok().map(|v| v.mm()),
            // In degrees with the digits as written.
            ValueKind::Angle => text.parse::<fabkit_geometry::Angle>().ok().map(|v| v.deg()),
            ValueKind::Count => <u32 as Scalar>::parse(text).ok().map(f64::from),
            _ => <f64 as Scalar>::parse(text).ok(),
        };
        // A value above all limits is refused at its own place.
        let value = value.filter(|value| value.abs() < MAX_MAGNITUDE);
        value.map(|value| Quantity { value, dimension }).ok_or(Failure::ReportedElsewhere)
    }

    /// Reports a cycle once, with its chain of names. The problem is placed at the parameter of the highest layer,
    /// because the cycle was closed there.
    fn report_cycle(&mut self, path: &str) {
        let from = self.open.iter().position(|open| open == path).unwrap_or_default();
        let mut circle: Vec<String> = self.open[from..].to_vec();
        let layer = |path: &String| self.document.value(path).map(|written| written.place.layer);
        let is_over = |a: &String, b: &String| match (layer(a), layer(b)) {
            (Some(a), Some(b)) => a.overrides(b) || a == b,
            _ => false,
        };
        // Among several names of the highest layer the alphabetically first is taken, so that the message does not
        // depend on where evaluation began.
        let last = circle.iter().filter(|one| circle.iter().all(|other| is_over(one, other))).min();
        let begin = last.and_then(|last| circle.iter().position(|one| one == last));
        circle.rotate_left(begin.unwrap_or_default());
        let mut names: Vec<&str> = circle.iter().map(String::as_str).collect();
        names.extend(circle.first().map(String::as_str));
        let says = format!("follows from itself: {}", names.join(" -> "));
        let wrong = ExpressionError::new(says, "write a plain value for one of them").code("cycle");
        if let Some((path, written)) =
            circle.first().and_then(|path| Some((path, self.document.value(path)?)))
        {
            self.found.push(problem(path, &written_text(&written.text), &written.place, wrong));
        }
        self.unreadable.extend(circle);
    }
}

impl NameLookup for Resolver<'_> {
    fn dimension(&self, name: &str) -> Result<Dimension, Failure> {
        self.kind_and_dimension(name).map(|(_, dimension)| dimension)
    }

    fn value(&mut self, name: &str) -> Result<Quantity, Failure> {
        self.kind_and_dimension(name)?;
        if self.is_expression(name) || self.unreadable.contains(name) {
            return self.compute(name).ok_or(Failure::ReportedElsewhere);
        }
        self.plain_value(name)
    }

    fn plain(&mut self, name: &str) -> Result<Option<Quantity>, Failure> {
        self.kind_and_dimension(name)?;
        let is_computed = self.is_expression(name) || self.is_replaced(name);
        match (is_computed, self.unreadable.contains(name)) {
            (true, _) => Ok(None),
            (false, true) => Err(Failure::ReportedElsewhere),
            (false, false) => self.plain_value(name).map(Some),
        }
    }
}

/// Returns the text of an expression as written, on one line.
fn written_text(text: &WrittenText) -> String {
    let shown = text.to_printable();
    expression_text(&shown).map(str::to_owned).unwrap_or(shown)
}

/// Returns the whole expression with white space collapsed.
fn collapse_spaces(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Returns the value if the parameter accepts its dimension; rounds counts.
fn check_value(value: Quantity, kind: ValueKind) -> Result<Quantity, ExpressionError> {
    let wanted = Dimension::of(kind).unwrap_or(Dimension::NUMBER);
    if value.dimension != wanted {
        let says = format!("comes out as {}; it must be {wanted}", value.dimension);
        let hint = match (value.dimension, wanted) {
            (Dimension::NUMBER, Dimension::LENGTH) => "give its numbers units, for example `3 mm`",
            (Dimension::NUMBER, Dimension::ANGLE) => "give its numbers units, for example `3 deg`",
            (_, Dimension::NUMBER) => "divide by a value of the same unit, for example `/ 1 mm`",
            _ => "check what is multiplied and divided",
        };
        return Err(ExpressionError::new(says, hint).code("wrong_unit"));
    }
    let whole = value.value.round();
    match kind {
        ValueKind::Count if (value.value - whole).abs() > TOLERANCE => {
            let says = format!("comes out as {}; it must be a whole number", value.to_text());
            Err(ExpressionError::new(says, "use `round(...)`, `floor(...)` or `ceil(...)`"))
        }
        ValueKind::Count => Ok(Quantity { value: whole, ..value }),
        _ => Ok(value),
    }
}

/// Creates the problem of an expression.
fn problem(
    path: &str,
    text: &str,
    place: &TextPlace,
    ExpressionError { says, hint, code }: ExpressionError,
) -> LocatedProblem {
    let text = format!("= {text}");
    let message = format!("{path} is `{}`, which {says}", to_printable(&text));
    place.problem(path, &to_printable(&text), message).hint(hint).code(code)
}
