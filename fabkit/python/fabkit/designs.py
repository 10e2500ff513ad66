"""Sensors and the fixtures that calibrate them."""

from __future__ import annotations

import html
import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fabkit import _arrays, _fabkit
from fabkit._named import Named
from fabkit._progress import shown
from fabkit.bodies import Body
from fabkit.cameras import Camera
from fabkit.checking import CheckReport
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
    """Names of the built-in sensors.

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
    """Read a sensor: a built-in one by name, or a YAML file.

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
        Keep what is given here and in the file, and change what fabkit has chosen, as little as
        possible, until all fits; see :attr:`Sensor.changes`.
    values
        The same as overrides, with two underscores for a dot: ``coat__thickness="0.1 mm"``.

    Raises
    ------
    FabkitError
        No such sensor, preset or parameter; values that cannot be, all of them at once.

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
    return _loaded(os.fspath(sensor), preset, listed, fix)


def _loaded(name: str, preset: str | None, listed: list[str], fix: bool = False) -> Sensor:
    project = _fabkit.load(name, preset, listed, fix)
    changed = [f"{path}={to}" for path, _, to, _ in project.changes()]
    return Sensor(project, name, (preset, listed + changed))


@dataclass(frozen=True)
class Step:
    """One step of building a design."""

    name: str
    """Unique within the design."""
    instruction: str
    """What to do."""
    action: str
    """``make``, ``prepare``, ``assemble``, ``bond``, ``spray``, ``pour`` or ``demold``."""
    assembly: str | None
    """Where it happens, for example ``translucent-mold``."""
    bodies: list[str]
    """The bodies it is about."""
    batch: dict[str, Any] | None
    """What to mix: ``layer``, ``volume_mm3``, ``components`` with ``name`` and ``mass_g``."""
    during: str | None
    """The earlier step whose cure is waited for meanwhile."""
    adjust: list[str]
    """What is set right in it: lenses that are focused."""
    cure: dict[str, float] | None
    """How it hardens: ``hours``, ``celsius``."""
    remove: list[str]
    """The tools that come off."""
    source: str
    """Where that is described."""


@dataclass(frozen=True)
class Change:
    """A value that gave way so that a design can be built."""

    path: str
    """For example ``tube.wall``."""
    before: str
    """What fabkit had chosen."""
    value: str
    """What it is now."""
    because: str
    """Which rule is broken without it."""


