"""Design sweeps: many variants of one sensor, with metrics of each.

A plan (``fabkit schema --sweep`` describes it) names a sensor, the parameters to vary, constraints
and metrics. :func:`run` computes one row for each variant, on threads of this machine or on any
executor, and writes ``sweep.csv``, ``sweep.parquet`` and ``report.html``. Rows depend only on the
plan, so the tables are the same bytes on every executor.

>>> import fabkit, tempfile
>>> plan = fabkit.sweep.load({
...     "sensor": "rtac0",
...     "axes": {"camera.depth": {"from": "6 mm", "to": "7 mm", "steps": 3}},
...     "metrics": ["coverage"],
... })
>>> len(plan), plan.evaluate(0).parameters
(3, {'camera.depth_mm': 6.0})
>>> with tempfile.TemporaryDirectory() as folder:
...     fabkit.sweep.run(plan, folder).status["ok"]
3
"""

from __future__ import annotations

import csv
import functools
import json
import math
import os
import sys
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from fabkit import _fabkit
from fabkit._executors import completed, submitter
from fabkit._progress import shown
from fabkit.designs import Sensor
from fabkit.errors import FabkitError, InvalidInputError, Problem, invalid, unknown

if TYPE_CHECKING:
    from collections.abc import Iterable
    from os import PathLike

    from fabkit._progress import Progress

__all__ = ["Axis", "Explorer", "MetricError", "Plan", "Row", "Sweep", "load", "run"]


def __dir__() -> list[str]:
    return __all__


Metric: TypeAlias = Callable[[Sensor], float]
"""A metric: a function that rates a variant's sensor."""

# Most variants in one task: a lost worker loses no more rows than these.
_MOST_TOGETHER = 16


class MetricError(InvalidInputError):
    """A user-defined metric raised an exception or did not return a finite number."""

    def __init__(self, metric: str, variant: int, why: str) -> None:
        text = f"the metric `{metric}` of variant {variant} {why}"
        hint = "finished rows are kept; correct the metric and run again with resume=True"
        super().__init__(f"{text}\n  = help: {hint}", problems=(Problem(text, hint),))
        self.metric = metric
        """Name of the metric."""
        self.variant = variant
        """Number of the variant."""
        self.why = why
        """Reason, for example ``is nan``."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self.metric, self.variant, self.why))


@dataclass(frozen=True)
class Axis:
    """A parameter that a sweep varies: a range of numbers, or a list of choices."""

    path: str
    """Path of the parameter, for example ``camera.depth``."""
    unit: str
    """Unit: ``mm``, ``deg``, or empty."""
    choices: tuple[str, ...] | None = None
    """Choices as in sensor files; ``None`` for a range."""
    low: float = 0.0
    """Lower end of the range, in the axis's unit."""
    high: float = 0.0
    """Upper end of the range, in the axis's unit."""
    log: bool = False
    """True for a logarithmic axis."""
    steps: int | None = None
    """Number of values on a grid; ``None`` for a continuous range."""
    whole: bool = False
    """True if all values are integers."""

    def text(self, value: object) -> str:
        """Write a value as in a sensor file; a number gets the axis's unit."""
        if isinstance(value, str):
            return value
        if isinstance(value, bool):
            return str(value).lower()
        number = int(value) if self.whole else value  # pyright: ignore[reportArgumentType, reportCallIssue, reportUnknownVariableType]
        return f"{number} {self.unit}".rstrip()


@dataclass(frozen=True)
class Row:
    """Result of one variant: a row of the table."""

    variant: int
    """Number of the variant."""
    status: str
    """Status: ``ok``, ``excluded``, ``invalid`` or ``failed``."""
    error_code: str | None
    """Cause if not ok: ``design``, ``constraint``, ``not-finite``, or ``panic`` (a bug in
    fabkit)."""
    reason: str | None
    """Reason in words if not ok."""
    notes: list[str]
    """Reasons for cells that are empty."""
    parameters: dict[str, float | str]
    """Values of the axes, by column."""
    metrics: dict[str, float]
    """Values of the metrics that apply to the variant, by column."""


