"""Ground truth: exactly what a camera sees of a sensor's surface, pressed or not."""

from __future__ import annotations

import copy
import json
import os
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from fabkit import _arrays, _fabkit
from fabkit._capture import Capture
from fabkit._cast import Cast, cast
from fabkit.calibrate import Extrinsics
from fabkit.cameras import Camera
from fabkit.designs import Sensor, load
from fabkit.errors import invalid

if TYPE_CHECKING:
    from os import PathLike

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Captured", "Scene", "Truth", "cast"]


def __dir__() -> list[str]:
    return __all__


@dataclass(frozen=True)
class Truth:
    """What a camera sees, pixel by pixel: the arrays of ``fabkit depth -o FILE.npz``.

    Maps are rows x columns; NaN where no surface is seen.
    """

    range_mm: NDArray[np.float64]
    """Distance along each pixel's ray, mm."""
    z_mm: NDArray[np.float64]
    """Third coordinate in the camera frame, mm."""
    point_in_sensor: NDArray[np.float64]
    """Where each ray ends, sensor frame, mm: rows x columns x 3."""
    normal_in_sensor: NDArray[np.float64]
    """Unit normals out of the gel, sensor frame: rows x columns x 3."""
    label: NDArray[np.uint16]
    """What each pixel sees: an index into ``label_names``."""
    indentation_mm: NDArray[np.float64]
    """Range without contact minus range with it, mm: at least 0, but where elastic layers bulge."""
    contact: NDArray[np.bool_]
    """Whether each pixel sees what presses."""
    incidence_rad: NDArray[np.float64]
    """Angle between ray and normal, rad."""
    sigma_mm: NDArray[np.float64]
    """Standard deviation of the range, mm. A range begins where its ray was bent last: it may err
    by far more than the point at its end does."""
    point_sigma_mm: NDArray[np.float64]
    """Standard deviation of ``point_in_sensor``, root of the sum of squares over x, y, z, mm."""
    indentation_sigma_mm: NDArray[np.float64]
    """Standard deviation of ``indentation_mm``, for presses that are where they are said to be."""
    normal_sigma_rad: NDArray[np.float64]
    """Standard deviation of ``normal_in_sensor``, by position: how much it turns between what is
    shown and what should be, rad."""
    label_names: list[str]
    """``none``, ``surface``, then what presses."""
    seen_by: NDArray[np.uint8]
    """What of the sensor each pixel sees, contact or not: an index into ``seen_by_names``."""
    seen_by_names: list[str]
    """``nothing``, ``surface``, then the sensor's bodies, and ``total reflection``."""
    elastic: dict[str, Any] | None = None
    """In linear contact, what the layers answer: ``force_n``, ``moment_nmm``, ``bulge_mm`` and
    what they rest on, as in ``fabkit depth --json``; ``against_rigid``, how far ranges are from
    those of rigid contact; simulated."""

    def arrays(self) -> dict[str, NDArray[np.generic] | list[str]]:
        """All maps by name, for example for ``numpy.savez``."""
        names = [field.name for field in fields(self) if field.name != "elastic"]
        return {name: getattr(self, name) for name in names}

    def picture(self, show: str = "indentation_mm") -> bytes:
        """Draw a map with a colour for each value and a scale beside it: PNG.

        Parameters
        ----------
        show
            ``range_mm``, ``z_mm``, ``indentation_mm``, ``incidence_rad``, ``sigma_mm``,
            ``point_sigma_mm`` or ``indentation_sigma_mm``.
        """
        return _fabkit.false_color(_arrays.numbers(getattr(self, show), show))

    def _repr_png_(self) -> bytes:
        return self.picture("indentation_mm" if self.contact.any() else "range_mm")


@dataclass(frozen=True)
class Captured:
    """The picture that a camera would take, simulated: what ``fabkit capture`` writes."""

    grey: NDArray[np.float64]
    """Grey values from 0 to 255, not rounded: rows x columns, and red, green, blue where there
    are colours."""
    truth: Truth
    """What it shows."""
    document: dict[str, Any]
    """All that ``fabkit capture --json`` says: constants with their sources, what is left out."""


@dataclass(frozen=True)
class _PoseText:
    """The content of a pose file: what travels to other processes."""

    text: str


