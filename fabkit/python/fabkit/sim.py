"""A sensor to press again and again: picture, depth and force for simulators, studies and training.

What no press changes is computed once, when the sensor is made ready; a press then takes
milliseconds. Everything is simulated: elastic layers at small strain, each press on a surface at
rest, pictures with the constants that ``document`` names.

>>> import fabkit.sim
>>> sensor = fabkit.sim.Sensor("rtac0", size_px=(80, 60), spacing_mm=0.5)
>>> felt = sensor.press("hemisphere@30deg,0deg,0.6mm", seed=None)
>>> felt.image.shape, felt.image.dtype, felt.depth_mm.shape
((60, 80), dtype('uint8'), (60, 80))
>>> bool(felt.force_n[2] < 0), bool(abs(felt.deepest_mm - 0.6) < 0.05)
(True, True)

Bodies of one's own are placed by ``sensor_from_body``; here a ball that dips 0.5 mm into the tip:

>>> tip_mm = 21.0
>>> felt = sensor.press(fabkit.sim.ball(4.0).at(0, 0, tip_mm + 4.0 - 0.5))
>>> bool(felt.contact.any())
True
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from fabkit import _arrays, _fabkit
from fabkit.depth import Scene
from fabkit.designs import load
from fabkit.errors import invalid

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import ArrayLike, NDArray

    from fabkit.calibrate import Extrinsics
    from fabkit.cameras import Camera
    from fabkit.designs import Sensor as Design

__all__ = [
    "Asked",
    "Body",
    "Felt",
    "Followed",
    "Many",
    "MarkFollower",
    "Sensor",
    "Skin",
    "SkinMany",
    "ball",
    "box",
    "capsule",
    "convex",
    "cylinder",
]


def __dir__() -> list[str]:
    return __all__


@dataclass(frozen=True, eq=False)
class Body:
    """Something exact that presses; its middle is its origin, its axis z."""

    kind: str
    """``ball``, ``cylinder``, ``box``, ``capsule`` or ``convex``."""
    sizes_mm: tuple[float, ...]
    """What the kind asks for."""
    sensor_from_body: NDArray[np.float64]
    """Where it is, (4, 4), mm."""

    def placed(self, sensor_from_body: ArrayLike) -> Body:
        """Stand somewhere else: (4, 4), mm."""
        pose = np.array(_arrays.matrix(sensor_from_body, 4, "sensor_from_body"))
        return replace(self, sensor_from_body=pose)

    def at(self, x_mm: float, y_mm: float, z_mm: float) -> Body:
        """Stand somewhere else, turned as it is."""
        pose: NDArray[np.float64] = np.array(self.sensor_from_body, dtype=np.float64)
        pose[:3, 3] = x_mm, y_mm, z_mm
        return replace(self, sensor_from_body=pose)


def ball(radius_mm: float) -> Body:
    """Make a ball."""
    return Body("ball", (float(radius_mm),), np.eye(4))


def cylinder(radius_mm: float, height_mm: float) -> Body:
    """Make a cylinder around z."""
    return Body("cylinder", (float(radius_mm), float(height_mm)), np.eye(4))


def box(x_mm: float, y_mm: float, z_mm: float) -> Body:
    """Make a box by its edges' lengths."""
    return Body("box", (float(x_mm), float(y_mm), float(z_mm)), np.eye(4))


def capsule(radius_mm: float, height_mm: float) -> Body:
    """Make a capsule around z: a cylinder of that height between the centres of two half balls."""
    return Body("capsule", (float(radius_mm), float(height_mm)), np.eye(4))


