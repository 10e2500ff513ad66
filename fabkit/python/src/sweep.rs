//! Design sweeps: plans, rows as lines of JSON, and the folder that stores them.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use fabkit_application::designs::UserFile;
use fabkit_application::diagnostics::{DiagnosedDesign, SourceText};
use fabkit_application::progress::ProgressStep;
use fabkit_application::source::Source;
use fabkit_application::sweep::{CustomMetrics, Plan, PlanSource, Variant};
use fabkit_application::sweep_runs::{self, Store, Sweep};
use fabkit_application::{documents, fixtures};
use pyo3::prelude::*;

use crate::design::Project;
use crate::errors::{Failure, OrRaise, exception};
use crate::running::{InterruptPolicy, run_on_thread, run_short};

/// Valid plan of a sweep.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct SweepPlan {
    plan: Arc<Plan>,
    /// Sensor that is varied, for callers that receive its projects.
    sensor: Arc<Source>,
}

impl SweepPlan {
    fn new(plan: Plan) -> Self {
        let PlanSource { sensor_file, sensor_yaml, user, .. } = plan.source();
        let main = SourceText { file: sensor_file.clone(), text: sensor_yaml.clone() };
        let user = user.clone().map(|(file, text)| UserFile { file, text });
        let source = Source::from_texts(main, plan.source().bases()).with_user(user);
        Self { sensor: Arc::new(source), plan: Arc::new(plan) }
    }

    fn variant(&self, number: usize) -> Result<Variant, Failure> {
        if number < self.plan.len() {
            return Ok(self.plan.variant(number));
        }
        let message = format!("there is no variant {number}: there are {}", self.plan.len());
        Err(Failure::call(message))
    }
}

#[pymethods]
impl SweepPlan {
    #[staticmethod]
    fn read(py: Python<'_>, path: &str, custom: Vec<String>) -> PyResult<Self> {
        let plan = run_short(py, || sweep_runs::read_plan(Path::new(path), &custom))?;
        Ok(Self::new(plan.or_raise(py)?))
    }

    /// Reads a plan from text. A sensor's path is relative to `folder`.
    #[staticmethod]
    fn of_text(
        py: Python<'_>,
        file: &str,
        text: &str,
        folder: &str,
        custom: Vec<String>,
    ) -> PyResult<Self> {
        let plan =
            run_short(py, || sweep_runs::parse_plan(file, text, Path::new(folder), &custom))?;
        Ok(Self::new(plan.or_raise(py)?))
    }

    /// Restores the plan from [`SweepPlan::source`], on any machine.
    #[staticmethod]
    fn of_source(py: Python<'_>, source: &str) -> PyResult<Self> {
        let plan = run_short(py, || {
            let source = PlanSource::from_json(source).map_err(Failure::bug)?;
            Plan::new(source).map_err(|invalid| Failure::from(DiagnosedDesign::new(invalid, [])))
        })?;
        Ok(Self::new(plan.or_raise(py)?))
    }

    fn source(&self, py: Python<'_>) -> PyResult<String> {
        self.plan.source().to_json().map_err(|error| exception(py, Failure::bug(error)))
    }

    /// The sensor's name or path as written in the plan.
    fn sensor(&self) -> &str {
        self.plan.sensor()
    }

    fn count(&self) -> usize {
        self.plan.len()
    }

    /// The search space of each axis, as JSON.
    fn space(&self) -> Vec<String> {
        self.plan.axes().iter().map(|axis| axis.search_space().to_string()).collect()
    }

    /// The column name of each axis.
    fn columns(&self) -> Vec<String> {
        self.plan.axes().iter().map(|axis| axis.column()).collect()
    }

    /// Objectives: metric, and `min` or `max`.
    fn objectives(&self) -> Vec<(String, &'static str)> {
        let objectives = self.plan.objectives().iter();
        objectives.map(|o| (o.metric.clone(), o.direction.word())).collect()
    }

    fn overrides(&self, py: Python<'_>, number: usize) -> PyResult<Vec<String>> {
        Ok(self.variant(number).or_raise(py)?.overrides)
    }

    /// Computes rows of variants, as lines of JSON.
    fn rows(&self, py: Python<'_>, numbers: Vec<usize>) -> PyResult<Vec<String>> {
        let plan = Arc::clone(&self.plan);
        for number in &numbers {
            self.variant(*number).or_raise(py)?;
        }
        run_on_thread(py, InterruptPolicy::Abandon, None, move |link| {
            let mut lines = Vec::with_capacity(numbers.len());
            for number in numbers {
                if link.is_cancelled() {
                    break;
                }
                lines.push(plan.evaluate(number).to_line().map_err(Failure::bug)?);
            }
            Ok(lines)
        })
    }

