"""Measured properties of a solid that a kernel built."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy


class RebuildError(Exception):
    """A kernel could not build the solid, or built one that its own check rejects."""


@dataclass(frozen=True)
class Mass:
    """Volume, area, centroid and inertia of a solid, for density 1; inertia about the centroid."""

    volume_mm3: float
    area_mm2: float
    centroid_mm: numpy.ndarray
    inertia_mm5: numpy.ndarray


@dataclass(frozen=True)
class Rebuilt:
    """A solid as a kernel built it, in the frame of the tree's root; everything in mm."""

    kernel: str
    mass: Mass
    # Lower and upper corner of the bounding box, 2 x 3.
    bounds_mm: numpy.ndarray
    # Number of through holes and handles, summed over shells; None if the kernel cannot determine it.
    genus: int | None
    # Largest distance of its faces from the exact ones by construction: 0 for exact faces.
    chord_mm: float
    # Number of connected boundaries; a closed cavity counts as one.
    shells: int
    # Maps n x 3 origins and n x 3 unit directions to n sorted arrays of positions along the lines.
    crossings: Callable[[numpy.ndarray, numpy.ndarray], list[numpy.ndarray]]
    # Maps n x 3 points to n truth values: inside or not.
    contains: Callable[[numpy.ndarray], list[bool]]
    # Distance from a point to the surface.
    distance_mm: Callable[[numpy.ndarray], float]
    # Faults that the kernel finds in the solid that it read or built, in words.
    complaints: list[str] = field(default_factory=list)
    # Number of faces by type of surface, for kernels with such types.
    face_types: dict[str, int] = field(default_factory=dict)
