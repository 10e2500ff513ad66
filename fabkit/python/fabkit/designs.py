"""Sensors and their calibration fixtures."""

from __future__ import annotations

import html
import json
import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import _arrays, _fabkit
from fabkit._named import Named
from fabkit._progress import shown
from fabkit.bodies import Body
from fabkit.cameras import Camera
from fabkit.checking import CheckReport
from fabkit.errors import DesignWarning
from fabkit.parameters import Parameter, Section, as_yaml, overrides_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from os import PathLike

    from numpy.typing import NDArray

    from fabkit._progress import Progress

__all__ = [
    "Design",
    "Fixture",
    "Parameter",
    "Section",
    "Sensor",
    "Step",
    "check",
    "export",
    "load",
    "sensors",
]


def __dir__() -> list[str]:
    return __all__


def sensors() -> list[str]:
    """List the names of the built-in sensors.

    >>> import fabkit
    >>> "rtac0" in fabkit.sensors()
    True
    """
    return _fabkit.sensors()


def load(
    sensor: str | PathLike[str],
    overrides: Mapping[str, object] | None = None,
    *,
    preset: str | None = None,
    fix: bool = False,
    **values: object,
) -> Sensor:
    """Load a sensor: a built-in one by name, or a YAML file.

    Parameters
    ----------
    sensor
        A name of :func:`sensors`, or a path that ends in ``.yaml``.
    overrides
        Parameters by path, ``{"coat.thickness": "0.1 mm"}``. Lengths and angles are text with a
        unit, or a :class:`Parameter` of another sensor.
    preset
        A built-in variant: ``load("rtac0", preset="published-2025")``.
    fix
        Keep the values that are given here and in the file, and change those that fabkit has
        chosen, as little as possible, until the design can be built; see :attr:`Sensor.changes`.
    values
        The same as ``overrides``, with two underscores for a dot: ``coat__thickness="0.1 mm"``.

    Raises
    ------
    FabkitError
        The sensor, preset or a parameter does not exist, or values are impossible; all errors are
        reported at once.

    Warns
    -----
    DesignWarning
        A value changes nothing in the design, or it is no length and changes the size of the whole.

    >>> import fabkit
    >>> sensor = fabkit.load("rtac0", coat__thickness="0.1 mm")
    >>> sensor.parameters["coat.thickness"].value, sensor.coat.thickness
    (0.1, 0.1)
    >>> try:
    ...     fabkit.load("rtac0", coat__thicknes="0.1 mm")
    ... except fabkit.FabkitError as error:
    ...     print(error.hint)
    did you mean `coat.thickness`?
    """
    given = overrides_of(overrides, values)
    listed = [f"{path}={as_yaml(path, value)}" for path, value in given.items()]
    loaded = _loaded(os.fspath(sensor), preset, listed, fix)
    _warn(loaded._project)  # pyright: ignore[reportPrivateUsage]
    return loaded


def _warn(project: _fabkit.Project) -> None:
    """Warn of values that change nothing, or the size of the whole, where the public call is."""
    for sentence in project.value_effects():
        warnings.warn(sentence, DesignWarning, stacklevel=3)


def _loaded(name: str, preset: str | None, listed: list[str], fix: bool = False) -> Sensor:
    project = _fabkit.load(name, preset, listed, fix)
    changed = [f"{path}={to}" for path, _, to, _ in project.changes()]
    return Sensor(project, name, (preset, listed + changed))


@dataclass(frozen=True)
class Step:
    """One step of building a design."""

    name: str
    """Name of the step, unique within the design."""
    instruction: str
    """Instruction for the builder."""
    action: str
    """``make``, ``prepare``, ``assemble``, ``bond``, ``spray``, ``pour`` or ``demold``."""
    assembly: str | None
    """Assembly in which the step takes place, for example ``translucent-mold``."""
    bodies: list[str]
    """Names of the bodies that the step handles."""
    batch: dict[str, Any] | None
    """Mixture to prepare: ``layer``, ``volume_mm3``, ``components`` (``name`` and ``mass_g``)."""
    during: str | None
    """Name of an earlier step; this one is done while that one cures."""
    adjust: list[str]
    """Names of components to adjust in this step, such as lenses to focus."""
    cure: dict[str, float] | None
    """Curing conditions: ``hours``, ``celsius``."""
    remove: list[str]
    """Names of the tools to remove."""
    source: str
    """Publication or data sheet that describes the step."""