def convex(vertices_mm: ArrayLike, triangles: ArrayLike) -> Body:
    """Make a convex body of a mesh, exactly: what lies behind all of its triangles.

    Several make a body with hollows: presses take any number of bodies.

    Parameters
    ----------
    vertices_mm
        (n, 3), mm.
    triangles
        (m, 3), counter-clockwise seen from outside, as :class:`fabkit.Mesh` and trimesh have them.

    Raises
    ------
    FabkitError
        A mesh with a hollow, or one that is turned inside out.
    """
    points, shape = _arrays.rows(vertices_mm, 3, "vertices_mm")
    corners = np.asarray(triangles)
    if len(shape) != 1 or corners.ndim != 2 or corners.shape[1] != 3 or not len(corners):
        raise invalid("a convex body needs vertices (n, 3) and triangles (m, 3)")
    if corners.dtype.kind not in "iu" or corners.min() < 0 or corners.max() >= len(points):
        raise invalid(f"triangles must hold indices of the {len(points)} vertices")
    first, second, third = (points[corners[:, k]] for k in range(3))
    normals = np.cross(second - first, third - first)
    areas = np.linalg.norm(normals, axis=1)
    size_mm = float(np.ptp(points, axis=0).max())
    solid = areas > 1e-9 * size_mm**2
    normals = normals[solid] / areas[solid, None]
    # Triangles of one face say the same.
    offsets = np.einsum("ij,ij->i", normals, first[solid])
    planes = np.round(np.column_stack([normals, offsets / max(size_mm, 1e-300)]), 9)
    _, kept = np.unique(planes, axis=0, return_index=True)
    kept.sort()
    normals, offsets = normals[kept], offsets[kept]
    beyond_mm = float((points @ normals.T - offsets).max()) if len(kept) else np.inf
    if beyond_mm > 1e-6 * size_mm:
        hint = "split it into convex pieces, and press all of them; or turn its triangles around"
        raise invalid(f"the mesh is not convex: a vertex lies {beyond_mm:.3g} mm outside", hint)
    margin = 0.01 * size_mm
    faces = np.column_stack([normals * offsets[:, None], normals])
    around = [*(points.min(axis=0) - margin), *(points.max(axis=0) + margin)]
    return Body("convex", (*map(float, around), *map(float, faces.ravel())), np.eye(4))


Presser: TypeAlias = str | Body | Sequence[str | Body]
"""A press by its name, a body in its place, or several that press at once."""


@dataclass(frozen=True)
class Asked:
    """A press, for :meth:`Sensor.press_all`."""

    presser: Presser = ()
    """What presses, and where; nothing for a sensor at rest."""
    shear_mm: tuple[float | str, float | str] = (0.0, 0.0)
    """How far it then moves along the surface: on a dome away from the tip and around it, on a pad
    along x and y."""
    friction: float | None = None
    """Coulomb's coefficient, instead of the touched material's own."""
    seed: int | None = 0
    """Of noise and drift; ``None`` for neither."""


@dataclass(frozen=True, eq=False)
class Felt:
    """What one press does. Simulated."""

    image: NDArray[np.uint8]
    """What the camera takes: rows x columns, and red, green, blue where there are colours."""
    depth_mm: NDArray[np.float32]
    """How much nearer the surface is than at rest, along each pixel's ray: rows x columns; negative
    where it bulges, NaN where no surface is seen."""
    contact: NDArray[np.bool_]
    """Where what presses is seen: rows x columns."""
    force_n: NDArray[np.float64]
    """Of what presses on the sensor, sensor frame, N: 3; zeros where nothing touches."""
    moment_nmm: NDArray[np.float64]
    """The same about the sensor's origin, N mm: 3."""
    contact_area_mm2: float
    """Of all that touches."""
    deepest_mm: float
    """How far the surface moves in, at most."""
    mark_displacement_mm: NDArray[np.float64]
    """How what the camera follows (dots, dimples, slots) has moved: m x 3; NaN where unknown."""
    mark_px: NDArray[np.float64]
    """Where it is seen, column and row: m x 2; NaN where it is not."""


@dataclass(frozen=True, eq=False)
class Many:
    """What many presses do: the arrays of :class:`Felt`, with the press as their first axis."""

    image: NDArray[np.uint8]
    depth_mm: NDArray[np.float32]
    contact: NDArray[np.bool_]
    force_n: NDArray[np.float64]
    moment_nmm: NDArray[np.float64]
    contact_area_mm2: NDArray[np.float64]
    deepest_mm: NDArray[np.float64]
    mark_displacement_mm: NDArray[np.float64]
    mark_px: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.image)

    def __getitem__(self, index: int) -> Felt:
        felt = {name: getattr(self, name)[index] for name in _FIELDS}
        for name in ("contact_area_mm2", "deepest_mm"):
            felt[name] = float(felt[name])
        return Felt(**felt)


_FIELDS = (
    "image",
    "depth_mm",
    "contact",
    "force_n",
    "moment_nmm",
    "contact_area_mm2",
    "deepest_mm",
    "mark_displacement_mm",
    "mark_px",
)