class Scene(Cast, Capture):
    """A sensor's surface and the camera that looks at it.

    Parameters
    ----------
    sensor
        A sensor, or the name of one.
    camera
        A camera or the path of a camera file; without it, the one that belongs to ``pose``, else
        the nominal lens.
    pose
        A pose file, the result of :func:`fabkit.calibrate.extrinsics`, or ``camera_from_sensor``,
        (4, 4), mm; without it, where the design puts the camera.
    pose_covariance
        (6, 6), a small rotation about the camera's axes through the sensor's origin, rad, then the
        translation, mm; instead of what ``pose`` says, and taken for independent of the camera.
    unit
        Number of a unit of the design, as for ``fabkit capture --unit``: its parts, camera, lamps
        and layers differ from the drawing as tolerances let them. Simulated.

    Raises
    ------
    FabkitError
        Files with faults, a matrix that is no rigid motion, a camera that sees nothing of the
        surface.
    """

    def __init__(
        self,
        sensor: Sensor | str,
        *,
        camera: Camera | str | PathLike[str] | None = None,
        pose: Extrinsics | str | PathLike[str] | ArrayLike | None = None,
        pose_covariance: ArrayLike | None = None,
        unit: int | None = None,
    ) -> None:
        if unit is not None and not 0 <= unit < 1 << 64:
            raise invalid(f"unit is {unit}; it must be a number from 0 to 2^64 - 1")
        self.sensor = load(sensor) if isinstance(sensor, str) else sensor
        """Whose surface is seen."""
        covariance = pose_covariance
        pose_file: str | None = None
        text: _PoseText | None = None
        matrix: list[list[float]] | None = None
        if isinstance(pose, Extrinsics):
            camera = pose.camera if camera is None else camera
            text = _PoseText(pose._native.pose_text())  # pyright: ignore[reportPrivateUsage]
        elif isinstance(pose, _PoseText):
            text = pose
        elif isinstance(pose, str | os.PathLike):
            pose_file = os.fspath(pose)
        elif pose is not None:
            matrix = _arrays.matrix(pose, 4, "pose")
            if matrix[3] != [0, 0, 0, 1]:
                raise invalid(f"the last row of pose is {matrix[3]}; it must be [0, 0, 0, 1]")
        given = isinstance(camera, Camera)
        camera_file = None if isinstance(camera, Camera) or camera is None else os.fspath(camera)
        of_pose = None if covariance is None else _arrays.matrix(covariance, 6, "pose_covariance")
        self._size_px: tuple[int, int] | None = None
        self._given = (camera if given else camera_file, pose_file or text or matrix, of_pose)
        self._unit = unit
        self._native = _fabkit.Scene(
            self.sensor._project,  # pyright: ignore[reportPrivateUsage]
            self.sensor.source,
            camera_file,
            pose_file,
            camera._native if given else None,  # pyright: ignore[reportPrivateUsage]
            None if text is None else text.text,
            matrix,
            of_pose,
            unit,
        )

    def __reduce__(self) -> tuple[Any, ...]:
        # To another process of the same machine, or one that sees the same files.
        there = [os.path.abspath(x) if isinstance(x, str) else x for x in self._given]
        return (_scene, (self.sensor, *there, self._size_px, self._unit))

    def resized(self, width_px: int, height_px: int) -> Scene:
        """See the same in another number of pixels: for simulators and networks.

        Rays are bent as before. How sure camera and pose are is not carried over.

        >>> import fabkit
        >>> scene = fabkit.depth.Scene("rtac0").resized(160, 120)
        >>> scene.cast().range_mm.shape
        (120, 160)
        """
        small = copy.copy(self)
        small._size_px = (width_px, height_px)
        small._native = self._native.resized(width_px, height_px)
        return small

    @property
    def camera(self) -> Camera:
        """The camera that looks; a lens alone, whose rays drawn bodies bend, says so."""
        return Camera(self._native.camera())

    @property
    def sensor_from_camera(self) -> NDArray[np.float64]:
        """Camera frame to sensor frame, (4, 4), mm."""
        return self._native.sensor_from_camera()

    @property
    def sigma_of(self) -> str:
        """What :attr:`Truth.sigma_mm` contains, for example ``pose, lens, interface, shape``.

        Pose and camera err together, and count so, if the pose says it and the camera is the one
        it was solved with; else this ends in ``pose and camera as if independent``.
        """
        return self._native.sigma_of()

    @property
    def sigma_parameters(self) -> list[str]:
        """Names of the parameters whose variances are in :attr:`Truth.sigma_mm`."""
        return self._native.sigma_parameters()

    @property
    def coverage(self) -> float:
        """Share of the surface's area that the camera sees, 0 to 1."""
        return self._native.coverage()[0]

    def _see(self, presses: list[str], options: dict[str, Any]) -> Truth:
        seen, elastic = self._native.cast(presses, options)
        return Truth(**seen, elastic=None if elastic is None else json.loads(elastic))

    def _take(self, presses: list[str], options: dict[str, Any]) -> Captured:
        found, document = self._native.capture(presses, options)
        said = json.loads(document)
        grey = found.pop("grey")
        return Captured(grey, Truth(**found, elastic=said["elastic"]), said)


def _scene(
    sensor: Sensor,
    camera: Any,
    pose: Any,
    pose_covariance: Any,
    size_px: tuple[int, int] | None,
    unit: int | None,
) -> Scene:
    scene = Scene(sensor, camera=camera, pose=pose, pose_covariance=pose_covariance, unit=unit)
    return scene if size_px is None else scene.resized(*size_px)