@dataclass(frozen=True)
class Change:
    """A parameter that :func:`load` changed so that the design can be built."""

    path: str
    """Path of the parameter, for example ``tube.wall``."""
    before: str
    """Value that fabkit had chosen."""
    value: str
    """New value."""
    because: str
    """Rule that the old value breaks."""


class Design:
    """A kit of parts: a sensor, or a fixture that is made for one."""

    def __init__(self, native: _fabkit.Design) -> None:
        self._native = native
        about: dict[str, Any] = json.loads(native.about())
        self._about = about

        def of(kind: str) -> Named[Body]:
            bodies = {body["name"]: body for body in about["bodies"] if body["kind"] == kind}
            return Named(kind, list(bodies), lambda name: Body(native, bodies[name]))

        self.parts = of("part")
        """Parts, which are made from a file, by name."""
        self.layers = of("layer")
        """Layers, which are poured or sprayed, by name."""
        self.components = of("component")
        """Components, which are bought, by name."""
        parameters = {entry["path"]: Parameter(**entry) for entry in about["parameters"]}
        self.parameters = Named("parameter", list(parameters), parameters.__getitem__)
        """All parameters of the design, by path."""
        self.values = Section(self.parameters)
        """Values of the parameters by attribute: ``design.values.surface.radius``."""

    def __getattr__(self, name: str) -> Any:
        # Called only if no attribute has the name: `sensor.coat` is `sensor.values.coat`.
        if name.startswith("_") or name == "values":
            raise AttributeError(f"{type(self).__name__} has no attribute {name}")
        return getattr(self.values, name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *dir(self.values)})

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}: {self.title}>"

    def _repr_png_(self) -> bytes:
        return self.picture(size_px=(480, 360), exploded=True)

    def _repr_html_(self) -> str:
        counts = f"{len(self.parts)} parts, {len(self.layers)} layers"
        counts += f", {len(self.components)} components"
        name, title = html.escape(self.name), html.escape(self.title)
        return (
            f'<iframe srcdoc="{html.escape(self.page())}" sandbox="allow-scripts" title="{title}" '
            'style="width: 100%; height: 46rem; border: 0"></iframe>'
            f"<p><b>{name}</b>: {title}<br>{counts}; design {self.design_hash[:16]}</p>"
        )

    @property
    def name(self) -> str:
        """Name of the design, for example ``rtac0`` or ``rtac0-pin-dome``."""
        return self._about["name"]

    @property
    def title(self) -> str:
        """Title of the design, for reports."""
        return self._about["title"]

    @property
    def reference(self) -> str:
        """Publication that the design follows."""
        return self._about["reference"]

    @property
    def design_hash(self) -> str:
        """BLAKE3 hash, in hex, over fabkit's version and all parameters; it is in all exports."""
        return self._about["design_hash"]

    @property
    def derived(self) -> dict[str, str]:
        """Quantities that are derived from the parameters, by name, with units."""
        return {entry["name"]: entry["written"] for entry in self._about["derived"]}

    @property
    def chain(self) -> list[Step]:
        """Build steps in order, as ``fabkit show --chain`` prints them.

        >>> import fabkit
        >>> pours = [step for step in fabkit.load("rtac0").chain if step.action == "pour"]
        >>> pours[0].batch["layer"], pours[0].batch["components"][0]["name"]
        ('silicone-mold-transparent-gel', 'MoldStar 30 A')
        """
        return [Step(**step) for step in json.loads(self._native.chain())["steps"]]

    @property
    def bought(self) -> list[Body]:
        """Components to buy, with ``quantity`` and, in ``summary``, the product to order."""
        return list(self.components.values())

    @property
    def files(self) -> dict[str, bytes]:
        """Content of additional files by name: landmarks, boards, guides; no files of parts."""
        return dict(self._native.companions())

    def picture(
        self,
        size_px: tuple[int, int] = (800, 600),
        *,
        assembly: str | None = None,
        exploded: bool = False,
        section: bool = False,
        view: str | tuple[float, float] | None = None,
    ) -> bytes:
        """Draw an assembly from its exact geometry; return a PNG file's content.

        Poured layers have the pose in which they are poured.

        Parameters
        ----------
        size_px
            Width and height of the image, px.
        assembly
            Name of the assembly. Default: the sensor itself, or a fixture's first assembly.
        exploded
            Pull the bodies apart.
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
            The assembly or view does not exist, or the image is too large.
        """
        seen_from = _arrays.view(view)
        return self._native.picture(None, assembly, exploded, section, seen_from, size_px)

    def page(self) -> str:
        """Create an HTML page with a 3D model to rotate, cut and take apart; it works offline.

        Notebooks show this page for a sensor or a fixture.

        >>> import fabkit
        >>> fabkit.load("rtac0").page().startswith("<!DOCTYPE html>")
        True
        """
        return self._native.page()

    def export(
        self,
        folder: str | PathLike[str],
        *,
        parts: Sequence[str] = (),
        formats: Sequence[str] = ("stl", "3mf", "dxf"),
        tolerance_mm: float | str = 0.01,
        edge_mm: float | str | None = None,
        nominal: bool = False,
        process: str | PathLike[str] | None = None,
        process_for_any_material: bool = False,
        bed_mm: tuple[float | str, float | str] | None = None,
        stock_mm: tuple[float | str, float | str] | None = None,
        kerf_mm: float | str | None = None,
        clean: bool = False,
        force: bool = False,
        progress: Progress = None,
    ) -> dict[str, Any]:
        """Write the design's files, all or none, with the same bytes as ``fabkit export``.

        Parameters
        ----------
        folder
            Folder to write to; it is created if it does not exist.
        parts
            Names of parts, layers or components. Default: all parts.
        formats
            Any of ``stl``, ``3mf``, ``dxf``, ``svg``, ``png``, ``tree``, ``step``, ``glb``,
            ``gerber``, ``light``, ``msh``, ``vtk``; and of a whole sensor, for robots, ``urdf``,
            ``mjcf``, ``sdf``.
        tolerance_mm
            Largest distance between triangles and the exact surface; as all lengths, a number of
            mm, or text with a unit, ``"10 um"``.
        edge_mm
            Edge length of the tetrahedra in ``msh`` and ``vtk``. Default: 0.5 mm.
        nominal
            Leave out the compensation of shrinkage, kerf and printer.
        process
            Path of a printer's profile, as ``fabkit profile`` writes it; it applies to parts of
            its process and material.
        process_for_any_material
            Apply the profile to parts of other materials too, if the process is the same.
        bed_mm, stock_mm
            Width and depth of the printer's bed, and of the sheets to cut from, mm.
        kerf_mm
            Width of the laser's cut, mm.
        clean
            Remove files that the folder's manifest lists and this export does not write, unless
            they were changed since.
        force
            Replace also files that were changed since fabkit wrote them, or that it did not write.
        progress
            ``False`` for none, or a function of ``(done, total)``. Default: a bar if tqdm is
            installed.

        Returns
        -------
        The manifest: parts, files, volumes, hashes; it also lists the remaining files of earlier
        exports of the same design.

        Raises
        ------
        FabkitError
            A part or format is unknown, a part cannot be made in a format, or a file cannot be
            written.
        KeyboardInterrupt
            The export was interrupted; nothing was written.
        """
        with shown(progress, f"export {self.name}") as tell:
            exported = self._native.exported(
                {
                    "parts": list(parts),
                    "formats": list(formats),
                    "tolerance_mm": _arrays.length_mm(tolerance_mm, "tolerance_mm"),
                    "nominal": nominal,
                    "edge_mm": _arrays.optional_length_mm(edge_mm, "edge_mm"),
                    "process": None if process is None else os.fspath(process),
                    "process_for_any_material": process_for_any_material,
                    "bed_mm": _arrays.sides_mm(bed_mm, "bed_mm"),
                    "stock_mm": _arrays.sides_mm(stock_mm, "stock_mm"),
                    "kerf_mm": _arrays.optional_length_mm(kerf_mm, "kerf_mm"),
                },
                tell,
            )
        return json.loads(exported.write(os.fspath(folder), clean, force))


