//! Reading of plans from YAML, with all problems together.

mod axes;
mod exclusion;

use fabkit_text::{
    Dialect, Entry, InvalidDesign, Kind, Node, Place, Position, Problem, Reading, TextLayer,
    check_format, mapping_of, shown, suggestion,
};

use super::{
    Base, Constraint, Direction, Known, MAX_AXES, MAX_VARIANTS, Objective, Plan, PlanSource,
    Sampling, quantity,
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
fn entries(file: &str, text: &str) -> Result<(Vec<Entry>, Reading), InvalidDesign> {
    let mut reading = Reading::new(Place::new(TextLayer::File, file, &PLAN).at(START));
    match mapping_of(text, &reading.place, &mut reading.found) {
        Some(entries) => Ok((entries, reading)),
        None => Err(reading.invalid()),
    }
}

fn find<'n>(entries: &'n [Entry], key: &str) -> Option<&'n Entry> {
    entries.iter().find(|entry| entry.key == key)
}

impl Plan {
    /// Returns the sensor that a plan names: a built-in one, or a file.
    ///
    /// # Errors
    /// Fails for a text that cannot be read, or names no sensor.
    pub fn sensor_of(file: &str, text: &str) -> Result<String, InvalidDesign> {
        sensor_of(file, text)
    }

    /// Reads a plan.
    ///
    /// # Errors
    /// Returns all problems of the plan, with their lines; then those of its sensor; then constraints on parameters
    /// that no variant fulfils.
    pub fn new(source: PlanSource) -> Result<Self, InvalidDesign> {
        read(source)
    }
}

/// Returns the sensor that a plan names.
fn sensor_of(file: &str, text: &str) -> Result<String, InvalidDesign> {
    let (entries, mut reading) = entries(file, text)?;
    let sensor = match find(&entries, "sensor") {
        Some(entry) => reading.scalar("sensor", &entry.value).map(str::to_owned),
        None => {
            let names = fabkit_designs::builtin_names();
            let hint = format!("write `sensor: NAME` with one of {}, or a path", names.join(", "));
            reading.problem(START, "sensor", "", "the sensor is missing", hint);
            None
        }
    };
    sensor.ok_or_else(|| reading.invalid())
}

