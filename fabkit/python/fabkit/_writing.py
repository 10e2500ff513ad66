"""Writing of data sets, in this process or on workers of an executor."""

from __future__ import annotations

import functools
import os
from contextlib import closing
from typing import TYPE_CHECKING, Any

from fabkit import _fabkit
from fabkit._executors import completed, submitter
from fabkit._progress import shown
from fabkit.errors import FabkitError, Problem

if TYPE_CHECKING:
    from fabkit._progress import Progress
    from fabkit.depth import Scene


def write(
    scene: Scene,
    folder: str,
    options: dict[str, Any],
    executor: Any,
    progress: Progress,
    retries: int,
) -> None:
    """Write the missing files of a data set into ``folder``."""
    order = _order(scene, options)
    with shown(progress, f"data set of {scene.sensor.name}") as tell:
        if executor is None:
            order.write(folder, tell)
            return
        with submitter(executor, retries) as submit, closing(order.begin(folder)) as begun:
            plan, missing = begun.missing()
            files = {name: options[name] for name in ("presses", "captures", "constants")}
            # Workers may run in another folder.
            there = {name: path and os.path.abspath(path) for name, path in files.items()}
            work = functools.partial(_shard, scene, options | there, plan)
            tasks = [[number] for number in missing]
            for shards in completed(submit, work, tasks, retries, "shards"):
                begun.keep(shards)
            begun.write(tell)


def _order(scene: Scene, options: dict[str, Any]) -> _fabkit.DatasetOrder:
    return _fabkit.DatasetOrder(scene._native, options)  # pyright: ignore[reportPrivateUsage]


def _shard(
    scene: Scene, options: dict[str, Any], plan: str, numbers: list[int]
) -> tuple[list[tuple[str, bytes]], FabkitError | None]:
    """Cast the halves of some shards, here or on a worker; return files by name, and an error."""
    order = _order(scene, options)
    files: list[tuple[str, bytes]] = []
    for number in numbers:
        of_plan, shard = order.shard(number)
        # Another version of fabkit or other files would mix two data sets.
        if of_plan != plan:
            text = f"a worker makes another data set: its plan is {of_plan} instead of {plan}"
            hint = "give all workers this version of fabkit and the same files"
            problem = Problem(text, hint)
            message = f"{text}\n  = help: {hint}"
            return [], FabkitError(message, code="io", exit_code=4, problems=(problem,))
        files += shard
    return files, None