class Fixture(Design):
    """Calibration hardware for a sensor."""

    def __init__(self, project: _fabkit.Project, key: str) -> None:
        super().__init__(project.fixture(key))
        self._project = project
        self.key = key
        """Name of the fixture without the sensor's, for example ``pin-dome``."""

    def check(self) -> CheckReport:
        """Check the fixture by the rules for all designs and by those for its kind."""
        return CheckReport(json.loads(self._project.check(self.key)))

    @property
    def landmarks(self) -> NDArray[np.void]:
        """Points where pins touch the sensor: a structured array.

        One row for each hole and kind of pin. Fields: ``hole`` (uint32, from 1), ``kind`` (text),
        and in the sensor frame ``tip_centre_in_sensor_mm``, ``contact_in_sensor_mm`` (3 x float64,
        mm) and ``axis_in_sensor`` (3 x float64, unit length: the direction in which the pin is
        pushed). Empty for fixtures without pins. :func:`fabkit.calibrate.extrinsics` uses these
        points.

        >>> import fabkit
        >>> landmarks = fabkit.load("rtac0").fixtures["pin-dome"].landmarks
        >>> landmarks.dtype.names[:2], len(landmarks)
        (('hole', 'kind'), 58)
        """
        text = self._native.pin_landmarks()
        pins: list[dict[str, Any]] = [] if text is None else json.loads(text)["pins"]
        width = max((len(pin["kind"]) for pin in pins), default=1)
        vectors = ("tip_centre_in_sensor_mm", "contact_in_sensor_mm", "axis_in_sensor")
        fields = [("hole", "u4"), ("kind", f"U{width}"), *((name, "f8", 3) for name in vectors)]
        landmarks = np.zeros(len(pins), dtype=fields)
        for row, pin in enumerate(pins):
            landmarks[row] = tuple(pin[name] for name in ("hole", "kind", *vectors))
        return landmarks


