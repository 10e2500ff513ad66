//! What to vary, and what to know of each variant.

mod axis;
mod constraint;
mod quantity;
mod reading;
mod schema;

use std::collections::BTreeMap;

use fabkit_designs::{BaseFile, SensorText, UserFile};
use fabkit_fixtures::Project;
use fabkit_geometry::sequences;
use fabkit_text::{InvalidDesign, Kind};
use serde::{Deserialize, Serialize};

pub use axis::PlanAxis;
pub use constraint::Constraint;
pub(crate) use constraint::Numbers;
pub use schema::json_schema;

use crate::metrics::{self, Computed, Metric};
use crate::panics;
use crate::row::{PANIC, Row, Status, Value};

/// Most variants of one plan.
pub const MAX_VARIANTS: usize = 100_000;
/// Most axes of one plan.
pub const MAX_AXES: usize = sequences::MAX_DIMENSIONS;

/// Everything that a plan is made from: enough to make it again on another machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanSource {
    /// Name of the plan for messages.
    pub file: String,
    /// The plan, YAML.
    pub text: String,
    /// Name of the sensor's file for messages.
    pub sensor_file: String,
    /// The sensor, YAML.
    pub sensor_yaml: String,
    /// Files that the sensor's extends: texts in the order of [`BaseFile`]'s fields.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensor_bases: Vec<[String; 4]>,
    /// Metrics that somebody else computes, by name.
    pub custom_metrics: Vec<String>,
    /// Name and text of the file with what the user keeps for all sensors.
    #[serde(default)]
    pub user: Option<(String, String)>,
}

impl PlanSource {
    /// Without metrics of somebody else.
    pub fn new(file: &str, text: &str, sensor_file: &str, sensor_yaml: &str) -> Self {
        Self {
            file: file.into(),
            text: text.into(),
            sensor_file: sensor_file.into(),
            sensor_yaml: sensor_yaml.into(),
            sensor_bases: Vec::new(),
            custom_metrics: Vec::new(),
            user: None,
        }
    }

    /// The files that the sensor's extends.
    pub fn bases(&self) -> Vec<BaseFile> {
        let base = |[by, word, file, text]: [String; 4]| BaseFile { by, word, file, text };
        self.sensor_bases.iter().cloned().map(base).collect()
    }

    /// The same with the files that the sensor's extends.
    #[must_use]
    pub fn with_bases(mut self, bases: &[BaseFile]) -> Self {
        let texts = |base: BaseFile| [base.by, base.word, base.file, base.text];
        self.sensor_bases = bases.iter().cloned().map(texts).collect();
        self
    }

    /// Reads the sensor.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub(crate) fn load(&self, overrides: &[String]) -> Result<Project, InvalidDesign> {
        self.with_text(|text| fabkit_fixtures::load_text(text, overrides))
    }

    /// Does something with all that the sensor is read from.
    fn with_text<R>(&self, work: impl FnOnce(SensorText) -> R) -> R {
        let user = self.user.clone().map(|(file, text)| UserFile { file, text });
        let (file, yaml, bases) = (&*self.sensor_file, &*self.sensor_yaml, &*self.bases());
        work(SensorText { file, yaml, bases, user: user.as_ref() })
    }
}

/// Why a text is no source of a plan.
#[derive(Debug, thiserror::Error)]
#[error("this is not the source of a plan: {0}")]
pub struct InvalidSource(#[from] serde_json::Error);

impl PlanSource {
    /// As one line of JSON, to be sent elsewhere.
    ///
    /// # Errors
    /// None that texts can cause.
    pub fn to_json(&self) -> Result<String, InvalidSource> {
        Ok(serde_json::to_string(self)?)
    }

    /// Reads what [`PlanSource::to_json`] wrote.
    ///
    /// # Errors
    /// [`InvalidSource`].
    pub fn from_json(json: &str) -> Result<Self, InvalidSource> {
        Ok(serde_json::from_str(json)?)
    }
}

/// How variants are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Every combination of the axes' values; the last axis changes fastest.
    Grid,
    /// This many points of a scrambled Halton sequence.
    Sample(usize),
}

