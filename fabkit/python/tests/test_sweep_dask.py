"""Sweeps on a cluster: real worker processes on loopback, one of them killed."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest

import fabkit

distributed = pytest.importorskip("distributed")

PLAN = {
    "sensor": "rtac0",
    "sample": 40,
    "axes": {
        "camera.depth": {"from": "6 mm", "to": "7.4 mm"},
        "camera.field_of_view": {"from": "120 deg", "to": "175 deg"},
    },
    "metrics": ["coverage", "mm_per_px_median", "calibration"],
    "objectives": {"coverage": "max", "mm_per_px_median": "min"},
}


@pytest.fixture
def client():
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def test_a_killed_worker_loses_nothing(client, tmp_path: Path) -> None:
    local = fabkit.sweep.run(PLAN, tmp_path / "local")
    shown: list[int] = []
    killed: list[int] = []

    def kill() -> None:
        # In the middle of the sweep: some rows are finished, others are not.
        while not shown or shown[-1] < 8:
            time.sleep(0.01)
        pids = list(client.run(os.getpid).values())
        os.kill(pids[0], signal.SIGKILL)
        killed.extend(pids[:1])

    killer = threading.Thread(target=kill)
    killer.start()
    address = client.scheduler.address
    progress = lambda done, _: shown.append(done)  # noqa: E731
    sweep = fabkit.sweep.run(PLAN, tmp_path / "dask", executor=address, progress=progress)
    killer.join()
    assert killed
    assert max(shown) == 40
    assert sweep.variants == local.variants == 40
    for name in ("sweep.csv", "sweep.parquet", "report.html", "sweep.json"):
        assert (tmp_path / "dask" / name).read_bytes() == (tmp_path / "local" / name).read_bytes()


def test_metrics_are_pickled_and_their_errors_returned(client, tmp_path: Path) -> None:
    few = {"sensor": "rtac0", "axes": {"camera.depth": ["6 mm", "6.5 mm"]}, "metrics": ["coverage"]}
    metrics = {"twice": lambda sensor: 2 * sensor.parameters["camera.depth"].value}
    sweep = fabkit.sweep.run(few, tmp_path / "out", executor=client, metrics=metrics)
    assert [row["twice"] for row in sweep.rows()] == ["12", "13"]
    # `int` of the text "6.5 mm" raises.
    bad = {"bad": lambda sensor: int(sensor.parameters["camera.depth"].written[:-3])}
    with pytest.raises(fabkit.sweep.MetricError, match="`bad` of variant 1 raised ValueError"):
        fabkit.sweep.run(few, tmp_path / "bad", executor=client, metrics=bad)


def test_a_data_set_is_cast_on_the_cluster(client, tmp_path: Path) -> None:
    presses = tmp_path / "presses.txt"
    # The halves of twenty patterns fill three shards.
    presses.write_text("".join(f"semi-dome-{number:03}\n" for number in range(1, 21)))
    there = fabkit.dataset.write("rtac0", tmp_path / "there", presses=presses, executor=client)
    here = fabkit.dataset.write("rtac0", tmp_path / "here", presses=presses)
    assert len(there) == len(here) == 400
    files = sorted(path.relative_to(here.folder) for path in here.folder.rglob("*.*"))
    shards = [path for path in here.folder.rglob("c/**/*") if path.is_file()]
    assert len(shards) == 6
    for path in [*(here.folder / file for file in files), *shards]:
        same = there.folder / path.relative_to(here.folder)
        assert same.read_bytes() == path.read_bytes()


def test_an_unreachable_scheduler_is_named(tmp_path: Path) -> None:
    address = "tcp://127.0.0.1:9"
    with pytest.raises(fabkit.FabkitError, match=address):
        fabkit.sweep.run(PLAN, tmp_path / "out", executor=address)
    assert not (tmp_path / "out").exists()
