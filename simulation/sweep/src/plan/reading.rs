//! Reading of plans from YAML, with all problems together.

mod axes;
mod exclusion;

use fabkit_text::{
    Dialect, InvalidDesign, NodeReader, Position, Problem, TextLayer, TextPlace, ValueKind,
    YamlEntry, YamlNode, read_mapping, suggestion, take_format, to_printable,
};

use super::{
    BaseParameter, Constraint, Direction, KnownNames, MAX_AXES, MAX_VARIANTS, Objective, Plan,
    PlanSource, Sampling, quantity,
};
use crate::metrics::{self, Metric};

const KEYS: [&str; 10] = [
    "format",
    "sensor",
    "seed",
    "sample",
    "set",
    "fix",
    "axes",
    "constraints",
    "metrics",
    "objectives",
];

/// Dialect of plan files.
const PLAN: Dialect = Dialect::new("sweep", 1, ", `sensor: NAME` and `axes:`");

/// Position of missing keys in messages.
const START: Position = Position { line: 1, column: 1 };

/// Parses the top level of a plan, and collects its problems.
fn entries(file: &str, text: &str) -> Result<(Vec<YamlEntry>, NodeReader), InvalidDesign> {
    let mut reading = NodeReader::new(TextPlace::new(TextLayer::File, file, &PLAN).at(START));
    match read_mapping(text, &reading.place, &mut reading.found) {
        Some(entries) => Ok((entries, reading)),
        None => Err(reading.into_invalid()),
    }
}

fn find<'n>(entries: &'n [YamlEntry], key: &str) -> Option<&'n YamlEntry> {
    entries.iter().find(|entry| entry.key == key)
}

impl Plan {
    /// Returns the sensor that a plan names: a built-in one, or a file.
    ///
    /// # Errors
    /// Fails for a text that cannot be read, or names no sensor.
    ///
    /// ```
    /// use fabkit_sweep::Plan;
    /// assert_eq!(Plan::sensor_name("sweep.yaml", "sensor: rtac0")?, "rtac0");
    /// let invalid = Plan::sensor_name("sweep.yaml", "format: 1").unwrap_err();
    /// assert_eq!(invalid.problems[0].message, "the sensor is missing");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sensor_name(file: &str, text: &str) -> Result<String, InvalidDesign> {
        read_sensor_name(file, text)
    }

    /// Reads a plan.
    ///
    /// # Errors
    /// Returns all problems of the plan, with their lines; then those of its sensor; then constraints on parameters
    /// that no variant fulfils.
    ///
    /// ```
    /// use fabkit_sweep::{Plan, PlanSource};
    ///
    /// let text = "
    /// format: 1
    /// sensor: rtac0
    /// axes: {camera.dept: [6 mm, 7 mm]}
    /// metrics: [covrage]
    /// ";
    /// let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
    /// // Both misspelled names are told at once.
    /// let invalid = Plan::new(PlanSource::new("sweep.yaml", text, "rtac0.yaml", yaml)).unwrap_err();
    /// assert_eq!(invalid.problems.iter().map(|problem| problem.line).collect::<Vec<_>>(), [Some(4), Some(5)]);
    /// assert_eq!(invalid.problems[1].hint.as_deref(), Some("did you mean `coverage`?"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(source: PlanSource) -> Result<Self, InvalidDesign> {
        read(source)
    }
}

/// Returns the sensor that a plan names.
fn read_sensor_name(file: &str, text: &str) -> Result<String, InvalidDesign> {
    let (entries, mut reading) = entries(file, text)?;
    let sensor = match find(&entries, "sensor") {
        Some(entry) => reading.read_scalar("sensor", &entry.value).map(str::to_owned),
        None => {
            let names = fabkit_designs::builtin_names();
            let hint = format!("write `sensor: NAME` with one of {}, or a path", names.join(", "));
            reading.report_problem(START, "sensor", "", "the sensor is missing", hint);
            None
        }
    };
    sensor.ok_or_else(|| reading.into_invalid())
}