/// Which way is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// The smaller, the better.
    Min,
    /// The larger, the better.
    Max,
}

impl Direction {
    /// As written in plans.
    pub fn word(self) -> &'static str {
        match self {
            Self::Min => "min",
            Self::Max => "max",
        }
    }
}

/// A metric to be made small or large.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Objective {
    /// Its name.
    pub metric: String,
    /// Which way is better.
    pub direction: Direction,
}

/// A parameter as the sensor has it.
#[derive(Clone, Debug)]
pub(crate) struct Base {
    pub kind: Kind,
    pub value: String,
    /// Whether it follows from other parameters, so that only a built variant tells it.
    pub follows: bool,
}

/// What names in a plan may refer to.
#[derive(Debug)]
pub(crate) struct Known {
    pub parameters: BTreeMap<String, Base>,
    pub metrics: Vec<&'static Metric>,
    pub custom: Vec<String>,
}

impl Known {
    /// Whether rows will have a metric of this name.
    fn is_computed(&self, name: &str) -> bool {
        let of = |metric: &&'static Metric| metric.covers(name);
        self.custom.iter().any(|custom| custom == name) || self.metrics.iter().any(of)
    }

    fn names(&self) -> Vec<String> {
        let metrics = self.metrics.iter().map(|metric| metric.name.to_owned());
        self.parameters.keys().cloned().chain(metrics).chain(self.custom.clone()).collect()
    }
}

/// One variant: its number and what it changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// From 0.
    pub number: usize,
    /// `path=value`, as for `--set`: what the plan fixes, then the axes.
    pub overrides: Vec<String>,
    /// The values of the axes, in their order.
    pub values: Vec<Value>,
}

/// What has to change so that the sensor can be built with some overrides.
fn changes(source: &PlanSource, overrides: &[String]) -> Result<Vec<String>, InvalidDesign> {
    let others = [fabkit_fixtures::KEY];
    let changes = source.with_text(|text| fabkit_designs::fixing::fix(text, overrides, &others))?;
    Ok(changes.iter().map(fabkit_designs::fixing::Change::as_override).collect())
}

/// What somebody else knows of a variant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct More {
    /// Metrics by name; those that the plan does not ask for are left out.
    pub values: Vec<(String, f64)>,
    /// Why others are missing.
    pub notes: Vec<String>,
}

/// Computes metrics that are not computed here, for a variant, with what else had to change, and its design.
pub type AskMore<'a, E> = &'a mut dyn FnMut(&Variant, &Project) -> Result<More, E>;

/// A plan that can be carried out.
#[derive(Debug)]
pub struct Plan {
    /// What variants have in common; rows do not depend on it.
    pub(crate) shared: metrics::Shared,
    pub(crate) source: PlanSource,
    /// The sensor as the plan names it.
    pub(crate) sensor: String,
    pub(crate) seed: u64,
    pub(crate) sampling: Sampling,
    pub(crate) axes: Vec<PlanAxis>,
    pub(crate) fixed: Vec<String>,
    /// Whether what is chosen follows the axes.
    pub(crate) fix: bool,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) objectives: Vec<Objective>,
    pub(crate) known: Known,
    len: usize,
}

impl Plan {
    /// How many variants there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none, which [`Plan::new`] refuses.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The sensor as the plan names it.
    pub fn sensor(&self) -> &str {
        &self.sensor
    }

    /// What is varied.
    pub fn axes(&self) -> &[PlanAxis] {
        &self.axes
    }

    /// What is to be made small or large.
    pub fn objectives(&self) -> &[Objective] {
        &self.objectives
    }

    /// The metrics that rows have, if they apply.
    pub fn metrics(&self) -> &[&'static Metric] {
        &self.known.metrics
    }

    /// Whether rows may have a metric of this name, somebody else's among them.
    pub fn has_metric(&self, name: &str) -> bool {
        self.known.is_computed(name)
    }

