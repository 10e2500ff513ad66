"""Simulated units of one design, with randomly drawn dimensions, lens, pose and light."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from fabkit import sim
    from fabkit_bench._bench import Bench

__all__ = ["Spread", "draw_unit"]

# Light constants in a file of `fabkit fit-light`; such a file has all of them.
_LIGHT = ("layer_grey", "ground_grey", "scatter_per_mm", "spread_mm")


@dataclass(frozen=True)
class Spread:
    """Standard deviations between units of one design."""

    sizes_mm: dict[str, float]
    """Standard deviation of lengths, by parameter; draws are clipped at two of them."""
    overrides: dict[str, object] = field(default_factory=dict[str, object])
    """Further overrides that a unit's design needs to be valid."""
    shift_mm: float = 0.2
    """Standard deviation of the camera's position along each axis."""
    turn_deg: float = 0.5
    """Standard deviation of the camera's rotation about each axis."""
    light: float = 0.1
    """Relative standard deviation of each light constant."""

    def words(self) -> str:
        """Return a description for the report."""
        sizes = ", ".join(f"{path} {sigma:g} mm" for path, sigma in self.sizes_mm.items())
        return (
            f"a new unit has drawn of it: {sizes}; camera {self.shift_mm:g} mm and "
            f"{self.turn_deg:g} deg an axis, constants of light {100 * self.light:g} % each (all "
            "standard deviations); focal length and middle evenly within the design's tolerances"
        )


def draw_unit(
    bench: Bench, of: sim.Sensor, number: int, spread: Spread, **options: Any
) -> sim.Sensor:
    """Draw another unit of the bench's design and prepare it for presses.

    Parameters
    ----------
    bench
        The run, with the design.
    of
        The nominal unit. Its exposure is kept, as a fixed one would be.
    number
        Number of the unit, the seed of its draws.
    spread
        Standard deviations of the draws.
    options
        Arguments of :class:`fabkit.sim.Sensor`.
    """
    random = bench.random(f"unit {number}")
    sizes: dict[str, object] = {
        path: float(bench.design.parameters[path].value + sigma * np.clip(random.normal(), -2, 2))
        for path, sigma in spread.sizes_mm.items()
    }
    design = bench.design.replace({**spread.overrides, **sizes})
    camera = design.camera
    lens = camera.parameters
    longer = 1.0 + random.uniform(-1, 1) * design.values.camera.focal_tolerance
    aside = random.uniform(-1, 1, size=2) * design.values.camera.centre_tolerance * camera.width_px
    camera = camera.with_parameters(
        {
            "fx_px": lens["fx_px"] * longer,
            "fy_px": lens["fy_px"] * longer,
            "cx_px": lens["cx_px"] + aside[0],
            "cy_px": lens["cy_px"] + aside[1],
        }
    )
    # The small motion is in the camera frame.
    moved = np.linalg.inv(design.sensor_from_camera)
    moved = _motion(random, spread) @ moved
    factors = 1.0 + spread.light * random.standard_normal(len(_LIGHT))
    options = {**options, "camera": camera, "pose": moved}
    nominal = {one["name"]: one["value"] for one in of.document["constants"]}
    if not set(_LIGHT) <= set(nominal):
        return bench.sensor(design, **options)
    exposure = float(of.document.get("exposure", 1.0))
    values = {
        name: float(nominal[name] * factor * (exposure if name.endswith("_grey") else 1.0))
        for name, factor in zip(_LIGHT, factors, strict=True)
    }
    path = bench.folder() / f"light-{number}.json"
    path.write_text(json.dumps(_light_file(design.name, values)), encoding="utf-8")
    return bench.sensor(design, constants=path, **options)


def _motion(random: np.random.Generator, spread: Spread) -> np.ndarray[Any, Any]:
    """Draw a small rigid motion, (4, 4), mm."""
    x, y, z = np.deg2rad(spread.turn_deg) * random.standard_normal(3)
    # The nearest exact rotation to the linearised one: poses must be orthogonal to rounding.
    turn, _, back = np.linalg.svd(np.array([[1, -z, y], [z, 1, -x], [-y, x, 1]]))
    motion = np.eye(4)
    motion[:3, :3] = turn @ back
    motion[:3, 3] = spread.shift_mm * random.standard_normal(3)
    return motion


def _light_file(sensor: str, values: dict[str, float]) -> dict[str, Any]:
    """Return a document like that of ``fabkit fit-light``, with drawn constants."""
    return {
        "format": "fabkit-fit-light",
        "version": 1,
        "sensor": sensor,
        "captures": 0,
        "constants": [{"name": name, "value": value} for name, value in values.items()],
    }
