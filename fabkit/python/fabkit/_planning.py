"""Forecasts of a calibration by pins, before its captures: part of :mod:`fabkit.calibrate`."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fabkit import _fabkit
from fabkit.cameras import Camera
from fabkit.designs import Sensor, as_sensor
from fabkit.errors import invalid

if TYPE_CHECKING:
    from collections.abc import Sequence
    from os import PathLike


@dataclass(frozen=True)
class Expected:
    """Standard deviations that a calibration by pins will reach. Simulated."""

    surface_mm: float
    """Standard deviation of the surface point that a pixel shows, mm: root mean square over the
    surface."""
    worst_mm: float
    """Largest standard deviation of such a point on the surface, mm."""
    position_mm: float
    """Standard deviation of the camera's position, mm: root of the sum of squares over the
    axes."""
    scatter_px: float
    """Scatter of one pin's image from capture to capture, px: root mean square."""
    seating_solved: bool
    """True if solving for the common seating depth of all pins is better than taking the drawn
    one."""


@dataclass(frozen=True)
class Effort:
    """A number of captures, and the accuracy that they reach."""

    captures: int
    """Number of captures."""
    pins: int
    """Number of pins in each capture."""
    expected: Expected | None
    """Expected accuracy; ``None`` where the captures do not determine the pose."""


@dataclass(frozen=True)
class NextCapture:
    """Pins of the next capture."""

    holes: list[int]
    """Numbers of the holes that get a pin."""
    kind: str
    """Kind of all its pins, for example ``long``."""
    expected: Expected | None
    """Expected accuracy after this capture and all before it."""


@dataclass(frozen=True)
class CapturePlan:
    """Expected accuracy of a calibration by pins, and the captures to take next."""

    efforts: list[Effort]
    """Expected accuracy by number of captures and pins."""
    kinds: dict[str, Expected | None]
    """Expected accuracy of the same number of captures with all kinds of pin, and with each kind
    alone."""
    done: Expected | None
    """Accuracy that the existing captures reach; ``None`` if they do not determine the pose."""
    next: list[NextCapture]
    """Captures to take, in order; each improves the surface most, given those before it."""
    document: dict[str, Any]
    """The whole forecast with its assumptions, as ``fabkit calibrate plan --json`` prints it."""


def plan(
    sensor: Sensor | str,
    *,
    camera: Camera | str | PathLike[str] | None = None,
    done: str | PathLike[str] | Sequence[Sequence[int]] = (),
    captures: int | None = None,
    pins: int | None = None,
    pin: str | None = None,
) -> CapturePlan:
    """Forecast how accurate a calibration by pins will be, and propose its captures.

    The simulation includes the play of pins in their holes, a fixture that is seated anew, the
    spread of pin images, and noise.

    >>> import fabkit.calibrate
    >>> plan = fabkit.calibrate.plan("tactip", captures=2, pins=5)
    >>> len(plan.next), [len(capture.holes) for capture in plan.next]
    (2, [5, 5])

    Parameters
    ----------
    sensor
        A sensor with a pin dome or pin plate, or its name.
    camera
        The calibrated lens, or the path of its file. Default: the design's lens, taken as exact.
    done
        Existing captures: a folder, whose images are not read, or the hole numbers of each
        capture.
    captures
        Number of further captures, 1 to 500. Default: what is left of the number in the sensor's
        file.
    pins
        Number of pins in each capture, 1 to 100. Default: the number in the sensor's file.
    pin
        Kind of pin, where the fixture has several.

    Raises
    ------
    FabkitError
        The sensor has no pins or no such holes, or a file has errors.
    """
    sensor = as_sensor(sensor)
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