/// Reads a plan.
fn read(source: PlanSource) -> Result<Plan, InvalidDesign> {
    let sensor = sensor_of(&source.file, &source.text)?;
    let (mut entries, mut reading) = entries(&source.file, &source.text)?;
    check_format(&mut entries, &reading.place, &mut reading.found);
    check_keys(&mut reading, &entries);
    let (fixed, places) = fixed(&mut reading, &entries);

    let fix = find(&entries, "fix").is_some_and(|entry| is_true(&mut reading, entry));
    // The sensor with the fixed overrides shows which parameters exist.
    let project = match fix {
        true => super::changes(&source, &fixed),
        false => Ok(Vec::new()),
    };
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
            let mut invalid = reading.invalid();
            invalid.problems.extend(placed);
            return Err(invalid);
        }
    };
    let base = |s: &fabkit_text::Setting| {
        let follows = s.expression.is_some();
        (s.path.clone(), Base { kind: s.kind, value: s.value.clone(), follows })
    };
    let mut known = Known {
        parameters: project.settings().map(base).collect(),
        metrics: Vec::new(),
        custom: source.custom_metrics.clone(),
    };
    let node = |key: &str| find(&entries, key).map(|entry| &entry.value);
    known.metrics = match node("metrics") {
        Some(node) => metrics_of(&mut reading, node),
        None => metrics::default_metrics(),
    };
    let seed = node("seed").and_then(|n| reading.count("seed", n, [0, u64::MAX])).unwrap_or(0);
    let sample = node("sample").map(|n| reading.count("sample", n, [1, MAX_VARIANTS as u64]));
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
                    reading.problem(*at, &axis.path, "", message, "keep one of them");
                }
            }
            axes
        }
        None => {
            let hint = "write `axes:`, then for example `  camera.depth: [6 mm, 8 mm]`";
            reading.problem(START, "axes", "", "the plan has no axes", hint);
            Vec::new()
        }
    };
    let mut constraints = Vec::new();
    for item in node("constraints").map(|node| reading.list("constraints", node)).unwrap_or(&[]) {
        let Some(text) = reading.scalar("constraints", item) else { continue };
        match Constraint::read(text, &known) {
            Ok(constraint) => constraints.push((constraint, item.position)),
            Err((message, hint)) => {
                reading.problem(item.position, "constraints", text, message, hint);
            }
        }
    }
    let objectives = match node("objectives") {
        Some(node) => objectives_of(&mut reading, node, &known),
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
                reading.problem(at.unwrap_or(START), "axes", "", message, hint);
            }
            len
        }
    };
    if !reading.found.is_empty() {
        return Err(reading.invalid());
    }
    let (constraints, places): (Vec<_>, Vec<_>) = constraints.into_iter().unzip();
    let plan = Plan {
        shared: Default::default(),
        sensor,
        seed,
        sampling,
        axes,
        fixed,
        fix,
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
fn is_true(reading: &mut Reading, entry: &Entry) -> bool {
    match reading.scalar("fix", &entry.value) {
        Some("true") => true,
        Some("false") | None => false,
        Some(other) => {
            let message = format!("fix is `{}`, which is neither true nor false", shown(other));
            let hint = "write `true` or `false`";
            reading.problem(entry.value.position, "fix", other, message, hint);
            false
        }
    }
}

/// Reports unknown keys.
fn check_keys(reading: &mut Reading, entries: &[Entry]) {
    for entry in entries {
        if !KEYS.contains(&&*entry.key) {
            let message = format!("`{}` is not a key of a sweep", shown(&entry.key));
            let hint = suggestion(&entry.key, KEYS, "the keys are");
            reading.problem(entry.key_position, &entry.key, &entry.key, message, hint);
        }
    }
}

/// Reads the overrides that all variants share, with their positions.
fn fixed(reading: &mut Reading, entries: &[Entry]) -> (Vec<String>, Vec<(String, Position)>) {
    let Some(entry) = find(entries, "set") else { return Default::default() };
    let mut overrides = Vec::new();
    let mut places = Vec::new();
    for entry in reading.map("set", &entry.value) {
        if let Some(text) = axes::value_text(reading, &entry.key, &entry.value) {
            overrides.push(format!("{}={text}", entry.key));
            places.push((entry.key.clone(), entry.key_position));
        }
    }
    (overrides, places)
}

/// Reads the metrics of the plan.
fn metrics_of(reading: &mut Reading, node: &Node) -> Vec<&'static Metric> {
    let mut wanted = Vec::new();
    for item in reading.list("metrics", node) {
        let Some(word) = reading.scalar("metrics", item) else { continue };
        let found = metrics::named(word);
        if found.is_empty() {
            let message = format!("`{}` is not a metric", shown(word));
            let hint = suggestion(word, metrics::words(), "the metrics are");
            reading.problem(item.position, "metrics", word, message, hint);
        }
        wanted.extend(found);
    }
    // In the order of the table, each once.
    let is_wanted = |metric: &&Metric| wanted.iter().any(|w: &&Metric| w.name == metric.name);
    metrics::METRICS.iter().filter(is_wanted).collect()
}

/// Reads the objectives of the plan.
fn objectives_of(reading: &mut Reading, node: &Node, known: &Known) -> Vec<Objective> {
    let mut objectives = Vec::new();
    for entry in reading.map("objectives", node) {
        let name = metrics::current(&entry.key);
        if !known.is_computed(name) {
            let (message, hint) = match metrics::is_metric(name) {
                true => (
                    format!("`{name}` is not among the metrics of this plan"),
                    format!("add `{name}` to `metrics`"),
                ),
                false => {
                    let names = known.metrics.iter().map(|metric| metric.name);
                    let names: Vec<&str> = names.chain(known.custom.iter().map(|c| &**c)).collect();
                    let hint = suggestion(name, names, "the metrics are");
                    (format!("`{}` is not a metric", shown(name)), hint)
                }
            };
            reading.problem(entry.key_position, "objectives", name, message, hint);
        }
        let Some(word) = reading.scalar(name, &entry.value) else { continue };
        let directions = [Direction::Min, Direction::Max];
        match directions.into_iter().find(|direction| direction.word() == word) {
            Some(direction) => objectives.push(Objective { metric: name.into(), direction }),
            None => {
                let message = format!("`{}` is neither `min` nor `max`", shown(word));
                let hint = format!("write `{name}: min` or `{name}: max`");
                reading.problem(entry.value.position, name, word, message, hint);
            }
        }
    }
    objectives
}

/// Returns whether a text is a value of a kind, as far as that is known without the sensor.
fn is_of(kind: Kind, text: &str) -> bool {
    match kind {
        Kind::Switch => matches!(text, "true" | "false"),
        Kind::Text => !text.is_empty(),
        Kind::List => text.starts_with('['),
        _ => quantity::parse(kind, text).is_some(),
    }
}

/// Limits for reading an axis: numbers of axes and of variants.
const LIMITS: [usize; 2] = [MAX_AXES, MAX_VARIANTS];
