"""Fast simulation of many presses: image, indentation and force, for simulators and training.

Everything that does not depend on the press is computed once, when a :class:`Sensor` is created; a
press then takes milliseconds. Everything is simulated: elastic layers at small strain, each press
on a surface at rest, images with the constants that ``document`` names.

>>> import fabkit.sim
>>> sensor = fabkit.sim.Sensor("rtac0", size_px=(80, 60), spacing_mm=0.5)
>>> felt = sensor.press("hemisphere@30deg,0deg,0.6mm", seed=None)
>>> felt.image.shape, felt.image.dtype, felt.depth_mm.shape
((60, 80), dtype('uint8'), (60, 80))
>>> bool(felt.force_n[2] < 0), bool(abs(felt.deepest_mm - 0.6) < 0.05)
(True, True)

Other indenters are placed by ``sensor_from_body``; here a ball that is pressed 0.5 mm into the tip:

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
from fabkit.designs import as_sensor
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
    """An indenter with an exact shape; its origin is its centre, its axis is z."""

    kind: str
    """``ball``, ``cylinder``, ``box``, ``capsule`` or ``convex``."""
    sizes_mm: tuple[float, ...]
    """Arguments of the function that creates this kind; for ``convex`` box, points and normals."""
    sensor_from_body: NDArray[np.float64]
    """Pose: body frame to sensor frame, (4, 4), mm."""

    def placed(self, sensor_from_body: ArrayLike) -> Body:
        """Return the body at another pose, (4, 4), mm."""
        pose = np.array(_arrays.matrix(sensor_from_body, 4, "sensor_from_body"))
        return replace(self, sensor_from_body=pose)

    def at(self, x_mm: float, y_mm: float, z_mm: float) -> Body:
        """Return the body with its centre at another point of the sensor frame, not rotated."""
        pose: NDArray[np.float64] = np.array(self.sensor_from_body, dtype=np.float64)
        pose[:3, 3] = x_mm, y_mm, z_mm
        return replace(self, sensor_from_body=pose)


def ball(radius_mm: float) -> Body:
    """Create a ball."""
    return Body("ball", (float(radius_mm),), np.eye(4))


def cylinder(radius_mm: float, height_mm: float) -> Body:
    """Create a cylinder around z."""
    return Body("cylinder", (float(radius_mm), float(height_mm)), np.eye(4))


def box(x_mm: float, y_mm: float, z_mm: float) -> Body:
    """Create a box from the lengths of its edges."""
    return Body("box", (float(x_mm), float(y_mm), float(z_mm)), np.eye(4))


def capsule(radius_mm: float, height_mm: float) -> Body:
    """Create a capsule around z: a cylinder of ``height_mm`` between two hemispheres."""
    return Body("capsule", (float(radius_mm), float(height_mm)), np.eye(4))


def convex(vertices_mm: ArrayLike, triangles: ArrayLike) -> Body:
    """Create a convex body from a mesh: the intersection of the half spaces of its triangles.

    For a shape with hollows, press several convex bodies at once.

    Parameters
    ----------
    vertices_mm
        Vertices, (n, 3), mm.
    triangles
        Vertex indices, (m, 3), counter-clockwise seen from outside, as in :class:`fabkit.Mesh`.

    Raises
    ------
    FabkitError
        The mesh is not convex, or is turned inside out.
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
    # Triangles of one face share a plane: keep one of them. No vertex may lie in front of a plane.
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
"""An indenter: the name of a press, a body at its pose, or several that press at once."""


@dataclass(frozen=True)
class Asked:
    """One press for :meth:`Sensor.press_all`."""

    presser: Presser = ()
    """Indenter at its pose, or several; empty for a sensor at rest."""
    shear_mm: tuple[float | str, float | str] = (0.0, 0.0)
    """Tangential motion after pressing, mm: on a dome away from the tip and around it, on a pad
    along x and y."""
    friction: float | None = None
    """Coulomb's coefficient of friction. Default: that of the touched material."""
    seed: int | None = 0
    """Seed of noise and drift; ``None`` for neither."""