/// Reads a plan.
fn read(source: PlanSource) -> Result<Plan, InvalidDesign> {
    let sensor = read_sensor_name(&source.file, &source.text)?;
    let (mut entries, mut reading) = entries(&source.file, &source.text)?;
    take_format(&mut entries, &reading.place, &mut reading.found);
    check_keys(&mut reading, &entries);
    let (fixed, places) = read_fixed_overrides(&mut reading, &entries);

    let fix = find(&entries, "fix").is_some_and(|entry| is_true(&mut reading, entry));
    // The sensor with the fixed overrides shows which parameters exist.
    let project = if fix { super::find_changes(&source, &fixed) } else { Ok(Vec::new()) };
    let project = project.and_then(|changes| source.load(&[&fixed[..], &changes].concat()));
    let project = match project {
        Ok(project) => project,
        Err(invalid) => {
            let placed = invalid.problems.into_iter().map(|problem| {
                // A fixed override stands in the plan, not on the command line.
                let at = places
                    .iter()
                    .find(|(path, _)| problem.file == "--set" && problem.path == *path);
                match at {
                    Some((_, at)) => Problem {
                        file: source.file.clone(),
                        line: Some(at.line),
                        column: Some(at.column),
                        ..problem
                    },
                    None => problem,
                }
            });
            let mut invalid = reading.into_invalid();
            invalid.extend(placed);
            return Err(invalid);
        }
    };
    let base = |s: &fabkit_text::Setting| {
        let follows = s.expression.is_some();
        (
            s.path.clone(),
            BaseParameter { kind: s.kind, value: s.value.clone(), is_derived: follows },
        )
    };
    let mut known = KnownNames {
        parameters: project.settings().map(base).collect(),
        metrics: Vec::new(),
        custom: source.custom_metrics.clone(),
    };
    let node = |key: &str| find(&entries, key).map(|entry| &entry.value);
    known.metrics = match node("metrics") {
        Some(node) => read_metrics(&mut reading, node),
        None => metrics::default_metrics(),
    };
    let seed = node("seed").and_then(|n| reading.read_count("seed", n, [0, u64::MAX])).unwrap_or(0);
    let sample = node("sample").map(|n| reading.read_count("sample", n, [1, MAX_VARIANTS as u64]));
    let sampling = match sample {
        None => Sampling::Grid,
        Some(count) => Sampling::Sample(count.unwrap_or(1) as usize),
    };
    let axes = match find(&entries, "axes") {
        Some(entry) => {
            let axes = axes::read(&mut reading, &entry.value, &known, sampling);
            for axis in &axes {
                if let Some((_, at)) = places.iter().find(|(path, _)| *path == axis.path) {
                    let message = format!("{} is set, and is an axis too", axis.path);
                    reading.report_problem(*at, &axis.path, "", message, "keep one of them");
                }
            }
            axes
        }
        None => {
            let hint = "write `axes:`, then for example `  camera.depth: [6 mm, 8 mm]`";
            reading.report_problem(START, "axes", "", "the plan has no axes", hint);
            Vec::new()
        }
    };
    let mut constraints = Vec::new();
    for item in
        node("constraints").map(|node| reading.read_list("constraints", node)).unwrap_or(&[])
    {
        let Some(text) = reading.read_scalar("constraints", item) else { continue };
        match Constraint::read(text, &known) {
            Ok(constraint) => constraints.push((constraint, item.position)),
            Err((message, hint)) => {
                reading.report_problem(item.position, "constraints", text, message, hint);
            }
        }
    }
    let objectives = match node("objectives") {
        Some(node) => read_objectives(&mut reading, node, &known),
        None => Vec::new(),
    };
    let len = match sampling {
        Sampling::Sample(count) => count,
        Sampling::Grid => {
            let lens = axes.iter().filter_map(|axis| axis.len());
            // The product may overflow before it can be compared with the limit.
            let len = lens.fold(1usize, usize::saturating_mul);
            if len > MAX_VARIANTS {
                let at = find(&entries, "axes").map(|entry| entry.key_position);
                let message = format!("the axes have {len} combinations; at most {MAX_VARIANTS}");
                let hint = "take fewer steps, or add `sample: 1000` to draw some of them";
                reading.report_problem(at.unwrap_or(START), "axes", "", message, hint);
            }
            len
        }
    };
    if !reading.found.is_empty() {
        return Err(reading.into_invalid());
    }
    let (constraints, places): (Vec<_>, Vec<_>) = constraints.into_iter().unzip();
    let plan = Plan {
        shared: Default::default(),
        sensor,
        seed,
        sampling,
        axes,
        fixed,
        adapts_chosen_values: fix,
        constraints,
        objectives,
        known,
        len,
        source: source.clone(),
    };
    exclusion::require_a_variant(&mut reading, &plan, &places);
    reading.finish(Some(plan))
}

