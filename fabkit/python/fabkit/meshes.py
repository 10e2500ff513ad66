"""Triangle meshes."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fabkit import _fabkit
from fabkit.errors import invalid

if TYPE_CHECKING:
    from os import PathLike

    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Mesh"]


def __dir__() -> list[str]:
    return __all__


class Mesh:
    """A closed, oriented triangle mesh, mm, in the frame of its body.

    >>> import fabkit
    >>> mesh = fabkit.load("rtac0").parts["base"].mesh(tolerance_mm=0.05)
    >>> mesh.vertices.shape[1], mesh.triangles.shape[1]
    (3, 3)
    >>> mesh.genus, round(mesh.volume_mm3)
    (4, 3332)
    """

    def __init__(self, native: _fabkit.Mesh) -> None:
        self._native = native

    def __repr__(self) -> str:
        counts = f"{len(self.vertices)} vertices, {len(self.triangles)} triangles"
        return f"<Mesh: {counts}, {self.volume_mm3:.2f} mm3>"

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Vertex positions, (n, 3) float64, mm: the mesh's own memory; copy it before changes."""
        return self._native.vertices()

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """Vertex indices of each triangle, (m, 3) uint32, counter-clockwise seen from outside."""
        return self._native.triangles()

    @property
    def leaves(self) -> NDArray[np.uint32]:
        """Index of the body's primitive on which each triangle lies, (m,) uint32."""
        return self._native.leaves()

    @property
    def volume_mm3(self) -> float:
        """Enclosed volume, mm^3."""
        return self._native.volume_mm3

    @property
    def area_mm2(self) -> float:
        """Area of all triangles, mm^2."""
        return self._native.area_mm2

    @property
    def genus(self) -> int:
        """Number of through holes and handles."""
        return self._native.genus

    def export(self, path: str | PathLike[str]) -> None:
        """Write a binary STL file, mm, in the mesh's own frame.

        :meth:`fabkit.Body.export` writes a file for printing: in its orientation on the bed, and
        compensated for shrinkage.

        Raises
        ------
        FabkitError
            The path does not end in ``.stl``, or the file cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() != ".stl":
            raise invalid(f"{path} does not name a .stl file", "Body.export writes other formats")
        _fabkit.write_files(str(path.parent), [(path.name, self._native.stl())])

    def to_trimesh(self) -> Any:
        """Convert to a ``trimesh.Trimesh`` with the same vertices; needs the package trimesh."""
        trimesh: Any = importlib.import_module("trimesh")
        return trimesh.Trimesh(self.vertices, self.triangles, process=False)
