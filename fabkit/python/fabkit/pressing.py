"""Presses of soft layers: forces by depth, and how the surface moves. Simulated."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fabkit import _arrays, _fabkit
from fabkit._press import press
from fabkit.designs import Sensor, load

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Pressed", "press"]


def __dir__() -> list[str]:
    return __all__


@dataclass(frozen=True, eq=False)
class Pressed:
    """A press by the theory that ``contact_level`` names: what ``fabkit press`` writes.

    Forces are those of the presser on the sensor, in the sensor frame. n nodes, k steps.
    """

    force_n: tuple[float, float, float]
    """At full depth, N."""
    moment_nmm: tuple[float, float, float]
    """About the sensor's origin, N mm."""
    contact_radius_mm: float
    """Of the circle that has the contact's area, mm."""
    contact_area_mm2: float
    """Of all that touches, mm2."""
    max_indentation_mm: float
    """How far the surface moves in, at most, mm."""
    bulge_mm: float
    """How far it moves out beside the presser, at most, mm."""
    stiffness_n_mm: float
    """How force grows with depth at the end, N/mm."""
    contact_level: str
    """By which theory: ``linear`` or ``finite``."""
    curve: list[dict[str, Any]]
    """The same figures step by step, with ``depth_mm`` and ``shear_mm``."""
    place_mm: NDArray[np.float64]
    """Nodes of the surface at rest, sensor frame, mm: n x 3."""
    outward: NDArray[np.float64]
    """Unit normals there: n x 3."""
    displacement_mm: NDArray[np.float64]
    """How each node moved, mm: n x 3."""
    pressure_mpa: NDArray[np.float64]
    """What the presser pushes each node with, MPa: n."""
    shear_mpa: NDArray[np.float64]
    """What friction drags it with, MPa: n x 3."""
    area_mm2: NDArray[np.float64]
    """What area each node stands for, mm2: n."""
    mark_place_mm: NDArray[np.float64]
    """What the camera follows (dots, dimples, slots) at rest, sensor frame, mm: m x 3."""
    mark_displacement_mm: NDArray[np.float64]
    """How each mark moved, mm: m x 3; NaN where the layers that are solved have ended."""
    mark_axis: NDArray[np.float64]
    """Which way each then points, unit: m x 3."""
    document: dict[str, Any]
    """All that ``fabkit press --json`` says, with the layers and what was left out."""


def pressed(
    sensor: Sensor | str, indenter: str, depth_mm: float | str, options: dict[str, Any]
) -> Pressed:
    """Press with all options of the command."""
    sensor = load(sensor) if isinstance(sensor, str) else sensor
    text, field = _fabkit.press(
        sensor._project,  # pyright: ignore[reportPrivateUsage]
        sensor.name,
        indenter,
        _arrays.length_mm(depth_mm, "depth_mm"),
        options,
    )
    document = json.loads(text)
    said = {name: document[name] for name in _SAID}
    for name in ("force_n", "moment_nmm"):
        said[name] = tuple(said[name])
    return Pressed(**said, **{name: field[name] for name in _FIELD}, document=document)


_SAID = (
    "force_n",
    "moment_nmm",
    "contact_radius_mm",
    "contact_area_mm2",
    "max_indentation_mm",
    "bulge_mm",
    "stiffness_n_mm",
    "contact_level",
    "curve",
)
_FIELD = (
    "place_mm",
    "outward",
    "displacement_mm",
    "pressure_mpa",
    "shear_mpa",
    "area_mm2",
    "mark_place_mm",
    "mark_displacement_mm",
    "mark_axis",
)