/// Reads the key `fix`.
fn is_true(reading: &mut NodeReader, entry: &YamlEntry) -> bool {
    match reading.read_scalar("fix", &entry.value) {
        Some("true") => true,
        Some("false") | None => false,
        Some(other) => {
            let message =
                format!("fix is `{}`, which is neither true nor false", to_printable(other));
            let hint = "write `true` or `false`";
            reading.report_problem(entry.value.position, "fix", other, message, hint);
            false
        }
    }
}

/// Reports unknown keys.
fn check_keys(reading: &mut NodeReader, entries: &[YamlEntry]) {
    for entry in entries {
        if !KEYS.contains(&&*entry.key) {
            let message = format!("`{}` is not a key of a sweep", to_printable(&entry.key));
            let hint = suggestion(&entry.key, KEYS, "the keys are");
            reading.report_problem(entry.key_position, &entry.key, &entry.key, message, hint);
        }
    }
}

/// Reads the overrides that all variants share, with their positions.
fn read_fixed_overrides(
    reading: &mut NodeReader,
    entries: &[YamlEntry],
) -> (Vec<String>, Vec<(String, Position)>) {
    let Some(entry) = find(entries, "set") else { return Default::default() };
    let mut overrides = Vec::new();
    let mut places = Vec::new();
    for entry in reading.read_map("set", &entry.value) {
        if let Some(text) = axes::value_text(reading, &entry.key, &entry.value) {
            overrides.push(format!("{}={text}", entry.key));
            places.push((entry.key.clone(), entry.key_position));
        }
    }
    (overrides, places)
}

/// Reads the metrics of the plan.
fn read_metrics(reading: &mut NodeReader, node: &YamlNode) -> Vec<&'static Metric> {
    let mut wanted = Vec::new();
    for item in reading.read_list("metrics", node) {
        let Some(word) = reading.read_scalar("metrics", item) else { continue };
        let found = metrics::metrics_by_word(word);
        if found.is_empty() {
            let message = format!("`{}` is not a metric", to_printable(word));
            let hint = suggestion(word, metrics::words(), "the metrics are");
            reading.report_problem(item.position, "metrics", word, message, hint);
        }
        wanted.extend(found);
    }
    // In the order of the table, each once.
    let is_wanted = |metric: &&Metric| wanted.iter().any(|w: &&Metric| w.name == metric.name);
    metrics::METRICS.iter().filter(is_wanted).collect()
}

/// Reads the objectives of the plan.
fn read_objectives(
    reading: &mut NodeReader,
    node: &YamlNode,
    known: &KnownNames,
) -> Vec<Objective> {
    let mut objectives = Vec::new();
    for entry in reading.read_map("objectives", node) {
        let name = metrics::current_name(&entry.key);
        if !known.is_computed(name) {
            let (message, hint) = if metrics::is_metric(name) {
                (
                    format!("`{name}` is not among the metrics of this plan"),
                    format!("add `{name}` to `metrics`"),
                )
            } else {
                let names = known.metrics.iter().map(|metric| metric.name);
                let names: Vec<&str> = names.chain(known.custom.iter().map(|c| &**c)).collect();
                let hint = suggestion(name, names, "the metrics are");
                (format!("`{}` is not a metric", to_printable(name)), hint)
            };
            reading.report_problem(entry.key_position, "objectives", name, message, hint);
        }
        let Some(word) = reading.read_scalar(name, &entry.value) else { continue };
        let directions = [Direction::Min, Direction::Max];
        match directions.into_iter().find(|direction| direction.word() == word) {
            Some(direction) => objectives.push(Objective { metric: name.into(), direction }),
            None => {
                let message = format!("`{}` is neither `min` nor `max`", to_printable(word));
                let hint = format!("write `{name}: min` or `{name}: max`");
                reading.report_problem(entry.value.position, name, word, message, hint);
            }
        }
    }
    objectives
}

/// Returns whether a text is a value of a kind, as far as that is known without the sensor.
fn is_value_of(kind: ValueKind, text: &str) -> bool {
    match kind {
        ValueKind::Switch => matches!(text, "true" | "false"),
        ValueKind::Text => !text.is_empty(),
        ValueKind::List => text.starts_with('['),
        _ => quantity::parse(kind, text).is_some(),
    }
}

/// Limits for reading an axis: numbers of axes and of variants.
const LIMITS: [usize; 2] = [MAX_AXES, MAX_VARIANTS];
