"""Camera models: projection of points to pixels, and of pixels to rays."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fabkit import _arrays, _fabkit
from fabkit.errors import FabkitError, Problem

if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike

    from numpy.typing import ArrayLike, NDArray

__all__ = ["Camera"]


def __dir__() -> list[str]:
    return __all__


class Camera:
    """A lens model with its interface, image size and covariance.

    Points are in the camera frame, mm: +z forward, +x right, +y down. Pixels are column and row;
    the first pixel's centre is (0, 0).

    >>> import numpy as np
    >>> import fabkit
    >>> camera = fabkit.Camera.equidistant(640, 480, np.deg2rad(160))
    >>> camera.project([[10, 0, 10], [0, 0, 5]]).round(3).tolist()
    [[544.5, 239.5], [319.5, 239.5]]
    """

    def __init__(self, native: _fabkit.Camera) -> None:
        self._native = native

    @staticmethod
    def load(path: str | PathLike[str]) -> Camera:
        """Read a camera file of fabkit, OpenCV, ROS, Kalibr, COLMAP, mrcal, camodocal or ORB-SLAM.

        ``FILE#NAME`` selects one camera of a file with several. Unusual values, and parts of the
        file that are not used, are given as a ``UserWarning``.

        Raises
        ------
        FabkitError
            The file cannot be read or holds no camera; all errors are listed, with lines.
        """
        shown = os.fspath(path)
        path, name = _fabkit.split_camera_path(shown)
        try:
            text = Path(path).read_text(encoding="utf-8")
        except OSError as error:
            message = f"cannot read {os.fspath(path)}: {error.strerror or error}"
            problems = (Problem(message, file=os.fspath(path)),)
            raise FabkitError(message, code="io", exit_code=4, problems=problems) from error
        return _read(text, shown, name)

    @staticmethod
    def from_text(text: str, name: str | None = None) -> Camera:
        """Read a camera from the content of a camera file, or the one of several with a name."""
        return _read(text, "", name)

    @staticmethod
    def equidistant(width_px: int, height_px: int, field_of_view_rad: float) -> Camera:
        """Create an ideal equidistant lens: the pixel's distance from the centre grows with angle.

        ``field_of_view_rad`` is the full angle of view over the image's diagonal, as makers of
        small cameras state it.
        """
        return Camera(_fabkit.Camera.equidistant(width_px, height_px, field_of_view_rad))

    def __repr__(self) -> str:
        behind = "" if self.interface == "none" else f" behind a {self.interface} interface"
        return f"<Camera {self.width_px} x {self.height_px} px, {self.lens}{behind}>"

    def __reduce__(self) -> tuple[object, ...]:
        return (Camera.from_text, (self.to_text(),))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Camera) and self.to_text() == other.to_text()

    def __hash__(self) -> int:
        return hash(self.to_text())

    def to_text(self, format: str = "fabkit") -> str:
        """Write the camera as text in a file format.

        ``fabkit`` keeps everything; the others are ``opencv``, ``ros`` and ``kalibr``.

        Raises
        ------
        FabkitError
            The format cannot hold the camera; the message says what it would lose.
        """
        return self._native.to_text(format)

    def save(self, path: str | PathLike[str], format: str = "fabkit") -> None:
        """Write a camera file, completely or not at all; see :meth:`to_text`."""
        path = Path(path)
        _fabkit.write_files(str(path.parent), [(path.name, self.to_text(format).encode())])

    @property
    def width_px(self) -> int:
        """Number of columns of the image."""
        return self._native.size_px()[0]

    @property
    def height_px(self) -> int:
        """Number of rows of the image."""
        return self._native.size_px()[1]

    @property
    def lens(self) -> str:
        """Name of the lens model, for example ``kannala_brandt``."""
        return self._native.lens()

    @property
    def interface(self) -> str:
        """Name of the refracting interface between lens and scene, for example ``none``.

        The camera of a calibrated sensor may include the first refracting face. The design's bodies
        behind it refract rays further: a :class:`fabkit.depth.Scene` follows that, the camera alone
        does not.
        """
        return self._native.interface()

    @property
    def angle_limit_rad(self) -> float:
        """Largest angle to +z, in front of the lens, that projects to a pixel, rad."""
        return self._native.angle_limit_rad()

    @property
    def parameters(self) -> dict[str, float]:
        """Calibratable parameters in order, by names that end in their units."""
        return dict(self._native.parameters())

    @property
    def covariance(self) -> NDArray[np.float64] | None:
        """Covariance of :attr:`parameters`, (p, p), in their units; ``None`` if unknown."""
        return self._native.covariance()

    @property
    def sigmas(self) -> dict[str, float] | None:
        """Standard deviation of each parameter, by name, in its unit; ``None`` if unknown."""
        covariance = self.covariance
        if covariance is None:
            return None
        # Rounding may leave a variance of zero slightly negative.
        sigmas = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
        return dict(zip(self.parameters, sigmas.tolist(), strict=True))

    def with_parameters(self, parameters: Mapping[str, float]) -> Camera:
        """Return a copy with some parameters changed, by name, and without covariance.

        >>> import fabkit
        >>> camera = fabkit.load("rtac0").camera
        >>> camera.with_parameters({"cx_px": 300.0}).parameters["cx_px"]
        300.0
        """
        known = self.parameters
        for name in parameters:
            if name not in known:
                from fabkit.errors import unknown

                raise unknown("parameter", name, list(known))
        numbers = [float(value) for value in {**known, **parameters}.values()]
        return Camera(self._native.with_parameters(numbers))

    def behind_drawing(self) -> Camera:
        """Return a copy that models the lens alone: the design's bodies then refract its rays.

        Other cameras contain the refraction in their own model, because it was fitted to images
        taken through these bodies.

        >>> import fabkit
        >>> fabkit.Camera.equidistant(640, 480, 2.8).behind_drawing().interface
        'drawn'

        The camera of a design is of this kind already.

        >>> fabkit.load("rtac0").camera.interface
        'drawn'
        """
        return Camera(self._native.behind_drawing())

    def resized(self, width_px: int, height_px: int) -> Camera:
        """Return a camera with the same view and another number of pixels, without covariance.

        >>> import fabkit
        >>> camera = fabkit.load("rtac0").camera
        >>> small = camera.resized(160, 120)
        >>> small.width_px, small.height_px, round(small.parameters["cx_px"], 3)
        (160, 120, 79.5)
        """
        return Camera(self._native.resized(width_px, height_px))

    def project(self, points_in_camera: ArrayLike) -> NDArray[np.float64]:
        """Project points to pixels, inside the image or not.

        Parameters
        ----------
        points_in_camera
            (..., 3), mm.

        Returns
        -------
        Column and row, (..., 2), px; NaN where a point is outside the lens's domain, on the
        camera's side of the interface, or not finite.

        Raises
        ------
        FabkitError
            The array has another shape or dtype.
        """
        points, shape = _arrays.rows(points_in_camera, 3, "points_in_camera")
        return self._native.project(points).reshape(*shape, 2)

    def project_with_jacobians(
        self, points_in_camera: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Project points to pixels, with derivatives.

        Parameters
        ----------
        points_in_camera
            (..., 3), mm.

        Returns
        -------
        Pixels (..., 2); derivatives by the point (..., 2, 3), px per mm; derivatives by the
        parameters (..., 2, p), px per unit of each, in the order of :attr:`parameters`. NaN as in
        :meth:`project`.
        """
        points, shape = _arrays.rows(points_in_camera, 3, "points_in_camera")
        pixels, by_point, by_parameters = self._native.project_with_jacobians(points)
        count = by_parameters.shape[2]
        return (
            pixels.reshape(*shape, 2),
            by_point.reshape(*shape, 2, 3),
            by_parameters.reshape(*shape, 2, count),
        )

    def unproject(self, pixels: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Compute the rays of pixels, in the last medium.

        Parameters
        ----------
        pixels
            Column and row, (..., 2), px.

        Returns
        -------
        Origins (..., 3), mm: on the interface, or the lens's centre without one. Directions
        (..., 3): unit length, away from the camera. NaN where a pixel has no ray.

        >>> import fabkit
        >>> camera = fabkit.load("rtac0").camera
        >>> origins, directions = camera.unproject([[[0, 0], [639, 479]]])
        >>> directions.shape
        (1, 2, 3)
        """
        given, shape = _arrays.rows(pixels, 2, "pixels")
        origins, directions = self._native.unproject(given)
        return origins.reshape(*shape, 3), directions.reshape(*shape, 3)


def _read(text: str, file: str, name: str | None) -> Camera:
    """Read a camera, and warn of what is unusual about it."""
    camera, unusual = _fabkit.Camera.from_text(text, file, name)
    for sentence in unusual:
        # At the line that called `load` or `from_text`.
        warnings.warn(sentence if file == "" else f"{file}: {sentence}", stacklevel=3)
    return Camera(camera)
