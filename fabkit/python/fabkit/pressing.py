"""Presses of soft layers: force by indentation, and displacement of the surface. Simulated."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fabkit import _arrays, _fabkit
from fabkit._press import press
from fabkit.designs import Sensor, as_sensor

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Pressed", "press"]


def __dir__() -> list[str]:
    return __all__


@dataclass(frozen=True, eq=False)
class Pressed:
    """Result of a press, simulated with the contact model of ``contact_level``.

    It holds everything that ``fabkit press`` writes. Forces are those of the indenter on the
    sensor, in the sensor frame. Arrays have one row for each of n nodes or m markers.
    """

    force_n: tuple[float, float, float]
    """Force at full indentation, N."""
    moment_nmm: tuple[float, float, float]
    """Moment about the sensor's origin, N mm."""
    contact_radius_mm: float
    """Radius of the circle with the area of the contact, mm."""
    contact_area_mm2: float
    """Area of the contact, mm2."""
    max_indentation_mm: float
    """Largest inward displacement of the surface, mm."""
    bulge_mm: float
    """Largest outward displacement of the surface beside the indenter, mm."""
    stiffness_n_mm: float
    """Slope of force over indentation at the end, N/mm."""
    contact_level: str
    """Contact model: ``linear`` or ``finite``."""
    curve: list[dict[str, Any]]
    """The figures above at each step, with ``depth_mm`` and ``shear_mm``."""
    place_mm: NDArray[np.float64]
    """Nodes of the surface at rest, sensor frame, mm: n x 3."""
    outward: NDArray[np.float64]
    """Unit outward normals at the nodes: n x 3."""
    displacement_mm: NDArray[np.float64]
    """Displacement of each node, mm: n x 3."""
    pressure_mpa: NDArray[np.float64]
    """Contact pressure at each node, MPa: n."""
    shear_mpa: NDArray[np.float64]
    """Friction traction at each node, MPa: n x 3."""
    area_mm2: NDArray[np.float64]
    """Surface area that belongs to each node, mm2: n."""
    mark_place_mm: NDArray[np.float64]
    """Markers (dots, dimples, slots) at rest, sensor frame, mm: m x 3."""
    mark_displacement_mm: NDArray[np.float64]
    """Displacement of each marker, mm: m x 3; NaN beyond the layers that are solved."""
    mark_axis: NDArray[np.float64]
    """Direction of each marker after the press, unit length: m x 3."""
    document: dict[str, Any]
    """Output of ``fabkit press --json``, with the layers and what the model leaves out."""


def pressed(
    sensor: Sensor | str, indenter: str, depth_mm: float | str, options: dict[str, Any]
) -> Pressed:
    """Simulate a press; ``options`` are those of ``fabkit press``, by name."""
    sensor = as_sensor(sensor)
    text, field = _fabkit.press(
        sensor._project,  # pyright: ignore[reportPrivateUsage]
        sensor.name,
        indenter,
        _arrays.length_mm(depth_mm, "depth_mm"),
        options,
    )
    document = json.loads(text)
    said = {name: document[name] for name in _FIGURES}
    for name in ("force_n", "moment_nmm"):
        said[name] = tuple(said[name])
    return Pressed(**said, **{name: field[name] for name in _ARRAYS}, document=document)


_FIGURES = (
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
_ARRAYS = (
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
