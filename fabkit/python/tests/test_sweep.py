"""Sweeps from Python: the command's bytes on any executor, and errors that name the cause."""

from __future__ import annotations

import importlib
import json
import math
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

import fabkit
from fabkit import _fabkit, bench

PLAN = """\
format: 1
sensor: rtac0
sample: 24
seed: 5
axes:
  camera.depth: {from: 6 mm, to: 7.4 mm}
  camera.field_of_view: {from: 120 deg, to: 175 deg}
  translucent_gel.thickness: [1.4 mm, 1.5 mm, 0.7 mm]
metrics: [camera, calibration]
constraints: [coverage > 0.45]
objectives: {coverage: max, mm_per_px_median: min}
"""

TABLES = ("sweep.csv", "sweep.parquet", "report.html", "sweep.json")


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    path = tmp_path / "sweep.yaml"
    path.write_text(PLAN)
    return path


def tables(folder: Path) -> dict[str, bytes]:
    assert sorted(path.name for path in folder.iterdir()) == sorted(TABLES)
    return {name: (folder / name).read_bytes() for name in TABLES}


def shell_mass(sensor: fabkit.Sensor) -> float:
    return 1e-3 * sensor.parts["shell"].mesh(tolerance_mm=0.2).volume_mm3


def test_any_executor_gives_the_bytes_of_the_command(plan: Path, tmp_path: Path) -> None:
    code = _fabkit.command(["fabkit", "sweep", str(plan), "-o", str(tmp_path / "a"), "--quiet"])
    assert code == 0
    expected = tables(tmp_path / "a")
    sweep = fabkit.sweep.run(plan, tmp_path / "b")
    assert tables(tmp_path / "b") == expected
    assert sweep.variants == 24
    assert sum(sweep.status.values()) == 24
    assert sweep.status["invalid"] >= 3
    assert sum(row["pareto"] == "true" for row in sweep.rows()) == sweep.pareto
    with ThreadPoolExecutor(2) as threads:
        fabkit.sweep.run(plan, tmp_path / "c", executor=threads)
    assert tables(tmp_path / "c") == expected
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        fabkit.sweep.run(plan, tmp_path / "d", executor=processes)
    assert tables(tmp_path / "d") == expected


def test_user_metric_is_a_column(plan: Path, tmp_path: Path) -> None:
    metrics = {"shell_cm3": shell_mass}
    axes = {"shell.wall": ["1.5 mm", "1.52 mm"]}
    few = {"sensor": "rtac0", "axes": axes, "metrics": ["coverage"]}
    few["objectives"] = {"shell_cm3": "min"}
    sweep = fabkit.sweep.run(few, tmp_path / "a", metrics=metrics)
    thin, thick = (float(row["shell_cm3"]) for row in sweep.rows())
    assert thin < thick
    assert [row["pareto"] for row in sweep.rows()] == ["true", "false"]
    with ThreadPoolExecutor(2) as threads:
        fabkit.sweep.run(few, tmp_path / "b", metrics=metrics, executor=threads)
    assert tables(tmp_path / "a") == tables(tmp_path / "b")


@pytest.mark.parametrize(
    ("metric", "says"),
    [(lambda _: 1 / 0, "raised ZeroDivisionError"), (lambda _: math.nan, "is nan")],
)
def test_a_bad_metric_is_named_and_finished_rows_are_kept(
    tmp_path: Path, metric: fabkit.sweep.Metric, says: str
) -> None:
    plan = fabkit.sweep.load(
        {"sensor": "rtac0", "axes": {"camera.depth": [f"{d} mm" for d in (6, 6.5, 7)]}},
        metrics=["mine"],
    )

    def from_the_second(sensor: fabkit.Sensor) -> float:
        depth = sensor.parameters["camera.depth"].value
        return 6.0 if depth == 6.0 else metric(sensor)

    with pytest.raises(fabkit.sweep.MetricError, match=f"`mine` of variant 1 {says}") as caught:
        fabkit.sweep.run(plan, tmp_path / "out", metrics={"mine": from_the_second})
    assert (caught.value.metric, caught.value.variant) == ("mine", 1)
    kept = list((tmp_path / "out" / "sweep.partial").glob("rows-*.jsonl"))
    assert [json.loads(line)["variant"] for path in kept for line in path.open()] == [0]
    # With a corrected metric the sweep resumes; the rows are those of an undisturbed run.
    good = {"mine": lambda _: 6.0}
    fabkit.sweep.run(plan, tmp_path / "out", metrics=good, resume=True)
    fabkit.sweep.run(plan, tmp_path / "whole", metrics=good)
    assert tables(tmp_path / "out") == tables(tmp_path / "whole")


def test_bad_input_names_the_culprit(plan: Path, tmp_path: Path) -> None:
    with pytest.raises(fabkit.InvalidInputError, match=r"surface.raduis") as caught:
        fabkit.sweep.load({"sensor": "rtac0", "axes": {"surface.raduis": ["14 mm"]}})
    assert "surface.radius" in (caught.value.hint or "")
    everything = {"sensor": "rtac0", "axes": {"camera.depth": ["6 mm"]}, "metrics": ["coverage"]}
    with pytest.raises(fabkit.InvalidInputError, match="excludes all 1 variants"):
        fabkit.sweep.load({**everything, "constraints": ["camera.depth > 7 mm"]})
    with pytest.raises(fabkit.InvalidInputError, match="`coverage > 2` excludes 1 of 1"):
        fabkit.sweep.run({**everything, "constraints": ["coverage > 2"]}, tmp_path / "none")
    assert len((tmp_path / "none" / "sweep.csv").read_text().splitlines()) == 2
    with pytest.raises(fabkit.InvalidInputError, match="is not an executor"):
        fabkit.sweep.run(plan, tmp_path / "out", executor=7)
    assert not (tmp_path / "out").exists()
    with pytest.raises(fabkit.FabkitError, match="there is no variant 24"):
        fabkit.sweep.load(plan).evaluate(24)