    /// Benchmark metrics that rows need; `custom` has to provide them.
    fn bench(&self) -> Vec<&'static str> {
        self.plan.bench_metrics().collect()
    }

    /// The seed of the sampling and of the benchmark.
    fn seed(&self) -> u64 {
        self.plan.seed()
    }

    /// Computes the row of a variant, or of the values `texts` of the axes. `custom` receives the variant's project and
    /// returns metrics by name, and notes on missing ones.
    fn row(
        &self,
        py: Python<'_>,
        number: usize,
        texts: Option<Vec<String>>,
        custom: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let variant = match texts {
            None => self.variant(number).or_raise(py)?,
            Some(texts) => self.plan.variant_at(number, &texts),
        };
        let (plan, sensor) = (Arc::clone(&self.plan), Arc::clone(&self.sensor));
        let row = run_short(py, move || {
            let mut ask = |variant: &Variant, project: &fixtures::Project| {
                // Called without the interpreter's lock, which is taken only for the caller's function.
                let Some(custom) = &custom else { return Ok::<_, PyErr>(CustomMetrics::default()) };
                Python::attach(|py| {
                    let project = Arc::new(project.clone());
                    let (source, overrides) = (Arc::clone(&sensor), variant.overrides.clone());
                    let project = Project { source, project, overrides, changes: Vec::new() };
                    let (values, notes) = custom.call1(py, (project,))?.extract(py)?;
                    Ok(CustomMetrics { values, notes })
                })
            };
            plan.evaluate_with(&variant, &mut ask)
        })??;
        row.to_line().map_err(|error| exception(py, Failure::bug(error)))
    }
}

/// Folder of a sweep.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct SweepStore {
    plan: Arc<Plan>,
    folder: String,
    /// `None` once it is finished.
    store: Mutex<Option<Store>>,
}

impl SweepStore {
    fn with<T>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Option<Store>) -> Result<T, Failure> + Send,
    ) -> PyResult<T>
    where
        T: Send,
    {
        let result = run_short(py, || match self.store.lock() {
            Ok(mut store) => work(&mut store),
            Err(error) => Err(Failure::bug(error)),
        })?;
        result.or_raise(py)
    }
}

fn finished() -> Failure {
    Failure::bug("the sweep is finished")
}

#[pymethods]
impl SweepStore {
    #[staticmethod]
    fn open(py: Python<'_>, folder: String, plan: &SweepPlan, resume: bool) -> PyResult<Self> {
        let plan = Arc::clone(&plan.plan);
        let store =
            run_short(py, || Store::open(Path::new(&folder), &plan, resume))?.or_raise(py)?;
        Ok(Self { plan, folder, store: Mutex::new(Some(store)) })
    }

    /// Variants whose rows are missing.
    fn missing(&self, py: Python<'_>) -> PyResult<Vec<usize>> {
        self.with(py, |store| Ok(store.as_ref().ok_or_else(finished)?.missing()))
    }

    fn put(&self, py: Python<'_>, lines: Vec<String>) -> PyResult<()> {
        self.with(py, |store| {
            let rows = sweep_runs::parse_rows(&lines)?;
            Ok(store.as_ref().ok_or_else(finished)?.store_rows(&self.plan, &rows)?)
        })
    }

    /// Releases the folder's lock.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |store| {
            *store = None;
            Ok(())
        })
    }

    /// Writes the tables. Returns a `fabkit-sweep-report` document.
    fn finish(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |store| {
            let store = store.take().ok_or_else(finished)?;
            let finished = store.finish(&self.plan, &|| false)?;
            Ok(documents::sweep(Path::new(&self.folder), &finished).to_string())
        })
    }
}

/// Computes and writes a sweep on all threads. `python` is the interpreter for benchmarks. Returns a
/// `fabkit-sweep-report` document.
#[pyfunction]
#[pyo3(signature = (folder, plan, resume, python, progress))]
pub fn run_sweep(
    py: Python<'_>,
    folder: String,
    plan: &SweepPlan,
    resume: bool,
    python: PathBuf,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<String> {
    let plan = Arc::clone(&plan.plan);
    run_on_thread(py, InterruptPolicy::Wait, progress.as_ref(), move |link| {
        let folder = Path::new(&folder);
        let show = |step: ProgressStep| link.show(step.done, step.total);
        let sweep = Sweep { plan: &plan, resume, python: Some(&python) };
        let finished = sweep_runs::run(folder, sweep, &show, &|| link.is_cancelled())?;
        Ok(documents::sweep(folder, &finished).to_string())
    })
}

/// Writes the tables of rows that an optimiser chose. Returns a `fabkit-sweep-report` document.
#[pyfunction]
pub fn save_sweep(
    py: Python<'_>,
    folder: &str,
    plan: &SweepPlan,
    lines: Vec<String>,
) -> PyResult<String> {
    let folder = Path::new(folder);
    let saved = run_short(py, || {
        let finished = sweep_runs::write_rows(folder, &plan.plan, sweep_runs::parse_rows(&lines)?)?;
        Ok::<_, Failure>(documents::sweep(folder, &finished).to_string())
    })?;
    saved.or_raise(py)
}