class Sensor:
    """A sensor that is ready to be pressed.

    Parameters
    ----------
    design
        A sensor, or the name of one.
    size_px
        Width and height of pictures, instead of the camera's own: the same view in fewer pixels.
    light, constants
        As for :meth:`fabkit.depth.Scene.capture`.
    camera, pose, unit
        As for :class:`fabkit.depth.Scene`.
    samples
        Rays along each side of a pixel, 1 to 8: a pixel records the mean of its own.
    spacing_mm
        Distance of the surface's nodes: wider is faster, and rough where contacts are only some
        nodes wide; without it as fine as some seconds of setup allow.

    Raises
    ------
    FabkitError
        A sensor without a surface of known shape, a light that it has not, and as for
        :class:`fabkit.depth.Scene`.
    """

    def __init__(
        self,
        design: Design | str,
        *,
        size_px: tuple[int, int] | None = None,
        light: str | None = None,
        constants: str | PathLike[str] | None = None,
        camera: Camera | str | PathLike[str] | None = None,
        pose: Extrinsics | str | PathLike[str] | ArrayLike | None = None,
        unit: int | None = None,
        samples: int = 1,
        spacing_mm: float | str | None = None,
    ) -> None:
        scene = Scene(design, camera=camera, pose=pose, unit=unit)
        if size_px is not None:
            scene = scene.resized(*size_px)
        self.scene = scene
        """The surface, and the camera that looks at it."""
        self._known: tuple[NDArray[np.float32], str | None, _fabkit.Reconstructor] | None = None
        self._lit = (light, None if constants is None else os.fspath(constants))
        self._live = _fabkit.Live(
            scene._native,  # pyright: ignore[reportPrivateUsage]
            *self._lit,
            samples,
            None if spacing_mm is None else _arrays.length_mm(spacing_mm, "spacing_mm"),
        )
        self.document: dict[str, Any] = json.loads(self._live.document())
        """What pictures and forces rest on: lamps, constants with their sources, layers, and what
        is left out."""
        self.sensor_from_touch = np.array(self._live.sensor_from_touch())
        """Where the middle of what is touched is, z out of the sensor: (4, 4), mm."""
        marks = self._live.marks()
        self.mark_names = [name for name, _ in marks]
        """What the camera follows."""
        self.mark_place_mm = np.array([place for _, place in marks]).reshape(-1, 3)
        """Where it is at rest, sensor frame: m x 3."""

    def press(
        self,
        presser: Presser = (),
        *,
        shear_mm: tuple[float | str, float | str] = (0.0, 0.0),
        friction: float | None = None,
        seed: int | None = 0,
    ) -> Felt:
        """Press; each press meets a surface at rest. The arguments are those of :class:`Asked`.

        Raises
        ------
        FabkitError
            An unknown press, a body that is none, one deeper than the layers, a contact that does
            not converge, a way along a surface of unknown friction.
        """
        return self.press_all([Asked(presser, shear_mm, friction, seed)])[0]

    def press_all(self, asked: Sequence[Asked]) -> Many:
        """Press many times, on all cores.

        >>> import fabkit.sim
        >>> sensor = fabkit.sim.Sensor("rtac0", size_px=(40, 30), spacing_mm=1.0)
        >>> places = [f"hemisphere@30deg,{azimuth}deg,0.5mm" for azimuth in (0, 90, 180)]
        >>> many = sensor.press_all([fabkit.sim.Asked(place) for place in places])
        >>> many.image.shape, many.force_n.shape
        ((3, 30, 40), (3, 3))
        """
        if not asked:
            raise invalid("press_all needs at least one press")
        return Many(**self._live.press([_native(one) for one in asked]))

    def reconstruct(
        self,
        images: ArrayLike,
        reference: ArrayLike,
        *,
        network: str | PathLike[str] | None = None,
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Find depth from pictures, as ``fabkit reconstruct`` does.

        Parameters
        ----------
        images
            rows x columns, rows x columns x 3, or n of either: real pictures or simulated ones.
        reference
            The picture at rest.
        network
            An ONNX file, a chain of convolutions from one channel to one; what it takes and gives
            stands in the file of the same name that ends in ``.json``, or else it is taken for
            R-Tac0's published network. Without it depth is found by what the sensor's light shows.

        Returns
        -------
        ``depth_mm`` as :attr:`Felt.depth_mm` (by a network 0 where nothing touches), and
        ``contact``, each (n, rows, columns), or without n for one picture.

        Raises
        ------
        FabkitError
            A sensor whose light shows neither thickness nor slopes, pictures of another size, a
            network of other layers.
        """
        rest = _taken(reference, "reference")
        # Seconds; the same picture at rest serves many calls.
        by = None if network is None else os.fspath(network)
        same = self._known is not None and self._known[1] == by
        if self._known is None or not same or not np.array_equal(self._known[0], rest):
            native = self.scene._native  # pyright: ignore[reportPrivateUsage]
            self._known = (rest, by, _fabkit.Reconstructor(native, *self._lit, rest, by))
        known = self._known[2]
        given = np.asarray(images)
        is_one = given.ndim == np.asarray(reference).ndim
        shown = [known.depth(_taken(one, "images")) for one in (given[None] if is_one else given)]
        depth_mm, contact = (np.stack([one[k] for one in shown]) for k in (0, 1))
        return (depth_mm[0], contact[0]) if is_one else (depth_mm, contact)


@dataclass(frozen=True, eq=False)
class Followed:
    """Where marks are in n pictures; NaN where one is not found, and without n of one picture."""

    px: NDArray[np.float64]
    """Column and row of each, 0 in the middle of the first pixel: (n, m, 2)."""
    moved_px: NDArray[np.float64]
    """How far it has moved from the picture at rest: (n, m, 2)."""
    moved_mm: NDArray[np.float64]
    """The same along the surface on which the mark lies at rest, or along its column, sensor
    frame: (n, m, 3). A picture tells nothing of the rest of its way, which is taken as none."""
    seen: NDArray[np.bool_]
    """Which are found: (n, m)."""


class MarkFollower:
    """Marks (dots, dimples, markers, ends of columns) that are followed by their names.

    The same as ``fabkit reconstruct`` does, for pictures that are real or simulated.

    >>> import fabkit.sim
    >>> skin = fabkit.sim.Skin("fluidic", spacing_mm=2.0)
    >>> rest, pressed = skin.press_all(
    ...     ["hemisphere@20mm,3mm,0.1mm", "hemisphere@20mm,3mm,4mm"], lights=["white"]
    ... ).images["white"]
    >>> marks = fabkit.sim.MarkFollower("fluidic", rest)
    >>> followed = marks.follow(pressed)
    >>> marks.names[:2], followed.px.shape, bool(followed.seen.all())
    (['marker 1', 'marker 2'], (100, 2), True)

    Parameters
    ----------
    design
        A sensor, the name of one, or a :class:`fabkit.depth.Scene` with the calibrated camera that
        took the pictures; otherwise they were taken by the drawn one, more or less.
    reference
        The picture at rest: rows x columns, or x 3 in colour. Its size is the camera's.
    light
        Which of the sensor's lights is on; its usual one if not said.

    Raises
    ------
    FabkitError
        A light that shows no marks, or a picture in which less than half of them are found.
    """

    def __init__(
        self, design: Design | str | Scene, reference: ArrayLike, *, light: str | None = None
    ) -> None:
        scene = design if isinstance(design, Scene) else None
        sensor = design.sensor if isinstance(design, Scene) else design
        sensor = load(sensor) if isinstance(sensor, str) else sensor
        rest = _taken(reference, "reference")
        self._colors = np.asarray(reference).ndim
        self._known = _fabkit.MarkFollower(
            sensor._project,  # pyright: ignore[reportPrivateUsage]
            None if scene is None else scene._native,  # pyright: ignore[reportPrivateUsage]
            light,
            rest,
        )
        self.names = self._known.names()
        """Of the m marks, in the description's order."""
        first = self._known.follow(rest)
        self.drawn_px: NDArray[np.float64] = first["mark_drawn_px"]
        """Where the camera would see them as they are drawn: (m, 2); NaN beside the picture."""
        self.rest_px: NDArray[np.float64] = first["mark_rest_px"]
        """Where they are in the picture at rest: (m, 2); NaN of those that are not found there, and
        are not looked for elsewhere."""

    def follow(self, images: ArrayLike) -> Followed:
        """Find the marks in a picture like the reference, or in n of them.

        Raises
        ------
        FabkitError
            Pictures of another size, or without colours where they are needed.
        """
        given = np.asarray(images)
        is_one = given.ndim == self._colors
        told = [
            self._known.follow(_taken(one, "images")) for one in (given[None] if is_one else given)
        ]
        names = ("mark_px", "mark_moved_px", "mark_moved_mm", "mark_seen")
        found = [np.stack([one[name] for one in told]) for name in names]
        return Followed(*(array[0] if is_one else array for array in found))


@dataclass(frozen=True, eq=False)
class SkinMany:
    """What presses on a skin with channels of liquid do; the first axis is the press. Simulated."""

    force_n: NDArray[np.float64]
    """Of what presses on the skin, sensor frame, N: n x 3; zeros where nothing touches."""
    column_mm: NDArray[np.float64]
    """How far the liquid of each channel moves in its tube: n x channels."""
    column_px: NDArray[np.float64]
    """Where each column ends in the display's picture, column and row: n x channels x 2."""
    mark_displacement_mm: NDArray[np.float64]
    """How each mark below the channels moves: n x m x 3."""
    mark_px: NDArray[np.float64]
    """Where it is seen: n x m x 2; NaN where it is not."""
    images: dict[str, NDArray[np.uint8]]
    """Pictures by light, of those that were asked for: n x rows x columns, and x 3 in colour."""

    def __len__(self) -> int:
        return len(self.force_n)


class Skin:
    """A skin with channels of liquid that is ready to be pressed.

    >>> import fabkit.sim
    >>> skin = fabkit.sim.Skin("fluidic", spacing_mm=2.0)
    >>> many = skin.press_all(["hemisphere@20mm,3mm,1mm", "hemisphere@20mm,3mm,2mm"])
    >>> many.column_mm.shape, bool(many.force_n[1, 2] < many.force_n[0, 2] < 0)
    ((2, 16), True)

    Parameters
    ----------
    design
        A sensor, or the name of one.
    spacing_mm
        Distance of the skin's nodes, 1 mm if not said.
    size_px
        Width and height of both cameras' pictures, instead of their own.

    Raises
    ------
    FabkitError
        A sensor without such a skin.
    """

    def __init__(
        self,
        design: Design | str,
        *,
        spacing_mm: float | str | None = None,
        size_px: tuple[int, int] | None = None,
    ) -> None:
        self.sensor = load(design) if isinstance(design, str) else design
        """What is pressed."""
        self._live = _fabkit.LiveSkin(
            self.sensor._project,  # pyright: ignore[reportPrivateUsage]
            self.sensor.name,
            None if spacing_mm is None else _arrays.length_mm(spacing_mm, "spacing_mm"),
            size_px,
        )
        self.column_names = self._live.channels()
        """The channels."""
        marks = self._live.marks()
        self.mark_names = [name for name, _ in marks]
        """What the camera below follows."""
        self.mark_place_mm = np.array([place for _, place in marks]).reshape(-1, 3)
        """Where it is at rest, sensor frame: m x 3."""

    def press_all(
        self, pressers: Sequence[str], *, lights: Sequence[str] = (), seed: int | None = 0
    ) -> SkinMany:
        """Press straight down, without friction; presses at one place cost hardly more than one.

        Parameters
        ----------
        pressers
            Names of presses.
        lights
            In which of the sensor's lights pictures are wanted.
        seed
            Of the first picture's noise, and the next numbers for the next; None for none.

        >>> import fabkit.sim
        >>> skin = fabkit.sim.Skin("fluidic", spacing_mm=2.0, size_px=(160, 120))
        >>> many = skin.press_all(["hemisphere@20mm,3mm,2mm"], lights=["white", "display"])
        >>> {light: images.shape for light, images in many.images.items()}
        {'white': (1, 120, 160), 'display': (1, 120, 160, 3)}

        Raises
        ------
        FabkitError
            An unknown press or light, a channel that is pressed shut, a contact that does not
            converge.
        """
        if not pressers:
            raise invalid("press_all needs at least one press")
        told = self._live.press(list(pressers), list(lights), seed)
        # Lights may have any name: a space tells them from what else there is.
        images = {light: told.pop(f" {light}") for light in lights}
        return SkinMany(**told, images=images)


def _taken(picture: ArrayLike, name: str) -> NDArray[np.float32]:
    """Rows x columns x channels, from 0 to 1."""
    given = np.asarray(picture)
    if given.dtype.kind == "u":
        given = given / np.float32(np.iinfo(given.dtype).max)
    elif given.dtype.kind != "f":
        raise invalid(f"{name} has the dtype {given.dtype}; it must be unsigned or floating point")
    if given.ndim == 2:
        given = given[:, :, None]
    if given.ndim != 3 or given.shape[2] not in (1, 3):
        raise invalid(f"{name} has the shape {given.shape}; a picture has rows, columns, colours")
    return np.ascontiguousarray(given, dtype=np.float32)


def _native(
    asked: Asked,
) -> tuple[
    list[str],
    list[tuple[str, list[float], list[list[float]]]],
    tuple[float, float],
    float | None,
    int | None,
]:
    given = [asked.presser] if isinstance(asked.presser, str | Body) else list(asked.presser)
    names = [one for one in given if isinstance(one, str)]
    bodies = [
        (one.kind, list(one.sizes_mm), one.sensor_from_body.tolist())
        for one in given
        if isinstance(one, Body)
    ]
    shear_mm = _arrays.lengths_mm(asked.shear_mm, "shear_mm")
    return names, bodies, shear_mm, asked.friction, asked.seed
