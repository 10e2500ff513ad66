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
    """Write a data set as ``fabkit dataset`` does, byte for byte, and open it.

    Lengths are numbers of mm, or texts with a unit.

    Parameters
    ----------
    sensor
        A sensor, or the name of one.
    folder
        Where; it must be empty or not exist, unless ``resume``.
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
        Who casts the halves: ``None`` for threads of this machine; anything with the interface of
        ``concurrent.futures``; a ``dask.distributed.Client``, or the address of its scheduler.
        Workers need fabkit, and see files that the arguments name under the same paths; what they
        cast is sent back, and only this process writes.
    progress
        ``False`` for none, or a function of ``(done, all)``; else a bar if tqdm is installed.
    retries
        How often a shard of halves is tried again that a worker lost.

    Raises
    ------
    FabkitError
        A folder that is not empty or that another process writes to, presses and captures that
        cannot be had, a full disk, an executor that cannot be reached or is broken, a worker that
        sends something else than it should; finished files are kept.
    KeyboardInterrupt
        Finished files stay for ``resume``.
    """
    scene = fabkit.depth.Scene(sensor, camera=camera, pose=pose)
    options: dict[str, Any] = {
        # VALUES
    }
    _writing.write(scene, os.fspath(folder), options, executor, progress, retries)
    return fabkit.dataset.Dataset(folder)
