"""Running of the experiments of a sensor's family."""

from __future__ import annotations

import importlib
import pkgutil
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from fabkit.designs import Sensor, load
from fabkit.errors import FabkitError, invalid, unknown
from fabkit_bench import _models
from fabkit_bench import families as _experiments
from fabkit_bench._bench import Bench, Family, row_of_failure
from fabkit_bench._report import Report, Row

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

__all__ = ["experiments", "figures", "run"]


def families() -> list[str]:
    """List the families that have experiments."""
    return sorted(
        module.name.replace("_", "-") for module in pkgutil.iter_modules(_experiments.__path__)
    )


def run(
    design: Sensor | str,
    *,
    quick: bool = True,
    seed: int = 0,
    rows: Sequence[str] | None = None,
    tell: Callable[[str], None] | None = None,
    size: Any = None,
) -> Report:
    """Run the experiments of the paper that introduced a sensor's family.

    Parameters
    ----------
    design
        A sensor, or the name of one. A file that extends a built-in sensor gets the experiments of
        the same family.
    quick
        Run few presses and small sizes, in minutes; otherwise larger sizes, with the same models.
    seed
        Seed of press positions, noise and models, 0 or more. The same seed gives the same figures.
    rows
        Names of the experiments to run, of :func:`experiments`. Default: all, but if ``quick``
        only those that do not need PyTorch.
    tell
        Function that is called with a text when something begins.
    size
        Own sizes, a ``Size`` of the family's module; for tests.

    Raises
    ------
    FabkitError
        The family has no experiments, an experiment is unknown, the seed is out of range,
        scikit-learn is missing, or no experiment can be run on the sensor.

    >>> import fabkit, fabkit_bench
    >>> try:
    ...     fabkit_bench.run("rtac0", rows=["depths"])
    ... except fabkit.FabkitError as error:
    ...     print(error.hint)
    did you mean `depth`?
    """
    started = time.monotonic()
    bench, family = _ready(design, seed, quick, size, tell)
    known = list(family.experiments)
    usual = [name for name in known if not (quick and name in family.deep)]
    names = usual if rows is None else list(rows)
    for name in names:
        if name not in known:
            raise unknown("experiment", name, known)
    if not set(names) <= family.plain:
        # Fail now, not after minutes of presses.
        _models.require()
    found: list[Row] = []
    failures: list[FabkitError] = []
    with _models.one_thread():
        for name in names:
            bench.experiment = name
            bench.tell(f"{bench.design.name}: {name}")
            try:
                rows_of = family.experiments[name](bench)
            except FabkitError as error:
                # A changed design may not support one experiment: the others still run.
                failures.append(error)
                rows_of = [row_of_failure(name, error)]
            found += [replace(row, experiment=name) for row in rows_of]
    if failures and len(failures) == len(names):
        raise failures[0]
    document = bench.document()
    return Report(
        sensor=bench.design.name,
        title=bench.design.title,
        reference=bench.design.reference,
        design_hash=bench.design.design_hash,
        seed=seed,
        quick=quick,
        rows=found,
        choices=[*family.choices, *bench.notes],
        constants=document["constants"],
        left_out=[*family.left_out, *document["left_out"]],
        seconds=time.monotonic() - started,
        networks=bench.networks,
    )


def figures(
    design: Sensor | str,
    *,
    seed: int = 0,
    names: Collection[str] | None = None,
    size: Any = None,
) -> dict[str, float]:
    """Compute a few metrics of a design for sweeps, in seconds.

    Parameters
    ----------
    design, seed, size
        As for :func:`run`.
    names
        Names of the metrics to compute. Default: all of the family.

    Returns
    -------
    Metrics by name: ``depth_mae_mm`` on domes and flat gels, ``localisation_mm`` and
    ``force_mae_n`` on half ellipsoids, and so on. They are errors, so smaller is better, unless
    the name says otherwise.

    Raises
    ------
    FabkitError
        As for :func:`run`.
    """
    bench, family = _ready(design, seed, True, size, None, small=True)
    _models.require()
    with _models.one_thread():
        wanted = [name for name in family.figures if names is None or name in names]
        return {name: family.figures[name](bench) for name in wanted}


def experiments(design: Sensor | str) -> list[str]:
    """List the names of a sensor's experiments, for :func:`run`.

    >>> import fabkit_bench
    >>> fabkit_bench.experiments("rtac0")
    ['depth', 'largest-depth']
    """
    return list(_family(load(design) if isinstance(design, str) else design).experiments)


def _ready(
    design: Sensor | str,
    seed: int,
    quick: bool,
    size: Any,
    tell: Callable[[str], None] | None,
    small: bool = False,
) -> tuple[Bench, Family]:
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**31:  # pyright: ignore[reportUnnecessaryIsInstance]
        raise invalid(f"the seed is {seed!r}; it must be a whole number from 0 to 2147483647")
    design = load(design) if isinstance(design, str) else design
    family = _family(design)
    if size is None:
        size = family.small if small else family.quick if quick else family.full
    # Sweeps need metrics only: no networks are kept.
    return Bench(design, seed, size, tell, keeps=not small), family


def _family(design: Sensor) -> Family:
    """Import the experiments of a sensor's family."""
    name = design.family
    if name not in families():
        hint = f"there are experiments for {', '.join(families())}"
        raise invalid(f"{design.name} is of the family {name}, which has no experiment", hint)
    module = importlib.import_module(f"{_experiments.__name__}.{name.replace('-', '_')}")
    return module.FAMILY
