"""What captures of pins will tell, before they are taken: part of :mod:`fabkit.calibrate`."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fabkit import _fabkit
from fabkit.cameras import Camera
from fabkit.designs import Sensor, load
from fabkit.errors import invalid

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike


@dataclass(frozen=True)
class Expected:
    """How well captures of pins will tell where things are: standard deviations, simulated."""

    surface_mm: float
    """Of a point of the surface that a pixel shows, root mean square over the surface."""
    worst_mm: float
    """The same where it is largest."""
    position_mm: float
    """Of the camera's place, root of the sum of squares over the axes."""
    scatter_px: float
    """By how much the same pin is off from capture to capture, root mean square."""
    seating_solved: bool
    """Whether it is better to solve for how deep all pins sit than to take it for as drawn."""


@dataclass(frozen=True)
class Effort:
    """A number of captures, and what they come to."""

    captures: int
    pins: int
    """In each capture."""
    expected: Expected | None
    """Nothing where they do not tell the pose."""


@dataclass(frozen=True)
class NextCapture:
    """Which pins to press."""

    holes: list[int]
    kind: str
    """Of all its pins."""
    expected: Expected | None
    """After this capture, and all before it."""


@dataclass(frozen=True)
class CapturePlan:
    """What captures of pins will tell, and which to take next."""

    efforts: list[Effort]
    kinds: dict[str, Expected | None]
    """The same number of captures with all kinds of pin, and with each alone."""
    done: Expected | None
    """What the captures that there are come to."""
    next: list[NextCapture]
    """Each helps the surface most, after those before it."""
    document: dict[str, Any]
    """All of it with what it rests on, as ``fabkit calibrate plan --json`` has it."""


def plan(
    sensor: Sensor | str,
    *,
    camera: Camera | str | PathLike[str] | None = None,
    done: str | PathLike[str] | Sequence[Sequence[int]] = (),
    captures: int | None = None,
    pins: int | None = None,
    pin: str | None = None,
) -> CapturePlan:
    """Forecast a calibration by pins: play of holes, a dome that is seated anew, marks, noise.

    >>> import fabkit.calibrate
    >>> plan = fabkit.calibrate.plan("tactip", captures=2, pins=5)
    >>> len(plan.next), [len(capture.holes) for capture in plan.next]
    (2, [5, 5])

    Parameters
    ----------
    sensor
        With a pin dome or plate.
    camera
        The calibrated lens, or the path of its file; without, the design's, of which nothing is
        known to err.
    done
        The captures that there are: a folder, whose pictures are not looked at, or the holes of
        each.
    captures
        How many more, 1 to 500; without, what is left of the number in the sensor's file.
    pins
        In each, 1 to 100; without, as many as the sensor's file says.
    pin
        Which kind of pin was used, where the dome has several.

    Raises
    ------
    FabkitError
        A sensor without pins, holes that it has not, files with faults.
    """
    sensor = load(sensor) if isinstance(sensor, str) else sensor
    for name, count, most in [("captures", captures, 500), ("pins", pins, 100)]:
        if count is not None and not 1 <= count <= most:
            raise invalid(f"{name} is {count}; the limits are 1 and {most}")
    lens = None
    if camera is not None:
        file = "camera" if isinstance(camera, Camera) else os.fspath(camera)
        camera = camera if isinstance(camera, Camera) else Camera.load(camera)
        lens = (camera._native, file)  # pyright: ignore[reportPrivateUsage]
    is_folder = isinstance(done, str | os.PathLike)
    text = _fabkit.plan(
        sensor._project,  # pyright: ignore[reportPrivateUsage]
        lens,
        os.fspath(done) if is_folder else None,
        [] if is_folder else [[int(hole) for hole in holes] for holes in done],
        pin,
        captures,
        pins,
    )
    document = json.loads(text)

    def expected(found: dict[str, Any] | None) -> Expected | None:
        return None if found is None else Expected(**found)

    return CapturePlan(
        efforts=[
            Effort(one["captures"], one["pins"], expected(one["expected"]))
            for one in document["efforts"]
        ],
        kinds={one["kind"]: expected(one["expected"]) for one in document["kinds"]},
        done=expected(document["done"]),
        next=[
            NextCapture(one["holes"], one["kind"], expected(one["expected"]))
            for one in document["next"]
        ],
        document=document,
    )