@dataclass(frozen=True)
class Sweep:
    """A finished sweep."""

    folder: Path
    """Folder of ``sweep.csv``, ``sweep.parquet``, ``sweep.json`` and ``report.html``."""
    variants: int
    """Number of rows in the tables."""
    status: dict[str, int]
    """Number of variants by status."""
    pareto: int
    """Number of variants on the Pareto front."""

    def rows(self) -> list[dict[str, str]]:
        """Read the table: a dictionary of texts by column for each row."""
        with (self.folder / "sweep.csv").open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


class Plan:
    """A valid sweep plan; see :func:`load`."""

    def __init__(self, native: _fabkit.SweepPlan) -> None:
        self._native = native
        self.sensor = native.sensor()
        """Name or path of the sensor, as in the plan."""
        self.columns = native.columns()
        """Name of the table column of each axis."""
        self.objectives = dict(native.objectives())
        """Direction of each objective, ``min`` or ``max``, by metric."""
        self.axes = [_axis(json.loads(space)) for space in native.space()]
        """The parameters to vary, in order."""

    def __len__(self) -> int:
        """Return the number of variants."""
        return self._native.count()

    def overrides(self, variant: int) -> dict[str, str]:
        """Return the parameters that a variant changes, by path, for :func:`fabkit.load`."""
        return dict(text.split("=", 1) for text in self._native.overrides(variant))

    def evaluate(self, variant: int, metrics: Mapping[str, Metric] | None = None) -> Row:
        """Compute the row of a variant; ``metrics`` are user-defined ones, by name."""
        return self._row(self.line(variant, metrics))

    def line(self, variant: int, metrics: Mapping[str, Metric] | None = None) -> str:
        """Compute the row of a variant as a line of JSON, for transfer between processes."""
        return self._native.row(variant, None, _metric_function(self, variant, metrics))

    def _row(self, line: str) -> Row:
        about: dict[str, Any] = json.loads(line)
        values = dict(zip(self.columns, about.pop("parameters"), strict=True))
        return Row(parameters=values, **about)


class Explorer:
    """An ask-and-tell interface for optimisers that choose the variants themselves.

    >>> import fabkit
    >>> plan = {"sensor": "rtac0", "axes": {"camera.depth": {"from": "6 mm", "to": "7 mm"}},
    ...         "sample": 1, "metrics": ["coverage"], "objectives": {"coverage": "max"}}
    >>> explorer = fabkit.sweep.Explorer(plan)
    >>> near, far = (explorer.tell({"camera.depth": depth}) for depth in (6.0, 7.0))
    >>> near.metrics["coverage"] < far.metrics["coverage"]
    True
    """

    def __init__(
        self,
        plan: Plan | Mapping[str, object] | str | PathLike[str],
        metrics: Mapping[str, Metric] | None = None,
    ) -> None:
        self.plan = load(plan, metrics=metrics or ())
        """The plan: axes to vary and metrics to compute."""
        self._metrics = metrics
        self._lines: list[str] = []

    def ask(self, trial: Any) -> dict[str, object]:
        """Let an Optuna trial, or any object with its ``suggest_...`` methods, choose values.

        Returns a value for each axis, by path, for :meth:`tell`.
        """
        values: dict[str, object] = {}
        for axis in self.plan.axes:
            if axis.choices is not None:
                values[axis.path] = trial.suggest_categorical(axis.path, list(axis.choices))
            elif axis.whole:
                low, high = int(axis.low), int(axis.high)
                values[axis.path] = trial.suggest_int(axis.path, low, high, log=axis.log)
            else:
                suggest = trial.suggest_float
                values[axis.path] = suggest(axis.path, axis.low, axis.high, log=axis.log)
        return values

    def tell(self, values: Mapping[str, object]) -> Row:
        """Compute the row of a variant.

        ``values`` has a value for each axis, by path; numbers are in the axis's unit.
        """
        known = [axis.path for axis in self.plan.axes]
        for path in values:
            if path not in known:
                raise unknown("axis", path, known)
        missing = [path for path in known if path not in values]
        if missing:
            raise invalid(f"no value for {', '.join(missing)}")
        number = len(self._lines)
        texts = [axis.text(values[axis.path]) for axis in self.plan.axes]
        asked = _metric_function(self.plan, number, self._metrics)
        line = self.plan._native.row(number, texts, asked)  # pyright: ignore[reportPrivateUsage]
        self._lines.append(line)
        return self.plan._row(line)  # pyright: ignore[reportPrivateUsage]

    def objectives(self, row: Row) -> list[float] | None:
        """Return the objectives of a row, in the plan's order; ``None`` if any is missing."""
        names = self.plan.objectives
        if row.status != "ok" or any(name not in row.metrics for name in names):
            return None
        return [row.metrics[name] for name in names]

    def save(self, out: str | PathLike[str]) -> Sweep:
        """Write the tables of all rows so far into a new folder."""
        native = self.plan._native  # pyright: ignore[reportPrivateUsage]
        return _finished_sweep(_fabkit.save_sweep(os.fspath(out), native, self._lines))