def test_an_explorer_computes_what_an_optimiser_asks_for(tmp_path: Path) -> None:
    plan = {
        "sensor": "rtac0",
        "sample": 1,
        "axes": {
            "camera.depth": {"from": "6 mm", "to": "7.4 mm"},
            "mold.vents": {"from": 8, "to": 12},
            "shell.material": ["black PLA", "black ABS"],
        },
        "metrics": ["coverage", "parts_mass_g"],
        "objectives": {"coverage": "max"},
    }

    class Trial:
        """A stand-in for Optuna's trials that suggests the middle or the first choice."""

        def suggest_float(self, _: str, low: float, high: float, *, log: bool) -> float:
            assert not log
            return (low + high) / 2

        def suggest_int(self, _: str, low: int, high: int, *, log: bool) -> int:
            assert not log
            return (low + high) // 2

        def suggest_categorical(self, _: str, choices: list[str]) -> str:
            return choices[0]

    explorer = fabkit.sweep.Explorer(plan)
    values = explorer.ask(Trial())
    assert values == {"camera.depth": 6.7, "mold.vents": 10, "shell.material": "black PLA"}
    row = explorer.tell(values)
    assert explorer.objectives(row) == [row.metrics["coverage"]]
    bad = explorer.tell({**values, "camera.depth": 70.0})
    assert bad.status == "invalid"
    assert explorer.objectives(bad) is None
    with pytest.raises(fabkit.UnknownNameError, match=r"camera.dept"):
        explorer.tell({**values, "camera.dept": 6.0})
    sweep = explorer.save(tmp_path / "out")
    assert [r["camera.depth_mm"] for r in sweep.rows()] == ["6.7", "70"]


def test_data_from_workers_is_validated(plan: Path, tmp_path: Path) -> None:
    loaded = fabkit.sweep.load(plan)
    native = loaded._native  # pyright: ignore[reportPrivateUsage]
    store = _fabkit.SweepStore.open(str(tmp_path / "out"), native, False)
    line = json.loads(native.rows([3])[0])
    wrong = [
        ({**line, "variant": 24}, "variant 24, but there are 24"),
        ({**line, "variant": 4}, "variant 4, with other values than the plan's"),
        ({**line, "metrics": {"../x": 1.0}}, "`../x`, which is no metric"),
        ({"variant": 3}, "not a row of a sweep"),
    ]
    for row, says in wrong:
        with pytest.raises(fabkit.FabkitError, match=says):
            store.put([json.dumps(row)])
    assert not list((tmp_path / "out").rglob("*.jsonl"))
    with pytest.raises(fabkit.FabkitError, match="is being written to by process"):
        _fabkit.SweepStore.open(str(tmp_path / "out"), native, True)
    store.close()
    fabkit.sweep.run(plan, tmp_path / "out", resume=True)


def test_figures_of_the_bench_are_columns(tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    plan = {
        "sensor": "digit-like",
        "seed": 3,
        "axes": {"pad.thickness": ["2.5 mm", "3 mm"]},
        "metrics": ["depth_mae_mm", "coverage"],
        "objectives": {"depth_mae_mm": "min"},
    }
    by_workers = fabkit.sweep.run(plan, tmp_path / "a")
    assert by_workers.pareto == 1
    row = by_workers.rows()[0]
    sensor = fabkit.load("digit-like", fabkit.sweep.load(plan).overrides(0))
    figures = bench.figures(sensor, seed=3, names=["depth_mae_mm"])
    assert figures == {"depth_mae_mm": float(row["depth_mae_mm"])}


def test_impossible_bench_press_is_an_empty_cell_with_a_note() -> None:
    pytest.importorskip("sklearn")
    row = fabkit.sweep.load(
        {
            "sensor": "rtac0",
            # A gel thinner than the depth of the bench's semi-domes.
            "axes": {"translucent_gel.thickness": ["0.9 mm"]},
            "metrics": ["depth_mae_mm", "coverage"],
        }
    ).evaluate(0)
    assert (row.status, list(row.metrics)) == ("ok", ["coverage"])
    assert row.notes[0].startswith("bench: fixtures.semi_domes.depth.deepest is ")


def test_plans_know_every_figure_of_the_bench() -> None:
    from fabkit_bench import _run

    for name in _run.families():
        family = importlib.import_module(f"fabkit_bench.families.{name.replace('-', '_')}").FAMILY
        fabkit.sweep.load(
            {
                "sensor": "rtac0",
                "axes": {"camera.depth": ["7 mm"]},
                "metrics": list(family.figures),
            }
        )


def test_a_variant_can_be_changed_again() -> None:
    thicker: list[tuple[float, float]] = []

    def ask(sensor: fabkit.Sensor) -> float:
        again = sensor.replace(coat__thickness="0.2 mm")
        thicker.append((again.surface.radius, again.coat.thickness))
        return 1.0

    plan = {"sensor": "rtac0", "axes": {"surface.radius": ["16 mm"]}, "metrics": ["coverage"]}
    fabkit.sweep.load(plan, metrics=["mine"]).evaluate(0, {"mine": ask})
    assert thicker == [(16.0, 0.2)]
