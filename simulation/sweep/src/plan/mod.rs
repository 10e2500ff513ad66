//! Plans: the parameters to vary, and the metrics to compute for each variant.

mod axis;
mod constraint;
mod quantity;
mod reading;
mod schema;

use std::collections::BTreeMap;

use fabkit_designs::{BaseFile, SensorText, UserFile};
use fabkit_fixtures::Project;
use fabkit_geometry::sequences;
use fabkit_text::{InvalidDesign, ValueKind};
use serde::{Deserialize, Serialize};

pub use axis::PlanAxis;
pub use constraint::Constraint;
pub(crate) use constraint::Numbers;
pub use schema::json_schema;

use crate::metrics::{self, ComputedMetrics, Metric};
use crate::panics;
use crate::row::{PANIC, Row, Status, Value};

/// Largest number of variants of a plan.
pub const MAX_VARIANTS: usize = 100_000;
/// Largest number of axes of a plan.
pub const MAX_AXES: usize = sequences::MAX_DIMENSIONS;

/// Everything that a plan is made from, sufficient to recreate it on another machine.
///
/// ```
/// use fabkit_sweep::PlanSource;
/// let source = PlanSource::new("sweep.yaml", "sensor: mine.yaml", "mine.yaml", "format: 1");
/// // One line, from which another machine makes the same plan.
/// let line = source.to_json()?;
/// assert!(!line.contains('\n'));
/// assert_eq!(PlanSource::from_json(&line)?, source);
/// # Ok::<(), fabkit_sweep::InvalidSource>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanSource {
    /// Name of the plan in messages.
    pub file: String,
    /// Text of the plan, YAML.
    pub text: String,
    /// Name of the sensor's file in messages.
    pub sensor_file: String,
    /// Text of the sensor, YAML.
    pub sensor_yaml: String,
    /// Base files that the sensor extends: texts in the order of [`BaseFile`]'s fields.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensor_bases: Vec<[String; 4]>,
    /// Names of custom metrics, which the caller computes.
    pub custom_metrics: Vec<String>,
    /// Name and text of the file with the user's settings for all sensors.
    #[serde(default)]
    pub user: Option<(String, String)>,
}

impl PlanSource {
    /// Creates a source without base files and custom metrics.
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

    /// Returns the base files that the sensor extends.
    pub fn bases(&self) -> Vec<BaseFile> {
        let base =
            |[by, word, file, text]: [String; 4]| BaseFile { extending_file: by, word, file, text };
        self.sensor_bases.iter().cloned().map(base).collect()
    }

    /// Adds the base files that the sensor extends.
    #[must_use]
    pub fn with_bases(mut self, bases: &[BaseFile]) -> Self {
        let texts = |base: BaseFile| [base.extending_file, base.word, base.file, base.text];
        self.sensor_bases = bases.iter().cloned().map(texts).collect();
        self
    }

    /// Loads the sensor with overrides.
    ///
    /// # Errors
    /// Returns all problems of the sensor.
    pub(crate) fn load(&self, overrides: &[String]) -> Result<Project, InvalidDesign> {
        self.with_text(|text| fabkit_fixtures::load_text(text, overrides))
    }

    /// Calls `work` with all texts from which the sensor is read.
    fn with_text<R>(&self, work: impl FnOnce(SensorText) -> R) -> R {
        let user = self.user.clone().map(|(file, text)| UserFile { file, text });
        let (file, yaml, bases) = (&*self.sensor_file, &*self.sensor_yaml, &*self.bases());
        work(SensorText { file, yaml, bases, user: user.as_ref(), omitted: None })
    }
}

