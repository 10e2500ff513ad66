"""Press positions on the surface, drawn where the camera sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fabkit import sim

__all__ = ["Places", "places"]


@dataclass(frozen=True, eq=False)
class Places:
    """Points of the surface at rest, sensor frame, mm: n x 3."""

    points_mm: NDArray[np.float64]
    outward: NDArray[np.float64]
    """Unit outward normals at the points: n x 3."""

    def __len__(self) -> int:
        return len(self.points_mm)

    def beyond(self, distance_mm: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Move the points outwards along their normals by a distance: n x 3."""
        return self.points_mm + np.asarray(distance_mm)[..., None] * self.outward


def places(
    sensor: sim.Sensor, random: np.random.Generator, count: int, *, margin_mm: float = 3.0
) -> Places:
    """Draw press positions on the surface that the camera sees, uniformly by area.

    On domes they are ``margin_mm`` above the lowest visible point, on pads ``margin_mm`` inside the
    outermost ones: an indenter nearer to the edge would touch rigid bodies.
    """
    truth = sensor.scene.cast()
    points = truth.point_in_sensor
    across, down = np.gradient(points, axis=1), np.gradient(points, axis=0)
    areas = np.linalg.norm(np.cross(across, down), axis=2)
    seen = np.isfinite(points).all(axis=2)
    lowest, highest = points[seen].min(axis=0), points[seen].max(axis=0)
    inside = points[..., 2] > lowest[2] + margin_mm
    if np.ptp(points[seen][:, 2]) < margin_mm:
        # A flat pad: keep the margin from its sides, not from its base.
        sides = (points[..., :2] > lowest[:2] + margin_mm) & (
            points[..., :2] < highest[:2] - margin_mm
        )
        inside = sides.all(axis=2)
    weights = np.where(seen & inside & np.isfinite(areas), areas, 0.0).ravel()
    drawn = random.choice(len(weights), size=count, p=weights / weights.sum())
    return Places(points.reshape(-1, 3)[drawn], truth.normal_in_sensor.reshape(-1, 3)[drawn])
