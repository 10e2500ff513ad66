"""Triangle meshes."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fabkit import _fabkit


class Mesh:
    """A closed, oriented triangle mesh in the frame of its part, mm."""

    def __init__(self, native: _fabkit.Mesh) -> None:
        self._native = native

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Positions, (n, 3) float64, mm."""
        return self._native.vertices()

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """Indices of vertices, (m, 3) uint32, counter-clockwise seen from outside."""
        return self._native.triangles()

    @property
    def volume_mm3(self) -> float:
        """What it encloses, mm^3."""
        return self._native.volume_mm3()
