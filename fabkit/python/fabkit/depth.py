"""Ground truth: exact depth maps, normals and labels of a sensor's surface, pressed or not."""

from __future__ import annotations

import copy
import json
import os
import warnings
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from fabkit import _arrays, _fabkit
from fabkit._capture import Capture
from fabkit._cast import Cast, cast
from fabkit.calibrate import Extrinsics
from fabkit.cameras import Camera
from fabkit.designs import Sensor, as_sensor
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
    """Ground truth for each pixel of a camera: the arrays of ``fabkit depth -o FILE.npz``.

    Maps are rows x columns; NaN where the pixel does not see the surface.
    """

    range_mm: NDArray[np.float64]
    """Distance along each pixel's ray, mm, from the last refraction to the surface."""
    z_mm: NDArray[np.float64]
    """Depth map: z in the camera frame, mm."""
    point_in_sensor: NDArray[np.float64]
    """Surface point that each pixel sees, sensor frame, mm: rows x columns x 3."""
    normal_in_sensor: NDArray[np.float64]
    """Unit normals out of the gel, sensor frame: rows x columns x 3."""
    label: NDArray[np.uint16]
    """Label of each pixel: an index into ``label_names``."""
    indentation_mm: NDArray[np.float64]
    """Range without contact minus range with it, mm; negative only where elastic layers bulge."""
    contact: NDArray[np.bool_]
    """True where the pixel sees the contact with an indenter."""
    incidence_rad: NDArray[np.float64]
    """Angle between ray and normal, rad."""
    sigma_mm: NDArray[np.float64]
    """Standard deviation of ``range_mm``, mm. A range starts at the last refraction of its ray, so
    it can be far less certain than the surface point at its end."""
    point_sigma_mm: NDArray[np.float64]
    """Standard deviation of ``point_in_sensor``, mm: root of the sum of squares over x, y, z."""
    indentation_sigma_mm: NDArray[np.float64]
    """Standard deviation of ``indentation_mm``, mm, if the indenters are exactly in their
    places."""
    normal_sigma_rad: NDArray[np.float64]
    """Standard deviation of ``normal_in_sensor``, rad: how much the normal turns within the
    uncertainty of the surface point's position."""
    label_names: list[str]
    """Names of labels: ``none``, ``surface``, then the indenters."""
    seen_by: NDArray[np.uint8]
    """Body of the sensor that each pixel sees, contact or not: an index into ``seen_by_names``."""
    seen_by_names: list[str]
    """Names for ``seen_by``: ``nothing``, ``surface``, then the sensor's bodies, and ``total
    reflection``."""
    elastic: dict[str, Any] | None = None
    """Elastic response in linear contact, simulated: ``force_n``, ``moment_nmm``, ``bulge_mm`` and
    their assumptions, as in ``fabkit depth --json``; ``against_rigid`` is the difference of the
    ranges to those of rigid contact. ``None`` for other contact models."""

    def arrays(self) -> dict[str, NDArray[np.generic] | list[str]]:
        """Return all maps and names by name, for example for ``numpy.savez``."""
        names = [field.name for field in fields(self) if field.name != "elastic"]
        return {name: getattr(self, name) for name in names}

    def picture(self, show: str = "indentation_mm") -> bytes:
        """Draw a map in false colours, with a scale beside it; return a PNG file's content.

        Parameters
        ----------
        show
            The map: ``range_mm``, ``z_mm``, ``indentation_mm``, ``incidence_rad``, ``sigma_mm``,
            ``point_sigma_mm`` or ``indentation_sigma_mm``.
        """
        return _fabkit.false_color(_arrays.numbers(getattr(self, show), show))

    def _repr_png_(self) -> bytes:
        return self.picture("indentation_mm" if self.contact.any() else "range_mm")


@dataclass(frozen=True)
class Captured:
    """A simulated capture: what ``fabkit capture`` writes."""

    grey: NDArray[np.float64]
    """Intensities from 0 to 255, not rounded: rows x columns, or rows x columns x 3 (red, green,
    blue) for a colour camera."""
    truth: Truth
    """Ground truth of the same view."""
    document: dict[str, Any]
    """Output of ``fabkit capture --json``: constants with their sources, and what the simulation
    leaves out."""


@dataclass(frozen=True)
class _PoseText:
    """Content of a pose file; a scene sends it to other processes in place of the file."""

    text: str


class Scene(Cast, Capture):
    """A sensor's surface and a camera that looks at it, for any number of presses.

    Parameters
    ----------
    sensor
        A sensor, or the name of one.
    camera
        A camera or the path of a camera file, ``FILE#NAME`` for one of several. Default: the one
        that belongs to ``pose``, else the design's lens.
    pose
        A pose file, the result of :func:`fabkit.calibrate.extrinsics`, or ``camera_from_sensor``,
        (4, 4), mm. Default: the camera's pose in the design.
    pose_covariance
        Covariance of the pose, (6, 6): a small rotation about the camera's axes through the
        sensor's origin, rad, then the translation, mm. It replaces that of ``pose`` and counts as
        independent of the camera.
    unit
        Number of a unit of the design, as for ``fabkit capture --unit``: its parts, camera, light
        sources and layers differ from the design within their tolerances. Simulated.

    Raises
    ------
    FabkitError
        A file has errors, a matrix is not a rigid motion, or the camera sees nothing of the
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
        self.sensor = as_sensor(sensor)
        """The sensor whose surface the camera sees."""
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
        # A camera object was checked when it was read, and may have any size.
        for sentence in [] if given else self._native.warnings():
            warnings.warn(sentence, stacklevel=2)

    def __reduce__(self) -> tuple[Any, ...]:
        # For another process, possibly in another folder: paths become absolute.
        there = [os.path.abspath(x) if isinstance(x, str) else x for x in self._given]
        return (_scene, (self.sensor, *there, self._size_px, self._unit))

    def resized(self, width_px: int, height_px: int) -> Scene:
        """Return a scene with the same view and another number of pixels.

        Refraction stays the same. The covariances of camera and pose are dropped.

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
        """Camera of the scene; its ``interface`` is ``drawn`` if the design refracts its rays."""
        return Camera(self._native.camera())

    @property
    def sensor_from_camera(self) -> NDArray[np.float64]:
        """Pose of the camera: camera frame to sensor frame, (4, 4), mm."""
        return self._native.sensor_from_camera()

    @property
    def sigma_of(self) -> str:
        """Sources of error in :attr:`Truth.sigma_mm`, for example ``pose, lens, interface, shape``.

        The joint covariance of pose and camera is used if the pose has one and the camera is the
        one it was solved with. Otherwise this ends in ``pose and camera as if independent``.
        """
        return self._native.sigma_of()

    @property
    def sigma_parameters(self) -> list[str]:
        """Names of the parameters whose variances :attr:`Truth.sigma_mm` includes."""
        return self._native.sigma_parameters()

    @property
    def coverage(self) -> float:
        """Fraction of the surface's area that the camera sees, 0 to 1."""
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
