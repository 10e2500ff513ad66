"""Parts, layers and components of a design."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import _arrays, _fabkit
from fabkit.errors import invalid
from fabkit.meshes import Mesh

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import NDArray

__all__ = ["Body"]


def __dir__() -> list[str]:
    return __all__


#: Format of an exported file by the end of its name.
_FORMATS = {
    ".stl": "stl",
    ".3mf": "3mf",
    ".dxf": "dxf",
    ".svg": "svg",
    ".png": "png",
    ".tree.json": "tree",
    ".step": "step",
}


class Body:
    """A body of a design: a made part, a poured layer, or a bought component.

    >>> import fabkit
    >>> sensor = fabkit.load("rtac0")
    >>> sensor.parts["shell"].kind, sensor.parts["shell"].process
    ('part', 'fdm')
    >>> sensor.layers["translucent-gel"].material
    'Smooth-On Ecoflex 00-30'
    """

    def __init__(self, native: _fabkit.Design, about: dict[str, Any]) -> None:
        self._native = native
        self._about = about

    def __repr__(self) -> str:
        return f"<{self.kind} {self.name}: {self.summary}>"

    def _repr_png_(self) -> bytes:
        return self.picture(size_px=(480, 360))

    @property
    def name(self) -> str:
        """Name, unique within the design."""
        return self._about["name"]

    @property
    def kind(self) -> str:
        """Kind of body: ``part``, ``layer`` or ``component``."""
        return self._about["kind"]

    @property
    def summary(self) -> str:
        """Description in one line; for a component, the product to order."""
        return self._about["summary"]

    @property
    def process(self) -> str:
        """Process that makes it, for example ``fdm``; empty for components."""
        return self._about["process"]

    @property
    def material(self) -> str:
        """Material; empty for components."""
        return self._about["material"]

    @property
    def quantity(self) -> int:
        """Number of pieces to make or buy."""
        return self._about["quantity"]

    @property
    def assemblies(self) -> list[str]:
        """Names of the assemblies that contain it, for example ``sensor``."""
        return self._about["assemblies"]

    @property
    def landmarks(self) -> NDArray[np.void]:
        """Named reference points of the body, in its own frame: a structured array.

        Fields: ``name`` (text), ``point_mm`` (3 x float64, mm) and ``axis`` (3 x float64, unit
        length).
        """
        names, points, axes = self._native.landmarks(self.name)
        width = max((len(name) for name in names), default=1)
        fields = [("name", f"U{width}"), ("point_mm", "f8", 3), ("axis", "f8", 3)]
        landmarks = np.zeros(len(names), dtype=fields)
        landmarks["name"], landmarks["point_mm"], landmarks["axis"] = names, points, axes
        return landmarks

    def mesh(self, tolerance_mm: float | str = 0.01) -> Mesh:
        """Triangulate the exact solid: nominal size, in the body's own frame.

        Parameters
        ----------
        tolerance_mm
            Largest distance between triangles and the exact surface, 1e-4 mm to 5 mm: a number
            of mm, or text with a unit, ``"10 um"``.

        Raises
        ------
        FabkitError
            The tolerance is outside its limits, or needs too many triangles.
        """
        return Mesh(self._native.mesh(self.name, _arrays.length_mm(tolerance_mm, "tolerance_mm")))

    def picture(
        self,
        size_px: tuple[int, int] = (800, 600),
        *,
        section: bool = False,
        view: str | tuple[float, float] | None = None,
    ) -> bytes:
        """Draw the body from its exact geometry; return a PNG file's content.

        Parameters
        ----------
        size_px
            Width and height of the image, px.
        section
            Cut away the half nearer to the viewer; without ``view``, the half in front of the x-z
            plane.
        view
            Viewing direction: ``"front"``, ``"back"``, ``"left"``, ``"right"``, ``"top"``,
            ``"bottom"``, or azimuth from +x and elevation in degrees, ``(30, 20)``. Default: from
            a corner above.

        Raises
        ------
        FabkitError
            The view has no such name, or the image is too large.
        """
        seen_from = _arrays.view(view)
        return self._native.picture(self.name, None, False, section, seen_from, size_px)

    def export(
        self, path: str | PathLike[str], *, tolerance_mm: float | str = 0.01, nominal: bool = False
    ) -> None:
        """Write the body to a file, in its printing orientation, as ``fabkit export --part`` does.

        The file is the same as the command's, byte for byte.

        Parameters
        ----------
        path
            Path of the file; it ends in ``.stl``, ``.3mf``, ``.dxf``, ``.svg``, ``.png``,
            ``.tree.json`` or ``.step``.
        tolerance_mm
            Largest distance between triangles and the exact surface: mm, or text with a unit.
        nominal
            Leave out the compensation of shrinkage and of the laser's kerf.

        Raises
        ------
        FabkitError
            The path has another ending, the body does not have the format, or the file cannot be
            written.
        """
        path = Path(path)
        ending = next((end for end in _FORMATS if path.name.lower().endswith(end)), None)
        if ending is None:
            known = ", ".join(_FORMATS)
            raise invalid(f"{path} has an unknown ending", f"use one of {known}")
        exported = self._native.exported(
            {
                "parts": [self.name],
                "formats": [_FORMATS[ending]],
                "tolerance_mm": _arrays.length_mm(tolerance_mm, "tolerance_mm"),
                "nominal": nominal,
            },
            None,
        )
        files = [file for file in exported.files() if file[0].endswith(ending)]
        # A part of a print group shares one 3MF file with the others, under the group's name.
        own = [file for file in files if file[0] == self.name + ending] or files
        if not own:
            raise invalid(f"{self.name} has no {ending} file", "printed parts have .stl and .3mf")
        _fabkit.write_files(str(path.parent), [(path.name, own[0][1])])
