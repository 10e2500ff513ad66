"""What a kernel says about the solid that it built."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy


class RebuildError(Exception):
    """A kernel could not build the solid, or built something that it calls invalid itself."""


@dataclass(frozen=True)
class Mass:
    """Integrals over a solid, for density 1; inertia about the centroid."""

    volume_mm3: float
    area_mm2: float
    centroid_mm: numpy.ndarray
    inertia_mm5: numpy.ndarray


@dataclass(frozen=True)
class Rebuilt:
    """A solid as a kernel built it, in the frame of the tree's root; everything in mm."""

    kernel: str
    mass: Mass
    # Lower and upper corner.
    bounds_mm: numpy.ndarray
    # Through holes and handles, summed over shells; None where the kernel cannot say.
    genus: int | None
    # How far its faces may be from the exact ones by construction: 0 for exact faces.
    chord_mm: float
    # Connected boundaries; a closed cavity counts as one.
    shells: int
    # n x 3 origins and n x 3 unit directions to n sorted arrays of positions along the lines.
    crossings: Callable[[numpy.ndarray, numpy.ndarray], list[numpy.ndarray]]
    # n x 3 points to n truth values.
    contains: Callable[[numpy.ndarray], list[bool]]
    # From a point to the nearest point of the surface.
    distance_mm: Callable[[numpy.ndarray], float]
    # What the kernel finds wrong with what it read or made, in words.
    complaints: list[str] = field(default_factory=list)
    # How many faces of which kind, for kernels that have kinds.
    face_types: dict[str, int] = field(default_factory=dict)