/// Error of a text that is not the source of a plan.
#[derive(Debug, thiserror::Error)]
#[error("this is not the source of a plan: {0}")]
pub struct InvalidSource(#[from] serde_json::Error);

impl PlanSource {
    /// Writes one line of JSON, for transmission.
    ///
    /// # Errors
    /// Does not fail for texts.
    pub fn to_json(&self) -> Result<String, InvalidSource> {
        Ok(serde_json::to_string(self)?)
    }

    /// Reads the JSON of [`PlanSource::to_json`].
    ///
    /// # Errors
    /// Returns [`InvalidSource`] for any other text.
    pub fn from_json(json: &str) -> Result<Self, InvalidSource> {
        Ok(serde_json::from_str(json)?)
    }
}

/// Choice of the variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// All combinations of the axes' values; the last axis changes fastest.
    Grid,
    /// Given number of points of a scrambled Halton sequence.
    Sample(usize),
}

/// Direction of improvement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Smaller is better.
    Min,
    /// Larger is better.
    Max,
}

impl Direction {
    /// Name of the direction in plans.
    pub fn word(self) -> &'static str {
        match self {
            Self::Min => "min",
            Self::Max => "max",
        }
    }
}

/// Metric to minimise or maximise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Objective {
    /// Name of the metric.
    pub metric: String,
    /// Direction of improvement.
    pub direction: Direction,
}

/// Parameter with the sensor's value.
#[derive(Clone, Debug)]
pub(crate) struct BaseParameter {
    pub kind: ValueKind,
    pub value: String,
    /// True if the value follows from other parameters, so that it is known only after a variant is built.
    pub is_derived: bool,
}

/// Names that a plan may refer to.
#[derive(Debug)]
pub(crate) struct KnownNames {
    pub parameters: BTreeMap<String, BaseParameter>,
    pub metrics: Vec<&'static Metric>,
    pub custom: Vec<String>,
}

impl KnownNames {
    /// Returns whether rows will have a metric of this name.
    fn is_computed(&self, name: &str) -> bool {
        let of = |metric: &&'static Metric| metric.covers(name);
        self.custom.iter().any(|custom| custom == name) || self.metrics.iter().any(of)
    }

    fn names(&self) -> Vec<String> {
        let metrics = self.metrics.iter().map(|metric| metric.name.to_owned());
        self.parameters.keys().cloned().chain(metrics).chain(self.custom.clone()).collect()
    }
}

/// Variant: its number and its changes of the sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Number of the variant, from 0.
    pub number: usize,
    /// Overrides `path=value`, as for `--set`: the plan's fixed ones, then the axes.
    pub overrides: Vec<String>,
    /// Values on the axes, in their order.
    pub values: Vec<Value>,
}

/// Finds the additional changes that make the sensor buildable with some overrides.
fn find_changes(source: &PlanSource, overrides: &[String]) -> Result<Vec<String>, InvalidDesign> {
    let others = [fabkit_fixtures::KEY];
    let changes = source.with_text(|text| fabkit_designs::fixing::fix(text, overrides, &others))?;
    Ok(changes.iter().map(fabkit_designs::fixing::ValueChange::as_override).collect())
}

/// Custom metrics of a variant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CustomMetrics {
    /// Metrics by name; those that the plan does not contain are ignored.
    pub values: Vec<(String, f64)>,
    /// Reasons why others are missing.
    pub notes: Vec<String>,
}

/// Function that computes custom metrics of a variant, given with its additional changes, and of its design.
pub type ComputeCustomMetrics<'a, E> =
    &'a mut dyn FnMut(&Variant, &Project) -> Result<CustomMetrics, E>;

/// Plan that has been read and checked.
///
/// ```
/// use fabkit_sweep::{Plan, PlanSource, Value};
///
/// let text = "
/// format: 1
/// sensor: rtac0
/// axes: {camera.depth: [6 mm, 7 mm], camera.field_of_view: {from: 100 deg, to: 120 deg, steps: 3}}
/// metrics: [coverage]
/// ";
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let plan = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml))?;
/// // All combinations; the last axis changes fastest.
/// assert_eq!(plan.len(), 2 * 3);
/// assert_eq!(plan.variant(1).values, [Value::Number(6.0), Value::Number(110.0)]);
/// assert_eq!(plan.variant(3).overrides, ["camera.depth=7 mm", "camera.field_of_view=100 deg"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Plan {
    /// Cache of results that variants share; rows do not depend on it.
    pub(crate) shared: metrics::MetricsCache,
    pub(crate) source: PlanSource,
    /// Sensor as named in the plan.
    pub(crate) sensor: String,
    pub(crate) seed: u64,
    pub(crate) sampling: Sampling,
    pub(crate) axes: Vec<PlanAxis>,
    pub(crate) fixed: Vec<String>,
    /// True if chosen values follow the axes, so that fewer variants are invalid.
    pub(crate) adapts_chosen_values: bool,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) objectives: Vec<Objective>,
    pub(crate) known: KnownNames,
    len: usize,
}

