from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import fabkit
from fabkit import _arrays, _writing

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import ArrayLike

    from fabkit._progress import Progress
    from fabkit.calibrate import Extrinsics
    from fabkit.cameras import Camera
    from fabkit.dataset import Dataset
    from fabkit.designs import Sensor


def write(
    sensor: Sensor | str,
    folder: str | PathLike[str],
    *,
    # ARGUMENTS presses
    camera: Camera | str | PathLike[str] | None = None,
    pose: Extrinsics | str | PathLike[str] | ArrayLike | None = None,
    # ARGUMENTS
    executor: Any = None,
    progress: Progress = None,
    retries: int = 3,
) -> Dataset:
    """Write a data set with the same bytes as ``fabkit dataset``, and open it.

    Lengths are numbers of mm, or texts with a unit.

    Parameters
    ----------
    sensor
        A sensor, or the name of one.
    folder
        Folder to write to; it must be empty or not exist, unless ``resume``.
    # PARAMETERS presses
    camera, pose
        As for :class:`fabkit.depth.Scene`.
    # PARAMETERS
    seed
        Which patterns are for training, validation and test.
    allow_no_contact
        Go on where a press does not touch the surface.
    resume
        Go on where an earlier call with the same arguments was stopped.
    executor
        Executor of the computation: ``None`` for threads of this machine; anything with the
        interface of ``concurrent.futures``; a ``dask.distributed.Client``, or the address of its
        scheduler. Workers need fabkit, and must see the files that the arguments name under the
        same paths. They send their results back, and only this process writes.
    progress
        ``False`` for none, or a function of ``(done, total)``. Default: a bar if tqdm is
        installed.
    retries
        Number of further attempts at a shard of halves whose worker was lost.

    Raises
    ------
    FabkitError
        The folder is not empty or another process writes to it, presses or captures cannot be
        used, the disk is full, the executor cannot be reached or is broken, or a worker sends
        wrong data. Finished files are kept.
    KeyboardInterrupt
        The call was interrupted; finished files are kept for ``resume``.
    """
    scene = fabkit.depth.Scene(sensor, camera=camera, pose=pose)
    options: dict[str, Any] = {
        # VALUES
    }
    _writing.write(scene, os.fspath(folder), options, executor, progress, retries)
    return fabkit.dataset.Dataset(folder)
