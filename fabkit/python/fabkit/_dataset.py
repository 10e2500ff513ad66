"""Made from the options of ``fabkit dataset`` by ``cargo test -p fabkit``; do not edit."""

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
    presses: str | PathLike[str] | None = None,
    camera: Camera | str | PathLike[str] | None = None,
    pose: Extrinsics | str | PathLike[str] | ArrayLike | None = None,
    captures: str | PathLike[str] | None = None,
    images: bool = False,
    light: str | None = None,
    constants: str | PathLike[str] | None = None,
    contact: str | None = None,
    membrane_mm: float | str = 0.0,
    friction: float | None = None,
    spacing_mm: float | str | None = None,
    seam_margin_mm: float | str = 0.5,
    seed: int = 1,
    materialise: bool = False,
    allow_no_contact: bool = False,
    resume: bool = False,
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
    presses
        Text file of presses for the left half, one per line: an ID, or ``NAME = ID + ID``, with
        linear contact followed by ``shear 0.5mm,0mm``. Default: all semi-domes or half-plates of
        the sensor.
    camera, pose
        As for :class:`fabkit.depth.Scene`.
    captures
        Captured images to stitch like the halves: a folder with ``PATTERN-left.png`` and
        ``PATTERN-right.png``, or a CSV file with the columns pattern, side, file.
    images
        Simulate an image of each half, as ``capture`` does, and stitch them like the halves;
        ``seed`` determines the noise of each.
    light
        Light source that is on in simulated images. Default: the sensor's usual one.
    constants
        Light constants of a unit for simulated images, written by ``fit-light``.
    contact
        Contact model. Default: membrane with ``membrane_mm``, else rigid. ``"rigid"``: the surface
        follows the indenter; nothing else moves; ``"membrane"``: the surface returns to rest over
        the distance ``membrane_mm``; ``"linear"``: elastic layers that yield and bulge, small
        strain.
    membrane_mm
        Distance around a contact over which the gel returns to rest, 0 mm to 10 mm; without it only
        the contact moves.
    friction
        Coulomb friction coefficient for --shear, linear contact only. Default: of the touched
        material.
    spacing_mm
        Node spacing on the surface, linear contact only. Default: as fine as a few seconds allow.
    seam_margin_mm
        Margin to leave out on both sides of the seam between the halves, 0 mm to 10 mm.
    materialise
        Write all stitched samples, not only their halves.
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
        "presses": None if presses is None else os.fspath(presses),
        "captures": None if captures is None else os.fspath(captures),
        "images": images,
        "light": light,
        "constants": None if constants is None else os.fspath(constants),
        "contact": contact,
        "membrane": _arrays.length_mm(membrane_mm, "membrane_mm"),
        "friction": friction,
        "spacing": _arrays.optional_length_mm(spacing_mm, "spacing_mm"),
        "seam_margin": _arrays.length_mm(seam_margin_mm, "seam_margin_mm"),
        "seed": seed,
        "materialise": materialise,
        "allow_no_contact": allow_no_contact,
        "resume": resume,
    }
    _writing.write(scene, os.fspath(folder), options, executor, progress, retries)
    return fabkit.dataset.Dataset(folder)