class Sensor(Design):
    """A sensor design.

    >>> import fabkit
    >>> sensor = fabkit.load("rtac0")
    >>> list(sensor.parts)[:2], "pin-dome" in sensor.fixtures
    (['shell', 'base'], True)
    """

    def __init__(
        self,
        project: _fabkit.Project,
        source: str,
        changes: tuple[str | None, list[str]] | None = None,
    ) -> None:
        super().__init__(project.design())
        self._project = project
        self._changes = changes
        self.source = source
        """Name or path that the sensor was loaded from."""
        names = project.fixture_names()
        self.fixtures = Named("fixture", names, lambda name: Fixture(project, name))
        """Calibration fixtures by name; each is designed at its first access."""

    def __reduce__(self) -> tuple[Any, ...]:
        # For another process, possibly in another folder: it loads the sensor again.
        if self._changes is None:
            raise TypeError("a variant of a sweep cannot be pickled; send its plan and its number")
        is_file = self.source not in sensors()
        return (_loaded, (os.path.abspath(self.source) if is_file else self.source, *self._changes))

    @property
    def changes(self) -> list[Change]:
        """Changes that :func:`load` made with ``fix=True`` so that the sensor can be built.

        >>> import fabkit
        >>> fabkit.load("rtac0", surface__radius="20 mm", fix=True).changes
        []
        """
        return [Change(*change) for change in self._project.changes()]

    @property
    def family(self) -> str:
        """Name of the sensor's family, for example ``dome``.

        >>> import fabkit
        >>> fabkit.load("9dtact").family
        'flat-gel'
        """
        return self._project.family()

    @property
    def camera(self) -> Camera:
        """Nominal camera: the lens alone; the design's bodies refract its rays."""
        return Camera(self._project.camera())

    @property
    def sensor_from_camera(self) -> NDArray[np.float64]:
        """Nominal pose of the camera: camera frame to sensor frame, (4, 4), mm."""
        return self._project.sensor_from_camera()

    @property
    def presses(self) -> list[str]:
        """IDs of the presses at fixed poses, for :func:`fabkit.depth.cast`.

        With ``-flipped`` appended, an ID is the same press after half a turn. Indenters at any
        pose have an ID such as ``hemisphere@30deg,120deg,1.2mm``.
        """
        return self._project.presses()

    def replace(self, overrides: Mapping[str, object] | None = None, **values: object) -> Sensor:
        """Return a copy of the sensor with some parameters changed.

        Parameters
        ----------
        overrides, values
            As for :func:`load`. A plain number for a length or an angle is in the parameter's
            unit.

        Raises
        ------
        FabkitError
            As for :func:`load`.

        >>> import fabkit
        >>> sensor = fabkit.load("rtac0", coat__thickness="0.1 mm")
        >>> larger = sensor.replace({"surface.radius": 1.1 * sensor.surface.radius})
        >>> larger.surface.radius, larger.coat.thickness
        (16.5, 0.1)
        """
        changes = overrides_of(overrides, values)
        given = {path: self._with_unit(path, value) for path, value in changes.items()}
        kept = [one for one in self._project.overrides() if one.partition("=")[0] not in given]
        listed = [*kept, *(f"{p}={as_yaml(p, v)}" for p, v in given.items())]
        again = None if self._changes is None else (self._changes[0], listed)
        replaced = self._project.replaced(listed)
        _warn(replaced)
        return Sensor(replaced, self.source, again)

    def _with_unit(self, path: str, value: object) -> object:
        """Append the parameter's unit to a plain number."""
        parameter = self.parameters.get(path)
        is_number = isinstance(value, int | float | np.integer | np.floating)
        is_number = is_number and not isinstance(value, bool)
        unit = parameter.unit if parameter else None
        return f"{as_yaml(path, value)} {unit}" if is_number and unit else value

    def check(self) -> CheckReport:
        """Check that the sensor can be built: overlaps, molds, trapped air, demolding."""
        return CheckReport(json.loads(self._project.check(None)))


def as_sensor(sensor: object, name: str = "sensor") -> Sensor:
    """Return a sensor, loaded if it is given by its name; ``name`` is that of the argument."""
    found = _as_design(sensor, name)
    if not isinstance(found, Sensor):
        raise _wrong_type(found, name)
    return found


def _as_design(design: object, name: str) -> Design:
    if isinstance(design, str | Path):
        return load(design)
    if not isinstance(design, Design):
        raise _wrong_type(design, name)
    return design


def _wrong_type(given: object, name: str) -> TypeError:
    message = f"{name} is {type(given).__name__}; it must be what `fabkit.load` returns, or a name"
    return TypeError(message)


def check(design: Sensor | Fixture | str) -> CheckReport:
    """Check a design as ``design.check()`` does; a name is loaded first."""
    found = _as_design(design, "design")
    if not isinstance(found, Sensor | Fixture):
        raise _wrong_type(found, "design")
    return found.check()


def export(design: Design | str, folder: str | PathLike[str], **options: Any) -> dict[str, Any]:
    """Write a design's files as ``design.export(...)`` does; a name is loaded first."""
    return _as_design(design, "design").export(folder, **options)
