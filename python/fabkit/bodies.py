"""Parts, layers and components of a design."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fabkit.meshes import Mesh

if TYPE_CHECKING:
    from fabkit import _fabkit


class Body:
    """A part, a layer or a component."""

    def __init__(self, native: _fabkit.Design, name: str, kind: str) -> None:
        self._native = native
        self.name = name
        self.kind = kind

    def mesh(self, tolerance_mm: float = 0.01) -> Mesh:
        """Mesh the exact solid, at most ``tolerance_mm`` from its surface."""
        return Mesh(self._native.mesh(self.name, tolerance_mm))
