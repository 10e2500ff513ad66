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


#: By the end of a file's name.
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
    """A part that is made, a layer that is poured, or a component that is bought.

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
        """Unique within the design."""
        return self._about["name"]

    @property
    def kind(self) -> str:
        """``part``, ``layer`` or ``component``."""
        return self._about["kind"]

    @property
    def summary(self) -> str:
        """One line for people; for a component, what to order."""
        return self._about["summary"]

    @property
    def process(self) -> str:
        """How it is made, for example ``fdm``; empty for what is bought."""
        return self._about["process"]

    @property
    def material(self) -> str:
        """From what; empty for what is bought."""
        return self._about["material"]

    @property
    def quantity(self) -> int:
        """How many a lab needs."""
        return self._about["quantity"]

    @property
    def assemblies(self) -> list[str]:
        """In which assemblies it stands, for example ``sensor``."""
        return self._about["assemblies"]

    @property
    def landmarks(self) -> NDArray[np.void]:
        """Named points that others rely on, in the body's own frame: a structured array.

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
        """Mesh the exact solid: nominal, in the body's own frame.

        Parameters
        ----------
        tolerance_mm
            Largest distance between triangles and the exact surface, 1e-4 mm to 5 mm: a number
            of mm, or text with a unit, ``"10 um"``.

        Raises
        ------
        FabkitError
            A tolerance beyond its limits, or too fine for a sensible number of triangles.
        """
        return Mesh(self._native.mesh(self.name, _arrays.length_mm(tolerance_mm, "tolerance_mm")))

    def picture(
        self,
        size_px: tuple[int, int] = (800, 600),
        *,
        section: bool = False,
        view: str | tuple[float, float] | None = None,
    ) -> bytes:
        """Draw it from the exact geometry: PNG, width x height as given.

        Parameters
        ----------
        size_px
            Width and height.
        section
            Take the half nearer to the viewer away; without `view`, that before the x-z plane.
        view
            From where: ``"front"``, ``"back"``, ``"left"``, ``"right"``, ``"top"``, ``"bottom"``,
            or azimuth from +x and elevation in degrees, ``(30, 20)``; else a corner above.

        Raises
        ------
        FabkitError
            No such side; a picture that is too large.
        """
        seen_from = _arrays.view(view)
        return self._native.picture(self.name, None, False, section, seen_from, size_px)

    def export(
        self, path: str | PathLike[str], *, tolerance_mm: float | str = 0.01, nominal: bool = False
    ) -> None:
        """Write it as ``fabkit export --part`` does: lying as it should be printed, byte for byte.

        Parameters
        ----------
        path
            Ends in ``.stl``, ``.3mf``, ``.dxf``, ``.svg``, ``.png``, ``.tree.json`` or ``.step``.
        tolerance_mm
            Largest distance between triangles and the exact surface: mm, or text with a unit.
        nominal
            Leave out what makes up for shrinkage and for the laser's kerf.

        Raises
        ------
        FabkitError
            Another ending, a format that this body does not have, a file that cannot be written.
        """
        path = Path(path)
        ending = next((end for end in _FORMATS if path.name.lower().endswith(end)), None)
        if ending is None:
            known = ", ".join(_FORMATS)
            raise invalid(f"{path} has no ending that fabkit knows", f"known: {known}")
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
        # A part of a print group brings the others with it; their 3MF is one file.
        own = [file for file in files if file[0] == self.name + ending] or files
        if not own:
            raise invalid(f"{self.name} has no {ending} file", "printed parts have .stl and .3mf")
        _fabkit.write_files(str(path.parent), [(path.name, own[0][1])])