impl Plan {
    /// Returns the number of variants.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns whether there are no variants, which [`Plan::new`] refuses.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Sensor as named in the plan.
    pub fn sensor(&self) -> &str {
        &self.sensor
    }

    /// Axes: the parameters that are varied.
    pub fn axes(&self) -> &[PlanAxis] {
        &self.axes
    }

    /// Objectives: the metrics to minimise or maximise.
    pub fn objectives(&self) -> &[Objective] {
        &self.objectives
    }

    /// Metrics that rows have, if they apply.
    pub fn metrics(&self) -> &[&'static Metric] {
        &self.known.metrics
    }

    /// Returns whether rows may have a metric of this name, custom ones included.
    pub fn has_metric(&self, name: &str) -> bool {
        self.known.is_computed(name)
    }

    /// Lists the metrics of the bench that rows need. [`Plan::evaluate`] leaves them empty, [`Plan::evaluate_with`]
    /// requests them.
    pub fn bench_metrics(&self) -> impl Iterator<Item = &'static str> {
        let metrics = self.known.metrics.iter();
        metrics
            .filter(|metric| metric.group == metrics::MetricGroup::Bench)
            .map(|metric| metric.name)
    }

    /// Seed of the sample, and of the bench.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns whether values that fabkit chose follow the axes, so that fewer variants are invalid.
    pub fn adapts_chosen_values(&self) -> bool {
        self.adapts_chosen_values
    }

    /// Source of the plan.
    pub fn source(&self) -> &PlanSource {
        &self.source
    }

    /// Computes a BLAKE3 hash, in hex, over everything that determines the rows: plan, sensor, version.
    ///
    /// ```
    /// use fabkit_sweep::{Plan, PlanSource};
    ///
    /// let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// let hash = |depth: &str| -> Result<String, Box<dyn std::error::Error>> {
    ///     let text = format!("format: 1\nsensor: rtac0\naxes: {{camera.depth: [{depth}]}}\nmetrics: [coverage]\n");
    ///     Ok(Plan::new(PlanSource::new("sweep.yaml", &text, "rtac0.yaml", yaml))?.hash())
    /// };
    /// assert_eq!(hash("6 mm")?, hash("6 mm")?);
    /// assert_ne!(hash("6 mm")?, hash("7 mm")?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let PlanSource { text, sensor_yaml, custom_metrics, sensor_bases, user, .. } = &self.source;
        let bases = sensor_bases.iter().map(|[_, _, _, text]| &**text);
        let own = bases.chain(user.as_ref().map(|(_, text)| &**text));
        let custom_metrics = custom_metrics.join("\n");
        for part in
            [fabkit_export::VERSION, text, sensor_yaml, &custom_metrics].into_iter().chain(own)
        {
            // The length keeps different divisions of the same text apart.
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part.as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Returns a variant by its number.
    ///
    /// # Panics
    /// Panics if `number` is not below [`Plan::len`].
    pub fn variant(&self, number: usize) -> Variant {
        assert!(number < self.len, "there are {} variants, not {number}", self.len);
        let texts: Vec<String> = match self.sampling {
            Sampling::Grid => {
                // The digits of the number in a mixed-radix system, one digit for each axis.
                let mut rest = number;
                let mut indices = vec![0; self.axes.len()];
                for (index, axis) in indices.iter_mut().zip(&self.axes).rev() {
                    let len = axis.len().unwrap_or(1);
                    *index = rest % len;
                    rest /= len;
                }
                self.axes
                    .iter()
                    .zip(indices)
                    .map(|(axis, index)| axis.value_text_at_index(index))
                    .collect()
            }
            Sampling::Sample(_) => {
                let shares = sequences::halton(number as u64, self.axes.len(), self.seed);
                self.axes
                    .iter()
                    .zip(shares)
                    .map(|(axis, share)| axis.value_text_at_fraction(share))
                    .collect()
            }
        };
        self.variant_at(number, &texts)
    }

    /// Creates a variant that the plan does not number itself from the value of each axis, in their order, as sensor
    /// files write it. A variant that cannot be built gets a row that says so.
    ///
    /// ```
    /// use fabkit_sweep::{Plan, PlanSource};
    ///
    /// let axes = "axes: {camera.depth: {from: 6 mm, to: 7 mm, steps: 2}}";
    /// let text = &format!("format: 1\nsensor: rtac0\n{axes}\nmetrics: [coverage]\n");
    /// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// let plan = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml))?;
    /// // An optimiser asks for a depth between those of the plan, and for one that cannot be.
    /// let between = plan.variant_at(2, &["6.5 mm".into()]);
    /// assert_eq!(between.overrides, ["camera.depth=6.5 mm"]);
    /// let project = plan.load(&between)?;
    /// assert!(project.design.parameters.iter().any(|one| one.path == "camera.depth" && one.value == "6.5 mm"));
    /// assert!(plan.load(&plan.variant_at(3, &["-1 mm".into()])).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn variant_at(&self, number: usize, texts: &[String]) -> Variant {
        let pairs = || self.axes.iter().zip(texts);
        let set = pairs().map(|(axis, text)| format!("{}={text}", axis.path));
        Variant {
            number,
            overrides: self.fixed.iter().cloned().chain(set).collect(),
            values: pairs().map(|(axis, text)| axis.cell(text)).collect(),
        }
    }

    /// Builds a variant and computes its row, which is the same at any time on any machine.
    ///
    /// # Panics
    /// Panics if `number` is not below [`Plan::len`].
    pub fn evaluate(&self, number: usize) -> Row {
        let nothing = &mut |_: &Variant, _: &Project| {
            Ok::<_, std::convert::Infallible>(CustomMetrics::default())
        };
        match self.evaluate_with(&self.variant(number), nothing) {
            Ok(row) => row,
            Err(never) => match never {},
        }
    }

    /// Computes a row like [`Plan::evaluate`], with custom metrics. `custom` is called for variants that can be built
    /// and fulfil the constraints on parameters.
    ///
    /// A panic while the variant is built or measured becomes a row with the code [`PANIC`].
    ///
    /// # Errors
    /// Returns the errors of `custom`.
    ///
    /// ```
    /// use fabkit_sweep::{CustomMetrics, Plan, PlanSource};
    ///
    /// let text = "format: 1\nsensor: rtac0\naxes: {camera.depth: [6 mm, 7 mm]}\nmetrics: [coverage]\n";
    /// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// let mut source = PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml);
    /// source.custom_metrics = vec!["bodies".into()];
    /// let plan = Plan::new(source)?;
    /// let row = plan.evaluate_with(&plan.variant(0), &mut |_, project| {
    ///     let bodies = project.design.sensor.bodies.len() as f64;
    ///     Ok::<_, String>(CustomMetrics { values: vec![("bodies".into(), bodies)], notes: Vec::new() })
    /// })?;
    /// assert!(row.metrics["bodies"] > 1.0 && row.metrics.contains_key("coverage"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn evaluate_with<E>(
        &self,
        variant: &Variant,
        custom: ComputeCustomMetrics<E>,
    ) -> Result<Row, E> {
        let mut row = Row::new(variant.number, variant.values.clone());
        let mut parameters = self.constraint_values(variant);
        let broken = |is_early: bool, parameters: &Numbers, metrics: &Numbers| {
            let asked = self.constraints.iter().filter(|c| self.is_early(c) == is_early);
            asked.filter_map(|c| c.violation(parameters, metrics)).collect::<Vec<_>>()
        };
        let early = broken(true, &parameters, &Numbers::new());
        if !early.is_empty() {
            row.set_failure(Status::Excluded, "constraint", early.join("; "));
            return Ok(row);
        }
        let (project, mut computed, changes) = match panics::catch_panics(|| self.build(variant)) {
            Ok(Ok(built)) => built,
            Ok(Err(why)) => {
                row.set_failure(Status::Invalid, "design", why);
                return Ok(row);
            }
            Err(panic) => {
                row.set_failure(Status::Failed, PANIC, panic.to_string());
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
            row.set_failure(Status::Failed, "not-finite", wrong.join("; "));
            return Ok(row);
        }
        // Values that follow from other parameters are known now.
        for setting in project.settings() {
            if let Some(number) = parameters.get_mut(&setting.path)
                && let Some(value) = quantity::parse(setting.kind, &setting.value)
            {
                *number = value;
            }
        }
        // Constraints on metrics and on derived parameters can be checked only now.
        let late = broken(false, &parameters, &row.metrics);
        if !late.is_empty() {
            row.set_failure(Status::Excluded, "constraint", late.join("; "));
        }
        Ok(row)
    }

    /// Builds a variant's design with its built-in metrics and additional changes; returns the reason if that fails.
    fn build(&self, variant: &Variant) -> Result<(Project, ComputedMetrics, Vec<String>), String> {
        #[cfg(test)]
        panics::tests::misbehave(&variant.overrides);
        let told = |invalid: InvalidDesign| {
            let messages: Vec<&str> = invalid.problems.iter().map(|p| &*p.message).collect();
            messages.join("; ")
        };
        let changes = self.find_changes(variant).map_err(told)?;
        let overrides = [&variant.overrides[..], &changes].concat();
        let project = self.source.load(&overrides).map_err(told)?;
        let mut computed = ComputedMetrics::default();
        metrics::compute(&project, &self.known.metrics, &self.shared, &mut computed)
            .map_err(|why| why.to_string())?;
        Ok((project, computed, changes))
    }

    /// Builds a variant's design with its fixtures.
    ///
    /// # Errors
    /// Returns all problems that keep it from being built.
    pub fn load(&self, variant: &Variant) -> Result<Project, InvalidDesign> {
        let changes = self.find_changes(variant)?;
        let overrides = [&variant.overrides[..], &changes].concat();
        self.source.load(&overrides)
    }

    /// Finds the additional changes of a variant, as `path=value`; none unless the plan asks for them.
    ///
    /// # Errors
    /// Fails for rules that contradict each other.
    fn find_changes(&self, variant: &Variant) -> Result<Vec<String>, InvalidDesign> {
        if self.adapts_chosen_values {
            find_changes(&self.source, &variant.overrides)
        } else {
            Ok(Vec::new())
        }
    }

    /// Returns whether a constraint can be checked before a variant is built, from written values alone.
    fn is_early(&self, constraint: &Constraint) -> bool {
        let is_written = |path: &str| {
            let is_axis = self.axes.iter().any(|axis| axis.path == path);
            is_axis || self.known.parameters.get(path).is_some_and(|base| !base.is_derived)
        };
        constraint.depends_on_parameters_only() && constraint.parameters().all(is_written)
    }

    /// Returns the values of a variant's parameters that occur in constraints.
    fn constraint_values(&self, variant: &Variant) -> Numbers {
        let spoken_of = |path: &str| self.constraints.iter().any(|c| c.mentions(path));
        let base = self.known.parameters.iter().filter(|(path, _)| spoken_of(path));
        let base = base.filter_map(|(path, base)| {
            Some((path.clone(), quantity::parse(base.kind, &base.value)?))
        });
        let axes = self.axes.iter().zip(&variant.values);
        let axes = axes.filter_map(|(axis, value)| Some((axis.path.clone(), value.number()?)));
        // The values on the axes replace the sensor's own, because they come later.
        base.chain(axes).collect()
    }
}