    /// Figures of the bench that rows need: [`Plan::evaluate`] leaves them empty, [`Plan::evaluate_with`] asks.
    pub fn bench(&self) -> impl Iterator<Item = &'static str> {
        let metrics = self.known.metrics.iter();
        metrics.filter(|metric| metric.group == metrics::Group::Bench).map(|metric| metric.name)
    }

    /// Which sample is drawn, and what the bench draws.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Whether what fabkit has chosen follows the axes, so that fewer variants are lost.
    pub fn is_fixed(&self) -> bool {
        self.fix
    }

    /// What the plan is made from.
    pub fn source(&self) -> &PlanSource {
        &self.source
    }

    /// BLAKE3 over everything that decides the rows: plan, sensor, version. Hexadecimal.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let PlanSource { text, sensor_yaml, custom_metrics, sensor_bases, user, .. } = &self.source;
        let bases = sensor_bases.iter().map(|[_, _, _, text]| &**text);
        let own = bases.chain(user.as_ref().map(|(_, text)| &**text));
        let custom_metrics = custom_metrics.join("\n");
        for part in
            [fabkit_export::VERSION, text, sensor_yaml, &custom_metrics].into_iter().chain(own)
        {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part.as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// A variant.
    ///
    /// # Panics
    /// From [`Plan::len`] on.
    pub fn variant(&self, number: usize) -> Variant {
        assert!(number < self.len, "there are {} variants, not {number}", self.len);
        let texts: Vec<String> = match self.sampling {
            Sampling::Grid => {
                let mut rest = number;
                let mut indices = vec![0; self.axes.len()];
                for (index, axis) in indices.iter_mut().zip(&self.axes).rev() {
                    let len = axis.len().unwrap_or(1);
                    *index = rest % len;
                    rest /= len;
                }
                self.axes.iter().zip(indices).map(|(axis, index)| axis.nth(index)).collect()
            }
            Sampling::Sample(_) => {
                let shares = sequences::halton(number as u64, self.axes.len(), self.seed);
                self.axes.iter().zip(shares).map(|(axis, share)| axis.at(share)).collect()
            }
        };
        self.variant_at(number, &texts)
    }

    /// A variant that the plan does not number itself: the value of each axis, in their order, as
    /// sensor files write it. What cannot be built has a row that says so.
    pub fn variant_at(&self, number: usize, texts: &[String]) -> Variant {
        let pairs = || self.axes.iter().zip(texts);
        let set = pairs().map(|(axis, text)| format!("{}={text}", axis.path));
        Variant {
            number,
            overrides: self.fixed.iter().cloned().chain(set).collect(),
            values: pairs().map(|(axis, text)| axis.cell(text)).collect(),
        }
    }

    /// Builds a variant and computes its row. The same row whenever and wherever it is asked for.
    ///
    /// # Panics
    /// From [`Plan::len`] on.
    pub fn evaluate(&self, number: usize) -> Row {
        let nothing =
            &mut |_: &Variant, _: &Project| Ok::<_, std::convert::Infallible>(More::default());
        match self.evaluate_with(&self.variant(number), nothing) {
            Ok(row) => row,
            Err(never) => match never {},
        }
    }

    /// As [`Plan::evaluate`], with metrics that somebody else computes. `custom` is asked for variants
    /// that can be built and fulfil the constraints on parameters.
    ///
    /// A panic while the variant is built or measured becomes a row with the code [`PANIC`].
    ///
    /// # Errors
    /// Those of `custom`.
    pub fn evaluate_with<E>(&self, variant: &Variant, custom: AskMore<E>) -> Result<Row, E> {
        let mut row = Row::new(variant.number, variant.values.clone());
        let mut parameters = self.numbers(variant);
        let broken = |is_early: bool, parameters: &Numbers, metrics: &Numbers| {
            let asked = self.constraints.iter().filter(|c| self.is_early(c) == is_early);
            asked.filter_map(|c| c.broken(parameters, metrics)).collect::<Vec<_>>()
        };
        let early = broken(true, &parameters, &Numbers::new());
        if !early.is_empty() {
            row.refuse(Status::Excluded, "constraint", early.join("; "));
            return Ok(row);
        }
        let (project, mut computed, changes) = match panics::caught(|| self.built(variant)) {
            Ok(Ok(built)) => built,
            Ok(Err(why)) => {
                row.refuse(Status::Invalid, "design", why);
                return Ok(row);
            }
            Err(panic) => {
                row.refuse(Status::Failed, PANIC, panic.to_string());
                return Ok(row);
            }
        };
        row.changes = changes;
        let overrides = variant.overrides.iter().chain(&row.changes).cloned().collect();
        let more = custom(&Variant { overrides, ..variant.clone() }, &project)?;
        computed.values.extend(more.values.into_iter().filter(|(name, _)| self.has_metric(name)));
        computed.notes.extend(more.notes);
        let is_number = |value: &f64| value.is_finite();
        let wrong: Vec<String> = computed
            .values
            .iter()
            .filter(|(_, value)| !is_number(value))
            .map(|(name, value)| format!("{name} is {value}"))
            .collect();
        computed.values.retain(|_, value| is_number(value));
        row.metrics = computed.values;
        row.notes = computed.notes;
        if !wrong.is_empty() {
            row.refuse(Status::Failed, "not-finite", wrong.join("; "));
            return Ok(row);
        }
        // What follows from other parameters is known now.
        for setting in project.settings() {
            if let Some(number) = parameters.get_mut(&setting.path)
                && let Some(value) = quantity::parse(setting.kind, &setting.value)
            {
                *number = value;
            }
        }
        let late = broken(false, &parameters, &row.metrics);
        if !late.is_empty() {
            row.refuse(Status::Excluded, "constraint", late.join("; "));
        }
        Ok(row)
    }

    /// A variant's design with its built-in metrics, or why there is none.
    fn built(&self, variant: &Variant) -> Result<(Project, Computed, Vec<String>), String> {
        #[cfg(test)]
        panics::tests::misbehave(&variant.overrides);
        let told = |invalid: InvalidDesign| {
            let messages: Vec<&str> = invalid.problems.iter().map(|p| &*p.message).collect();
            messages.join("; ")
        };
        let changes = self.changes(variant).map_err(told)?;
        let overrides = [&variant.overrides[..], &changes].concat();
        let project = self.source.load(&overrides).map_err(told)?;
        let mut computed = Computed::default();
        metrics::compute(&project, &self.known.metrics, &self.shared, &mut computed)
            .map_err(|why| why.to_string())?;
        Ok((project, computed, changes))
    }

    /// Builds a variant's design with its fixtures.
    ///
    /// # Errors
    /// Everything that keeps it from being built.
    pub fn load(&self, variant: &Variant) -> Result<Project, InvalidDesign> {
        let changes = self.changes(variant)?;
        let overrides = [&variant.overrides[..], &changes].concat();
        self.source.load(&overrides)
    }

    /// What else has to change for a variant, as `path=value`; nothing unless the plan says so.
    ///
    /// # Errors
    /// Rules that contradict each other.
    fn changes(&self, variant: &Variant) -> Result<Vec<String>, InvalidDesign> {
        if self.fix { changes(&self.source, &variant.overrides) } else { Ok(Vec::new()) }
    }

    /// Whether a constraint is decided before a variant is built: by what is written for it.
    fn is_early(&self, constraint: &Constraint) -> bool {
        let is_written = |path: &str| {
            let is_axis = self.axes.iter().any(|axis| axis.path == path);
            is_axis || self.known.parameters.get(path).is_some_and(|base| !base.follows)
        };
        constraint.is_of_parameters() && constraint.parameters().all(is_written)
    }

    /// The parameters of a variant that constraints speak of.
    fn numbers(&self, variant: &Variant) -> Numbers {
        let spoken_of = |path: &str| self.constraints.iter().any(|c| c.mentions(path));
        let base = self.known.parameters.iter().filter(|(path, _)| spoken_of(path));
        let base = base.filter_map(|(path, base)| {
            Some((path.clone(), quantity::parse(base.kind, &base.value)?))
        });
        let axes = self.axes.iter().zip(&variant.values);
        let axes = axes.filter_map(|(axis, value)| Some((axis.path.clone(), value.number()?)));
        // The axes' values replace the sensor's own.
        base.chain(axes).collect()
    }
}