@dataclass(frozen=True, eq=False)
class Felt:
    """Result of one press: image, indentation, contact, force and markers. Simulated."""

    image: NDArray[np.uint8]
    """Image of the camera: rows x columns, or rows x columns x 3 (red, green, blue) in colour."""
    depth_mm: NDArray[np.float32]
    """Indentation along each pixel's ray, mm: rows x columns; negative where the surface bulges,
    NaN where the pixel does not see it."""
    contact: NDArray[np.bool_]
    """True where the pixel sees the contact with an indenter: rows x columns."""
    force_n: NDArray[np.float64]
    """Force of the indenters on the sensor, sensor frame, N: 3; zeros without contact."""
    moment_nmm: NDArray[np.float64]
    """Moment of the indenters about the sensor's origin, N mm: 3."""
    contact_area_mm2: float
    """Area of the contact, mm2."""
    deepest_mm: float
    """Largest indentation of the surface, mm."""
    mark_displacement_mm: NDArray[np.float64]
    """Displacement of each marker (dot, dimple, slot), mm: m x 3; NaN where unknown."""
    mark_px: NDArray[np.float64]
    """Pixel of each marker, column and row: m x 2; NaN where the camera does not see it."""


@dataclass(frozen=True, eq=False)
class Many:
    """Results of several presses: the arrays of :class:`Felt` with the press as first axis."""

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
    """A sensor that is prepared for fast simulation of presses.

    Parameters
    ----------
    design
        A sensor, or the name of one.
    size_px
        Width and height of images, px, with the same view. Default: the camera's own.
    light, constants
        As for :meth:`fabkit.depth.Scene.capture`.
    camera, pose, unit
        As for :class:`fabkit.depth.Scene`.
    samples
        Number of rays along each side of a pixel, 1 to 8; a pixel records the mean of its rays.
    spacing_mm
        Distance between the surface's nodes, mm. A larger distance is faster, but inaccurate for
        contacts that are only some nodes wide. Default: as fine as a few seconds of setup allow.

    Raises
    ------
    FabkitError
        The sensor has no surface of known shape or no such light; and as for
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
        """The sensor's surface and its camera."""
        self._known: (
            tuple[NDArray[np.float32], tuple[str | None, bool], _fabkit.Reconstructor] | None
        ) = None
        self._light = (light, None if constants is None else os.fspath(constants))
        self._live = _fabkit.Live(
            scene._native,  # pyright: ignore[reportPrivateUsage]
            *self._light,
            samples,
            None if spacing_mm is None else _arrays.length_mm(spacing_mm, "spacing_mm"),
        )
        self.document: dict[str, Any] = json.loads(self._live.document())
        """Assumptions of images and forces: light sources, constants with their sources, layers,
        and what the simulation leaves out."""
        self.sensor_from_touch = np.array(self._live.sensor_from_touch())
        """Pose of the middle of the touched surface, z out of the sensor: (4, 4), mm."""
        marks = self._live.marks()
        self.mark_names = [name for name, _ in marks]
        """Names of the markers that the camera tracks."""
        self.mark_place_mm = np.array([place for _, place in marks]).reshape(-1, 3)
        """Positions of the markers at rest, sensor frame, mm: m x 3."""

    def press(
        self,
        presser: Presser = (),
        *,
        shear_mm: tuple[float | str, float | str] = (0.0, 0.0),
        friction: float | None = None,
        seed: int | None = 0,
    ) -> Felt:
        """Simulate one press on the surface at rest. The arguments are those of :class:`Asked`.

        Raises
        ------
        FabkitError
            The press is unknown or deeper than the layers, a body is invalid, the contact does not
            converge, or shear needs a friction that is not known.
        """
        return self.press_all([Asked(presser, shear_mm, friction, seed)])[0]

    def press_all(self, asked: Sequence[Asked]) -> Many:
        """Simulate several independent presses, on all cores.

        >>> import fabkit.sim
        >>> sensor = fabkit.sim.Sensor("rtac0", size_px=(40, 30), spacing_mm=1.0)
        >>> places = [f"hemisphere@30deg,{azimuth}deg,0.5mm" for azimuth in (0, 90, 180)]
        >>> many = sensor.press_all([fabkit.sim.Asked(place) for place in places])
        >>> many.image.shape, many.force_n.shape
        ((3, 30, 40), (3, 3))
        """
        if not asked:
            raise invalid("press_all needs at least one press")
        pressers = [
            [one.presser] if isinstance(one.presser, str | Body) else list(one.presser)
            for one in asked
        ]
        pairs = zip(pressers, asked, strict=True)
        return Many(**self._live.press([_arrays.press_arguments(*pair) for pair in pairs]))

    def reconstruct(
        self,
        images: ArrayLike,
        reference: ArrayLike,
        *,
        network: str | PathLike[str] | None = None,
        force: bool = False,
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Reconstruct indentation from captures, as ``fabkit reconstruct`` does.

        Images are compared with the drawn light and with the reference, and depth with the soft
        layers: images of another sensor, in BGR, turned, or with 12 bits in 16 are refused.

        Parameters
        ----------
        images
            Captures, real or simulated: rows x columns, rows x columns x 3, or n of either.
        reference
            The reference image, without contact.
        network
            An ONNX file: a chain of convolutions from one channel to one. A ``.json`` file of the
            same name describes input and output; without that it counts as R-Tac0's published
            network. Default: a model of the sensor's light, which shows thickness or slopes.
        force
            Return results even if images or results are implausible.

        Returns
        -------
        ``depth_mm`` as :attr:`Felt.depth_mm` (a network gives 0 without contact), and ``contact``,
        each (n, rows, columns), or without n for one image.

        Raises
        ------
        FabkitError
            The sensor's light shows neither thickness nor slopes, images have another size, the
            network has other layers or gives no finite numbers, or images or results are
            implausible.
        """
        rest = _arrays.image(reference, "reference")
        # Preparation takes seconds; keep the result while reference image and network are the same.
        by = (None if network is None else os.fspath(network), force)
        same = self._known is not None and self._known[1] == by
        if self._known is None or not same or not np.array_equal(self._known[0], rest):
            native = self.scene._native  # pyright: ignore[reportPrivateUsage]
            self._known = (rest, by, _fabkit.Reconstructor(native, *self._light, rest, *by))
        known = self._known[2]
        given = np.asarray(images)
        is_one = given.ndim == np.asarray(reference).ndim
        several = given[None] if is_one else given
        shown = [known.depth(_arrays.image(one, "images")) for one in several]
        depth_mm, contact = (np.stack([one[k] for one in shown]) for k in (0, 1))
        return (depth_mm[0], contact[0]) if is_one else (depth_mm, contact)


@dataclass(frozen=True, eq=False)
class Followed:
    """Tracked positions of m markers in n images, or in one, without n; NaN if not found."""

    px: NDArray[np.float64]
    """Column and row of each marker, (n, m, 2), px; the first pixel's centre is (0, 0)."""
    moved_px: NDArray[np.float64]
    """Displacement from the reference image, (n, m, 2), px."""
    moved_mm: NDArray[np.float64]
    """Displacement along the surface at rest, or along the liquid column: sensor frame, (n, m, 3),
    mm. An image does not show the other component, which is taken as zero."""
    seen: NDArray[np.bool_]
    """True where a marker is found: (n, m)."""


class MarkFollower:
    """Tracks markers (dots, dimples, ends of liquid columns) in captures, real or simulated.

    It computes the same as ``fabkit reconstruct``. Each marker keeps its name.

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
        A sensor, its name, or a :class:`fabkit.depth.Scene` with the calibrated camera that took
        the images. Without a scene, the design's camera is taken as an approximation.
    reference
        The reference image, of the camera's size: rows x columns, or rows x columns x 3 in colour.
    light
        Name of the light that is on. Default: the sensor's usual one.
    force
        Track markers even in images that cannot belong to the reference image.

    Raises
    ------
    FabkitError
        The light shows no markers, or less than half of them are found in the reference image.
    """

    def __init__(
        self,
        design: Design | str | Scene,
        reference: ArrayLike,
        *,
        light: str | None = None,
        force: bool = False,
    ) -> None:
        scene = design if isinstance(design, Scene) else None
        sensor = design.sensor if isinstance(design, Scene) else design
        sensor = as_sensor(sensor)
        rest = _arrays.image(reference, "reference")
        self._colors = np.asarray(reference).ndim
        self._known = _fabkit.MarkFollower(
            sensor._project,  # pyright: ignore[reportPrivateUsage]
            None if scene is None else scene._native,  # pyright: ignore[reportPrivateUsage]
            light,
            rest,
            force,
        )
        self.names = self._known.names()
        """Names of the m markers, in the order of the design."""
        first = self._known.follow(rest)
        self.drawn_px: NDArray[np.float64] = first["mark_drawn_px"]
        """Pixels of the markers according to the design, (m, 2); NaN outside the image."""
        self.rest_px: NDArray[np.float64] = first["mark_rest_px"]
        """Pixels of the markers in the reference image, (m, 2); NaN for markers that are not found
        there, which are not tracked."""

    def follow(self, images: ArrayLike) -> Followed:
        """Find the markers in one image or in n images with the reference image's shape.

        Raises
        ------
        FabkitError
            The images have another size, or lack colours that the markers need.
        """
        given = np.asarray(images)
        is_one = given.ndim == self._colors
        several = given[None] if is_one else given
        told = [self._known.follow(_arrays.image(one, "images")) for one in several]
        names = ("mark_px", "mark_moved_px", "mark_moved_mm", "mark_seen")
        found = [np.stack([one[name] for one in told]) for name in names]
        return Followed(*(array[0] if is_one else array for array in found))


@dataclass(frozen=True, eq=False)
class SkinMany:
    """Results of n presses on a skin with liquid channels. Simulated."""

    force_n: NDArray[np.float64]
    """Force of the indenter on the skin, sensor frame, N: n x 3; zeros without contact."""
    column_mm: NDArray[np.float64]
    """Displacement of each channel's liquid column in its tube, mm: n x channels."""
    column_px: NDArray[np.float64]
    """End of each liquid column in the display's image, column and row: n x channels x 2."""
    mark_displacement_mm: NDArray[np.float64]
    """Displacement of each marker below the channels, mm: n x m x 3."""
    mark_px: NDArray[np.float64]
    """Pixel of each marker, column and row: n x m x 2; NaN where the camera does not see it."""
    images: dict[str, NDArray[np.uint8]]
    """Requested images by light: n x rows x columns, or n x rows x columns x 3 in colour."""

    def __len__(self) -> int:
        return len(self.force_n)


class Skin:
    """A skin with liquid channels that is prepared for fast simulation of presses.

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
        Distance between the skin's nodes, mm. Default: 1 mm.
    size_px
        Width and height of both cameras' images, px. Default: the cameras' own.

    Raises
    ------
    FabkitError
        The sensor has no such skin.
    """

    def __init__(
        self,
        design: Design | str,
        *,
        spacing_mm: float | str | None = None,
        size_px: tuple[int, int] | None = None,
    ) -> None:
        self.sensor = as_sensor(design, "design")
        """The sensor that has the skin."""
        self._live = _fabkit.LiveSkin(
            self.sensor._project,  # pyright: ignore[reportPrivateUsage]
            self.sensor.name,
            None if spacing_mm is None else _arrays.length_mm(spacing_mm, "spacing_mm"),
            size_px,
        )
        self.column_names = self._live.channels()
        """Names of the channels."""
        marks = self._live.marks()
        self.mark_names = [name for name, _ in marks]
        """Names of the markers that the camera below tracks."""
        self.mark_place_mm = np.array([place for _, place in marks]).reshape(-1, 3)
        """Positions of the markers at rest, sensor frame, mm: m x 3."""

    def press_all(
        self, pressers: Sequence[str], *, lights: Sequence[str] = (), seed: int | None = 0
    ) -> SkinMany:
        """Press several times along the normal, without friction; repeats at one place are fast.

        Parameters
        ----------
        pressers
            Names of presses.
        lights
            Names of the sensor's lights to render images in. Default: no images.
        seed
            Seed of the first image's noise; the next image uses the next number. ``None``: none.

        >>> import fabkit.sim
        >>> skin = fabkit.sim.Skin("fluidic", spacing_mm=2.0, size_px=(160, 120))
        >>> many = skin.press_all(["hemisphere@20mm,3mm,2mm"], lights=["white", "display"])
        >>> {light: images.shape for light, images in many.images.items()}
        {'white': (1, 120, 160), 'display': (1, 120, 160, 3)}

        Raises
        ------
        FabkitError
            A press or light is unknown, a channel is pressed shut, or the contact does not
            converge.
        """
        if not pressers:
            raise invalid("press_all needs at least one press")
        told = self._live.press(list(pressers), list(lights), seed)
        # Lights may have any name: a leading space keeps them apart from the other arrays.
        images = {light: told.pop(f" {light}") for light in lights}
        return SkinMany(**told, images=images)