class Design:
    """A kit of parts: a sensor, or a fixture made for one."""

    def __init__(self, native: _fabkit.Design) -> None:
        self._native = native
        about: dict[str, Any] = json.loads(native.about())
        self._about = about

        def of(kind: str) -> Named[Body]:
            bodies = {body["name"]: body for body in about["bodies"] if body["kind"] == kind}
            return Named(kind, list(bodies), lambda name: Body(native, bodies[name]))

        self.parts = of("part")
        """What is made from a file, by name."""
        self.layers = of("layer")
        """What is poured or sprayed, by name."""
        self.components = of("component")
        """What is bought, by name."""
        parameters = {entry["path"]: Parameter(**entry) for entry in about["parameters"]}
        self.parameters = Named("parameter", list(parameters), parameters.__getitem__)
        """Everything that shapes it, by path."""
        self.values = Section(self.parameters)
        """Their values by attribute: ``design.values.surface.radius``."""

    def __getattr__(self, name: str) -> Any:
        # Sections of parameters, where nothing else has the name.
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
        """For example ``rtac0`` or ``rtac0-pin-dome``."""
        return self._about["name"]

    @property
    def title(self) -> str:
        """For people."""
        return self._about["title"]

    @property
    def reference(self) -> str:
        """The publication it comes from."""
        return self._about["reference"]

    @property
    def design_hash(self) -> str:
        """BLAKE3, in hex, of everything that shapes it: what its files carry."""
        return self._about["design_hash"]

    @property
    def derived(self) -> dict[str, str]:
        """What follows from the parameters, with units."""
        return {entry["name"]: entry["written"] for entry in self._about["derived"]}

    @property
    def chain(self) -> list[Step]:
        """How it is built, step by step: what ``fabkit show --chain`` prints.

        >>> import fabkit
        >>> pours = [step for step in fabkit.load("rtac0").chain if step.action == "pour"]
        >>> pours[0].batch["layer"], pours[0].batch["components"][0]["name"]
        ('silicone-mold-transparent-gel', 'MoldStar 30 A')
        """
        return [Step(**step) for step in json.loads(self._native.chain())["steps"]]

    @property
    def bought(self) -> list[Body]:
        """What is bought for it, with ``quantity`` and, in ``summary``, what to order."""
        return list(self.components.values())

    @property
    def files(self) -> dict[str, bytes]:
        """What comes with it besides the files of its parts, by name: landmarks, boards, guides."""
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
        """Draw an assembly from the exact geometry: PNG. What is poured in stands as it is poured.

        Parameters
        ----------
        size_px
            Width and height.
        assembly
            Which one; without it, the sensor itself, or the first of a fixture.
        exploded
            Pulled apart.
        section
            Without the half nearer to the viewer; without `view`, that before the x-z plane.
        view
            From where: ``"front"``, ``"back"``, ``"left"``, ``"right"``, ``"top"``, ``"bottom"``,
            or azimuth from +x and elevation in degrees, ``(30, 20)``; else a corner above.

        Raises
        ------
        FabkitError
            No such assembly or side; a picture that is too large.
        """
        seen_from = _arrays.view(view)
        return self._native.picture(None, assembly, exploded, section, seen_from, size_px)

    def page(self) -> str:
        """Make one HTML page with a model to turn, cut and take apart; it needs no network.

        In a notebook, this is what a sensor or a fixture shows as.

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
        """Write files as ``fabkit export`` does, byte for byte: all of them, or none.

        Parameters
        ----------
        folder
            Where; it is made if it is missing.
        parts
            Names of parts, layers or components; none is all parts.
        formats
            Of ``stl``, ``3mf``, ``dxf``, ``svg``, ``png``, ``tree``, ``step``, ``glb``, ``gerber``,
            ``light``, ``msh``, ``vtk``; and for robots, of a whole sensor, ``urdf``, ``mjcf``,
            ``sdf``.
        tolerance_mm
            Largest distance between triangles and the exact surface; as all lengths, a number of
            mm, or text with a unit, ``"10 um"``.
        edge_mm
            Length of the edges of tetrahedra in ``msh`` and ``vtk``; 0.5 mm if not said.
        nominal
            Leave out what makes up for shrinkage, kerf and printer.
        process
            A printer's profile, as ``fabkit profile`` writes it, for parts of its process and
            material.
        process_for_any_material
            Apply the profile to parts of other materials too, where the process is the same.
        bed_mm, stock_mm
            Width and depth of the printer's bed, of sheets to cut from, mm.
        kerf_mm
            Width of the laser's cut, mm.
        clean
            Remove what the folder's manifest lists and this export does not write, if nobody has
            changed it since.
        force
            Replace also files that were changed since fabkit wrote them, or that it did not write.
        progress
            ``False`` for none, or a function of ``(done, all)``; else a bar if tqdm is installed.

        Returns
        -------
        The manifest: parts, files, volumes, hashes; what an earlier export of the same design left
        is in it.

        Raises
        ------
        FabkitError
            Unknown parts and formats; what cannot be made; files that cannot be written.
        KeyboardInterrupt
            Nothing was written then.
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
    """Calibration hardware made for a sensor."""

    def __init__(self, project: _fabkit.Project, key: str) -> None:
        super().__init__(project.fixture(key))
        self._project = project
        self.key = key
        """For example ``pin-dome``."""

    def check(self) -> CheckReport:
        """Apply the rules for any kit of parts, and the fixture's own."""
        return CheckReport(json.loads(self._project.check(self.key)))

    @property
    def landmarks(self) -> NDArray[np.void]:
        """Where pins touch the sensor: what the solver reads, as a structured array.

        One row for each hole and kind of pin. Fields: ``hole`` (uint32, from 1), ``kind`` (text),
        and in the sensor frame ``tip_centre_in_sensor_mm``, ``contact_in_sensor_mm`` (3 x float64,
        mm) and ``axis_in_sensor`` (3 x float64, unit length: the way the pin is pushed). Empty for
        fixtures without pins.

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
    """A sensor, from its description.

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
        """The name or path that it was loaded from."""
        names = project.fixture_names()
        self.fixtures = Named("fixture", names, lambda name: Fixture(project, name))
        """Calibration hardware, by name; each is designed when it is first asked for."""

    def __reduce__(self) -> tuple[Any, ...]:
        # To another process of the same machine, or one that sees the same files.
        if self._changes is None:
            raise TypeError("a variant of a sweep cannot be sent; send its plan and number")
        is_file = self.source not in sensors()
        return (_loaded, (os.path.abspath(self.source) if is_file else self.source, *self._changes))

    @property
    def changes(self) -> list[Change]:
        """What gave way so that it can be built, where :func:`load` was asked to fix it.

        >>> import fabkit
        >>> fabkit.load("rtac0", surface__radius="20 mm", fix=True).changes
        []
        """
        return [Change(*change) for change in self._project.changes()]

    @property
    def family(self) -> str:
        """What kind of sensor its file describes, for example ``dome``.

        >>> import fabkit
        >>> fabkit.load("9dtact").family
        'flat-gel'
        """
        return self._project.family()

    @property
    def camera(self) -> Camera:
        """The camera as designed, before any calibration: a lens, whose rays drawn bodies bend."""
        return Camera(self._project.camera())

    @property
    def sensor_from_camera(self) -> NDArray[np.float64]:
        """Camera frame to sensor frame as designed: (4, 4), mm."""
        return self._project.sensor_from_camera()

    @property
    def presses(self) -> list[str]:
        """IDs of the presses whose places are known, for :func:`fabkit.depth.cast`.

        Each with ``-flipped`` after it is the same after half a turn; indenters are placed by an ID
        such as ``hemisphere@30deg,120deg,1.2mm``.
        """
        return self._project.presses()

    def replace(self, overrides: Mapping[str, object] | None = None, **values: object) -> Sensor:
        """Make the same sensor with other values; everything else stays as it was given.

        Parameters
        ----------
        overrides, values
            As for :func:`load`. A number in place of a length or an angle is in the unit of the
            parameter.

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
        return Sensor(self._project.replaced(listed), self.source, again)

    def _with_unit(self, path: str, value: object) -> object:
        parameter = self.parameters.get(path)
        is_number = isinstance(value, int | float | np.integer | np.floating)
        is_number = is_number and not isinstance(value, bool)
        unit = parameter.unit if parameter else None
        return f"{as_yaml(path, value)} {unit}" if is_number and unit else value

    def check(self) -> CheckReport:
        """Check that it can be built: overlaps, molds, trapped air, demolding."""
        return CheckReport(json.loads(self._project.check(None)))


def check(design: Sensor | Fixture | str) -> CheckReport:
    """Check a design: the same as ``design.check()``; a name is loaded first."""
    return (load(design) if isinstance(design, str) else design).check()


def export(design: Design | str, folder: str | PathLike[str], **options: Any) -> dict[str, Any]:
    """Write a design's files: the same as ``design.export(...)``; a name is loaded first."""
    return (load(design) if isinstance(design, str) else design).export(folder, **options)