def load(
    plan: Plan | Mapping[str, object] | str | PathLike[str],
    *,
    metrics: Iterable[str] = (),
) -> Plan:
    """Load a sweep plan.

    Parameters
    ----------
    plan
        A YAML file, or its content as a mapping, which does not need ``format``.
    metrics
        Names of user-defined metrics that constraints and objectives may use.

    Raises
    ------
    FabkitError
        The plan or its sensor has errors (all are listed), or a constraint on parameters excludes
        all variants.
    """
    names = list(metrics)
    if isinstance(plan, Plan):
        return plan
    if isinstance(plan, Mapping):
        text = json.dumps({"format": 1, **plan}, indent=2)
        return Plan(_fabkit.SweepPlan.of_text("plan", text, "", names))
    return Plan(_fabkit.SweepPlan.read(os.fspath(plan), names))


def run(
    plan: Plan | Mapping[str, object] | str | PathLike[str],
    out: str | PathLike[str],
    *,
    executor: Any = None,
    metrics: Mapping[str, Metric] | None = None,
    resume: bool = False,
    progress: Progress = None,
    retries: int = 3,
) -> Sweep:
    """Compute a row for each variant of a plan, and write the tables.

    Parameters
    ----------
    plan
        A YAML file, its content as a mapping, or a :class:`Plan`.
    out
        Folder to write to; it must be empty or not exist, unless ``resume``.
    executor
        ``None`` for threads of this machine; anything with the interface of
        ``concurrent.futures``; a ``dask.distributed.Client``, or the address of its scheduler,
        ``"tcp://host:8786"``. Workers need fabkit, not the plan's files.
    metrics
        User-defined metrics by name, each a function of the variant's :class:`fabkit.Sensor`.
        Workers must be able to import them, unless the executor can send functions.
    resume
        Continue an earlier run of the same plan that was stopped.
    progress
        ``False`` for none, or a function of ``(done, total)``. Default: a bar if tqdm is
        installed.
    retries
        Number of further attempts at rows whose worker was lost.

    Raises
    ------
    MetricError
        A user-defined metric raised an exception or did not return a finite number; finished rows
        are kept.
    FabkitError
        The plan is invalid, no variant is left, the executor cannot be reached or is broken, or
        the folder is not empty.
    """
    metrics = dict(metrics or {})
    plan = load(plan, metrics=metrics)
    native = plan._native  # pyright: ignore[reportPrivateUsage]
    with shown(progress, "variants") as told:
        if executor is None and not metrics:
            return _finished_sweep(
                _fabkit.run_sweep(os.fspath(out), native, resume, sys.executable, told)
            )
        path = os.fspath(out)
        with (
            submitter(executor, retries) as submit,
            closing(_fabkit.SweepStore.open(path, native, resume)) as store,
        ):
            missing = store.missing()
            # About 64 tasks or more, each of at most 16 rows.
            together = min(max(len(missing) // 64, 1), _MOST_TOGETHER)
            tasks = [missing[i : i + together] for i in range(0, len(missing), together)]
            done = len(plan) - len(missing)
            work = functools.partial(_rows, native.source(), metrics=metrics)
            for lines in completed(submit, work, tasks, retries, "variants"):
                store.put(lines)
                done += len(lines)
                if told is not None:
                    told(done, len(plan))
            return _finished_sweep(store.finish())


def _rows(
    source: str, numbers: list[int], *, metrics: dict[str, Metric]
) -> tuple[list[str], MetricError | None]:
    """Compute rows, here or on a worker; return them with the error that stopped it, if any."""
    plan = _plan(source)
    native = plan._native  # pyright: ignore[reportPrivateUsage]
    if not metrics and not native.bench():
        return native.rows(numbers), None
    lines: list[str] = []
    for number in numbers:
        try:
            lines.append(plan.line(number, metrics))
        except MetricError as error:
            return lines, error
    return lines, None


# A worker parses each plan once, not once a task.
@functools.lru_cache(maxsize=4)
def _plan(source: str) -> Plan:
    return Plan(_fabkit.SweepPlan.of_source(source))


def _metric_function(
    plan: Plan, variant: int, metrics: Mapping[str, Metric] | None
) -> Callable[[_fabkit.Project], tuple[list[tuple[str, float]], list[str]]] | None:
    """Return the function that computes user-defined and bench metrics; ``None`` without any."""
    native = plan._native  # pyright: ignore[reportPrivateUsage]
    benched = bool(native.bench())
    if not metrics and not benched:
        return None

    def ask(project: _fabkit.Project) -> tuple[list[tuple[str, float]], list[str]]:
        sensor = Sensor(project, plan.sensor)
        values, notes = _bench_metrics(sensor, native) if benched else ({}, [])
        for name, metric in (metrics or {}).items():
            try:
                value = float(metric(sensor))
            except Exception as error:
                raise MetricError(name, variant, f"raised {error!r}") from error
            if not math.isfinite(value):
                raise MetricError(name, variant, f"is {value}")
            values[name] = value
        return list(values.items()), notes

    return ask


def _bench_metrics(sensor: Sensor, plan: _fabkit.SweepPlan) -> tuple[dict[str, float], list[str]]:
    """Compute a variant's bench metrics; return none and a note where presses are impossible."""
    # Without the package no variant has bench metrics: an error, not a note in each row.
    try:
        import fabkit_bench  # other sweeps need none of it
        from fabkit_bench import _models  # pyright: ignore[reportPrivateUsage]
    except ImportError as error:
        hint = "pip install fabkit-cad[bench]"
        raise invalid(
            "the bench's figures need fabkit-bench, which is not installed", hint
        ) from error
    _models.require()
    try:
        # The bench draws from seeds below 2^31; a plan's may be larger.
        return fabkit_bench.figures(sensor, seed=plan.seed() % 2**31, names=plan.bench()), []
    except FabkitError as error:
        return {}, [f"bench: {str(error).splitlines()[0]}"]


def _axis(space: dict[str, Any]) -> Axis:
    choices = space.pop("choices", None)
    return Axis(choices=None if choices is None else tuple(choices), **space)


def _finished_sweep(document: str) -> Sweep:
    about: dict[str, Any] = json.loads(document)
    if about["none_left"] is not None:
        hint = f"the rows are in {about['folder']}"
        raise invalid(f"no variant is left: {about['none_left']}", hint)
    return Sweep(Path(about["folder"]), about["variants"], about["status"], about["pareto"])
